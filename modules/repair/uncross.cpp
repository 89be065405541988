// Projection onto a prescribed geometry, and removal of boundary crossings.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.repair;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.crossing;
import camber.surface;

namespace camber {

namespace {

template <int D>
struct Sites {
    QuadraticMesh<D> mesh;
    Column<EdgeKind> kinds;
    Incidence<FacetId> facets;

    [[nodiscard]] EdgeSite<D> operator[](EdgeId edge) const {
        const auto& [a, b] = mesh.edges.vertices[edge];
        return {edge,
                kinds[edge],
                {mesh.linear.points[a], mesh.linear.points[b]},
                facet_sites<D>(mesh.linear, facets[edge])};
    }
    [[nodiscard]] bool is_prescribed(EdgeId edge, const Geometry<D>& geometry) const {
        return kinds[edge] != EdgeKind::volume && std::ranges::all_of(facets[edge], [&](FacetId f) {
                   return geometry->prescribes(mesh.linear.facets.references[f]);
               });
    }
};

template <int D>
Sym<D> outer(const Vec<D>& v) {
    Sym<D> s;
    for (int i = 0; i < D; ++i)
        for (int j = i; j < D; ++j) s(i, j) = v[i] * v[j];
    return s;
}

template <int D>
Vec<D> tangent_at(const Geometry<D>& geometry, const SurfacePoint<D>& foot, const EdgeSite<D>& site) {
    if (foot.parameters)
        if (const auto there = geometry->evaluate(foot.entity, *foot.parameters); there && norm(there->tangents[0]) > 0)
            return normalised(there->tangents[0]);
    return normalised(site.ends[1] - site.ends[0]);
}

template <int D>
GeometryFoot<D> foot_on(const Geometry<D>& geometry, const EdgeSite<D>& site, const Vec<D>& p) {
    const SurfacePoint<D> foot = geometry->on_edge(site, p);
    if (norm(foot.normal) > 0) return {foot.point, outer<D>(foot.normal)};
    return {foot.point, Sym<D>::identity() - outer<D>(tangent_at(geometry, foot, site))};
}

template <int D>
Outcome<FootOnGeometry<D>> feet_of(const Geometry<D>& geometry, const Column<EdgeKind>& boundary_kinds,
                                   const QuadraticMesh<D>& mesh, const Execution& execution, const auto& is_chosen) {
    auto facets = facet_shells(mesh.edges, execution);
    if (!facets) return fail(facets.error());
    return FootOnGeometry<D>([geometry, is_chosen, sites = Sites<D>{mesh, boundary_kinds, std::move(*facets)}](
                                 EdgeId edge, const Vec<D>& p) {
        if (!is_chosen(sites, edge)) return GeometryFoot<D>{p, Sym<D>::identity()};
        return foot_on(geometry, sites[edge], p);
    });
}

}  // namespace

template <int D>
Outcome<FootOnGeometry<D>> feet_on(const Geometry<D>& geometry, const Column<EdgeKind>& boundary_kinds,
                                   const QuadraticMesh<D>& mesh, const Execution& execution) {
    return feet_of(geometry, boundary_kinds, mesh, execution,
                   [geometry](const Sites<D>& sites, EdgeId edge) { return sites.is_prescribed(edge, geometry); });
}

template <int D>
Outcome<FootOnGeometry<D>> feet_on_any(const Geometry<D>& geometry, const Column<EdgeKind>& boundary_kinds,
                                       const QuadraticMesh<D>& mesh, const Execution& execution) {
    return feet_of(geometry, boundary_kinds, mesh, execution, [](const Sites<D>& sites, EdgeId edge) {
        return sites.kinds[edge] == EdgeKind::surface || sites.kinds[edge] == EdgeKind::ridge;
    });
}

namespace {

using EdgesAtVertices = std::vector<std::pair<VertexId, EdgeId>>;

template <int D>
EdgesAtVertices edges_at_vertices(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds) {
    EdgesAtVertices all;
    for (std::size_t e = 0; e < kinds.size(); ++e)
        if (kinds[e] != EdgeKind::volume)
            for (const VertexId v : mesh.edges.vertices[e]) all.emplace_back(v, EdgeId(e));
    std::ranges::sort(all);
    return all;
}

template <int D>
std::optional<EdgeId> edge_to_follow(const Geometry<D>& geometry, const Sites<D>& sites, const EdgesAtVertices& edges,
                                     VertexKind kind, VertexId v) {
    if (kind != VertexKind::surface && kind != VertexKind::ridge) return {};
    const EdgeKind followed = kind == VertexKind::ridge ? EdgeKind::ridge : EdgeKind::surface;
    std::optional<EdgeId> found;
    GeometryEntity entity;
    for (const auto& [vertex, edge] : std::ranges::equal_range(edges, v, {}, &EdgesAtVertices::value_type::first)) {
        if (!sites.is_prescribed(edge, geometry)) return {};
        if (sites.kinds[edge] != followed) continue;
        const GeometryEntity there = geometry->entity_at_edge(sites[edge]);
        if (there.kind == GeometryKind::none || (found && there != entity)) return {};
        found = edge;
        entity = there;
    }
    return found;
}

}  // namespace

template <int D>
Outcome<VertexOnGeometry<D>> vertex_feet_on(const Geometry<D>& geometry, const Features<D>& features,
                                            const QuadraticMesh<D>& mesh, const Execution& execution) {
    auto facets = facet_shells(mesh.edges, execution);
    if (!facets) return fail(facets.error());
    return VertexOnGeometry<D>([geometry, kinds = features.vertex_kinds,
                                sites = Sites<D>{mesh, features.edge_kinds, std::move(*facets)},
                                edges = edges_at_vertices(mesh, features.edge_kinds)](VertexId v, const Vec<D>& p) {
        const auto edge = edge_to_follow(geometry, sites, edges, kinds[v], v);
        return edge ? foot_on(geometry, sites[*edge], p) : GeometryFoot<D>{p, Sym<D>::identity()};
    });
}

template <int D>
Outcome<Column<LagrangeNode<D>>> mesh_nodes_on(const Geometry<D>& geometry, const Column<EdgeKind>& boundary_kinds,
                                               const QuadraticMesh<D>& mesh, RequiredBoundary required,
                                               const Execution& execution) {
    auto facets = facet_shells(mesh.edges, without_progress(execution));
    if (!facets) return fail(facets.error());
    const Sites<D> sites{mesh, boundary_kinds, std::move(*facets)};
    const Column<EdgeKind> kinds = kinds_with_required_fixed(mesh, boundary_kinds, required);
    auto nodes = map_each(execution, mesh.edges.size(), [&](std::size_t e) -> LagrangeNode<D> {
        const EdgeId edge(e);
        if (kinds[e] == EdgeKind::fixed || !sites.is_prescribed(edge, geometry)) return mesh.mid_nodes[e];
        return {geometry->on_edge(sites[edge], mesh.mid_nodes[e].point).point};
    });
    if (!nodes) return fail(nodes.error());
    return Column<LagrangeNode<D>>(std::move(*nodes));
}

namespace {

using FacetPairs = std::vector<std::pair<FacetId, FacetId>>;

FacetPairs crossing_pairs(const Crossings& crossings) {
    FacetPairs pairs;
    for (const FacetCrossing& found : crossings.found)
        if (found.verdict == Crossing::crossing) pairs.emplace_back(found.first, found.second);
    return pairs;
}

/// Finds positions without crossings, as shares of the way from the chord midpoint (0) to the initial position
/// (`whole`).
template <int D>
class Uncrossing {
  public:
    Uncrossing(const QuadraticMesh<D>& mesh, std::span<const Vec<D>> points, std::span<const LagrangeNode<D>> targets,
               std::span<const EdgeKind> kinds)
        : mesh_(mesh), points_(points), targets_(targets), kinds_(kinds), nodes_(targets.begin(), targets.end()) {}

