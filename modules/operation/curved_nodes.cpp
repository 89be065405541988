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
import camber.metric;
import camber.edge_optimisation;
import camber.validity;
import camber.crossing;
import camber.optimisation;
import camber.surface;

namespace camber {

namespace {

// Curves of a cavity before the operation. A removed element maps a point X of its straight shape to the point x(X) = X
// + Σ 4 λ_i λ_j d_k of its curved shape. The sum is over the edges k = (i, j). λ: barycentric coordinates of X. d_k:
// offset of the node of edge k from the chord middle.

std::array<Vec<2>, 2> dual(const Mat<2>& m) {
    const auto& [a, b] = m.column;
    return {Vec<2>{{b[1], -b[0]}}, Vec<2>{{-a[1], a[0]}}};
}
std::array<Vec<3>, 3> dual(const Mat<3>& m) {
    const auto& [a, b, c] = m.column;
    return {cross(b, c), cross(c, a), cross(a, b)};
}

/// Stores the elements of nonzero straight volume in `pieces`. Returns false if all elements are straight up to
/// rounding.
template <int D>
bool old_elements_of(const Adaptation<D>& r, const std::vector<ElementId>& elements,
                     std::vector<OldElement<D>>& pieces) {
    pieces.clear();
    const auto is_bent = [&](EdgeId edge) {
        constexpr double rounding = 1e-14;  // largest offset of a node from the chord middle that counts as 0, relative
                                            // to the chord
        const auto& [a, b] = r.mesh.edges[edge];
        const double chord = norm_squared(r.mesh.points[b] - r.mesh.points[a]);
        return norm_squared(offset_of(r.mesh, edge)) > rounding * rounding * chord;
    };
    if (std::ranges::none_of(elements, [&](ElementId e) { return std::ranges::any_of(r.mesh.edges_of[e], is_bent); }))
        return false;
    for (const ElementId e : elements) {
        const QuadraticNodes<D> nodes = nodes_of(r.mesh, e);
        OldElement<D> piece;
        piece.element = e;
        piece.origin = nodes[0];
        Mat<D> sides;
        for (int i = 0; i < D; ++i) sides.column[i] = nodes[i + 1] - nodes[0];
        const double volume = det(sides);
        piece.size = std::abs(volume);
        piece.gradients = dual(sides);
        for (Vec<D>& gradient : piece.gradients) gradient = gradient / volume;
        for (int k = 0; k < edges_per_simplex<D>; ++k) {
            const auto [i, j] = local_edges<D>[k];
            piece.offsets[k] = nodes[D + 1 + k] - midpoint(nodes[i], nodes[j]);
        }
        if (volume != 0) pieces.push_back(piece);
    }
    return true;
}

template <int D>
std::array<double, D + 1> place_in(const OldElement<D>& piece, const Vec<D>& p) {
    std::array<double, D + 1> xi{};
    xi[0] = 1;
    for (int i = 0; i < D; ++i) {
        xi[i + 1] = dot(piece.gradients[i], p - piece.origin);
        xi[0] -= xi[i + 1];
    }
    return xi;
}

template <int D>
Vec<D> old_map(const OldElement<D>& piece, const Vec<D>& p) {
    std::array<double, D + 1> xi = place_in(piece, p);
    if (*std::ranges::min_element(xi) < 0) {
        double sum = 0;
        for (double& x : xi) sum += x = std::max(x, 0.0);
        for (double& x : xi) x /= sum;
    }
    Vec<D> out = p;
    for (int k = 0; k < edges_per_simplex<D>; ++k) out += edge_shape<D>(xi, k) * piece.offsets[k];
    return out;
}

/// Maps `p` by the piece that contains `p`, otherwise by the piece in which the smallest barycentric coordinate of `p`
/// is largest.
template <int D>
Vec<D> old_map(const std::vector<OldElement<D>>& pieces, const Vec<D>& p) {
    const OldElement<D>* best = nullptr;
    double most = -std::numeric_limits<double>::infinity();
    for (const OldElement<D>& piece : pieces) {
        const auto xi = place_in(piece, p);
        const double least = *std::ranges::min_element(xi);
        if (!(least > most)) continue;
        most = least;
        best = &piece;
        if (least >= 0) break;
    }
    return best == nullptr ? p : old_map(*best, p);
}

template <int D>
struct OldPlace {
    Vec<D> point;
    int rank = 0;
    double least = -std::numeric_limits<double>::infinity();
};
/// Replaces `best` by the image of `p` on this boundary simplex if the simplex has a higher `rank`. If ranks are equal,
/// its smallest barycentric coordinate must be larger.
template <int D, int K>
void look_at(const std::array<Vec<D>, K + 1>& corners, const std::array<Vec<D>, edges_per_simplex<K>>& nodes,
             const Vec<D>& p, int rank, OldPlace<D>& best) {
    if (rank < best.rank) return;
    std::array<double, K + 1> xi{};
    const Vec<D> u = corners[1] - corners[0];
    const Vec<D> x = p - corners[0];
    if constexpr (K == 1) {
        xi[1] = dot(u, x) / norm_squared(u);
    } else {
        const Vec<D> v = corners[2] - corners[0];
        const Vec<D> n = cross(u, v);  // dot products of u, v and x would be inaccurate for thin facets
        xi[1] = dot(cross(x, v), n) / norm_squared(n);
        xi[2] = dot(cross(u, x), n) / norm_squared(n);
    }
    xi[0] = 1;
    for (int i = 1; i <= K; ++i) xi[0] -= xi[i];
    const double least = *std::ranges::min_element(xi);
    if (!(rank > best.rank ? std::isfinite(least) : least > best.least))
        return;  // if the simplex is degenerate, `least` is infinite or NaN
    best = {p, rank, least};
    double sum = 0;
    for (double& c : xi) sum += c = std::max(c, 0.0);
    for (int k = 0; k < edges_per_simplex<K>; ++k) {
        const auto [i, j] = local_edges<K>[k];
        best.point += edge_shape<K>(xi, k) / (sum * sum) * (nodes[k] - midpoint(corners[i], corners[j]));
    }
}

constexpr std::uint32_t no_spoke = std::numeric_limits<std::uint32_t>::max();

}  // namespace

template <int D>
void CurvedNodes<D>::place_inner() {
    begin_spokes();
    place_targets();
}

template <int D>
bool CurvedNodes<D>::place_others() {
    is_bent_ = old_elements_of(r_, out_.removed.elements, w_.old_elements);
    if (is_bent_) shift_ = 0.5 * (request_.place - old_place_of(request_.origin.value_or(request_.place), {}));
    for (std::size_t s = 0; s < w_.spokes.size(); ++s) {
        Spoke<D>& spoke = w_.spokes[s];
        if (spoke.kind == EdgeKind::fixed || is_free(s)) continue;
        extend(s);
        spoke.target = spoke.node = spoke.extended;
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
    for (const ElementFace& face : out_.star.preserved) {
        const auto& vertices = r_.mesh.elements.vertices[face.element];
        const int point_index = local_vertex(vertices, request_.point);
        for (int i = 0; i <= D; ++i) {
            if (i == point_index || i == static_cast<int>(face.opposite)) continue;
            const std::uint32_t at = star_.vertices.find(vertices[i]);
            if (at == no_spoke) continue;
            w_.spokes[at].kind = EdgeKind::fixed;
            w_.spokes[at].node = r_.mesh.nodes[r_.mesh.edges_of[face.element][edge_between<D>[i][point_index]]].point;
        }
    }
}

template <int D>
Vec<D> CurvedNodes<D>::old_place_of(const Vec<D>& p, VertexId v) const {
    const auto fixed_elements = std::span(out_.removed.elements).first(request_.fixed_element_count);
    const OldElement<D>* best = nullptr;
    for (const OldElement<D>& piece : w_.old_elements) {
        if (best != nullptr && !(piece.size > best->size)) continue;
        if (v.valid() && local_vertex(r_.mesh.elements.vertices[piece.element], v) < 0) continue;
        if (std::ranges::find(fixed_elements, piece.element) != fixed_elements.end()) best = &piece;
    }
    return best == nullptr ? old_map(w_.old_elements, p) : old_map(*best, p);
}

template <int D>
EdgeId CurvedNodes<D>::target_edge(VertexId v) const {
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
std::optional<Vec<D>> CurvedNodes<D>::old_edge_node(const Vec<D>& origin, VertexId v) const {
    if (!request_.point.valid() || origin != r_.mesh.points[request_.point]) return {};
    const EdgeId edge = target_edge(v);
    return edge.valid() ? std::optional(r_.mesh.nodes[edge].point) : std::nullopt;
}

template <int D>
void CurvedNodes<D>::extend(std::size_t s) {
    Spoke<D>& spoke = w_.spokes[s];
    if (spoke.is_extended) return;
    spoke.is_extended = true;
    const Vec<D> origin = request_.origin.value_or(request_.place);
    const Vec<D> half = midpoint(origin, end(s));
    if (const auto node = old_edge_node(origin, vertex(s)))
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
    // Several simplices may overlap at `p`. Simplices that contain the spoke's end get rank 1 more, those that contain
    // the split edge 2 more.
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
    if (!goal_.geometry && goal_.target_nodes.empty()) return;
    for (std::size_t s = 0; s < w_.spokes.size(); ++s) {
        Spoke<D>& spoke = w_.spokes[s];
        if (spoke.kind != EdgeKind::surface && spoke.kind != EdgeKind::ridge) continue;
        const std::optional<Vec<D>> target = target_on_geometry(s);
        if (!target) continue;
        if (request_.share == 1 && !goal_.target_nodes.empty())
            spoke.extended = *target;  // the formula below would give `target` with a rounding error
        else
            spoke.extended += request_.share * (*target - spoke.extended);
        spoke.target = spoke.node = spoke.extended;
    }
}

template <int D>
std::optional<Vec<D>> CurvedNodes<D>::target_on_geometry(std::size_t s) const {
    if (!goal_.target_nodes.empty()) return goal_.target_nodes[target_edge(vertex(s))].point;
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
void CurvedNodes<D>::place_targets() {
    const bool is_closed_form = goal_.target_nodes.empty() && !goal_.search;
    if (is_closed_form) {
        take_bent(request_.bent);
        take_bent(w_.bent);
    }
    w_.free.clear();
    for (std::uint32_t s = 0; s < w_.spokes.size(); ++s)
        if (is_free(s) && !(w_.spokes[s].length >= 0)) w_.free.push_back(s);
    if (w_.free.empty()) return;
    if (is_closed_form) return bend_free();
    return goal_.target_nodes.empty() ? search_free() : take_targets();
}

template <int D>
void CurvedNodes<D>::take_targets() {
    for (const std::uint32_t s : w_.free)
        w_.spokes[s].target = w_.spokes[s].node = goal_.target_nodes[target_edge(vertex(s))].point;
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
    spoke.target = spoke.node = spoke.measured = middle(s) + offset;
    spoke.length = length;
}

template <int D>
void CurvedNodes<D>::bend_free() {
    w_.chords.clear();
    w_.ends.clear();
    for (const std::uint32_t s : w_.free) {
        const VertexId v = vertex(s);
        w_.chords.push_back(end(s) - request_.place);
        w_.ends.push_back({end_sample_of(request_.metric, request_.gradient),
                           end_sample_of(r_.vertices.metrics[v], r_.vertices.gradients[v])});
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
        // The search always starts from the end whose coordinates are lower. So an edge with several minima has the
        // same target in all cavities.
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
        w_.spokes[w_.free[i]].target = w_.spokes[w_.free[i]].node = w_.found[i].node.point;
}

#define CAMBER_INSTANTIATE(D)                     \
    template void CurvedNodes<D>::place_inner();  \
    template bool CurvedNodes<D>::place_others(); \
    template EdgeId CurvedNodes<D>::target_edge(VertexId) const;

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
