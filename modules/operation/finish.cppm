module;
#include <cstddef>
export module camber.operation:finish;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.surface;
import :state;

export namespace camber {

/// A mesh that was remeshed, as any other mesh, its metric at each vertex, and what that lies on.
template <int D>
struct FinishedMesh {
    CompactMesh<D> compact;
    Column<LogMetric<D>> log_metrics;
    Column<GeometryPlace> places;  ///< see Adaptation
};

/// The mesh without free places. All corners are listed in it and all lines on which its surfaces break (3D), those
/// too that nobody listed before: who reads the mesh sees the breaks that the passes kept, which angles between new
/// facets need not show. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<FinishedMesh<D>> finished(const Adaptation<D>& r, const Execution& execution);

}  // namespace camber
