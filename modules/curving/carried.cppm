module;
#include <span>
export module camber.curving:carried;
import camber.core;
import camber.metric;

/// A field that goes along with its walls: the displacement of the boundary's nodes is extended into the volume, and
/// the metric read through that. docs/algorithms/carried-field.md.
export namespace camber {

/// The nodes of such a back mesh, for make_curved_back_mesh: `extended` (one an edge: see extend_boundary, or the nodes
/// that the mesh was read with), but the middles of chords where the displacement is less than a hundredth of the
/// metric's unit at both ends, so that nothing is searched where nothing moves. Displacements that would bring an
/// element of the back mesh below a tenth of the straight one's Jacobian are lessened. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> carried_nodes(const QuadraticMesh<D>& mesh,
                                                             std::span<const LagrangeNode<D>> extended,
                                                             const Column<LogMetric<D>>& log_metrics,
                                                             const Incidence<ElementId>& shells,
                                                             const Execution& execution);

}  // namespace camber