    [[nodiscard]] Outcome<UncrossedNodes<D>> run(const Execution& execution) {
        auto found = find(execution);
        if (!found) return fail(found.error());
        UncrossedNodes<D> out;
        out.crossings = std::move(*found);
        if (out.crossings.crossing == 0) return out;
        found = out.crossings;
        while (lower(crossing_pairs(*found))) {
            found = find(execution);
            if (!found) return fail(found.error());
        }
        unresolvable_ = crossing_pairs(*found);
        raise_all();
        for (const auto& [edge, share] : shares_)
            if (share < whole) out.nodes.emplace_back(edge, nodes_[edge.index()]);
        found = find(execution);
        if (!found) return fail(found.error());
        out.crossings = std::move(*found);
        return out;
    }

  private:
    static constexpr int whole = 256;
    static constexpr int lowering = whole / 8, raising = whole / 16;

    [[nodiscard]] Outcome<Crossings> find(const Execution& execution) const {
        return find_crossings<D>(mesh_, points_, nodes_, execution);
    }
    [[nodiscard]] LagrangeNode<D> node_at(EdgeId edge, int share) const {
        const LagrangeNode<D>& target = targets_[edge.index()];
        if (share == whole) return target;
        const auto& [a, b] = mesh_.edges.vertices[edge];
        const Vec<D> middle = midpoint(points_[a.index()], points_[b.index()]);
        return share == 0 ? LagrangeNode<D>{middle}
                          : LagrangeNode<D>{middle + (static_cast<double>(share) / whole) * (target.point - middle)};
    }
    [[nodiscard]] bool is_movable(EdgeId edge) const {
        return kinds_[edge.index()] != EdgeKind::fixed && node_at(edge, 0) != targets_[edge.index()];
    }
    void put(EdgeId edge, int share) {
        shares_[edge] = share;
        nodes_[edge.index()] = node_at(edge, share);
    }
    bool lower(const FacetPairs& pairs) {
        std::vector<EdgeId> edges;
        for (const auto& [f, g] : pairs)
            for (const FacetId facet : {f, g})
                for (const EdgeId edge : mesh_.edges.of_facets[facet]) edges.push_back(edge);
        std::ranges::sort(edges);
        edges.erase(std::ranges::unique(edges).begin(), edges.end());
        bool any = false;
        for (const EdgeId edge : edges) {
            if (!is_movable(edge)) continue;
            const auto at = shares_.find(edge);
            const int share = at == shares_.end() ? whole : at->second;
            if (share == 0) continue;
            put(edge, share - lowering);
            any = true;
        }
        return any;
    }

