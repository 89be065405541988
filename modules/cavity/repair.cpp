module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.cavity;
import :repair_rounds;
import :repair_state;
import camber.core;
import camber.bezier;
import camber.validity;

namespace camber {

namespace {

/// Turns over the nodes that are not where they are wanted, while they come nearer.
constexpr int most_returns = 12;

template <int D>
Outcome<Done> check(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal, std::size_t models,
                    const RepairOptions& options) {
    const std::size_t edges = mesh.edges.size();
    if (proposal.mid_nodes.size() != edges || proposal.kinds.size() != edges || proposal.changes.size() != edges ||
        models != edges)
        return fail(ErrorKind::internal, "the proposal or the models have another number of edges than the mesh");
    if (!(options.min_scaled_jacobian >= 0 && options.min_scaled_jacobian < 1))
        return fail(ErrorKind::usage, "min_scaled_jacobian must be at least 0 and below 1");
    if (!(options.target >= 0 && options.target < 1))
        return fail(ErrorKind::usage, "target must be at least 0 and below 1");
    return Done{};
}

/// 1 for the ends of edges that are not of the volume.
template <int D>
Buffer<std::uint8_t> boundary_vertices(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds) {
    Buffer<std::uint8_t> marks(mesh.linear.points.size(), 0);
    for (std::size_t e = 0; e < kinds.size(); ++e)
        if (kinds[e] != EdgeKind::volume)
            for (const VertexId v : mesh.edges.vertices[e]) marks[v.index()] = 1;
    return marks;
}

/// The passes of a repair over the elements that are not good enough yet, the queue.
template <int D>
struct Passes {
    RepairState<D> state;
    std::vector<ElementId> queue;
    Execution execution;

    [[nodiscard]] Outcome<Done> by_edges() {
        const auto needless = [&](ElementId e) { return state.good(e); };
        const auto claim = [&](ElementId e) { return repair_cavity(state, e, Reach{}).elements; };
        const auto plan = [&](ElementId e) { return plan_edge_repair(state, e); };
        return finish(in_rounds(state, queue, execution, needless, claim, plan, [](ElementId, bool) {}));
    }
    [[nodiscard]] Outcome<Done> by_cavities(Reach reach, double asked) {
        const auto needless = [&](ElementId e) { return state.good(e); };
        const auto claim = [&](ElementId e) { return repair_cavity(state, e, reach).elements; };
        const auto plan = [&](ElementId e) {
            return plan_cavity_repair(state, repair_cavity(state, e, reach), e, asked);
        };
        return finish(in_rounds(state, queue, execution, needless, claim, plan, [](ElementId, bool) {}));
    }
    [[nodiscard]] Outcome<Done> by_extension(const Incidence<ElementId>& shells) {
        auto extended =
            extend_boundary(state.mesh, state.kinds, Column<LagrangeNode<D>>(state.nodes), shells, {}, execution);
        if (!extended) return fail(extended.error());
        apply(state, plan_extension(state, queue, extended->nodes));
        return finish(Done{});
    }
    /// Nodes that are off their places come as near as they may.
    [[nodiscard]] Outcome<Done> returns() {
        std::vector<EdgeId> items;
        for (std::size_t e = 0; e < state.nodes.size(); ++e)
            if (state.kinds[e] == EdgeKind::volume && state.nodes[e].point != state.models[e].centre)
                items.push_back(EdgeId(e));
        for (int turn = 0; turn < most_returns && !items.empty(); ++turn) {
            std::vector<EdgeId> moved;
            const auto claim = [&](EdgeId e) {
                return std::vector<ElementId>(state.shells[e].begin(), state.shells[e].end());
            };
            const auto plan = [&](EdgeId e) { return plan_return(state, e); };
            auto done = in_rounds(
                state, items, execution, [](EdgeId) { return false; }, claim, plan,
                [&](EdgeId e, bool planned) {
                    if (planned) moved.push_back(e);
                });
            if (!done) return done;
            // What moved may have made room around it.
            std::vector<std::uint8_t> near(state.mesh.linear.elements.size(), 0);
            for (const EdgeId e : moved)
                for (const ElementId element : state.shells[e]) near[element.index()] = 1;
            std::erase_if(items, [&](EdgeId e) {
                return std::ranges::none_of(state.shells[e], [&](ElementId x) { return near[x.index()] != 0; });
            });
        }
        return Done{};
    }

