module;
#include <array>
#include <optional>
module camber.io:gmf_order;
import camber.core;
import camber.bezier;
import :gmf_file;
import :listing;

namespace camber::gmf {

/// The order that the file's …P2Ordering block gives; none when it has none. Errors: the nodes are not all there once.
template <int K>
[[nodiscard]] Outcome<std::optional<listing::NodeOrder<K>>> read_order(const File& file);

/// The order of rows of degree 2 under a plain keyword: Gmsh's own ends with e23 e13, its later versions write e13 e23.
/// The one whose nodes lie nearer the middles of the chords, in the sum of squares.
template <int D>
[[nodiscard]] Outcome<listing::NodeOrder<3>> likely_order(const Buffer<Vec<D>>& points,
                                                          const Buffer<std::array<VertexId, 10>>& tetrahedra,
                                                          const Execution& execution);

}  // namespace camber::gmf
