// Computes the metric field of blocks, and the nodes of their edges.
module;
#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.edge_optimisation;
import camber.validity;
import camber.surface;
import camber.curving;
import camber.repair;
import camber.stages;

namespace camber {

namespace {

template <int D>
Outcome<Done> metric_of(const BlockRun<D>& run, PartState<D>& state, const RingedPart<D>& part,
                        const Execution& execution) {
    if (run.goal.metric) {
        auto result = run.goal.metric(state.mesh.linear, part.vertices.view(), execution);
        if (!result) return fail(result.error());
        state.log_metrics = take(std::move(*result));
        return Done{};
    }
    const auto around = balls(state.mesh.linear, execution);
    if (!around) return fail(around.error());
    if (!state.extended.is_known()) {
        auto result = natural_log_metrics(state.mesh.linear, *around, execution);
        if (!result) return fail(result.error());
        state.log_metrics = std::move(*result);
        return Done{};
    }
    QuadraticMesh<D> bent = state.mesh;
    bent.mid_nodes = state.extended.all(state.mesh);
    auto result = curved_natural_log_metrics(bent, *around, execution);
    if (!result) return fail(result.error());
    state.log_metrics = std::move(result->curved);
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

template <int D>
Outcome<BackMesh<D>> field_on(const QuadraticMesh<D>& mesh, Buffer<LagrangeNode<D>> back_nodes,
                              const Buffer<LogMetric<D>>& log_metrics, StoredGradients stored,
                              const Execution& execution) {
    const auto around = balls(mesh.linear, execution);
    if (!around) return fail(around.error());
    Column<LogMetric<D>> logs(Buffer<LogMetric<D>>{log_metrics});
    if (back_nodes.empty()) return make_back_mesh(mesh.linear, *around, std::move(logs), execution);
    QuadraticMesh<D> bent = mesh;
    bent.mid_nodes = std::move(back_nodes);
    return make_curved_back_mesh(std::move(bent), *around, std::move(logs), execution, stored);
}

template <int D>
Outcome<BackMesh<D>> field_of(const PartState<D>& state, StoredGradients stored, const Execution& execution) {
    return field_on(state.mesh,
                    state.back_nodes.is_known() ? state.back_nodes.all(state.mesh) : Buffer<LagrangeNode<D>>{},
                    state.log_metrics, stored, execution);
}

template <int D>
Outcome<Done> make_metric(BlockRun<D>& run, const Execution& execution) {
    auto done = run.each_part(part_of(execution, 0, 0.6), [&](PartState<D>& state, RingedPart<D>& part) {
        return metric_of(run, state, part, without_progress(execution));
    });
    if (!done) return done;
    if (auto updated = update_ghost_rows<LogMetric<D>>(run.vertices, run.ranks,
                                                       columns_of(run.states, &PartState<D>::log_metrics));
        !updated)
        return updated;
    if (!run.is_displaced) return Done{};
    std::vector<Buffer<LagrangeNode<D>>> back_nodes;
    done =
        run.each_resident_part(part_of(execution, 0.6, 0.8), [&](PartState<D>& state, RingedPart<D>&) -> Outcome<Done> {
            const Column<LogMetric<D>> logs(Buffer<LogMetric<D>>(state.log_metrics));
            auto nodes =
                noticeable_nodes<D>(state.mesh, state.extended.all(state.mesh), logs, without_progress(execution));
            if (!nodes) return fail(nodes.error());
            // The searches start at the nodes of the back mesh. With the aim `accuracy` they start at the extended
            // nodes, which also follow boundaries with small sag.
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

namespace {

template <int D>
Outcome<Done> search_all(BlockRun<D>& run, const Execution& execution) {
    auto done = run.each_part(execution, [&](PartState<D>& state, RingedPart<D>&) -> Outcome<Done> {
        const Execution quiet = without_progress(execution);
        const auto field = field_of(state, StoredGradients::recovered, quiet);
        if (!field) return fail(field.error());
        CurveOptions edges = run.by->edges;
        edges.measured = MeasuredEdges::none;
        QuadraticMesh<D> mesh = state.mesh;
        mesh.mid_nodes = straight_nodes(mesh);
        const Column<LagrangeNode<D>> base(state.base.empty() ? starting_at(state, run.by->surface, state.extended)
                                                              : std::move(state.base));
        state.base = {};
        auto curved = camber::curve({mesh, state.own_kinds(), state.shells}, base, *field, edges, quiet);
        if (!curved) return fail(curved.error());
        run.out.statistics += curved->statistics;
        state.nodes = take(std::move(curved->proposal.mid_nodes));
        return Done{};
    });
    if (!done) return done;
    return update_ghost_rows<LagrangeNode<D>>(run.edges, run.ranks, columns_of(run.states, &PartState<D>::nodes));
}

template <int D>
Outcome<Done> limit_offsets(BlockRun<D>& run, Buffer<Vec<D>> PartState<D>::* rows, double bound,
                            const Execution& execution) {
    if (run.by->edges.metric_kind == MetricKind::natural) {
        std::vector<PartLosses<D>> losses;
        losses.reserve(run.states.size());
        for (PartState<D>& state : run.states) losses.push_back({state.mesh, state.shells, state.owned, state.*rows});
        const auto limited_by_loss = limit_smooth_loss<D>(losses, run.by->edges.smooth_loss, *run.between, execution);
        if (!limited_by_loss) return fail(limited_by_loss.error());
        run.out.statistics.loss_limited += *limited_by_loss;
    }
    if (auto updated = update_ghost_rows<Vec<D>>(run.edges, run.ranks, columns_of(run.states, rows)); !updated)
        return updated;
    std::vector<PartOffsets<D>> offsets;
    offsets.reserve(run.states.size());
    for (PartState<D>& state : run.states)
        offsets.push_back({state.mesh, state.base, state.shells, state.owned, state.*rows});
    const auto drawn = limit_by_jacobian<D>(offsets, bound, *run.between, execution);
    if (!drawn) return fail(drawn.error());
    run.out.statistics.relaxed += *drawn;
    return Done{};
}

template <int D>
Outcome<Done> slide_nodes(BlockRun<D>& run, const Execution& execution) {
    WholeSurface<D>& surface = run.by->surface;
    Buffer<Vec<D>> shifts(surface.mesh.edges.size(), Vec<D>{});
    auto gathered = run.gather_on_surface(shifts, [&](std::size_t b, EdgeId e, EdgeId) -> std::optional<Vec<D>> {
        if (run.states[b].slides.empty()) return std::nullopt;
        const Vec<D>& shift = run.states[b].slides[e.index()];
        return shift == Vec<D>{} ? std::nullopt : std::optional(shift);
    });
    if (!gathered) return gathered;
    if (std::ranges::all_of(shifts, [](const Vec<D>& shift) { return shift == Vec<D>{}; })) return Done{};
    const QuadraticMesh<D> mesh =
        surface.boundary.required == RequiredBoundary::keep ? surface.mesh : without_required(surface.mesh);
    const auto slid = slid_nodes<D>(mesh, surface.input.base, shifts, surface.boundary.features,
                                    surface.boundary.geometry, without_progress(execution));
    if (!slid) return fail(slid.error());
    for (PartState<D>& state : run.states) {
        state.slides = Buffer<Vec<D>>(state.mesh.edges.size());
        for (std::size_t e = 0; e < state.slides.size(); ++e) {
            const EdgeId at = state.on_surface[e];
            state.slides[e] = at.valid() ? (*slid)[at.index()].point - surface.input.base[at].point : Vec<D>{};
        }
    }
    if (auto limited = limit_offsets(run, &PartState<D>::slides, slide_bound(run.by->edges), execution); !limited)
        return limited;
    for (PartState<D>& state : run.states) {
        for (std::size_t e = 0; e < state.slides.size(); ++e)
            if (state.on_surface[e].valid()) state.base[e].point += state.slides[e];
        state.slides = {};
    }
    return Done{};
}

template <int D>
void place_nodes(BlockRun<D>& run, PartState<D>& state) {
    state.nodes = std::move(state.base);
    state.base = {};
    for (std::size_t e = 0; e < state.nodes.size(); ++e) {
        if (state.kinds[e] != EdgeKind::volume) continue;
        state.nodes[e].point += state.offsets[e];
        if (!state.owns(EdgeId(e))) continue;
        ++run.out.statistics.volume_edges;
        run.out.statistics.curved_edges += state.nodes[e] != straight_node(state.mesh, EdgeId(e)) ? 1 : 0;
    }
    state.offsets = {};
}

template <int D>
Outcome<Done> curve_accurately(BlockRun<D>& run, const Execution& execution) {
    auto done = run.each_part(part_of(execution, 0, 0.6), [&](PartState<D>& state, RingedPart<D>&) -> Outcome<Done> {
        const Execution quiet = without_progress(execution);
        const auto field = field_of(state, StoredGradients::sampled, quiet);
        if (!field) return fail(field.error());
        const Column<EdgeKind> own = state.own_kinds();
        const MeshEdges<D> edges{state.mesh, own, state.shells};
        auto slides = accurate_offsets(edges, EdgeKind::surface, *field, run.by->edges, quiet);
        if (!slides) return fail(slides.error());
        if (std::ranges::any_of(*slides, [](const Vec<D>& slide) { return slide != Vec<D>{}; }))
            state.slides = std::move(*slides);
        else
            *slides = {};
        auto offsets = accurate_offsets(edges, EdgeKind::volume, *field, run.by->edges, quiet);
        if (!offsets) return fail(offsets.error());
        state.offsets = std::move(*offsets);
        return Done{};
    });
    if (!done) return done;
    for (PartState<D>& state : run.states) state.base = starting_at(state, run.by->surface, state.extended);
    if (done = slide_nodes(run, part_of(execution, 0.6, 0.7)); !done) return done;
    if (done = limit_offsets(run, &PartState<D>::offsets, run.by->edges.min_jacobian, part_of(execution, 0.7, 0.95));
        !done)
        return done;
    return run.each_part(part_of(execution, 0.95, 1), [&](PartState<D>& state, RingedPart<D>&) -> Outcome<Done> {
        place_nodes(run, state);
        return Done{};
    });
}

}  // namespace

template <int D>
Outcome<Done> curve_nodes(BlockRun<D>& run, const Execution& execution) {
    return run.by->edges.aim == CurvingAim::accuracy ? curve_accurately(run, execution) : search_all(run, execution);
}

#define CAMBER_INSTANTIATE(D)                                                                                  \
    template Outcome<BackMesh<D>> field_on<D>(const QuadraticMesh<D>&, Buffer<LagrangeNode<D>>,                \
                                              const Buffer<LogMetric<D>>&, StoredGradients, const Execution&); \
    template Buffer<LagrangeNode<D>> starting_at<D>(const PartState<D>&, const WholeSurface<D>&,               \
                                                    const MovedNodes<D>&);                                     \
    template Outcome<BackMesh<D>> field_of<D>(const PartState<D>&, StoredGradients, const Execution&);         \
    template Outcome<Done> make_metric<D>(BlockRun<D>&, const Execution&);                                     \
    template Outcome<Done> curve_nodes<D>(BlockRun<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
