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
CurveOptions edges_by(const BlockRun<D>& run) {
    CurveOptions edges = edge_options(run.options.curving.curve);
    static_cast<EdgeAccuracyOptions&>(edges) =
        accuracy_for(run.goal.metric ? MetricOrigin::given : MetricOrigin::natural, edges);
    return edges;
}

/// Kinds and nodes of edges on the boundary, from the surface; others are the volume's, and straight.
template <int D>
Outcome<Done> take_boundary(const BlockRun<D>& run, PartState<D>& state, const RingedPart<D>& part) {
    const WholeSurface<D>& surface = run.by->surface;
    const auto& ends = state.mesh.edges.vertices;
    Buffer<EdgeKind> kinds(ends.size(), EdgeKind::volume);
    Buffer<EdgeId> on_surface(ends.size(), EdgeId{});
    state.base = straight_nodes(state.mesh);
    const std::vector<VertexId> vertices = surface.places_of(part.vertices.view());
    for (std::size_t e = 0; e < ends.size(); ++e) {
        const VertexId a = vertices[ends[e][0].index()], b = vertices[ends[e][1].index()];
        if (!a.valid() || !b.valid()) continue;
        const EdgeId at = find_edge(surface.mesh.edges, a, b);
        if (!at.valid()) continue;
        on_surface[e] = at;
        kinds[e] = surface.input.kinds[at];
        state.base[e] = surface.input.base[at];
    }
    state.kinds = std::move(kinds);
    state.on_surface = std::move(on_surface);
    return Done{};
}

/// The displacement of what is not of the volume by these kinds, extended.
template <int D>
Outcome<std::vector<Buffer<LagrangeNode<D>>>> extended_nodes(BlockRun<D>& run, Column<EdgeKind> PartState<D>::* kinds,
                                                             const Execution& execution) {
    std::vector<ExtensionPart<D>> parts;
    auto begun =
        run.each_part_keeping(without_progress(execution), [&](PartState<D>& state, RingedPart<D>&) -> Outcome<Done> {
            auto part = ExtensionPart<D>::make(state.mesh, state.*kinds, state.base, state.shells, state.owned,
                                               without_progress(execution));
            if (!part) return fail(part.error());
            parts.push_back(std::move(*part));
            return Done{};
        });
    if (!begun) return fail(begun.error());
    const auto solved = solve_extension<D>(parts, *run.between, {}, execution);
    if (!solved) return fail(solved.error());
    run.out.iterations = std::max(run.out.iterations, static_cast<std::size_t>(solved->iterations));
    std::vector<Buffer<LagrangeNode<D>>> nodes;
    for (ExtensionPart<D>& part : parts) {
        auto of_part = std::move(part).nodes(without_progress(execution));
        if (!of_part) return fail(of_part.error());
        nodes.push_back(std::move(*of_part));
    }
    return nodes;
}

/// Nodes of the surface's edges as the surface has them.
template <int D>
void take_base(const BlockRun<D>& run, PartState<D>& state) {
    for (std::size_t e = 0; e < state.base.size(); ++e)
        if (const EdgeId at = state.on_surface[e]; at.valid()) state.base[e] = run.by->surface.input.base[at];
}

/// See extended_in_planes of camber.recipes: nodes of edges within planes go as the displacement of all others.
template <int D>
Outcome<Done> extend_in_planes(BlockRun<D>& run, const Execution& execution) {
    WholeSurface<D>& surface = run.by->surface;
    const auto inside = edges_in_planes(surface.mesh, surface.boundary.features, surface.boundary.geometry,
                                        without_progress(execution));
    if (!inside) return fail(inside.error());
    const auto goes_along = [&](EdgeId at) {
        return at.valid() && (*inside)[at.index()] != 0 && surface.input.kinds[at] == EdgeKind::surface;
    };
    bool any = false;
    for (std::size_t e = 0; e < surface.mesh.edges.size(); ++e) any |= goes_along(EdgeId(e));
    if (!any) return Done{};
    for (PartState<D>& state : run.states) {
        Buffer<EdgeKind> kinds(state.kinds.begin(), state.kinds.end());
        for (std::size_t e = 0; e < kinds.size(); ++e)
            if (goes_along(state.on_surface[e])) kinds[e] = EdgeKind::volume;
        state.kinds_outside_planes = std::move(kinds);
    }
    const auto nodes = extended_nodes(run, &PartState<D>::kinds_outside_planes, execution);
    if (!nodes) return fail(nodes.error());
    Buffer<Vec<D>> shifts(surface.mesh.edges.size(), Vec<D>{});
    auto gathered = run.gather_on_surface(shifts, [&](std::size_t b, EdgeId e, EdgeId at) -> std::optional<Vec<D>> {
        if (!goes_along(at)) return std::nullopt;
        return (*nodes)[b][e.index()].point - run.states[b].base[e.index()].point;
    });
    if (!gathered) return gathered;
    for (PartState<D>& state : run.states) state.kinds_outside_planes = {};
    auto slid = slid_nodes<D>(surface.mesh, surface.input.base, shifts, surface.boundary.features,
                              surface.boundary.geometry, without_progress(execution));
    if (!slid) return fail(slid.error());
    surface.input.base = std::move(*slid);
    return run.each_part(without_progress(execution), [&](PartState<D>& state, RingedPart<D>&) -> Outcome<Done> {
        take_base(run, state);
        return Done{};
    });
}

}  // namespace

template <int D>
Outcome<Done> find_surface(BlockRun<D>& run, const MeshRows<D>& rows, const Execution& execution) {
    auto surface = whole_surface(rows, run.goal, part_of(execution, 0, 0.8));
    if (!surface) return fail(surface.error());
    run.by.emplace(CurvingBy<D>{std::move(*surface), edges_by(run)});
    return run.each_part(part_of(execution, 0.8, 1),
                         [&](PartState<D>& state, RingedPart<D>& part) { return take_boundary(run, state, part); });
}

template <int D>
Outcome<Done> extend_blocks(BlockRun<D>& run, const Execution& execution) {
    const auto straight = [&]() {
        const WholeSurface<D>& s = run.by->surface;
        for (std::size_t e = 0; e < s.mesh.edges.size(); ++e)
            if (s.input.kinds[e] != EdgeKind::volume && s.input.base[e] != s.mesh.mid_nodes[e]) return false;
        return true;
    };
    const auto let_base_go = [&] {
        for (PartState<D>& state : run.states) state.base = {};
    };
    if (straight()) return let_base_go(), Done{};
    if (D == 3)
        if (auto done = extend_in_planes(run, part_of(execution, 0, 0.5)); !done) return done;
    if (run.options.curving.curve.back_mesh != BackMeshKind::curved) return let_base_go(), Done{};
    run.is_displaced = true;
    auto nodes = extended_nodes(run, &PartState<D>::kinds, part_of(execution, 0.5, 1));
    if (!nodes) return fail(nodes.error());
    std::vector<std::span<LagrangeNode<D>>> columns(nodes->begin(), nodes->end());
    if (auto brought = bring_all<LagrangeNode<D>>(run.edges, run.ranks, columns); !brought) return brought;
    for (std::size_t p = 0; p < run.states.size(); ++p) {
        run.states[p].extended = {run.states[p].mesh, (*nodes)[p]};
        (*nodes)[p] = {};
    }
    return let_base_go(), Done{};
}

#define CAMBER_INSTANTIATE(D)                                                                   \
    template Outcome<Done> find_surface<D>(BlockRun<D>&, const MeshRows<D>&, const Execution&); \
    template Outcome<Done> extend_blocks<D>(BlockRun<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
