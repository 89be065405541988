module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <vector>
module camber.operation;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.metric;
import camber.optimisation;
import camber.validity;

/// Nodes of a star that bend together, and with those around it: where a long edge's sagitta passes the rows beside it,
/// no node alone makes its elements valid.
namespace camber {

namespace {

/// So many inner nodes of a star go together at most: a programme's step costs the square of them.
constexpr std::size_t max_together = 32;

/// The least quality of elements that bend together.
constexpr double fair_quality = 0.3;

/// The outer face's edges of an element that is joined there.
template <int D, class Visit>
void each_outer_edge(int opposite, const Visit& visit) {
    for (int k = 0; k < edges_per_simplex<D>; ++k)
        if (local_edges<D>[k][0] != opposite && local_edges<D>[k][1] != opposite) visit(k);
}

}  // namespace

template <int D>
bool CurvedNodes<D>::bend_together() {
    return limits_.bend_around > 0 && (bend_together(0) || bend_together(limits_.bend_around));
}

template <int D>
bool CurvedNodes<D>::bend_together(int rim) {
    gather_rim(rim);
    if (rim > 0 && w_.rim.empty()) return false;
    std::vector<Vec<D>> before;
    const JointProgramme<D> programme = bending_programme();
    if (programme.unknowns.size() < 2) return false;
    ++w_.programmes;
    before.reserve(programme.unknowns.size());
    for (const std::uint32_t s : w_.short_of_place) before.push_back(w_.spokes[s].node);
    for (const RimEdge<D>& edge : w_.rim) before.push_back(edge.before);
    const std::vector<Vec<D>> none(before.size());
    bend(before, solve(programme, none).offsets);
    if (is_bent_well()) {
        for (const std::uint32_t s : w_.short_of_place) w_.spokes[s].share = 0;
        return true;
    }
    bend(before, none);
    w_.rim.clear();
    w_.outside.clear();
    return false;
}

template <int D>
void CurvedNodes<D>::gather_rim(int rim) {
    w_.rim.clear();
    w_.outside.clear();
    const auto is_there = [&](EdgeId edge) {
        return std::ranges::find(w_.rim, edge, &RimEdge<D>::edge) != w_.rim.end();
    };
    for (std::size_t j = 0; j < w_.cones.size(); ++j) {
        if (w_.cones[j].verdict == Verdict::valid) continue;
        const auto& [element, opposite] = out_.star.joined[j];
        each_outer_edge<D>(static_cast<int>(opposite), [&](int k) {
            const EdgeId edge = r_.mesh.edges_of[element][k];
            if (std::ssize(w_.rim) >= rim || is_there(edge)) return;
            shell(r_.mesh, element, k, w_.around);
            const std::size_t outside = w_.outside.size();
            const auto is_movable = [&](ElementId e) {
                const auto& edges = r_.mesh.edges_of[e];
                return !is_node_fixed(r_.mesh, e, static_cast<int>(std::ranges::find(edges, edge) - edges.begin())) &&
                       gather_outside(e);
            };
            if (std::ranges::all_of(w_.around, is_movable)) {
                const Vec<D> node = r_.mesh.nodes[edge].point;
                w_.rim.push_back({edge, node, wanted_node_of(edge), node});
            } else {
                w_.outside.resize(outside);
            }
        });
    }
}

template <int D>
bool CurvedNodes<D>::gather_outside(ElementId e) {
    if (std::ranges::find(out_.removed.elements, e) != out_.removed.elements.end()) return true;
    if (std::ranges::find(w_.outside, e, &OutsideElement<D>::element) != w_.outside.end()) return true;
    OutsideElement<D> outside{e, nodes_of(r_.mesh, e), limits_.min_jacobian};
    if (decide(NodalSimplex<D>{outside.nodes}, outside.bound) != Verdict::valid)
        outside.bound = limits_.lowest_jacobian;
    if (decide(NodalSimplex<D>{outside.nodes}, outside.bound) != Verdict::valid) return false;
    w_.outside.push_back(outside);
    return true;
}

/// By the closed form from the ends; where nodes are searched for, where it is.
template <int D>
Vec<D> CurvedNodes<D>::wanted_node_of(EdgeId edge) const {
    if (!goal_.wanted.empty()) return goal_.wanted[edge].point;
    if (goal_.search) return r_.mesh.nodes[edge].point;
    const auto& [a, b] = r_.mesh.edges[edge];
    const std::array<Vec<D>, 1> chord{r_.mesh.points[b] - r_.mesh.points[a]};
    const std::array<EdgeEnds<D>, 1> ends{EdgeEnds<D>{{r_.vertices.metrics[a].log_metric, r_.vertices.gradients[a]},
                                                      {r_.vertices.metrics[b].log_metric, r_.vertices.gradients[b]}}};
    std::array<Vec<D>, 1> offset;
    accurate_offsets<D>(chord, ends, goal_.accuracy, offset);
    return midpoint(r_.mesh.points[a], r_.mesh.points[b]) + offset[0];
}

/// Which elements, at the bound, at the least distance of their nodes from where these are wanted.
template <int D>
JointProgramme<D> CurvedNodes<D>::bending_programme() {
    using Programme = JointProgramme<D>;
    Programme programme;
    programme.first_penalty = Programme::strong;
    constexpr double margin = 1e-3;  // of certificates, which know the rounding of coefficients
    std::vector<int> unknown_of(w_.spokes.size(), Programme::fixed);
    w_.short_of_place.clear();
    for (std::uint32_t s = 0; s < w_.spokes.size() && w_.short_of_place.size() < max_together; ++s) {
        if (!is_free(s)) continue;
        unknown_of[s] = static_cast<int>(programme.unknowns.size());
        w_.short_of_place.push_back(s);
        programme.unknowns.push_back({w_.spokes[s].wanted - w_.spokes[s].node, distance_seen_along(spoke_metrics(s))});
    }
    const int first_of_rim = static_cast<int>(programme.unknowns.size());
    for (const RimEdge<D>& edge : w_.rim)
        programme.unknowns.push_back(
            {edge.wanted - edge.before, distance_seen_along({&r_.vertices.metrics[r_.mesh.edges[edge.edge][0]],
                                                             &r_.vertices.metrics[r_.mesh.edges[edge.edge][1]]})});
    const auto rim_unknown = [&](EdgeId edge) {
        const auto at = std::ranges::find(w_.rim, edge, &RimEdge<D>::edge) - w_.rim.begin();
        return at == std::ssize(w_.rim) ? Programme::fixed : first_of_rim + static_cast<int>(at);
    };
    const auto add = [&](const QuadraticNodes<D>& nodes, double bound, const auto& unknown) {
        typename Programme::Element element;
        element.unknowns.fill(Programme::fixed);
        for (int k = 0; k < edges_per_simplex<D>; ++k) element.unknowns[D + 1 + k] = unknown(k);
        if (std::ranges::all_of(element.unknowns, [](int u) { return u == Programme::fixed; })) return;
        element.bezier = bezier_form(NodalSimplex<D>{nodes});
        element.floor = bound * (1 + margin);
        programme.elements.push_back(element);
    };
    for (std::size_t j = 0; j < w_.cones.size(); ++j) {
        const Cone<D>& cone = w_.cones[j];
        add(cone.nodes, bound_, [&](int k) {
            const auto& [a, b] = local_edges<D>[k];
            if (a != cone.point && b != cone.point)
                return rim_unknown(r_.mesh.edges_of[out_.star.joined[j].element][k]);
            return unknown_of[cone.spokes[a == cone.point ? b : a]];
        });
    }
    for (const OutsideElement<D>& outside : w_.outside)
        add(outside.nodes, outside.bound, [&](int k) { return rim_unknown(r_.mesh.edges_of[outside.element][k]); });
    return programme;
}

template <int D>
void CurvedNodes<D>::bend(const std::vector<Vec<D>>& before, const std::vector<Vec<D>>& offsets) {
    std::size_t i = 0;
    for (const std::uint32_t s : w_.short_of_place) {
        w_.spokes[s].node = before[i] + offsets[i];
        ++i;
    }
    for (RimEdge<D>& edge : w_.rim) {
        edge.node = before[i] + offsets[i];
        ++i;
    }
    const auto put = [&](QuadraticNodes<D>& nodes, ElementId e, int k) {
        const auto at = std::ranges::find(w_.rim, r_.mesh.edges_of[e][k], &RimEdge<D>::edge);
        if (at == w_.rim.end()) return false;
        nodes[D + 1 + k] = at->node;
        return true;
    };
    for (std::size_t j = 0; j < w_.cones.size(); ++j) {
        Cone<D>& cone = w_.cones[j];
        each_outer_edge<D>(cone.point,
                           [&](int k) { cone.is_stale |= put(cone.nodes, out_.star.joined[j].element, k); });
    }
    for (OutsideElement<D>& outside : w_.outside)
        for (int k = 0; k < edges_per_simplex<D>; ++k) put(outside.nodes, outside.element, k);
    mark_stale();
    refresh_stale();
}

/// All elements valid and of a fair shape, or outside as good as they were: what is bent by force is seldom good later.
template <int D>
bool CurvedNodes<D>::is_bent_well() {
    const double fair = shape_of_quality(fair_quality, D);
    const auto is_fair = [&](Cone<D>& cone) { return cone.verdict == Verdict::valid && shape_of_cone(cone) >= fair; };
    if (!std::ranges::all_of(w_.cones, is_fair)) return false;
    return std::ranges::all_of(w_.outside, [&](const OutsideElement<D>& outside) {
        if (decide(NodalSimplex<D>{outside.nodes}, outside.bound) != Verdict::valid) return false;
        VertexLogMetrics<D> logs;
        for (int i = 0; i <= D; ++i)
            logs[i] = r_.vertices.metrics[r_.mesh.elements.vertices[outside.element][i]].log_metric;
        const double shape = curved_shape(outside.nodes, logs);
        return shape >= fair || shape >= shape_of(r_, outside.element);
    });
}

#define CAMBER_INSTANTIATE(D) template bool CurvedNodes<D>::bend_together();

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
