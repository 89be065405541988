// Correction of quadratic stars with invalid elements. The edge nodes are relaxed first, then moved one by one by
// linear programs, then moved together.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
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

/// True if all coefficients of det J are zero up to rounding. Such an element counts as invalid, because a decision in
/// extended precision would be expensive.
template <int D>
bool is_flat_to_rounding(const NodalSimplex<D>& element, const JacobianSummary& jacobian) {
    if (!(std::abs(jacobian.straight) <= jacobian.error && std::abs(jacobian.lowest) <= jacobian.error)) return false;
    const BoundedJacobian<D> all = bounded_jacobian(element);
    return std::ranges::all_of(all.coefficients, [&](double x) { return std::abs(x) <= all.error; });
}

}  // namespace

template <int D>
void CurvedNodes<D>::begin_elements() {
    begin_cones();
    w_.rim.clear();
    w_.outside.clear();
    bound_ = limits_.min_jacobian;
    has_raised_ = false;
    w_.optimisation_problems = 0;
}

template <int D>
void CurvedNodes<D>::judge_elements() {
    refresh_stale();
    if (bound_ == limits_.lowest_jacobian || !replaces_worse_where_invalid()) return;
    bound_ = limits_.lowest_jacobian;
    for (Cone<D>& cone : w_.cones) cone.is_stale = cone.verdict != Verdict::valid;
    refresh_stale();
}

template <int D>
bool CurvedNodes<D>::replaces_worse_where_invalid() const {
    return std::ranges::any_of(w_.cones, [](const Cone<D>& c) { return c.verdict != Verdict::valid; }) &&
           replaces_worse();
}

template <int D>
bool CurvedNodes<D>::is_broken(std::size_t joined) const {
    return w_.cones[joined].verdict != Verdict::valid &&
           !(bound_ == limits_.lowest_jacobian && may_stay_invalid(joined));
}

template <int D>
ElementState CurvedNodes<D>::element(std::size_t joined) const {
    Cone<D>& cone = w_.cones[joined];
    if (cone.verdict == Verdict::valid) return {true, cone.is_flat, shape_of_cone(cone), false};
    return {false, false, 0, !is_broken(joined)};
}

template <int D>
double CurvedNodes<D>::length_to(std::size_t s) const {
    Spoke<D>& spoke = w_.spokes[s];
    if (spoke.length >= 0 && spoke.measured == spoke.node) return spoke.length;
    spoke.measured = spoke.node;
    return spoke.length = quadratic_edge_length<D>(end_of(request_.metric), end_of(r_.vertices.metrics[vertex(s)]),
                                                   end(s) - request_.place, spoke.node - middle(s));
}

template <int D>
bool CurvedNodes<D>::correct(RejectionReason reason) {
    if (has_raised_) return false;
    if (draw_back(reason)) return true;
    has_raised_ = true;
    return reason == RejectionReason::volume && (raise() || bend_together());
}

template <int D>
void CurvedNodes<D>::set_edges(Patch<D>& patch) const {
    for (const Spoke<D>& spoke : w_.spokes) patch.nodes.push_back({spoke.node});
    for (const RimEdge<D>& edge : w_.rim) patch.following.push_back({edge.edge, {edge.node}});
    for (const OutsideElement<D>& outside : w_.outside) patch.reshaped.push_back(outside.element);
}

template <int D>
void CurvedNodes<D>::begin_cones() {
    w_.cones.resize(out_.star.joined.size());
    for (std::size_t j = 0; j < w_.cones.size(); ++j) {
        const auto& [element, opposite] = out_.star.joined[j];
        Cone<D>& cone = w_.cones[j];
        cone = {};
        cone.nodes = nodes_of(r_.mesh, element);
        cone.point = static_cast<int>(opposite);
        cone.nodes[opposite] = request_.place;
        const auto& vertices = r_.mesh.elements.vertices[element];
        for (int i = 0; i <= D; ++i) {
            const bool is_point = i == cone.point;
            cone.metrics[i] = &(is_point ? request_.metric : r_.vertices.metrics[vertices[i]]).log_metric;
            if (!is_point) cone.spokes[i] = star_.vertices.find(vertices[i]);
        }
    }
}

