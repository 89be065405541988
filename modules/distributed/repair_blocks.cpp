// Verdicts, repair, crossing checks and boundary deviation of curved blocks.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;
import camber.crossing;
import camber.surface;
import camber.curving;
import camber.repair;
import camber.stages;

namespace camber {

namespace {

void add_up(RepairStatistics& sum, const RepairStatistics& place) {
    sum.corrected_elements += place.corrected_elements;
    sum.raised_elements += place.raised_elements;
    sum.moved_volume_nodes += place.moved_volume_nodes;
    sum.moved_surface_nodes += place.moved_surface_nodes;
    sum.moved_vertices += place.moved_vertices;
    sum.work += place.work;
    sum.by_edges += place.by_edges;
    sum.by_cavities += place.by_cavities;
    sum.by_extension += place.by_extension;
    sum.by_vertices += place.by_vertices;
    sum.by_slides += place.by_slides;
    sum.by_surface += place.by_surface;
}

template <int D>
struct RepairedBlocks {
    RingedParts<D>& parts;
    std::vector<PartState<D>>& states;
    const WholeSurface<D>& surface;
    CurvingAim aim;
};

/// Optimisation first uses two rings of elements, and extends up to eight. One more ring contains all elements that the
/// optimisation may change.
constexpr int rings_around = 9;

template <int D>
class RegionBoundary {
  public:
    RegionBoundary(const WholeSurface<D>& surface, Region<D>& region) : surface_(surface), region_(region) {
        of_surface_ = surface.places_of(region.vertices);
        for (std::size_t v = 0; v < of_surface_.size(); ++v)
            if (of_surface_[v].valid()) in_region_.emplace_back(of_surface_[v], VertexId(v));
    }

    [[nodiscard]] Outcome<Boundary<D>> take(const Execution& execution) {
        const LinearMesh<D>& from = surface_.mesh.linear;
        LinearMesh<D>& mesh = region_.mesh.linear;
        const auto facets = selected<D - 1>(from.facets, facets_);
        std::vector<std::uint32_t> edges;
        const auto feature_edges = selected<1>(from.edges, edges);
        mesh.facets = facets;
        mesh.edges = feature_edges;
        Buffer<VertexId> corners, required;
        for (const VertexId v : from.corners)
            if (const auto at = find(v)) corners.push_back(*at);
        for (const VertexId v : from.required_vertices)
            if (const auto at = find(v)) required.push_back(*at);
        for (std::size_t v = 0; v < region_.outer.size(); ++v)
            if (region_.outer[v] != 0) required.emplace_back(v);
        mesh.corners = std::move(corners);
        mesh.required_vertices = std::move(required);
        const Column<LagrangeNode<D>> nodes = region_.mesh.mid_nodes;
        auto elevated = elevate(std::move(mesh), execution);
        if (!elevated) return fail(elevated.error());
        region_.mesh = std::move(*elevated);
        region_.mesh.mid_nodes = nodes;
        return Boundary<D>{features(), surface_.boundary.required, surface_.boundary.geometry};
    }

