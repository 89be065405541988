module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <optional>
#include <string>
#include <utility>
#include <vector>
module camber.cavity;
import :repair_plan;
import camber.core;
import camber.bezier;
import camber.validity;

namespace camber {

namespace {

using Moves = Reach::Moves;
/// One after the other, for the elements that the one before did not mend.
constexpr std::array<Reach, 7> reaches{{{Moves::volume_nodes, 0},
                                        {Moves::volume_nodes, 1},
                                        {Moves::volume_nodes, 2},
                                        {Moves::vertices, 1},
                                        {Moves::vertices, 2},
                                        {Moves::surface_nodes, 1},
                                        {Moves::surface_nodes, 2}}};

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

/// The first seeds of the queue whose cavities have no element in common: by order alone, whatever the threads.
template <int D>
struct Chosen {
    std::vector<ElementId> seeds;
    std::vector<RepairCavity<D>> cavities;
};
template <int D>
Outcome<Chosen<D>> choose(const RepairState<D>& state, const std::vector<ElementId>& queue, Reach reach,
                          const Execution& execution) {
    auto cavities =
        map_each(execution, queue.size(), [&](std::size_t i) { return repair_cavity(state, queue[i], reach); }, 16);
    if (!cavities) return fail(cavities.error());
    std::vector<std::uint8_t> claimed(state.mesh.linear.elements.size(), 0);
    Chosen<D> chosen;
    for (std::size_t i = 0; i < queue.size(); ++i) {
        const auto& elements = (*cavities)[i].elements;
        if (std::ranges::any_of(elements, [&](ElementId e) { return claimed[e.index()] != 0; })) continue;
        for (const ElementId e : elements) claimed[e.index()] = 1;
        chosen.seeds.push_back(queue[i]);
        chosen.cavities.push_back(std::move((*cavities)[i]));
    }
    return chosen;
}

template <int D>
void commit_plan(RepairState<D>& state, const RepairPlan<D>& plan) {
    for (const auto& [edge, node] : plan.nodes) state.nodes[edge.index()] = node;
    for (const auto& [vertex, point] : plan.points) {
        state.shifts[vertex.index()] += point - state.points[vertex.index()];
        state.points[vertex.index()] = point;
    }
    for (const auto& [element, verdict] : plan.verdicts) state.verdicts[element.index()] = verdict;
}

/// Cavities of one reach for all elements of the queue, round by round; those that were not mended stay in it.
template <int D>
Outcome<Done> mend_all(RepairState<D>& state, std::vector<ElementId>& queue, Reach reach, RepairStatistics& statistics,
                       const Execution& execution) {
    std::vector<ElementId> left;
    while (!queue.empty()) {
        auto chosen = choose(state, queue, reach, execution);
        if (!chosen) return fail(chosen.error());
        auto plans = map_each(
            execution, chosen->seeds.size(),
            [&](std::size_t i) { return plan_repair(state, chosen->cavities[i], chosen->seeds[i]); }, 1);
        if (!plans) return fail(plans.error());
        if (std::getenv("CAMBER_TRACE")) {
            std::size_t ok = 0, ed = 0;
            for (auto& p : *plans) ok += p.has_value();
            for (auto& c : chosen->cavities) ed += c.edges.size();
            std::fprintf(stderr, "reach %d/%d queue %zu chosen %zu ok %zu edges %zu t %.3f\n", int(reach.moves), reach.closures, queue.size(), chosen->seeds.size(), ok, ed, double(std::clock()) / CLOCKS_PER_SEC);
        }
        for (std::size_t i = 0; i < plans->size(); ++i) {
            const auto& plan = (*plans)[i];
            ++(plan ? statistics.cavities : statistics.failures);
            if (plan)
                commit_plan(state, *plan);
            else
                left.push_back(chosen->seeds[i]);
        }
        std::ranges::sort(chosen->seeds);
        std::erase_if(queue,
                      [&](ElementId e) { return state.good(e) || std::ranges::binary_search(chosen->seeds, e); });
    }
    std::erase_if(left, [&](ElementId e) { return state.good(e); });
    std::ranges::sort(left);
    queue = std::move(left);
    return Done{};
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
                            const Column<EdgeModel<D>>& models, const RepairOptions& options,
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
        RepairState<D> state{mesh,
                             *around,
                             *vertex_balls,
                             models,
                             options,
                             proposal.kinds,
                             boundary_vertices(mesh, proposal.kinds),
                             Buffer<Vec<D>>(mesh.linear.points.begin(), mesh.linear.points.end()),
                             Buffer<Vec<D>>(mesh.linear.points.size(), Vec<D>{}),
                             take(proposal.mid_nodes),
                             take(validation.verdicts)};
        std::vector<ElementId> queue;
        for (std::size_t e = 0; e < state.verdicts.size(); ++e)
            if (state.verdicts[e] != Verdict::valid) queue.push_back(ElementId(e));
        RepairStatistics statistics;
        for (const Reach reach : reaches)
            if (auto done = mend_all(state, queue, reach, statistics, execution); !done) return fail(done.error());
        return summed_up(std::move(state), proposal, validation, statistics, execution);
    });
}

#define CAMBER_INSTANTIATE(D)                                                                           \
    template Outcome<Repaired<D>> repair<D>(const QuadraticMesh<D>&, Proposal<D>, const Validation<D>&, \
                                            const Column<EdgeModel<D>>&, const RepairOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
