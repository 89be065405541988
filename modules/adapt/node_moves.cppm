module;
#include <cstddef>
export module camber.adapt:node_moves;
import camber.core;
import camber.operation;
import :passes;

export namespace camber {

/// What sweeps over the nodes of inner edges did.
struct NodeMoves {
    std::size_t tried = 0, moved = 0;
};

/// Of a mesh of degree 2: nodes of inner edges go to where the elements around are less distorted in the metric of
/// their vertices (see camber.metric:distortion), the worst of them never more so. Vertices and the boundary stay.
/// Edges around which all elements are as good as `wanted` are left alone, and those of required elements, of elements
/// that are not valid, and of interfaces. Every element that changes is certified: to 0.1 of its straight one's
/// determinant, or det J > 0 where it was below that. As if one edge after the other, in an order by their numbers.
/// Errors: options out of range, stopped, memory.
template <int D>
[[nodiscard]] Outcome<NodeMoves> smooth_nodes(Adaptation<D>& r, const SmoothOptions& options,
                                              const Execution& execution);

}  // namespace camber
