module;
#include <cstddef>
#include <utility>
module camber.operation;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.surface;

namespace camber {

namespace {

/// The mesh with all of its breaks listed.
template <int D>
DynamicMesh<D> with_breaks_listed(DynamicMesh<D> mesh) {
    Buffer<Marks> lines = take(std::move(mesh.line_marks));
    for (Marks& marks : lines)
        if (!marks.has(Mark::embedded))
            marks = marks.has(Mark::required) ? Mark::ridge | Marks(Mark::required) : Mark::ridge;
    mesh.line_marks = std::move(lines);
    Buffer<VertexState> states = take(std::move(mesh.states));
    for (VertexState& state : states)
        if (state.place == VertexPlace::corner) state.marks |= Mark::corner;
    mesh.states = std::move(states);
    return mesh;
}

}  // namespace

template <int D>
Outcome<FinishedMesh<D>> finished(const Adaptation<D>& r, const Execution& execution) {
    return guarded([&]() -> Outcome<FinishedMesh<D>> {
        auto compact = compacted(with_breaks_listed(r.mesh), execution);
        if (!compact) return fail(compact.error());
        Buffer<LogMetric<D>> logs(compact->mesh.points.size());
        Buffer<GeometryPlace> places(r.vertices.places.empty() ? 0 : logs.size());
        const auto& map = compact->maps.vertices;
        for (std::size_t v = 0; v < r.vertices.metrics.size(); ++v)
            if (const VertexId to = map[VertexId(v)]; to.valid()) {
                logs[to.index()] = r.vertices.metrics[v].log_metric;
                if (!places.empty()) places[to.index()] = r.vertices.places[v];
            }
        return FinishedMesh<D>{std::move(*compact), std::move(logs), std::move(places)};
    });
}

#define CAMBER_INSTANTIATE(D) template Outcome<FinishedMesh<D>> finished<D>(const Adaptation<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
