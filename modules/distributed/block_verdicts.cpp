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
import camber.crossing;
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
import :ranks;
import :repair_blocks;
import :rows;
import :whole_surface;

namespace camber {

namespace {

template <int D>
Outcome<Done> judge_part(BlockRun<D>& run, PartState<D>& state, const RingedPart<D>& part, BlocksValidation& own,
                         const Execution& execution) {
    QuadraticMesh<D> mesh = state.mesh;
    mesh.mid_nodes = std::move(state.nodes);
    const auto validation = validate(mesh, run.options.curving.repair.min_scaled_jacobian, execution);
    state.nodes = take(std::move(mesh.mid_nodes));
    if (!validation) return fail(validation.error());
    for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e) {
        if (!part.owns(mesh.linear.elements.vertices[e])) continue;
        const Verdict verdict = validation->verdicts[e];
        own.invalid += verdict == Verdict::invalid ? 1 : 0;
        own.undecided += verdict == Verdict::undecided ? 1 : 0;
        if (verdict != Verdict::valid) run.not_valid.push_back(part.elements[e]);
        const auto smallest = static_cast<double>(validation->min_scaled_jacobian[e]);
        if (smallest < own.smallest) own.smallest = smallest, own.worst = part.elements[e];
    }
    for (const auto& [e, verdict] : validation->not_positive)
        own.not_positive += part.owns(mesh.linear.elements.vertices[e]) ? 1 : 0;
    return Done{};
}

/// Verdicts of all elements, of all ranks; those that are not valid are kept.
template <int D>
Outcome<BlocksValidation> judged_blocks(BlockRun<D>& run, const Execution& execution) {
    BlocksValidation own;
    run.not_valid.clear();
    auto done = run.each_part(execution, [&](PartState<D>& state, RingedPart<D>& part) -> Outcome<Done> {
        return judge_part(run, state, part, own, without_progress(execution));
    });
    if (!done) return fail(done.error());
    std::ranges::sort(run.not_valid);
    const auto all = gather_all(run.ranks, Outcome<std::vector<BlocksValidation>>({own}));
    if (!all) return fail(all.error());
    BlocksValidation sum;
    for (const BlocksValidation& v : *all) {
        sum.invalid += v.invalid;
        sum.undecided += v.undecided;
        sum.not_positive += v.not_positive;
        if (v.smallest < sum.smallest) sum.smallest = v.smallest, sum.worst = v.worst;
    }
    return sum;
}

/// Vertices and nodes of the whole surface as they are now.
template <int D>
struct SurfaceNow {
    Buffer<Vec<D>> points;
    Buffer<LagrangeNode<D>> nodes;
};
template <int D>
Outcome<SurfaceNow<D>> surface_now(BlockRun<D>& run) {
    struct Found {
        std::uint64_t at = 0;
        Vec<D> point;
    };
    const QuadraticMesh<D>& mesh = run.by->surface.mesh;
    Buffer<Vec<D>> places(mesh.edges.size());
    for (std::size_t e = 0; e < places.size(); ++e) places[e] = mesh.mid_nodes[e].point;
    auto gathered = run.gather_on_surface(places, [&](std::size_t b, EdgeId e, EdgeId) -> std::optional<Vec<D>> {
        return run.states[b].nodes[e.index()].point;
    });
    if (!gathered) return fail(gathered.error());
    SurfaceNow<D> now;
    now.points = Buffer<Vec<D>>(mesh.linear.points.begin(), mesh.linear.points.end());
    now.nodes = Buffer<LagrangeNode<D>>(places.size());
    for (std::size_t e = 0; e < places.size(); ++e) now.nodes[e] = {places[e]};
    std::vector<Found> moved;  // repair slides vertices of the boundary
    for (const RingedPart<D>& part : run.out.parts.own) {
        const std::vector<VertexId> at = run.by->surface.places_of(part.vertices.view());
        for (VertexId v = part.first; v < part.last; v = VertexId(v.index() + 1))
            if (at[v.index()].valid() && part.mesh.points[v] != mesh.linear.points[at[v.index()]])
                moved.push_back({at[v.index()].index(), part.mesh.points[v]});
    }
    const auto all = gather_all(run.ranks, Outcome<std::vector<Found>>(std::move(moved)));
    if (!all) return fail(all.error());
    for (const Found& f : *all) now.points[f.at] = f.point;
    return now;
}

/// The parts' nodes of these edges of the surface.
template <int D>
void put_on_parts(BlockRun<D>& run, const UncrossedNodes<D>& found) {
    for (PartState<D>& state : run.states)
        for (std::size_t e = 0; e < state.nodes.size(); ++e) {
            const EdgeId at = state.on_surface[e];
            if (!at.valid()) continue;
            const auto node = std::ranges::lower_bound(found.nodes, at, {}, [](const auto& n) { return n.first; });
            if (node != found.nodes.end() && node->first == at) state.nodes[e] = node->second;
        }
}

/// Where the first pair crosses, and the number of pairs that cross when straight.
template <int D>
Outcome<Done> find_first_crossing(const QuadraticMesh<D>& surface, const SurfaceNow<D>& now, WallsOfBlocks<D>& walls,
                                  const Execution& execution) {
    const auto& found = walls.crossings.found;
    const auto pair = std::ranges::find(found, Crossing::crossing, &FacetCrossing::verdict);
    if (pair == found.end()) return Done{};
    walls.first_crossing = {box_of(nodal_facet<D>(surface, now.points, now.nodes, pair->first)),
                            box_of(nodal_facet<D>(surface, now.points, now.nodes, pair->second))};
    const auto before = find_crossings(surface, execution);
    if (!before) return fail(before.error());
    walls.crossing_before = before->crossing;
    return Done{};
}

/// Elements that became invalid are repaired.
template <int D>
Outcome<Done> judge_uncrossed(BlockRun<D>& run, const Execution& execution) {
    auto validation = judged_blocks(run, execution);
    if (!validation) return fail(validation.error());
    const auto not_valid = [](const BlocksValidation& v) { return v.invalid + v.undecided; };
    const bool is_worse = not_valid(*validation) > not_valid(run.out.after);
    run.out.after = std::move(*validation);
    return is_worse ? relax_blocks(run, execution) : Outcome<Done>(Done{});
}

}  // namespace

