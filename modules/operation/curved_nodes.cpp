module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>
module camber.operation;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.crossing;
import camber.metric;
import camber.optimisation;
import camber.surface;
import camber.validity;

namespace camber {

namespace {

/// Not a vertex of the star's boundary.
constexpr std::uint32_t no_spoke = std::numeric_limits<std::uint32_t>::max();

}  // namespace

template <int D>
void CurvedNodes<D>::place_inner() {
    begin_spokes();
    put_wanted();
}

template <int D>
bool CurvedNodes<D>::place_others() {
    is_bent_ = old_elements_of(r_, out_.removed.elements, w_.old_elements);
    if (is_bent_) shift_ = 0.5 * (request_.place - old_place_of(request_.origin.value_or(request_.place), {}));
    for (std::size_t s = 0; s < w_.spokes.size(); ++s) {
        Spoke<D>& spoke = w_.spokes[s];
        if (spoke.kind == EdgeKind::fixed || is_free(s)) continue;
        extend(s);
        spoke.wanted = spoke.node = spoke.extended;
    }
    put_on_geometry();
    are_all_placed_ = true;
    const auto is_other = [](const Spoke<D>& s) { return s.kind != EdgeKind::volume; };
    return request_.halves[0].valid() || std::ranges::any_of(w_.spokes, is_other);
}

template <int D>
void CurvedNodes<D>::begin_spokes() {
    w_.spokes.assign(out_.star.boundary.size(), {});
    w_.facets.clear();
    w_.of_facets.clear();
    for (const auto& [facet, opposite] : out_.star.facets) {
        const auto& vertices = r_.mesh.facets.vertices[facet];
        FacetSite<D> site = site_of(r_.mesh, facet);
        site.corners[opposite] = request_.place;
        for (std::uint32_t i = 0; i < D; ++i) {
            if (i == opposite) continue;
            const std::uint32_t at = star_.vertices.find(vertices[i]);
            w_.spokes[at].kind = EdgeKind::surface;
            w_.of_facets.push_back({at, static_cast<std::uint32_t>(w_.facets.size())});
        }
        w_.facets.push_back(site);
    }
    if constexpr (D == 3)
        for (const auto& [line, opposite] : out_.star.lines) {
            Spoke<D>& spoke = w_.spokes[star_.vertices.find(r_.mesh.edges[r_.mesh.lines[line]][1 - opposite])];
            spoke.kind = EdgeKind::ridge;
            spoke.line = line;
        }
    for (const ElementFace& face : out_.star.kept) {
        const auto& vertices = r_.mesh.elements.vertices[face.element];
        const int held = local_vertex(vertices, request_.point);
        for (int i = 0; i <= D; ++i) {
            if (i == held || i == static_cast<int>(face.opposite)) continue;
            const std::uint32_t at = star_.vertices.find(vertices[i]);
            if (at == no_spoke) continue;
            w_.spokes[at].kind = EdgeKind::fixed;
            w_.spokes[at].node = r_.mesh.nodes[r_.mesh.edges_of[face.element][edge_between<D>[i][held]]].point;
        }
    }
}

template <int D>
Vec<D> CurvedNodes<D>::old_place_of(const Vec<D>& p, VertexId v) const {
    const auto holders = std::span(out_.removed.elements).first(request_.holders);
    const OldElement<D>* best = nullptr;
    for (const OldElement<D>& piece : w_.old_elements) {
        if (best != nullptr && !(piece.size > best->size)) continue;
        if (v.valid() && local_vertex(r_.mesh.elements.vertices[piece.element], v) < 0) continue;
        if (std::ranges::find(holders, piece.element) != holders.end()) best = &piece;
    }
    return best == nullptr ? old_map(w_.old_elements, p) : old_map(*best, p);
}

template <int D>
EdgeId CurvedNodes<D>::edge_there(VertexId v) const {
    if (!request_.point.valid()) return {};
    for (const ElementId e : out_.removed.elements) {
        const auto& vertices = r_.mesh.elements.vertices[e];
        const int from = local_vertex(vertices, request_.point);
        const int to = local_vertex(vertices, v);
        if (from >= 0 && to >= 0) return r_.mesh.edges_of[e][edge_between<D>[from][to]];
    }
    return {};
}

template <int D>
std::optional<Vec<D>> CurvedNodes<D>::node_there(const Vec<D>& origin, VertexId v) const {
    if (!request_.point.valid() || origin != r_.mesh.points[request_.point]) return {};
    const EdgeId edge = edge_there(v);
    return edge.valid() ? std::optional(r_.mesh.nodes[edge].point) : std::nullopt;
}

template <int D>
void CurvedNodes<D>::extend(std::size_t s) {
    Spoke<D>& spoke = w_.spokes[s];
    if (spoke.is_extended) return;
    spoke.is_extended = true;
    const Vec<D> origin = request_.origin.value_or(request_.place);
    const Vec<D> half = midpoint(origin, end(s));
    if (const auto node = node_there(origin, vertex(s)))
        spoke.extended = *node;
    else if (!is_bent_)
        spoke.extended = middle(s);
    else if (spoke.kind == EdgeKind::volume)
        spoke.extended = old_place_of(half, vertex(s)) + shift_;
    else
        spoke.extended = old_place_on_sides(s, half) + 0.5 * (request_.place - old_place_on_sides(s, origin));
}

template <int D>
Vec<D> CurvedNodes<D>::old_place_on_sides(std::size_t s, const Vec<D>& p) const {
    OldPlace<D> best{p};
    const auto [a, b] = request_.halves;
    // What has the spoke's end, and the edge that is split, has X whatever else lies there too.
    const auto rank = [&](const auto& simplex) {
        const bool is_split = a.valid() && local_vertex(simplex, a) >= 0 && local_vertex(simplex, b) >= 0;
        return (local_vertex(simplex, vertex(s)) >= 0 ? 1 : 0) + (is_split ? 2 : 0);
    };
    if constexpr (D == 3)
        if (w_.spokes[s].kind == EdgeKind::ridge) {
            for (const LineId line : out_.removed.lines) {
                const EdgeId edge = r_.mesh.lines[line];
                const auto& [from, to] = r_.mesh.edges[edge];
                look_at<D, 1>({r_.mesh.points[from], r_.mesh.points[to]}, {r_.mesh.nodes[edge].point}, p,
                              rank(r_.mesh.edges[edge]), best);
            }
            return best.point;
        }
    for (const FacetId f : out_.removed.facets) {
        const auto is_of = [&](const auto& of) {
            return of[0] == s && w_.facets[of[1]].reference == r_.mesh.facets.references[f];
        };
        if (std::ranges::none_of(w_.of_facets, is_of)) continue;
        const NodalFacet<D> facet = nodal_facet(r_.mesh, f);
        std::array<Vec<D>, D> corners;
        std::array<Vec<D>, edges_per_simplex<D - 1>> nodes;
        std::copy_n(facet.nodes.begin(), D, corners.begin());
        std::copy_n(facet.nodes.begin() + D, nodes.size(), nodes.begin());
        look_at<D, D - 1>(corners, nodes, p, rank(r_.mesh.facets.vertices[f]), best);
    }
    return best.point;
}

template <int D>
void CurvedNodes<D>::put_on_geometry() {
    if (!goal_.geometry && goal_.wanted.empty()) return;
    for (std::size_t s = 0; s < w_.spokes.size(); ++s) {
        Spoke<D>& spoke = w_.spokes[s];
        if (spoke.kind != EdgeKind::surface && spoke.kind != EdgeKind::ridge) continue;
        const std::optional<Vec<D>> target = target_on_geometry(s);
        if (!target) continue;
        if (request_.share == 1 && !goal_.wanted.empty())
            spoke.extended = *target;  // to the bit
        else
            spoke.extended += request_.share * (*target - spoke.extended);
        spoke.wanted = spoke.node = spoke.extended;
    }
}

template <int D>
std::optional<Vec<D>> CurvedNodes<D>::target_on_geometry(std::size_t s) const {
    if (!goal_.wanted.empty()) return goal_.wanted[edge_there(vertex(s))].point;
    const auto& geometry = *goal_.geometry;
    const LineId line = w_.spokes[s].line;
    EdgeSite<D> site{{}, w_.spokes[s].kind, {request_.place, end(s)}, {}};
    bool has_surface = false;
    for (const auto& [of, facet] : w_.of_facets) {
        if (of != s) continue;
        site.facets.push_back(w_.facets[facet]);
        has_surface |= geometry->has_surface_at(w_.facets[facet]);
    }
    if (r_.mesh.is_embedded(line))
        return on_embedded_curve(goal_, site, r_.mesh.line_references[line], site.middle()).point;
    return has_surface ? std::optional(node_without_cusp<D>(*geometry, site)) : std::nullopt;
}

template <int D>
void CurvedNodes<D>::put_wanted() {
    const bool is_closed_form = goal_.wanted.empty() && !goal_.search;
    if (is_closed_form) {
        take_bent(request_.bent);
        take_bent(w_.bent);
    }
    w_.free.clear();
    for (std::uint32_t s = 0; s < w_.spokes.size(); ++s)
        if (is_free(s) && !(w_.spokes[s].length >= 0)) w_.free.push_back(s);
    if (w_.free.empty()) return;
    if (is_closed_form) return bend_free();
    return goal_.wanted.empty() ? search_free() : take_wanted();
}

template <int D>
void CurvedNodes<D>::take_wanted() {
    for (const std::uint32_t s : w_.free)
        w_.spokes[s].wanted = w_.spokes[s].node = goal_.wanted[edge_there(vertex(s))].point;
}

template <int D>
void CurvedNodes<D>::take_bent(const std::vector<BentSpoke<D>>& bent) {
    for (const BentSpoke<D>& known : bent)
        if (const std::uint32_t s = star_.vertices.find(known.vertex); s != no_spoke && is_free(s))
            put_bent(s, known.offset, known.length);
}

template <int D>
void CurvedNodes<D>::put_bent(std::size_t s, const Vec<D>& offset, double length) {
    Spoke<D>& spoke = w_.spokes[s];
    spoke.wanted = spoke.node = spoke.measured = middle(s) + offset;
    spoke.length = length;
}

template <int D>
void CurvedNodes<D>::bend_free() {
    w_.chords.clear();
    w_.ends.clear();
    for (const std::uint32_t s : w_.free) {
        const VertexId v = vertex(s);
        w_.chords.push_back(end(s) - request_.place);
        w_.ends.push_back(
            {sight_of(request_.metric, request_.gradient), sight_of(r_.vertices.metrics[v], r_.vertices.gradients[v])});
    }
    w_.offsets.resize(w_.free.size());
    w_.lengths.resize(w_.free.size());
    bent_edges<D>(w_.chords, w_.ends, goal_.accuracy, w_.offsets, w_.lengths);
    for (std::size_t i = 0; i < w_.free.size(); ++i) {
        put_bent(w_.free[i], w_.offsets[i], w_.lengths[i]);
        w_.bent.push_back({vertex(w_.free[i]), w_.offsets[i], w_.lengths[i]});
    }
}

template <int D>
void CurvedNodes<D>::search_free() {
    const auto& [options, rules] = *goal_.search;
    w_.searched.clear();
    for (const std::uint32_t s : w_.free) {
        // From the lower end by coordinates, whichever is the point: where minima are several an edge has one
        // target.
        const VertexId v = vertex(s);
        const BackVertex<D> point{request_.place, request_.metric.log_metric};
        const BackVertex<D> other{end(s), r_.vertices.metrics[v].log_metric};
        if (request_.place.c < end(s).c)
            w_.searched.push_back({point, other, request_.metric.back});
        else
            w_.searched.push_back({other, point, r_.vertices.metrics[v].back});
    }
    w_.found.resize(w_.free.size());
    minimise_edges<D>(goal_.field, w_.searched, rules, options, w_.found);
    for (std::size_t i = 0; i < w_.free.size(); ++i)
        w_.spokes[w_.free[i]].wanted = w_.spokes[w_.free[i]].node = w_.found[i].node.point;
}

#define CAMBER_INSTANTIATE(D)                     \
    template void CurvedNodes<D>::place_inner();  \
    template bool CurvedNodes<D>::place_others(); \
    template EdgeId CurvedNodes<D>::edge_there(VertexId) const;

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