  private:
    Outcome<Done> finish(Outcome<Done> done) {
        std::erase_if(queue, [&](ElementId e) { return state.good(e); });
        return done;
    }
};

template <int D>
Outcome<Done> run(Passes<D>& passes, RepairStatistics& s, const Incidence<ElementId>& shells) {
    using Moves = Reach::Moves;
    const auto counted = [&](std::size_t& counter, auto&& pass) -> Outcome<Done> {
        if (passes.queue.empty()) return Done{};
        const std::size_t before = passes.queue.size();
        auto done = pass();
        counter += before - passes.queue.size();
        return done;
    };
    const double target = passes.state.options.target;
    const auto cavities = [&](std::size_t& counter, Reach reach, double asked) {
        return counted(counter, [&] { return passes.by_cavities(reach, asked); });
    };
    auto done = counted(s.by_edges, [&] { return passes.by_edges(); });
    if (done && passes.state.options.scope == RepairScope::cavities) {
        done = cavities(s.by_cavities, {Moves::volume_nodes, 0}, target);
        if (done) done = cavities(s.by_cavities, {Moves::volume_nodes, 1}, target);
        if (done) done = cavities(s.by_cavities, {Moves::volume_nodes, 1}, 0);
        if (done) done = counted(s.by_extension, [&] { return passes.by_extension(shells); });
        if (done) done = cavities(s.by_cavities, {Moves::volume_nodes, 2}, 0);
        if (done) done = cavities(s.by_vertices, {Moves::vertices, 1}, 0);
        if (done) done = cavities(s.by_surface, {Moves::surface_nodes, 1}, 0);
    }
    return done ? passes.returns() : done;
}

/// The state as a mesh and a proposal, judged as a whole.
template <int D>
Outcome<Repaired<D>> summed_up(RepairState<D> state, const Proposal<D>& before, const Validation<D>& validation,
                               RepairStatistics statistics, const Execution& execution) {
    Buffer<EdgeChange> changes(before.changes.begin(), before.changes.end());
    for (std::size_t e = 0; e < changes.size(); ++e) {
        const auto& [a, b] = state.mesh.edges.vertices[e];
        if (state.nodes[e] == before.mid_nodes[e]) continue;
        const bool straight = state.nodes[e].point == midpoint(state.points[a.index()], state.points[b.index()]);
        changes[e] = straight ? EdgeChange::straightened : EdgeChange::relaxed;
        ++(state.kinds[e] == EdgeKind::volume ? statistics.moved_volume_nodes : statistics.relaxed_surface_nodes);
    }
    for (const Vec<D>& shift : state.shifts) statistics.moved_vertices += shift != Vec<D>{};
    QuadraticMesh<D> mesh = state.mesh;
    if (statistics.moved_vertices > 0) mesh.linear.points = std::move(state.points);
    Proposal<D> proposal{std::move(state.nodes), before.kinds, std::move(changes)};
    auto after = validate(mesh, proposal, validation.bound, execution);
    if (!after) return fail(after.error());
    for (std::size_t e = 0; e < after->verdicts.size(); ++e)
        statistics.corrected_elements +=
            validation.verdicts[e] != Verdict::valid && after->verdicts[e] == Verdict::valid;
    return Repaired<D>{std::move(mesh.linear), std::move(proposal), std::move(*after), statistics};
}

}  // namespace

template <int D>
Outcome<Repaired<D>> repair(const QuadraticMesh<D>& mesh, Proposal<D> proposal, const Validation<D>& validation,
                            const Column<QuadraticModel<D>>& models, const RepairOptions& options,
                            const Execution& execution) {
    if (auto fits = check(mesh, proposal, models.size(), options); !fits) return fail(fits.error());
    if (validation.bound != options.min_scaled_jacobian || validation.verdicts.size() != mesh.linear.elements.size()) {
        auto again = validate(mesh, proposal, options.min_scaled_jacobian, execution);
        if (!again) return fail(again.error());
        return repair(mesh, std::move(proposal), *again, models, options, execution);
    }
    if (validation.all_valid()) return Repaired<D>{mesh.linear, std::move(proposal), validation, {}};
    return guarded([&]() -> Outcome<Repaired<D>> {
        const auto around = shells(mesh.edges, execution);
        if (!around) return fail(around.error());
        const auto vertex_balls = balls(mesh.linear, execution);
        if (!vertex_balls) return fail(vertex_balls.error());
        Passes<D> passes{
            {mesh, *around, *vertex_balls, models, options, proposal.kinds, boundary_vertices(mesh, proposal.kinds),
             Buffer<Vec<D>>(mesh.linear.points.begin(), mesh.linear.points.end()),
             Buffer<Vec<D>>(mesh.linear.points.size(), Vec<D>{}), take(proposal.mid_nodes), take(validation.verdicts)},
            {},
            execution};
        for (std::size_t e = 0; e < passes.state.verdicts.size(); ++e)
            if (passes.state.verdicts[e] != Verdict::valid) passes.queue.push_back(ElementId(e));
        RepairStatistics statistics;
        if (auto done = run(passes, statistics, *around); !done) return fail(done.error());
        return summed_up(std::move(passes.state), proposal, validation, statistics, execution);
    });
}

template <int D>
void apply(RepairState<D>& state, const RepairPlan<D>& plan) {
    for (const auto& [edge, node] : plan.nodes) state.nodes[edge.index()] = node;
    for (const auto& [vertex, point] : plan.points) {
        state.shifts[vertex.index()] += point - state.points[vertex.index()];
        state.points[vertex.index()] = point;
    }
    for (const auto& [element, verdict] : plan.verdicts) state.verdicts[element.index()] = verdict;
}

std::vector<std::size_t> independent(const Buffer<std::vector<ElementId>>& claims, std::vector<std::uint8_t>& claimed) {
    std::vector<std::size_t> chosen;
    for (std::size_t i = 0; i < claims.size(); ++i) {
        if (std::ranges::any_of(claims[i], [&](ElementId e) { return claimed[e.index()] != 0; })) continue;
        for (const ElementId e : claims[i]) claimed[e.index()] = 1;
        chosen.push_back(i);
    }
    for (const std::size_t i : chosen)
        for (const ElementId e : claims[i]) claimed[e.index()] = 0;
    return chosen;
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template Outcome<Repaired<D>> repair<D>(const QuadraticMesh<D>&, Proposal<D>, const Validation<D>&,                \
                                            const Column<QuadraticModel<D>>&, const RepairOptions&, const Execution&); \
    template void apply<D>(RepairState<D>&, const RepairPlan<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