template <int D>
Outcome<Done> judge_blocks(BlockRun<D>& run, const Execution& execution) {
    auto validation = judged_blocks(run, execution);
    if (!validation) return fail(validation.error());
    run.out.before = run.out.after = std::move(*validation);
    return Done{};
}

template <int D>
Outcome<Done> relax_blocks(BlockRun<D>& run, const Execution& execution) {
    if (run.out.after.all_valid()) return Done{};
    const RepairedBlocks<D> of{run.out.parts, run.states, run.by->surface, run.by->edges.aim};
    const auto repaired =
        repair_blocks(of, run.not_valid, run.options.curving.repair, run.ranks, part_of(execution, 0, 0.9));
    if (!repaired) return fail(repaired.error());
    const auto all = gather_all(run.ranks, Outcome<std::vector<RepairStatistics>>({*repaired}));
    if (!all) return fail(all.error());
    for (const RepairStatistics& s : *all) add_up(run.out.repair, s);
    auto validation = judged_blocks(run, part_of(execution, 0.9, 1));
    if (!validation) return fail(validation.error());
    run.out.after = std::move(*validation);
    return Done{};
}

template <int D>
Outcome<Done> uncross_blocks(BlockRun<D>& run, const Execution& execution) {
    constexpr int rounds = 3;
    const WholeSurface<D>& surface = run.by->surface;
    WallsOfBlocks<D>& walls = run.out.walls;
    std::optional<SurfaceNow<D>> first;
    for (int round = 0; round <= rounds; ++round) {
        auto now = surface_now(run);
        if (!now) return fail(now.error());
        auto found =
            round < rounds
                ? uncrossed_nodes<D>(surface.mesh, now->points, now->nodes, surface.input.kinds.view(), execution)
                : find_crossings<D>(surface.mesh, now->points, now->nodes, execution).map([](Crossings all) {
                      return UncrossedNodes<D>{{}, std::move(all)};
                  });
        if (!found) return fail(found.error());
        walls.crossings = std::move(found->crossings);
        if (!first) first = *now;
        if (found->nodes.empty()) {
            for (std::size_t e = 0; e < now->nodes.size(); ++e) walls.moved.add(first->nodes[e], now->nodes[e]);
            return find_first_crossing(surface.mesh, *now, walls, execution);
        }
        put_on_parts(run, *found);
        if (auto done = judge_uncrossed(run, execution); !done) return done;
    }
    return Done{};
}

template <int D>
Outcome<Done> measure_blocks(BlockRun<D>& run, const Execution& execution) {
    auto now = surface_now(run);
    if (!now) return fail(now.error());
    const WholeSurface<D>& surface = run.by->surface;
    QuadraticMesh<D> mesh = surface.mesh;
    mesh.linear.points = std::move(now->points);
    mesh.mid_nodes = std::move(now->nodes);
    auto found = boundary_deviation<D>(mesh, surface.input.kinds.view(), surface.boundary.geometry, {},
                                       run.options.tolerance, execution);
    if (!found) return fail(found.error());
    DeviationOfBlocks<D>& out = run.out.deviation;
    out.found = *found;
    if (const EdgeId e = found->nodes.worst; e.valid()) {
        const auto& [low, high] = mesh.edges.vertices[e];
        out.edge = {surface.vertices[low.index()], surface.vertices[high.index()]};
        out.node = mesh.mid_nodes[e].point;
    }
    if (const VertexId v = found->vertices.worst; v.valid()) {
        out.vertex = surface.vertices[v.index()];
        out.point = mesh.linear.points[v];
    }
    return Done{};
}

#define CAMBER_INSTANTIATE(D)                                                 \
    template Outcome<Done> judge_blocks<D>(BlockRun<D>&, const Execution&);   \
    template Outcome<Done> relax_blocks<D>(BlockRun<D>&, const Execution&);   \
    template Outcome<Done> uncross_blocks<D>(BlockRun<D>&, const Execution&); \
    template Outcome<Done> measure_blocks<D>(BlockRun<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