  private:
    [[nodiscard]] std::optional<VertexId> find(VertexId of_surface) const {
        const auto at =
            std::ranges::lower_bound(in_region_, of_surface, {}, [](const auto& pair) { return pair.first; });
        return at != in_region_.end() && at->first == of_surface ? std::optional(at->second) : std::nullopt;
    }
    [[nodiscard]] bool has_edges(const auto& simplex) const {
        for (std::size_t i = 0; i < simplex.size(); ++i)
            for (std::size_t j = 0; j < i; ++j)
                if (!find_edge(region_.mesh.edges, simplex[i], simplex[j]).valid()) return false;
        return true;
    }
    template <int K>
    [[nodiscard]] Simplices<K> selected(const Simplices<K>& from, std::vector<std::uint32_t>& rows) const {
        Buffer<SimplexVertices<K>> simplices;
        Buffer<Reference> references;
        Buffer<std::uint32_t> required;
        for (std::size_t s = 0; s < from.size(); ++s) {
            SimplexVertices<K> simplex = from.vertices[s];
            bool is_local = true;
            for (VertexId& v : simplex) {
                const auto at = find(v);
                is_local = at.has_value();
                if (!is_local) break;
                v = *at;
            }
            if (!is_local || !has_edges(simplex)) continue;
            if (std::ranges::find(from.required, s) != from.required.end())
                required.push_back(static_cast<std::uint32_t>(simplices.size()));
            simplices.push_back(simplex);
            references.push_back(from.references[s]);
            rows.push_back(static_cast<std::uint32_t>(s));
        }
        return {std::move(simplices), std::move(references), std::move(required)};
    }
    [[nodiscard]] Features<D> features() const {
        const Features<D>& from = surface_.boundary.features;
        Buffer<EdgeKind> edge_kinds;
        Buffer<std::uint32_t> curves, patches;
        for (const auto& [a, b] : region_.mesh.edges.vertices) {
            const EdgeId at = surface_.find(region_.vertices[a.index()], region_.vertices[b.index()]);
            edge_kinds.push_back(at.valid() ? from.edge_kinds[at] : EdgeKind::volume);
            curves.push_back(at.valid() ? from.curves[at] : no_feature);
        }
        Buffer<VertexKind> vertex_kinds;
        for (const VertexId v : of_surface_)
            vertex_kinds.push_back(v.valid() ? from.vertex_kinds[v] : VertexKind::volume);
        for (const std::uint32_t f : facets_) patches.push_back(from.patches[f]);
        return {std::move(edge_kinds), std::move(vertex_kinds), std::move(patches), std::move(curves), from.patch_count,
                from.curve_count,      from.surface_edges,      from.ridge_edges,   from.corners};
    }

