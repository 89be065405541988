module;
#include <cstddef>
module camber.curving:polish;
import camber.core;
import camber.bezier;
import camber.validity;
import :shape;

namespace camber {

/// What programmes of single edges came to.
template <int D>
struct Polished {
    Buffer<LagrangeNode<D>> nodes;
    std::size_t steps = 0;  ///< nodes moved
    double before = 0;      ///< smallest scaled Jacobian of the mesh, at most `enough`
    double smallest = 0;    ///< the same in the end
};

/// Nodes of volume edges moved so that the smallest scaled Jacobian rises: band after band of the worst elements, in
/// rounds. In a round the programmes of the edges around all elements of the band are solved, but for those around
/// which nothing has changed since; then elements, the worst first, take the edge that raises the smallest value around
/// it most, unless one that came before has changed an element there. So the result does not depend on the threads.
/// Where the worst of a band do not rise, the elements around them are raised too, and then the band is tried once
/// more. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<Polished<D>> polish(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                          Buffer<LagrangeNode<D>> nodes, const Incidence<ElementId>& shells,
                                          const ShapeOptions& options, const Execution& execution);

}  // namespace camber