    [[nodiscard]] NodalFacet<D> nodal(FacetId f) const { return nodal_facet<D>(mesh_, points_, nodes_, f); }
    void find_facets_of_edges() {
        for (const auto& [edge, share] : shares_) facets_[edge];
        for (std::size_t f = 0; f < mesh_.linear.facets.size(); ++f) {
            grid_.insert(FacetId(f), box_of(nodal(FacetId(f))));
            for (const EdgeId edge : mesh_.edges.of_facets[f])
                if (const auto at = facets_.find(edge); at != facets_.end()) at->second.emplace_back(f);
        }
    }
    [[nodiscard]] bool crosses(EdgeId edge) {
        for (const FacetId f : facets_.at(edge)) {
            const NodalFacet<D> facet = nodal(f);
            if (crossing_of_itself(facet) == Crossing::crossing && !is_unresolvable(f, f)) return true;
            const Box<D> box = box_of(facet);
            grid_.meeting(box, near_);
            for (const FacetId g : near_) {
                if (g == f) continue;
                const NodalFacet<D> other = nodal(g);
                if (!box_of(other).meets(box) || is_unresolvable(f, g)) continue;
                // The order is that of `find_crossings`, because with limited work a pair may be decidable in one order
                // only.
                if ((f < g ? crossing_of(facet, other) : crossing_of(other, facet)) == Crossing::crossing) return true;
            }
        }
        return false;
    }
    [[nodiscard]] bool is_unresolvable(FacetId f, FacetId g) const {
        return std::ranges::binary_search(unresolvable_, std::pair(std::min(f, g), std::max(f, g)));
    }
    bool raise(EdgeId edge, int share) {
        const int before = shares_.at(edge);
        put(edge, share);
        if (crosses(edge)) return put(edge, before), false;
        for (const FacetId f : facets_.at(edge)) grid_.insert(f, box_of(nodal(f)));
        return true;
    }
    void raise_all() {
        find_facets_of_edges();
        for (int step = raising; step >= 1; step /= 2) {
            for (bool any = true; any;) {
                any = false;
                for (const auto& [edge, share] : shares_)
                    if (share < whole && raise(edge, std::min(share + step, whole))) any = true;
            }
        }
    }