template <int D>
void CurvedNodes<D>::put_nodes(Cone<D>& cone) const {
    for (int i = 0; i <= D; ++i)
        if (i != cone.point) cone.nodes[D + 1 + edge_between<D>[i][cone.point]] = w_.spokes[cone.spokes[i]].node;
}

template <int D>
void CurvedNodes<D>::refresh_stale() {
    w_.stale.clear();
    for (std::size_t j = 0; j < w_.cones.size(); ++j)
        if (w_.cones[j].is_stale) w_.stale.push_back(j);
    each_jacobian_summary<D>(
        0, w_.stale.size(),
        [&](std::size_t i) {
            Cone<D>& cone = w_.cones[w_.stale[i]];
            put_nodes(cone);
            return NodalSimplex<D>{cone.nodes};
        },
        [&](std::size_t i, const JacobianSummary& jacobian) { decide_cone(w_.cones[w_.stale[i]], jacobian); });
}

template <int D>
void CurvedNodes<D>::decide_cone(Cone<D>& cone, const JacobianSummary& jacobian) const {
    const NodalSimplex<D> element{cone.nodes};
    if (is_clear(jacobian, bound_))
        cone.verdict = Verdict::valid;
    else
        cone.verdict = is_flat_to_rounding(element, jacobian) ? Verdict::invalid : decide(element, bound_);
    cone.is_flat = cone.verdict == Verdict::valid && is_flat(element, jacobian);
    cone.is_surely_straight_positive = jacobian.is_finite() && jacobian.straight > jacobian.error;
    cone.shape = -1;
    cone.is_stale = false;
}

template <int D>
double CurvedNodes<D>::shape_of_cone(Cone<D>& cone) const {
    if (cone.shape >= 0) return cone.shape;
    VertexLogMetrics<D> metrics;
    for (int i = 0; i <= D; ++i) metrics[i] = *cone.metrics[i];
    return cone.shape = curved_shape(cone.nodes, metrics);
}

template <int D>
bool CurvedNodes<D>::is_flat(const NodalSimplex<D>& element, const JacobianSummary& jacobian) const {
    std::array<Vec<D>, D + 1> corners;
    std::copy_n(element.nodes.begin(), D + 1, corners.begin());
    if (is_above_rounding<D>(jacobian.lowest - jacobian.error, corners)) return false;
    const double floor = rounding_floor<D>(corners);
    return decide(element, std::max(bound_, floor / std::abs(jacobian.straight))) != Verdict::valid;
}

template <int D>
bool CurvedNodes<D>::may_stay_invalid(std::size_t joined) const {
    return limits_.invalid_replacement == InvalidReplacement::may_stay &&
           decide(NodalSimplex<D>{nodes_of(r_.mesh, out_.star.joined[joined].element)}, bound_) != Verdict::valid;
}

template <int D>
bool CurvedNodes<D>::is_good(Cone<D>& cone) {
    return cone.verdict == Verdict::valid && !cone.is_flat && bar_.is_met(shape_of_cone(cone));
}

template <int D>
bool CurvedNodes<D>::replaces_worse() const {
    const auto& elements = out_.removed.elements;
    const auto element = [&](std::size_t i) { return NodalSimplex<D>{nodes_of(r_.mesh, elements[i])}; };
    bool is_worse = false;
    each_jacobian_summary<D>(0, elements.size(), element, [&](std::size_t i, const JacobianSummary& jacobian) {
        is_worse = is_worse || (!is_clear(jacobian, limits_.min_jacobian) &&
                                decide(element(i), limits_.min_jacobian) != Verdict::valid);
    });
    return is_worse;
}

template <int D>
bool CurvedNodes<D>::draw_back(RejectionReason reason) {
    bool drawn = false;
    const auto is_sound = [&](Cone<D>& cone) {
        if (reason == RejectionReason::quality) return is_good(cone);
        return cone.verdict == Verdict::valid && !cone.is_flat;
    };
    for (Cone<D>& cone : w_.cones) {
        if (is_sound(cone)) continue;
        for (int i = 0; i <= D; ++i) {
            if (i == cone.point) continue;
            Spoke<D>& spoke = w_.spokes[cone.spokes[i]];
            if (spoke.kind != EdgeKind::volume || spoke.share == 0) continue;
            extend(cone.spokes[i]);
            if (spoke.target == spoke.extended) continue;
            spoke.share = spoke.share > 0.5 ? 0.5 : 0;
            spoke.node = spoke.extended + spoke.share * (spoke.target - spoke.extended);
            drawn = true;
        }
    }
    if (drawn) mark_stale();
    return drawn;
}

