module;
#include <span>
export module camber.curving:back_mesh_nodes;
import camber.core;
import camber.metric;
import :parts;

/// A field that goes along with its walls: the displacement of the boundary's nodes is extended into the volume, and
/// the metric read through that. docs/algorithms/curved-back-mesh.md.
export namespace camber {

/// Where nodes go along with the boundary: where they are `extended` (one an edge: see extend_boundary), but the
/// middles of chords where the displacement is less than a hundredth of the metric's unit at both ends, so that nothing
/// is searched where nothing moves. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> noticeable_nodes(const QuadraticMesh<D>& mesh,
                                                                std::span<const LagrangeNode<D>> extended,
                                                                const Column<LogMetric<D>>& log_metrics,
                                                                const Execution& execution);

/// Of these nodes (one an edge) those of a back mesh, for make_curved_back_mesh: displacements that would bring an
/// element below a tenth of the straight one's Jacobian are limited, on the boundary too; so it is the field's map
/// alone, and no place for a mesh's nodes. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> back_mesh_nodes(const QuadraticMesh<D>& mesh,
                                                               std::span<const LagrangeNode<D>> nodes,
                                                               const Incidence<ElementId>& shells,
                                                               const Execution& execution);

/// A part of a mesh with nodes, one an edge, those of other parts as they have them.
template <int D>
struct PartNodes {
    const QuadraticMesh<D>& mesh;
    const Incidence<ElementId>& shells;
    OwnVertices owned;
    std::span<LagrangeNode<D>> nodes;
};
/// The same of the parts of a mesh that are here, in place.
template <int D>
[[nodiscard]] Outcome<Done> limit_to_back_mesh(std::span<const PartNodes<D>> parts, BetweenParts<D>& between,
                                               const Execution& execution);

}  // namespace camber