    const WholeSurface<D>& surface_;
    Region<D>& region_;
    std::vector<VertexId> of_surface_;
    std::vector<std::pair<VertexId, VertexId>> in_region_;
    std::vector<std::uint32_t> facets_;
};

template <int D>
Column<EdgeKind> with_fixed_rim(const Region<D>& region) {
    Buffer<EdgeKind> kinds(region.kinds.begin(), region.kinds.end());
    for (std::size_t e = 0; e < kinds.size(); ++e) {
        const auto& [a, b] = region.mesh.edges.vertices[e];
        if (region.outer[a.index()] != 0 && region.outer[b.index()] != 0) kinds[e] = EdgeKind::fixed;
    }
    return kinds;
}

template <int D>
struct MovedVertex {
    GlobalNumber vertex = 0;
    Vec<D> point;
};
template <int D>
struct MovedNode {
    std::array<GlobalNumber, 2> ends{};
    LagrangeNode<D> node;
};
template <int D>
struct Moved {
    std::vector<MovedVertex<D>> vertices;
    std::vector<MovedNode<D>> nodes;
    RepairStatistics statistics;
};

template <int D>
Outcome<Moved<D>> repair_region(const RepairedBlocks<D>& of, Region<D>& region, const RepairOptions& options,
                                const Execution& execution) {
    auto boundary = RegionBoundary<D>(of.surface, region).take(without_progress(execution));
    if (!boundary) return fail(boundary.error());
    const QuadraticMesh<D>& region_mesh = region.mesh;
    auto straight = elevate(region_mesh.linear, without_progress(execution));
    if (!straight) return fail(straight.error());
    const auto around = shells(straight->edges, without_progress(execution));
    if (!around) return fail(around.error());
    const std::size_t n = straight->edges.size();
    const Curved<D> curved{{straight->linear.points, region_mesh.mid_nodes, with_fixed_rim(region),
                            Buffer<EdgeChange>(n, EdgeChange::optimised)},
                           Buffer<double>(n, 0.0),
                           Buffer<double>(n, 0.0),
                           {}};
    const auto judged = validate(*straight, curved.proposal, options.min_scaled_jacobian, execution);
    if (!judged) return fail(judged.error());
    const auto field =
        field_on(*straight, std::move(region.back_nodes), region.log_metrics, StoredGradients::all, execution);
    if (!field) return fail(field.error());
    const Column<LagrangeNode<D>> extended(Buffer<LagrangeNode<D>>(region.extended));
    const TargetNodes<D> target{curved, *around, extended, of.aim, &*field};
    const auto guide = make_guide<D>(*judged, target, &*boundary, options, execution);
    if (!guide) return fail(guide.error());
    const auto repaired = repair_or_straighten(*judged, *guide, options, execution);
    if (!repaired) return fail(repaired.error());
    Moved<D> moved;
    moved.statistics = repaired->statistics;
    const Proposal<D>& after = repaired->judged.proposal();
    for (std::size_t v = 0; v < after.points.size(); ++v)
        if (after.points[v] != straight->linear.points[v])
            moved.vertices.push_back({region.vertices[v], after.points[v]});
    for (std::size_t e = 0; e < n; ++e) {
        if (after.mid_nodes[e] == curved.proposal.mid_nodes[e]) continue;
        const auto& [a, b] = straight->edges.vertices[e];
        moved.nodes.push_back({{region.vertices[a.index()], region.vertices[b.index()]}, after.mid_nodes[e]});
    }
    return moved;
}

template <int D>
Outcome<Moved<D>> repair_places(const RepairedBlocks<D>& of, std::vector<Region<D>> places,
                                const RepairOptions& options, const Execution& execution) {
    Moved<D> all;
    for (std::size_t p = 0; p < places.size(); ++p) {
        const auto share = [&](std::size_t n) { return static_cast<double>(n) / static_cast<double>(places.size()); };
        auto moved = repair_region(of, places[p], options, part_of(execution, share(p), share(p + 1)));
        if (!moved) return moved;
        all.vertices.insert(all.vertices.end(), moved->vertices.begin(), moved->vertices.end());
        all.nodes.insert(all.nodes.end(), moved->nodes.begin(), moved->nodes.end());
        add_up(all.statistics, moved->statistics);
        places[p] = {};
    }
    return all;
}

template <int D>
void apply_moves(const RepairedBlocks<D>& of, const Moved<D>& moved) {
    for (std::size_t b = 0; b < of.states.size(); ++b) {
        RingedPart<D>& part = of.parts.own[b];
        PartState<D>& state = of.states[b];
        const auto local = [&](GlobalNumber v) -> std::optional<VertexId> {
            const auto at = std::ranges::lower_bound(part.vertices, v);
            if (at == part.vertices.end() || *at != v) return std::nullopt;
            return VertexId(at - part.vertices.begin());
        };
        Buffer<Vec<D>> points;
        for (const auto& move : moved.vertices) {
            const auto v = local(move.vertex);
            if (!v) continue;
            if (points.empty()) points = Buffer<Vec<D>>(part.mesh.points.begin(), part.mesh.points.end());
            points[v->index()] = move.point;
        }
        if (!points.empty()) {
            part.mesh.points = std::move(points);
            state.mesh.linear.points = part.mesh.points;
        }
        for (const auto& move : moved.nodes) {
            const auto a = local(move.ends[0]), c = local(move.ends[1]);
            if (!a || !c) continue;
            if (const EdgeId e = find_edge(state.mesh.edges, *a, *c); e.valid()) state.nodes[e.index()] = move.node;
        }
    }
}

/// Repairs elements. Each connected set of elements, with nine rings around it (the maximum range of repair), is
/// repaired on one rank, like a mesh in `curve_mesh`. All ranks receive the moved nodes and vertices.
template <int D>
Outcome<RepairStatistics> repair_blocks(const RepairedBlocks<D>& of, const std::vector<GlobalNumber>& elements,
                                        const RepairOptions& options, Ranks& ranks, const Execution& execution) {
    auto places = regions_around(of.parts, of.states, elements, rings_around, ranks, execution);
    if (!places) return fail(places.error());
    auto moved = repair_places(of, std::move(*places), options, execution);
    if (!moved) return fail(moved.error());
    const auto vertices = gather_all(ranks, Outcome<std::vector<MovedVertex<D>>>(std::move(moved->vertices)));
    if (!vertices) return fail(vertices.error());
    const auto nodes = gather_all(ranks, Outcome<std::vector<MovedNode<D>>>(std::move(moved->nodes)));
    if (!nodes) return fail(nodes.error());
    apply_moves<D>(of, {*vertices, *nodes, {}});
    return moved->statistics;
}

template <int D>
Outcome<Done> validate_part(BlockRun<D>& run, PartState<D>& state, const RingedPart<D>& part, BlocksValidation& own,
                            const Execution& execution) {
    QuadraticMesh<D> mesh = state.mesh;
    mesh.mid_nodes = std::move(state.nodes);
    const RepairOptions& repair = run.options.curving.repair;
    const auto validation = validate(mesh, repair.min_scaled_jacobian, execution);
    state.nodes = take(std::move(mesh.mid_nodes));
    if (!validation) return fail(validation.error());
    for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e) {
        if (!part.owns(mesh.linear.elements.vertices[e])) continue;
        const Verdict verdict = validation->verdicts[e];
        own.below_bound += verdict != Verdict::valid ? 1 : 0;
        const auto smallest = static_cast<double>(validation->min_scaled_jacobian[e]);
        const bool is_low = raises(repair) && smallest < repair.target;
        if (verdict != Verdict::valid || is_low) run.to_repair.push_back(part.elements[e]);
        if (smallest < own.smallest) own.smallest = smallest, own.worst = part.elements[e];
    }
    for (const auto& [e, verdict] : validation->not_positive) {
        if (!part.owns(mesh.linear.elements.vertices[e])) continue;
        ++(verdict == Verdict::invalid ? own.invalid : own.undecided);
        own.below_bound -= validation->verdicts[e] != Verdict::valid ? 1 : 0;
    }
    return Done{};
}

template <int D>
Outcome<BlocksValidation> validate_all_blocks(BlockRun<D>& run, const Execution& execution) {
    BlocksValidation own;
    run.to_repair.clear();
    auto done = run.each_part(execution, [&](PartState<D>& state, RingedPart<D>& part) -> Outcome<Done> {
        return validate_part(run, state, part, own, without_progress(execution));
    });
    if (!done) return fail(done.error());
    std::ranges::sort(run.to_repair);
    const auto all = gather_all(run.ranks, Outcome<std::vector<BlocksValidation>>({own}));
    if (!all) return fail(all.error());
    BlocksValidation sum;
    for (const BlocksValidation& v : *all) {
        sum.invalid += v.invalid;
        sum.undecided += v.undecided;
        sum.below_bound += v.below_bound;
        if (v.smallest < sum.smallest) sum.smallest = v.smallest, sum.worst = v.worst;
    }
    return sum;
}

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
    std::vector<Found> moved;  // boundary vertices that repair has moved
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

template <int D>
Outcome<Done> validate_uncrossed(BlockRun<D>& run, const Execution& execution) {
    auto validation = validate_all_blocks(run, execution);
    if (!validation) return fail(validation.error());
    const bool is_worse = validation->not_valid() > run.out.after.not_valid();
    run.out.after = std::move(*validation);
    return is_worse ? relax_blocks(run, execution) : Outcome<Done>(Done{});
}

}  // namespace