template <int D>
void CurvedNodes<D>::mark_stale() {
    for (Cone<D>& cone : w_.cones)
        for (int i = 0; i <= D; ++i)
            if (i != cone.point)
                cone.is_stale |= cone.nodes[D + 1 + edge_between<D>[i][cone.point]] != w_.spokes[cone.spokes[i]].node;
}

template <int D>
bool CurvedNodes<D>::may_leave(std::ptrdiff_t joined) const {
    const auto& elements = out_.removed.elements;
    const auto at = std::ranges::find(elements, out_.star.joined[joined].element) - elements.begin();
    return request_.fixed_element_count > 0 && static_cast<std::size_t>(at) >= request_.fixed_element_count;
}

template <int D>
bool CurvedNodes<D>::raise() {
    const auto is_broken = [](const Cone<D>& cone) { return cone.verdict != Verdict::valid; };
    for (;;) {
        const auto broken = std::ranges::find_if(w_.cones, is_broken);
        if (broken == w_.cones.end()) return true;
        if (may_leave(broken - w_.cones.begin())) return false;
        bool raised = false;
        for (int i = 0; i <= D && is_broken(*broken); ++i) {
            if (i == broken->point || !is_free(broken->spokes[i])) continue;
            if (w_.optimisation_problems == limits_.optimisation_problems) return false;
            ++w_.optimisation_problems;
            raised |= raise(broken->spokes[i]);
        }
        if (!raised) return false;
    }
}

template <int D>
bool CurvedNodes<D>::raise(std::uint32_t s) {
    const EdgeShell<D> shell = shell_of(s);
    constexpr double worthwhile = 1e-3;
    const double before = smallest_scaled_jacobian(shell, shell.node, bound_);
    const auto highest = max_min_node(shell, {.max_cuts = 0, .enough = 2 * bound_, .least = before + worthwhile});
    if (!highest) return false;
    w_.spokes[s].share = 0;
    put(s, highest->node.point);
    return true;
}

template <int D>
EdgeShell<D> CurvedNodes<D>::shell_of(std::uint32_t s) const {
    EdgeShell<D> shell{{w_.spokes[s].node}, {}};
    for (const Cone<D>& cone : w_.cones)
        for (int i = 0; i <= D; ++i)
            if (i != cone.point && cone.spokes[i] == s)
                shell.elements.push_back({{cone.nodes}, edge_between<D>[i][cone.point], {}});
    return shell;
}

template <int D>
void CurvedNodes<D>::put(std::uint32_t s, const Vec<D>& node) {
    w_.spokes[s].node = node;
    mark_stale();
    refresh_stale();
}

template <int D>
void CurvedNodes<D>::approach() {
    w_.short_of_place.clear();
    for (std::uint32_t s = 0; s < w_.spokes.size() && std::ssize(w_.short_of_place) < limits_.approaching; ++s)
        if (w_.spokes[s].share < 1 && is_free(s) && w_.spokes[s].node != w_.spokes[s].target)
            w_.short_of_place.push_back(s);
    if (w_.short_of_place.empty()) return;
    ++w_.optimisation_problems;
    const JointProblem<D> problem = approach_problem();
    const std::vector<Vec<D>> none(problem.unknowns.size());
    const std::vector<Vec<D>> offsets = solve(problem, none).offsets;
    const auto cost = [&](double share) {
        double sum = 0;
        for (std::size_t i = 0; i < offsets.size(); ++i) sum += problem.unknowns[i](share * offsets[i]);
        return sum;
    };
    std::vector<Vec<D>> before;
    before.reserve(offsets.size());
    for (const std::uint32_t s : w_.short_of_place) before.push_back(w_.spokes[s].node);
    for (double share = 1; share > 0.1 && cost(share) < cost(0); share /= 2) {
        for (std::size_t i = 0; i < before.size(); ++i)
            w_.spokes[w_.short_of_place[i]].node = before[i] + share * offsets[i];
        mark_stale();
        refresh_stale();
        if (are_elements_good()) return;
    }
    for (std::size_t i = 0; i < before.size(); ++i) w_.spokes[w_.short_of_place[i]].node = before[i];
    mark_stale();
    refresh_stale();
}

