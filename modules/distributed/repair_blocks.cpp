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
import camber.curving;
import camber.metric;
import camber.recipes;
import camber.repair;
import camber.surface;
import camber.validity;
import :block_run;
import :part_state;
import :ringed_parts;
import :ranks;
import :region;
import :repair_blocks;
import :whole_surface;

namespace camber {

namespace {

/// Programmes look at two rings first, an extension at up to eight; a ring more holds what they may move.
constexpr int rings_around = 9;

/// The facets of the surface that are faces of elements of the region, its feature edges and lists, and what the
/// surface knows of its features.
template <int D>
class RegionBoundary {
  public:
    RegionBoundary(const WholeSurface<D>& surface, Region<D>& region) : surface_(surface), region_(region) {
        of_surface_ = surface.places_of(region.vertices);
        for (std::size_t v = 0; v < of_surface_.size(); ++v)
            if (of_surface_[v].valid()) in_region_.emplace_back(of_surface_[v], VertexId(v));
    }

    /// The mesh with them, its nodes and edges numbered as before: facets and feature edges have no others.
    [[nodiscard]] Outcome<Boundary<D>> take(const Execution& execution) {
        const LinearMesh<D>& from = surface_.mesh.linear;
        LinearMesh<D>& mesh = region_.mesh.linear;
        const auto facets = kept<D - 1>(from.facets, facets_);
        std::vector<std::uint32_t> edges;
        const auto feature_edges = kept<1>(from.edges, edges);
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
    /// Whether the region has an edge between all of them; a facet then is a face of an element, or parts two.
    [[nodiscard]] bool has_edges(const auto& simplex) const {
        for (std::size_t i = 0; i < simplex.size(); ++i)
            for (std::size_t j = 0; j < i; ++j)
                if (!find_edge(region_.mesh.edges, simplex[i], simplex[j]).valid()) return false;
        return true;
    }
    template <int K>
    [[nodiscard]] Simplices<K> kept(const Simplices<K>& from, std::vector<std::uint32_t>& rows) const {
        Buffer<SimplexVertices<K>> simplices;
        Buffer<Reference> references;
        Buffer<std::uint32_t> required;
        for (std::size_t s = 0; s < from.size(); ++s) {
            SimplexVertices<K> simplex = from.vertices[s];
            bool is_here = true;
            for (VertexId& v : simplex) {
                const auto at = find(v);
                is_here = at.has_value();
                if (!is_here) break;
                v = *at;
            }
            if (!is_here || !has_edges(simplex)) continue;
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
    std::vector<VertexId> of_surface_;                      ///< of each vertex of the region
    std::vector<std::pair<VertexId, VertexId>> in_region_;  ///< of the surface, rising, and the region
    std::vector<std::uint32_t> facets_;
};

/// Kinds by which what is not all here stays.
template <int D>
Column<EdgeKind> with_fixed_rim(const Region<D>& region) {
    Buffer<EdgeKind> kinds(region.kinds.begin(), region.kinds.end());
    for (std::size_t e = 0; e < kinds.size(); ++e) {
        const auto& [a, b] = region.mesh.edges.vertices[e];
        if (region.outer[a.index()] != 0 && region.outer[b.index()] != 0) kinds[e] = EdgeKind::fixed;
    }
    return kinds;
}

/// What moved, as all know it.
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
    const QuadraticMesh<D>& wanted_mesh = region.mesh;
    auto straight = elevate(wanted_mesh.linear, without_progress(execution));
    if (!straight) return fail(straight.error());
    const auto around = shells(straight->edges, without_progress(execution));
    if (!around) return fail(around.error());
    const std::size_t n = straight->edges.size();
    const Curved<D> curved{{straight->linear.points, wanted_mesh.mid_nodes, with_fixed_rim(region),
                            Buffer<EdgeChange>(n, EdgeChange::optimised)},
                           Buffer<double>(n, 0.0),
                           Buffer<double>(n, 0.0),
                           {}};
    const auto judged = validate(*straight, curved.proposal, options.min_scaled_jacobian, execution);
    if (!judged) return fail(judged.error());
    const auto field =
        field_on(*straight, std::move(region.back_nodes), region.log_metrics, KeptGradients::all, execution);
    if (!field) return fail(field.error());
    const Column<LagrangeNode<D>> extended(Buffer<LagrangeNode<D>>(region.extended));
    const WantedNodes<D> wanted{curved, *around, extended, of.aim, &*field};
    const auto guide = make_guide<D>(*judged, wanted, &*boundary, options.method, execution);
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

/// Of each place by itself, one after the other: so it does not matter which of them are here.
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

}  // namespace

template <int D>
Outcome<RepairStatistics> repair_blocks(const RepairedBlocks<D>& of, const std::vector<GlobalNumber>& not_valid,
                                        const RepairOptions& options, Ranks& ranks, const Execution& execution) {
    auto places = regions_around(of.parts, of.states, not_valid, rings_around, ranks, execution);
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

#define CAMBER_INSTANTIATE(D)                                                                                       \
    template Outcome<RepairStatistics> repair_blocks<D>(const RepairedBlocks<D>&, const std::vector<GlobalNumber>&, \
                                                        const RepairOptions&, Ranks&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
