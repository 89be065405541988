module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.bezier;
import camber.curving;
import camber.metric;
import camber.recipes;
import camber.repair;
import camber.surface;
import camber.validity;
import :block_run;
import :part_state;
import :ringed_parts;
import :curve_blocks;
import :halo;
import :moved_nodes;
import :ranks;
import :repair_blocks;
import :rows;
import :whole_surface;

namespace camber {

namespace {

template <int D>
Outcome<Done> metric_of(const BlockRun<D>& run, PartState<D>& state, const RingedPart<D>& part,
                        const Execution& execution) {
    if (run.goal.metric) {
        auto made = run.goal.metric(state.mesh.linear, part.vertices.view(), execution);
        if (!made) return fail(made.error());
        state.log_metrics = take(std::move(*made));
        return Done{};
    }
    const auto around = balls(state.mesh.linear, execution);
    if (!around) return fail(around.error());
    if (!state.extended.is_known()) {
        auto made = natural_log_metrics(state.mesh.linear, *around, execution);
        if (!made) return fail(made.error());
        state.log_metrics = std::move(*made);
        return Done{};
    }
    QuadraticMesh<D> bent = state.mesh;
    bent.mid_nodes = state.extended.all(state.mesh);
    auto made = curved_natural_log_metrics(bent, *around, execution);
    if (!made) return fail(made.error());
    state.log_metrics = std::move(made->curved);
    return Done{};
}

}  // namespace

template <int D>
Buffer<LagrangeNode<D>> starting_at(const PartState<D>& state, const WholeSurface<D>& surface,
                                    const MovedNodes<D>& nodes) {
    Buffer<LagrangeNode<D>> base = nodes.all(state.mesh);
    for (std::size_t e = 0; e < base.size(); ++e)
        if (const EdgeId at = state.on_surface[e]; at.valid() && state.kinds[e] != EdgeKind::volume)
            base[e] = surface.input.base[at];
    return base;
}

/// The field on a part of the mesh, of which some of its vertices and edges are.
template <int D>
Outcome<BackMesh<D>> field_on(const QuadraticMesh<D>& mesh, Buffer<LagrangeNode<D>> back_nodes,
                              const Buffer<LogMetric<D>>& log_metrics, KeptGradients kept, const Execution& execution) {
    const auto around = balls(mesh.linear, execution);
    if (!around) return fail(around.error());
    Column<LogMetric<D>> logs(Buffer<LogMetric<D>>{log_metrics});
    if (back_nodes.empty()) return make_back_mesh(mesh.linear, *around, std::move(logs), execution);
    QuadraticMesh<D> bent = mesh;
    bent.mid_nodes = std::move(back_nodes);
    return make_curved_back_mesh(std::move(bent), *around, std::move(logs), execution, kept);
}

template <int D>
Outcome<BackMesh<D>> field_of(const PartState<D>& state, KeptGradients kept, const Execution& execution) {
    return field_on(state.mesh,
                    state.back_nodes.is_known() ? state.back_nodes.all(state.mesh) : Buffer<LagrangeNode<D>>{},
                    state.log_metrics, kept, execution);
}

/// The metric at the vertices, and the nodes of the mesh that it is read in.
template <int D>
Outcome<Done> make_metric(BlockRun<D>& run, const Execution& execution) {
    auto done = run.each_part(part_of(execution, 0, 0.6), [&](PartState<D>& state, RingedPart<D>& part) {
        return metric_of(run, state, part, without_progress(execution));
    });
    if (!done) return done;
    if (auto brought =
            bring_all<LogMetric<D>>(run.vertices, run.ranks, columns_of(run.states, &PartState<D>::log_metrics));
        !brought)
        return brought;
    if (!run.is_displaced) return Done{};
    std::vector<Buffer<LagrangeNode<D>>> back_nodes;
    done =
        run.each_part_keeping(part_of(execution, 0.6, 0.8), [&](PartState<D>& state, RingedPart<D>&) -> Outcome<Done> {
            const Column<LogMetric<D>> logs(Buffer<LogMetric<D>>(state.log_metrics));
            auto nodes =
                noticeable_nodes<D>(state.mesh, state.extended.all(state.mesh), logs, without_progress(execution));
            if (!nodes) return fail(nodes.error());
            // Searches begin where the back mesh has their edges; nodes for accuracy follow walls that hardly sag, too.
            if (run.by->edges.aim != CurvingAim::accuracy)
                state.base = starting_at(state, run.by->surface, MovedNodes<D>(state.mesh, *nodes));
            back_nodes.push_back(std::move(*nodes));
            return Done{};
        });
    if (!done) return done;
    std::vector<PartNodes<D>> parts;
    parts.reserve(run.states.size());
    for (std::size_t p = 0; p < run.states.size(); ++p)
        parts.push_back({run.states[p].mesh, run.states[p].shells, run.states[p].owned, back_nodes[p]});
    if (done = limit_to_back_mesh<D>(parts, *run.between, part_of(execution, 0.8, 1)); !done) return done;
    for (std::size_t p = 0; p < run.states.size(); ++p) {
        PartState<D>& state = run.states[p];
        state.back_nodes = {state.mesh, back_nodes[p]};
        back_nodes[p] = {};
    }
    return Done{};
}

#define CAMBER_INSTANTIATE(D)                                                                                \
    template Outcome<BackMesh<D>> field_on<D>(const QuadraticMesh<D>&, Buffer<LagrangeNode<D>>,              \
                                              const Buffer<LogMetric<D>>&, KeptGradients, const Execution&); \
    template Buffer<LagrangeNode<D>> starting_at<D>(const PartState<D>&, const WholeSurface<D>&,             \
                                                    const MovedNodes<D>&);                                   \
    template Outcome<BackMesh<D>> field_of<D>(const PartState<D>&, KeptGradients, const Execution&);         \
    template Outcome<Done> make_metric<D>(BlockRun<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
