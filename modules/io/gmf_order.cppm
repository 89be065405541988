module;
#include <array>
#include <optional>
export module camber.io:gmf_order;
import camber.core;
import camber.bezier;
import :gmf_file;

namespace camber::gmf {

/// The local node, in the order of `local_edges`, that each node of a row in the file is.
template <int K>
using NodeOrder = std::array<int, quadratic_nodes<K>>;

/// The order that the file's …P2Ordering block gives; none when it has none. Errors: the nodes are not all there once.
template <int K>
[[nodiscard]] Outcome<std::optional<NodeOrder<K>>> read_order(const File& file);

/// Brings the nodes of simplices that have this order into that of `local_edges`.
template <int K>
[[nodiscard]] Outcome<Done> reorder(Buffer<std::array<VertexId, quadratic_nodes<K>>>& simplices,
                                    const NodeOrder<K>& order, const Execution& execution);

/// The order of rows of degree 2 under a plain keyword: Gmsh's own ends with e23 e13, its later versions write e13 e23.
/// The one whose nodes lie nearer the middles of the chords, in the sum of squares.
template <int D>
[[nodiscard]] Outcome<NodeOrder<3>> likely_order(const Buffer<Vec<D>>& points,
                                                 const Buffer<std::array<VertexId, 10>>& tetrahedra,
                                                 const Execution& execution);

}  // namespace camber::gmf
