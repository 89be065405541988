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
import :block_state;
import :blocks;
import :curve_blocks;
import :halo;
import :ranks;
import :repair_blocks;
import :rows;
import :whole_surface;

namespace camber {

namespace {

template <int D>
Outcome<Done> metric_of(const BlockRun<D>& run, BlockState<D>& state, const Block<D>& block,
                        const Execution& execution) {
    if (run.goal.metric) {
        auto made = run.goal.metric(state.mesh.linear, block.vertices.view(), execution);
        if (!made) return fail(made.error());
        state.log_metrics = take(std::move(*made));
        return Done{};
    }
    const auto around = balls(state.mesh.linear, execution);
    if (!around) return fail(around.error());
    if (state.extended.empty()) {
        auto made = natural_log_metrics(state.mesh.linear, *around, execution);
        if (!made) return fail(made.error());
        state.log_metrics = std::move(*made);
        return Done{};
    }
    QuadraticMesh<D> bent = state.mesh;
    bent.mid_nodes = Buffer<LagrangeNode<D>>(state.extended);
    auto made = curved_natural_log_metrics(bent, *around, execution);
    if (!made) return fail(made.error());
    state.log_metrics = std::move(made->curved);
    return Done{};
}

template <int D>
void start_at(BlockState<D>& state, const Buffer<LagrangeNode<D>>& nodes) {
    for (std::size_t e = 0; e < nodes.size(); ++e)
        if (state.kinds[e] == EdgeKind::volume) state.base[e] = nodes[e];
}

}  // namespace

/// The field on a part of the mesh, of which some of its vertices and edges are.
template <int D>
Outcome<BackMesh<D>> field_on(const QuadraticMesh<D>& mesh, const Buffer<LagrangeNode<D>>& back_nodes,
                              const Buffer<LogMetric<D>>& log_metrics, KeptGradients kept, const Execution& execution) {
    const auto around = balls(mesh.linear, execution);
    if (!around) return fail(around.error());
    Column<LogMetric<D>> logs(Buffer<LogMetric<D>>{log_metrics});
    if (back_nodes.empty()) return make_back_mesh(mesh.linear, *around, std::move(logs), execution);
    QuadraticMesh<D> bent = mesh;
    bent.mid_nodes = Buffer<LagrangeNode<D>>(back_nodes);
    return make_curved_back_mesh(std::move(bent), *around, std::move(logs), execution, kept);
}

template <int D>
Outcome<BackMesh<D>> field_of(const BlockState<D>& state, KeptGradients kept, const Execution& execution) {
    return field_on(state.mesh, state.back_nodes, state.log_metrics, kept, execution);
}

/// The metric at the vertices, and the nodes of the mesh that it is read in.
template <int D>
Outcome<Done> make_metric(BlockRun<D>& run, const Execution& execution) {
    auto done = run.each_block(part_of(execution, 0, 0.6), [&](BlockState<D>& state, Block<D>& block) {
        return metric_of(run, state, block, without_progress(execution));
    });
    if (!done) return done;
    if (auto brought =
            bring_all<LogMetric<D>>(run.vertices, run.ranks, columns_of(run.states, &BlockState<D>::log_metrics));
        !brought)
        return brought;
    if (!run.is_displaced) return Done{};
    done = run.each_block(part_of(execution, 0.6, 0.8), [&](BlockState<D>& state, Block<D>&) -> Outcome<Done> {
        const Column<LogMetric<D>> logs(Buffer<LogMetric<D>>(state.log_metrics));
        auto nodes = noticeable_nodes<D>(state.mesh, state.extended, logs, without_progress(execution));
        if (!nodes) return fail(nodes.error());
        state.back_nodes = std::move(*nodes);
        return Done{};
    });
    if (!done) return done;
    // Searches begin where the back mesh has their edges; nodes for accuracy follow walls that hardly sag, too.
    for (BlockState<D>& state : run.states)
        start_at(state, run.by->edges.aim == CurvingAim::accuracy ? state.extended : state.back_nodes);
    std::vector<PartNodes<D>> parts;
    parts.reserve(run.states.size());
    for (BlockState<D>& state : run.states) parts.push_back({state.mesh, state.shells, state.owned, state.back_nodes});
    return limit_to_back_mesh<D>(parts, *run.between, part_of(execution, 0.8, 1));
}

#define CAMBER_INSTANTIATE(D)                                                                                \
    template Outcome<BackMesh<D>> field_on<D>(const QuadraticMesh<D>&, const Buffer<LagrangeNode<D>>&,       \
                                              const Buffer<LogMetric<D>>&, KeptGradients, const Execution&); \
    template Outcome<BackMesh<D>> field_of<D>(const BlockState<D>&, KeptGradients, const Execution&);        \
    template Outcome<Done> make_metric<D>(BlockRun<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
