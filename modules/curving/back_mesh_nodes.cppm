module;
#include <span>
export module camber.curving:back_mesh_nodes;
import camber.core;
import camber.metric;

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

}  // namespace camber
