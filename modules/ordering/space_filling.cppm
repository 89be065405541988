module;
#include <cstddef>
#include <optional>
export module camber.ordering:space_filling;
import camber.core;
import :renumbering;

/// Whether what is near in a mesh is near in memory, and an order in which it is. Loops over elements and edges read
/// their vertices, those over vertices their elements: in a mesh of 1 million tetrahedra in random order most of these
/// reads miss the caches, and a run takes twice as long.
export namespace camber {

struct OrderingOptions {
    /// Smaller meshes fit into caches in any order.
    std::size_t min_elements = 100'000;
    /// The scatter above which an order is bad.
    double max_scatter = 0.02;
};

/// The mean distance of the lowest vertices of consecutive elements, by the number of vertices: near 0 in a good order,
/// in a random one 2k/((k + 1)(2k + 1)) of elements of k vertices: 0.178 for tetrahedra, 0.214 for triangles. 0 without
/// two elements. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<double> scatter(const LinearMesh<D>& mesh, const Execution& execution);

/// Vertices along the Morton curve through their bounding box (G. M. Morton, 1966), elements by their lowest vertex
/// then; ties in the order that was. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Renumbering> space_filling_order(const LinearMesh<D>& mesh, const Execution& execution);

/// An order to work in, and how bad the mesh's own is.
struct BetterOrder {
    Renumbering renumbering;
    double scatter = 0;
};
/// The space-filling one, where the mesh's own is bad; nothing where that will do. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<std::optional<BetterOrder>> better_order(const LinearMesh<D>& mesh,
                                                               const OrderingOptions& options,
                                                               const Execution& execution);

}  // namespace camber