template <int D>
Sym<D> CurvedNodes<D>::sum_of_end_metrics(const EndMetrics& ends) {
    Sym<D> sum;
    for (const VertexMetric<D>* metric : ends)
        for (const Vec<D>& row : metric->measure.rows)
            for (int i = 0; i < D; ++i)
                for (int j = 0; j <= i; ++j) sum(i, j) += row[i] * row[j];
    return sum;
}

template <int D>
JointProblem<D> CurvedNodes<D>::approach_problem() const {
    JointProblem<D> problem;
    std::vector<int> unknown_of(w_.spokes.size(), JointProblem<D>::fixed);
    for (const std::uint32_t s : w_.short_of_place) {
        unknown_of[s] = static_cast<int>(problem.unknowns.size());
        problem.unknowns.push_back({w_.spokes[s].target - w_.spokes[s].node, sum_of_end_metrics(spoke_metrics(s))});
    }
    for (const Cone<D>& cone : w_.cones) {
        if (cone.verdict != Verdict::valid) continue;
        typename JointProblem<D>::Element element;
        element.unknowns.fill(JointProblem<D>::fixed);
        bool is_moved = false;
        for (int i = 0; i <= D; ++i)
            if (i != cone.point) {
                const int unknown = unknown_of[cone.spokes[i]];
                element.unknowns[D + 1 + edge_between<D>[i][cone.point]] = unknown;
                is_moved |= unknown != JointProblem<D>::fixed;
            }
        if (!is_moved) continue;
        constexpr double margin = 1e-3;  // relative margin, so that certificates succeed in spite of rounding
        element.bezier = bezier_form(NodalSimplex<D>{cone.nodes});
        element.floor = bound_ * (1 + margin);
        problem.elements.push_back(element);
    }
    return problem;
}

template <int D>
bool CurvedNodes<D>::are_elements_good() {
    for (std::size_t j = 0; j < w_.cones.size(); ++j)
        if (!is_good(w_.cones[j]) && !element(j).is_tolerated) return false;
    return true;
}

// Joint optimisation of the inner nodes of a star and of nodes around the star. Moving one node after another fails if
// the sagitta of a long edge exceeds the height of the adjacent elements.

