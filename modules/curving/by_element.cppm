module;
#include <cstddef>
#include <span>
export module camber.curving:by_element;
import camber.core;
import camber.validity;
import :parts;

export namespace camber {

/// Nodes as their elements bear them: where `base` + `offsets` (one row an edge) would bring an element's scaled
/// Jacobian below `least`, those of its edges go only a part of their way, the largest of 3/4, 1/2, 1/4 and 0 that
/// holds it, or the best where none does; an edge takes the least share that its elements ask for. Elements around what
/// was limited are looked at again, until none asks for more (through a stack of layers that is a round a layer), and
/// shares multiply. What an edge alone does not see: error in the gradient grows as
/// 1/det J, so that a few elements that are nearly flat cost more than all others gain. The number of edges that
/// were limited. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_by_jacobian(const QuadraticMesh<D>& mesh,
                                                     std::span<const LagrangeNode<D>> base,
                                                     const Incidence<ElementId>& shells, double least,
                                                     std::span<Vec<D>> offsets, const Execution& execution);

/// A part of a mesh with its rows: one an edge, those of other parts as they have them.
template <int D>
struct PartOffsets {
    const QuadraticMesh<D>& mesh;
    std::span<const LagrangeNode<D>> base;  ///< none: the middles of chords
    const Incidence<ElementId>& shells;
    OwnVertices owned;
    std::span<Vec<D>> offsets;
};
/// The same of the parts of a mesh that are here; how many of their own edges were limited.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_by_jacobian(std::span<const PartOffsets<D>> parts, double least,
                                                     BetweenParts<D>& between, const Execution& execution);

}  // namespace camber
