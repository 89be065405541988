module;
#include <cstddef>
export module camber.remesh:settled;
import camber.core;
import camber.metric;
import camber.dynamic;
import :state;

export namespace camber {

/// A mesh that was remeshed, as any other mesh, and its metric at each vertex.
template <int D>
struct SettledMesh {
    CompactMesh<D> compact;
    Column<LogMetric<D>> log_metrics;
};

/// The mesh without free places. All corners are listed in it and all lines on which its surfaces break (3D), those
/// too that nobody listed before: who reads the mesh sees the breaks that the passes kept, which angles between new
/// facets need not show. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<SettledMesh<D>> settled(const Remeshing<D>& r, const Execution& execution);

}  // namespace camber