namespace {

/// Maximum number of inner nodes in one problem. The cost of a step is quadratic in this number.
constexpr std::size_t max_together = 32;

constexpr double fair_quality = 0.3;

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
    const JointProblem<D> problem = bending_problem();
    if (problem.unknowns.size() < 2) return false;
    ++w_.optimisation_problems;
    before.reserve(problem.unknowns.size());
    for (const std::uint32_t s : w_.short_of_place) before.push_back(w_.spokes[s].node);
    for (const RimEdge<D>& edge : w_.rim) before.push_back(edge.before);
    const std::vector<Vec<D>> none(before.size());
    bend(before, solve(problem, none).offsets);
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
    const auto is_present = [&](EdgeId edge) {
        return std::ranges::find(w_.rim, edge, &RimEdge<D>::edge) != w_.rim.end();
    };
    for (std::size_t j = 0; j < w_.cones.size(); ++j) {
        if (w_.cones[j].verdict == Verdict::valid) continue;
        const auto& [element, opposite] = out_.star.joined[j];
        each_outer_edge<D>(static_cast<int>(opposite), [&](int k) {
            const EdgeId edge = r_.mesh.edges_of[element][k];
            if (std::ssize(w_.rim) >= rim || is_present(edge)) return;
            shell(r_.mesh, element, k, w_.around);
            const std::size_t outside = w_.outside.size();
            const auto is_movable = [&](ElementId e) {
                const auto& edges = r_.mesh.edges_of[e];
                return !is_node_fixed(r_.mesh, e, static_cast<int>(std::ranges::find(edges, edge) - edges.begin())) &&
                       gather_outside(e);
            };
            if (std::ranges::all_of(w_.around, is_movable)) {
                const Vec<D> node = r_.mesh.nodes[edge].point;
                w_.rim.push_back({edge, node, target_node_of(edge), node});
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

/// Returns the target of the edge's node: the position in `goal_.target_nodes`, if there are any. Otherwise, with
/// `goal_.search`, the current position, and without it the position by `accurate_offsets`.
template <int D>
Vec<D> CurvedNodes<D>::target_node_of(EdgeId edge) const {
    if (!goal_.target_nodes.empty()) return goal_.target_nodes[edge].point;
    if (goal_.search) return r_.mesh.nodes[edge].point;
    const auto& [a, b] = r_.mesh.edges[edge];
    const std::array<Vec<D>, 1> chord{r_.mesh.points[b] - r_.mesh.points[a]};
    const std::array<EdgeEnds<D>, 1> ends{EdgeEnds<D>{{r_.vertices.metrics[a].log_metric, r_.vertices.gradients[a]},
                                                      {r_.vertices.metrics[b].log_metric, r_.vertices.gradients[b]}}};
    std::array<Vec<D>, 1> offset;
    accurate_offsets<D>(chord, ends, goal_.accuracy, offset);
    return midpoint(r_.mesh.points[a], r_.mesh.points[b]) + offset[0];
}

template <int D>
JointProblem<D> CurvedNodes<D>::bending_problem() {
    using Problem = JointProblem<D>;
    Problem problem;
    problem.first_penalty = Problem::strong;
    constexpr double margin = 1e-3;  // relative margin, so that certificates succeed in spite of rounding
    std::vector<int> unknown_of(w_.spokes.size(), Problem::fixed);
    w_.short_of_place.clear();
    for (std::uint32_t s = 0; s < w_.spokes.size() && w_.short_of_place.size() < max_together; ++s) {
        if (!is_free(s)) continue;
        unknown_of[s] = static_cast<int>(problem.unknowns.size());
        w_.short_of_place.push_back(s);
        problem.unknowns.push_back({w_.spokes[s].target - w_.spokes[s].node, sum_of_end_metrics(spoke_metrics(s))});
    }
    const int first_of_rim = static_cast<int>(problem.unknowns.size());
    for (const RimEdge<D>& edge : w_.rim)
        problem.unknowns.push_back(
            {edge.target - edge.before, sum_of_end_metrics({&r_.vertices.metrics[r_.mesh.edges[edge.edge][0]],
                                                            &r_.vertices.metrics[r_.mesh.edges[edge.edge][1]]})});
    const auto rim_unknown = [&](EdgeId edge) {
        const auto at = std::ranges::find(w_.rim, edge, &RimEdge<D>::edge) - w_.rim.begin();
        return at == std::ssize(w_.rim) ? Problem::fixed : first_of_rim + static_cast<int>(at);
    };
    const auto add = [&](const QuadraticNodes<D>& nodes, double bound, const auto& unknown) {
        typename Problem::Element element;
        element.unknowns.fill(Problem::fixed);
        for (int k = 0; k < edges_per_simplex<D>; ++k) element.unknowns[D + 1 + k] = unknown(k);
        if (std::ranges::all_of(element.unknowns, [](int u) { return u == Problem::fixed; })) return;
        element.bezier = bezier_form(NodalSimplex<D>{nodes});
        element.floor = bound * (1 + margin);
        problem.elements.push_back(element);
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
    return problem;
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

/// True if each new element has at least the quality `fair_quality`. Elements outside the star may be below it if they
/// do not get worse. Strongly bent elements seldom improve later.
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

#define CAMBER_INSTANTIATE(D)                                         \
    template void CurvedNodes<D>::begin_elements();                   \
    template void CurvedNodes<D>::judge_elements();                   \
    template bool CurvedNodes<D>::is_broken(std::size_t) const;       \
    template double CurvedNodes<D>::shape_of_cone(Cone<D>&) const;    \
    template ElementState CurvedNodes<D>::element(std::size_t) const; \
    template double CurvedNodes<D>::length_to(std::size_t) const;     \
    template bool CurvedNodes<D>::correct(RejectionReason);           \
    template void CurvedNodes<D>::approach();                         \
    template void CurvedNodes<D>::set_edges(Patch<D>&) const;         \
    template void CurvedNodes<D>::mark_stale();                       \
    template void CurvedNodes<D>::refresh_stale();                    \
    template Sym<D> CurvedNodes<D>::sum_of_end_metrics(const EndMetrics&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