template <int D>
Outcome<Done> validate_blocks(BlockRun<D>& run, const Execution& execution) {
    auto validation = validate_all_blocks(run, execution);
    if (!validation) return fail(validation.error());
    run.out.before = run.out.after = std::move(*validation);
    return Done{};
}

template <int D>
Outcome<Done> relax_blocks(BlockRun<D>& run, const Execution& execution) {
    const auto numbers = gather_all(run.ranks, Outcome<std::vector<std::size_t>>({run.to_repair.size()}));
    if (!numbers) return fail(numbers.error());
    if (std::ranges::all_of(*numbers, [](std::size_t n) { return n == 0; })) return Done{};
    const RepairedBlocks<D> of{run.out.parts, run.states, run.by->surface, run.by->edges.aim};
    const auto repaired =
        repair_blocks(of, run.to_repair, run.options.curving.repair, run.ranks, part_of(execution, 0, 0.9));
    if (!repaired) return fail(repaired.error());
    const auto all = gather_all(run.ranks, Outcome<std::vector<RepairStatistics>>({*repaired}));
    if (!all) return fail(all.error());
    for (const RepairStatistics& s : *all) add_up(run.out.repair, s);
    auto validation = validate_all_blocks(run, part_of(execution, 0.9, 1));
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
        if (auto done = validate_uncrossed(run, execution); !done) return done;
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

#define CAMBER_INSTANTIATE(D)                                                  \
    template Outcome<Done> validate_blocks<D>(BlockRun<D>&, const Execution&); \
    template Outcome<Done> relax_blocks<D>(BlockRun<D>&, const Execution&);    \
    template Outcome<Done> uncross_blocks<D>(BlockRun<D>&, const Execution&);  \
    template Outcome<Done> measure_blocks<D>(BlockRun<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
