module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
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
import :check_part;
import :curve_blocks;
import :halo;
import :ranks;
import :repair_blocks;
import :rows;
import :split;
import :whole_surface;

namespace camber {

namespace {

template <int D>
Outcome<Done> split_up(BlockRun<D>& run, const MeshRows<D>& rows, const Execution& execution) {
    auto parts = split(rows, run.options.blocks, run.ranks, execution);
    if (!parts) return fail(parts.error());
    run.out.parts = std::move(*parts);
    run.states.resize(run.out.parts.own.size());
    return Done{};
}

/// Who has whose edges and vertices, and how edges are numbered.
template <int D>
Outcome<Done> connect(BlockRun<D>& run) {
    std::vector<EdgeSet<D>> edges;
    std::vector<GlobalNumber> counts;
    for (const PartState<D>& state : run.states) {
        edges.push_back(state.mesh.edges);
        counts.push_back(state.last_edge.index() - state.first_edge.index());
    }
    const auto all = gather_all(run.ranks, Outcome<std::vector<GlobalNumber>>(counts));
    if (!all) return fail(all.error());
    run.out.first_edges.push_back(0);
    for (const GlobalNumber n : *all) run.out.first_edges.push_back(run.out.first_edges.back() + n);
    auto of_edges = edge_halo<D>(run.out.parts, edges, run.ranks);
    if (!of_edges) return fail(of_edges.error());
    run.edges = std::move(*of_edges);
    auto of_vertices = vertex_halo(run.out.parts, run.ranks);
    if (!of_vertices) return fail(of_vertices.error());
    run.vertices = std::move(*of_vertices);
    run.between.emplace(run.ranks, run.edges, run.states.size());
    return Done{};
}

/// Its own vertices, and where blocks begin among them.
template <int D>
OwnVertices owned_of(const PartLayout& layout, const RingedPart<D>& part) {
    OwnVertices owned{part.first, part.last};
    if (part.first == part.last) return owned;
    const GlobalNumber first = part.vertices[part.first];
    for (const GlobalNumber v : layout.later_blocks(layout.part_with(first)))
        owned.later_runs.emplace_back(part.first.index() + (v - first));
    return owned;
}

template <int D>
Outcome<Done> elevate_blocks(BlockRun<D>& run, const Execution& execution) {
    auto done = run.each_part(execution, [&](PartState<D>& state, RingedPart<D>& part) -> Outcome<Done> {
        if (auto sound = check_part(part, without_progress(execution)); !sound) return sound;
        auto edges = unique_edges(part.mesh, without_progress(execution));
        if (!edges) return fail(edges.error());
        state.mesh = {part.mesh, std::move(*edges), {}};
        auto around = shells(state.mesh.edges, without_progress(execution));
        if (!around) return fail(around.error());
        state.shells = std::move(*around);
        state.owned = owned_of(run.out.parts.layout, part);
        const auto& ends = state.mesh.edges.vertices;
        const auto begin_of = [&](VertexId v) {
            const auto at = std::ranges::lower_bound(ends, v, {}, [](const auto& e) { return e[0]; });
            return EdgeId(static_cast<std::size_t>(at - ends.begin()));
        };
        state.first_edge = begin_of(part.first);
        state.last_edge = begin_of(part.last);
        return Done{};
    });
    if (!done) return done;
    return connect(run);
}

template <int D>
Outcome<CurvedBlocks<D>> finish(BlockRun<D>& run) {
    const auto of_ranks = gather_all(run.ranks, Outcome<std::vector<CurveStatistics>>({run.out.statistics}));
    if (!of_ranks) return fail(of_ranks.error());
    run.out.statistics = {};
    for (const CurveStatistics& s : *of_ranks) run.out.statistics += s;
    for (PartState<D>& state : run.states) {
        state.mesh.mid_nodes = std::move(state.nodes);
        run.out.curved.push_back({std::move(state.mesh), state.first_edge, state.last_edge});
    }
    return std::move(run.out);
}

Outcome<Done> check_supported(const ProposeOptions& options) {
    if (!has_field(options.objective))
        return fail(ErrorKind::unsupported, "nodes are not found by shape or by a solution by blocks", {}, {},
                    "take another objective, or the mesh as a whole");
    if (options.boundary_nodes != BoundaryNodeAim::projection)
        return fail(ErrorKind::unsupported, "nodes of the boundary are projected alone by blocks", {}, {},
                    "leave boundary_nodes out, or take the mesh as a whole");
    return check_limits(static_cast<const CurveOptions&>(options));
}

}  // namespace

template <int D>
Outcome<CurvedBlocks<D>> curve_blocks(const MeshRows<D>& rows, const BlocksGoal<D>& goal,
                                      const CurveBlocksOptions& options, Ranks& ranks, const Around& around) {
    if (auto supported = check_supported(options.curving.curve); !supported) return fail(supported.error());
    const auto run_all = [&]() -> Outcome<CurvedBlocks<D>> {
        BlockRun<D> run{goal, options, ranks};
        run.out.counts = rows.counts();
        const auto step = [&](std::string_view name, const auto& f) { return run_step(around, name, f); };
        auto done = step("split", [&](const Execution& e) { return split_up(run, rows, e); });
        if (done) done = step("elevate", [&](const Execution& e) { return elevate_blocks(run, e); });
        if (done) done = step("surface", [&](const Execution& e) { return find_surface(run, rows, e); });
        if (done) done = step("extension", [&](const Execution& e) { return extend_blocks(run, e); });
        if (done) done = step("metric", [&](const Execution& e) { return make_metric(run, e); });
        if (done) done = step("curve", [&](const Execution& e) { return curve_nodes(run, e); });
        if (done) done = step("validate", [&](const Execution& e) { return judge_blocks(run, e); });
        if (done) done = step("relax", [&](const Execution& e) { return relax_blocks(run, e); });
        if (done) done = step("uncross", [&](const Execution& e) { return uncross_blocks(run, e); });
        if (done) done = step("measure", [&](const Execution& e) { return measure_blocks(run, e); });
        if (!done) return fail(done.error());
        return finish(run);
    };
    return together(ranks, [&] { return guarded(run_all); });
}

#define CAMBER_INSTANTIATE(D)                                                                   \
    template Outcome<CurvedBlocks<D>> curve_blocks<D>(const MeshRows<D>&, const BlocksGoal<D>&, \
                                                      const CurveBlocksOptions&, Ranks&, const Around&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