    const QuadraticMesh<D>& mesh_;
    std::span<const Vec<D>> points_;
    std::span<const LagrangeNode<D>> targets_;
    std::span<const EdgeKind> kinds_;
    Buffer<LagrangeNode<D>> nodes_;
    std::map<EdgeId, int> shares_;
    std::map<EdgeId, std::vector<FacetId>> facets_;
    FacetGrid<D> grid_;
    FacetPairs unresolvable_;
    std::vector<FacetId> near_;
};

template <int D>
Outcome<RepairGuide<D>> guide_or_own(const RepairGuide<D>& guide, const JudgedProposal<D>& judged,
                                     const Incidence<ElementId>& elements_of_edge, const Execution& execution) {
    if (guide.shells.size() > 0) return guide;
    auto result = is_standalone_surface(judged.mesh().linear)
                      ? Outcome<RepairGuide<D>>(RepairGuide<D>{elements_of_edge})
                      : guide_from_mesh(judged, elements_of_edge, execution);
    if (!result) return result;
    result->onto = guide.onto;
    result->vertices_onto = guide.vertices_onto;
    result->surface = guide.surface;
    return result;
}

template <int D>
struct Moved {
    JudgedProposal<D> judged;
    bool is_broken = false;
};
template <int D>
Outcome<Moved<D>> with_nodes(const JudgedProposal<D>& judged, const UncrossedNodes<D>& found,
                             const Incidence<ElementId>& shells, const Execution& execution) {
    MovedMesh<D> moved(judged);
    for (const auto& [edge, node] : found.nodes) moved.nodes.set(edge, node);
    auto again = judge_moved(moved, shells, judged, execution);
    if (!again) return fail(again.error());
    bool is_broken = false;
    for (const auto& [edge, node] : found.nodes)
        for (const ElementId e : shells[edge])
            is_broken = is_broken || again->validation().verdicts[e] != Verdict::valid;
    return Moved<D>{std::move(*again), is_broken};
}

}  // namespace

template <int D>
Outcome<UncrossedNodes<D>> uncrossed_nodes(const QuadraticMesh<D>& mesh, std::span<const Vec<D>> points,
                                           std::span<const LagrangeNode<D>> mid_nodes, std::span<const EdgeKind> kinds,
                                           const Execution& execution) {
    return guarded([&] { return Uncrossing<D>(mesh, points, mid_nodes, kinds).run(execution); });
}

template <int D>
Outcome<UncrossedWalls<D>> uncross_walls(const JudgedProposal<D>& judged, const RepairGuide<D>& guide,
                                         const RepairOptions& options, const Execution& execution) {
    constexpr int rounds = 3;
    const Execution quiet = without_progress(execution);
    return guarded([&]() -> Outcome<UncrossedWalls<D>> {
        const Proposal<D>& before = judged.proposal();
        std::optional<Incidence<ElementId>> elements_of_edge;
        JudgedProposal<D> now = judged;
        std::vector<EdgeId> edges;
        std::optional<Crossings> crossings;
        for (int round = 0; round < rounds; ++round) {
            const Proposal<D>& proposal = now.proposal();
            auto found = uncrossed_nodes<D>(now.mesh(), proposal.points.view(), proposal.mid_nodes.view(),
                                            before.kinds.view(), quiet);
            if (!found) return fail(found.error());
            crossings = std::move(found->crossings);
            if (found->nodes.empty()) break;
            for (const auto& [edge, node] : found->nodes) edges.push_back(edge);
            if (!elements_of_edge) {
                auto result = guide.shells.size() > 0 ? Outcome<Incidence<ElementId>>(guide.shells)
                                                      : elements_of_edges(judged.mesh(), quiet);
                if (!result) return fail(result.error());
                elements_of_edge = std::move(*result);
            }
            auto moved = with_nodes<D>(now, *found, *elements_of_edge, quiet);
            if (!moved) return fail(moved.error());
            now = std::move(moved->judged);
            if (!moved->is_broken) break;
            // The last iteration fixes no node, because elements with straight edges are valid wherever the straight
            // mesh is valid.
            Buffer<EdgeKind> kinds(before.kinds.begin(), before.kinds.end());
            if (round + 1 < rounds)
                for (const EdgeId edge : edges) kinds[edge.index()] = EdgeKind::fixed;
            const auto by = guide_or_own(guide, now, *elements_of_edge, quiet);
            if (!by) return fail(by.error());
            auto repaired = repair_or_straighten(now.with_kinds(std::move(kinds)), *by, options, quiet);
            if (!repaired) return fail(repaired.error());
            now = repaired->judged.with_kinds(before.kinds);
            crossings.reset();
        }
        std::ranges::sort(edges);
        edges.erase(std::ranges::unique(edges).begin(), edges.end());
        MoveBackStatistics<D> moved;
        for (const EdgeId edge : edges) moved.add(before.mid_nodes[edge], now.proposal().mid_nodes[edge]);
        return UncrossedWalls<D>{std::move(now), moved, std::move(crossings)};
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                      \
    template Outcome<FootOnGeometry<D>> feet_on<D>(const Geometry<D>&, const Column<EdgeKind>&,                    \
                                                   const QuadraticMesh<D>&, const Execution&);                     \
    template Outcome<FootOnGeometry<D>> feet_on_any<D>(const Geometry<D>&, const Column<EdgeKind>&,                \
                                                       const QuadraticMesh<D>&, const Execution&);                 \
    template Outcome<VertexOnGeometry<D>> vertex_feet_on<D>(const Geometry<D>&, const Features<D>&,                \
                                                            const QuadraticMesh<D>&, const Execution&);            \
    template Outcome<Column<LagrangeNode<D>>> mesh_nodes_on<D>(                                                    \
        const Geometry<D>&, const Column<EdgeKind>&, const QuadraticMesh<D>&, RequiredBoundary, const Execution&); \
    template Outcome<UncrossedNodes<D>> uncrossed_nodes<D>(const QuadraticMesh<D>&, std::span<const Vec<D>>,       \
                                                           std::span<const LagrangeNode<D>>,                       \
                                                           std::span<const EdgeKind>, const Execution&);           \
    template Outcome<UncrossedWalls<D>> uncross_walls<D>(const JudgedProposal<D>&, const RepairGuide<D>&,          \
                                                         const RepairOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
