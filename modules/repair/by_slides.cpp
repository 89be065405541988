// Moves nodes along segments, and slides boundary nodes on the geometry.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <tuple>
#include <vector>
module camber.repair;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;

namespace camber {

namespace {

/// Returns the divisor that scales det J: |det straight|, or the largest coefficient if the straight element is flat.
template <int D>
double scale_of(const BoundedJacobian<D>& j) {
    if (std::abs(j.straight) > 2 * j.error) return std::abs(j.straight);
    double largest = std::numeric_limits<double>::min();
    for (const double c : j.coefficients) largest = std::max(largest, std::abs(c));
    return largest;
}

/// An element with one node that moves along a segment, and its coefficients at both ends (θ = 0 and 1).
template <int D>
struct SegmentElement {
    ElementId element;
    bool valid = false;
    BoundedJacobian<D> at_0, at_1;
    double scale = 1;
    double min_at_1 = 0;
    double min_needed = 0;  ///< scaled coefficients above this prove validity despite rounding
};

template <int D>
std::vector<SegmentElement<D>> segment_shell(const Trial<D>& trial, EdgeId edge, const LagrangeNode<D>& from,
                                             const LagrangeNode<D>& to) {
    std::vector<SegmentElement<D>> shell;
    for (const ElementId e : trial.state.shells[edge]) {
        SegmentElement<D> s{
            e, trial.valid(e), jacobian_with(trial, e, edge, from), jacobian_with(trial, e, edge, to), 1, 0, 0};
        s.scale = std::max(scale_of(s.at_0), scale_of(s.at_1));
        s.min_at_1 = *std::min_element(s.at_1.coefficients.begin(), s.at_1.coefficients.end()) / s.scale;
        s.min_needed = trial.state.options.min_scaled_jacobian * (1 + 0x1p-40) +
                       4 * std::max(s.at_0.error, s.at_1.error) / s.scale;
        shell.push_back(s);
    }
    return shell;
}

template <int D>
void append(const SegmentElement<D>& s, double floor, std::vector<AffineConstraint>& constraints) {
    for (int i = 0; i < jacobian_coefficients<D>; ++i)
        constraints.push_back({s.at_0.coefficients[i] / s.scale, s.at_1.coefficients[i] / s.scale, floor});
}

/// Adds constraints only for coefficients that depend on the node. The others limit the minimum, but no move can raise
/// them.
template <int D>
void append_moving(const SegmentElement<D>& s, std::vector<AffineConstraint>& constraints) {
    for (int i = 0; i < jacobian_coefficients<D>; ++i)
        if (s.at_0.coefficients[i] != s.at_1.coefficients[i])
            constraints.push_back({s.at_0.coefficients[i] / s.scale, s.at_1.coefficients[i] / s.scale, 0});
}

/// A requirement on a move: all invalid elements, or only the seed (the element to repair), must reach the target or
/// the bound.
struct Demand {
    bool whole_shell;
    bool to_target;
};
constexpr std::array<Demand, 4> demands{{{true, true}, {false, true}, {true, false}, {false, false}}};

template <int D>
double floor_of(const Trial<D>& trial, const SegmentElement<D>& s, ElementId e, Demand demand) {
    const double target = std::max(trial.state.options.target.value, s.min_needed);
    if (s.valid) return std::min(target, s.min_at_1);
    if (demand.whole_shell || s.element == e) return demand.to_target ? target : s.min_needed;
    return s.min_at_1;
}

/// A candidate position. Candidates of lower rank are better; among those of equal rank, lower loss is better.
struct Candidate {
    EdgeId edge;
    double theta;
    double rank, loss;
    friend bool operator<(const Candidate& a, const Candidate& b) {
        return std::tuple(a.rank, a.loss, a.edge) < std::tuple(b.rank, b.loss, b.edge);
    }
};

template <int D>
double loss(const Trial<D>& trial, EdgeId edge, double theta) {
    return (1 - theta) * distance(trial.node(edge).point, trial.middle(edge).point) / trial.length(edge);
}

template <int D>
std::optional<Candidate> repairing_candidate(const Trial<D>& trial, ElementId e, EdgeId edge,
                                             std::span<const Demand> allowed) {
    const auto shell = segment_shell(trial, edge, trial.middle(edge), trial.node(edge));
    std::vector<AffineConstraint> constraints;
    double rank = 0;
    for (const Demand demand : allowed) {
        constraints.clear();
        for (const auto& s : shell) append(s, floor_of(trial, s, e, demand), constraints);
        if (const auto interval = feasible(constraints))
            return Candidate{edge, interval->high, rank, loss(trial, edge, interval->high)};
        ++rank;
    }
    return {};
}

template <int D>
double missing(const Trial<D>& trial, const BoundedJacobian<D>& j) {
    double sum = 0;
    for (const double c : j.coefficients) sum += std::max(0.0, trial.state.options.target - c / scale_of(j));
    return sum;
}

/// Returns the θ that maximises the minimum coefficient of the invalid elements; valid ones stay valid.
template <int D>
std::optional<Candidate> helping_candidate(const Trial<D>& trial, EdgeId edge) {
    const LagrangeNode<D> middle = trial.middle(edge);
    const auto shell = segment_shell(trial, edge, middle, trial.node(edge));
    std::vector<AffineConstraint> preserved, raised;
    for (const auto& s : shell) {
        if (s.valid)
            append(s, floor_of(trial, s, s.element, demands[0]), preserved);
        else
            append_moving(s, raised);
    }
    const auto within = feasible(preserved);
    if (!within || raised.empty()) return {};
    const double theta = max_min_parameter(raised, *within);
    if (!(theta < 1)) return {};
    double before = 0;
    double after = 0;
    const LagrangeNode<D> there = trial.towards_middle(edge, theta);
    for (const auto& s : shell) {
        if (s.valid) continue;
        before += missing(trial, s.at_1);
        after += missing(trial, jacobian_with(trial, s.element, edge, there));
    }
    // A small improvement does not justify the loss of curvature.
    if (!(after < 0.95 * before)) return {};
    return Candidate{edge, theta, after / before, 0};
}

template <int D>
bool try_candidate(Trial<D>& trial, const Candidate& candidate, ElementId must_be_valid) {
    Changes<D> changes;
    move_node(trial, candidate.edge, trial.towards_middle(candidate.edge, candidate.theta), changes);
    check_shells(trial, std::span(&candidate.edge, 1), changes);
    const bool good = changes.broken.empty() && (!must_be_valid.valid() || trial.valid(must_be_valid));
    if (!good) undo(trial, changes);
    return good;
}

template <int D, class Propose>
bool try_best(Trial<D>& trial, ElementId e, EdgeGroup group, ElementId must_be_valid, Propose&& propose) {
    std::vector<Candidate> candidates;
    for (const EdgeId edge : movable_edges(trial, e, group))
        if (const auto candidate = propose(edge)) candidates.push_back(*candidate);
    std::sort(candidates.begin(), candidates.end());
    for (const Candidate& candidate : candidates)
        if (try_candidate(trial, candidate, must_be_valid)) return true;
    return false;
}

}  // namespace

template <int D>
bool repair_element(Trial<D>& trial, ElementId e, EdgeGroup group, Steps steps) {
    bool moved = false;
    for (int turn = 0; turn < 2 * edges_per_simplex<D> && !trial.valid(e); ++turn) {
        const auto allowed = std::span(demands).first(steps == Steps::to_target ? 2 : 4);
        const auto repairing = [&](EdgeId edge) { return repairing_candidate(trial, e, edge, allowed); };
        const auto helping = [&](EdgeId edge) { return helping_candidate(trial, edge); };
        if (!try_best(trial, e, group, e, repairing) &&
            (steps != Steps::helping || !try_best(trial, e, group, ElementId{}, helping)))
            break;
        moved = true;
    }
    return moved;
}

template <int D>
bool put_back(Trial<D>& trial, EdgeId edge) {
    const LagrangeNode<D> from = trial.node(edge);
    const LagrangeNode<D> to = trial.state.moved.nodes.base()[edge];
    if (from == to) return false;
    std::vector<AffineConstraint> constraints;
    for (const auto& s : segment_shell(trial, edge, from, to)) {
        const double now = *std::min_element(s.at_0.coefficients.begin(), s.at_0.coefficients.end()) / s.scale;
        append(s, std::min(now, std::max(trial.state.options.target.value, s.min_needed)), constraints);
    }
    const auto interval = feasible(constraints);
    if (!interval || interval->high < 0.01) return false;
    const LagrangeNode<D> there =
        interval->high < 1 ? LagrangeNode<D>{from.point + interval->high * (to.point - from.point)} : to;
    Changes<D> changes;
    move_node(trial, edge, there, changes);
    check_shells(trial, std::span(&edge, 1), changes);
    if (!changes.broken.empty()) undo(trial, changes);
    return changes.broken.empty();
}

namespace {

constexpr int max_slide_steps = 10;
constexpr double slide_weight = 10;
constexpr double off_weight = 1e8;
/// Margins added to the required scaled Jacobian, because projection onto the geometry reduces it. The seed (the
/// element to repair) needs the larger one.
constexpr double slack = 2e-5, slack_of_seed = 1e-4;
/// Maximum distance of a node from the projected chord midpoint, as a share of the chord, unless the node was farther
/// before. At a quarter the derivative of the curve vanishes at one end.
constexpr double farthest = 0.24;
/// Like `determinant_shares` of by_cavities.cpp.
constexpr std::array determinant_shares{0.2, 0.02};

/// A moving point, and the projector onto the directions off the geometry (0 in the volume).
template <int D>
struct Slider {
    Vec<D> at;
    Sym<D> normal_projector = {};

    [[nodiscard]] Vec<D> along(const Vec<D>& x) const { return x - normal_projector * x; }
};

template <int D>
struct Sliding {
    const RepairState<D>& state;
    const RepairCavity<D>& cavity;
    std::vector<Slider<D>> nodes;
    std::vector<Slider<D>> points;

    [[nodiscard]] std::size_t unknowns() const { return nodes.size() + points.size(); }
    [[nodiscard]] Vec<D> point(VertexId v) const {
        const int at = index_in(cavity.vertices, v);
        return at < 0 ? state.moved.points[v] : points[static_cast<std::size_t>(at)].at;
    }
    [[nodiscard]] NodalSimplex<D> element(ElementId e) const {
        NodalSimplex<D> s = state.element(e);
        for (int i = 0; i <= D; ++i) s.nodes[i] = point(state.mesh().linear.elements.vertices[e][i]);
        for (int i = 0; i < edges_per_simplex<D>; ++i)
            if (const int at = index_in(cavity.edges, state.mesh().edges.of_elements[e][i]); at >= 0)
                s.nodes[D + 1 + i] = nodes[static_cast<std::size_t>(at)].at;
        return s;
    }
    [[nodiscard]] bool slides(std::size_t i) const { return state.kinds[cavity.edges[i]] != EdgeKind::volume; }
    [[nodiscard]] Vec<D> middle(std::size_t i) const {
        const auto& [a, b] = state.mesh().edges.vertices[cavity.edges[i]];
        return midpoint(point(a), point(b));
    }
    [[nodiscard]] double chord(std::size_t i) const {
        const auto& [a, b] = state.mesh().edges.vertices[cavity.edges[i]];
        return distance(point(a), point(b));
    }
    [[nodiscard]] Slider<D> foot(std::size_t i, const Vec<D>& p) const {
        if (!slides(i)) return {p};
        const GeometryFoot<D> there = (*state.onto)(cavity.edges[i], p);
        return {there.point, there.normal_projector};
    }
    [[nodiscard]] Slider<D> vertex_foot(std::size_t i, const Vec<D>& p) const {
        const VertexId v = cavity.vertices[i];
        if (state.around_vertices.freedom[v] != VertexFreedom::sliding) return {p};
        const GeometryFoot<D> there = (*state.vertices_onto)(v, p);
        return {there.point, there.normal_projector};
    }
    /// Moves points (nodes, then vertices) by `offsets` in their tangent planes, then projects them. Nodes also follow
    /// their chord midpoints.
    void move_nodes(const std::vector<Vec<D>>& offsets) {
        std::vector<Vec<D>> before(nodes.size());
        for (std::size_t i = 0; i < nodes.size(); ++i) before[i] = middle(i);
        for (std::size_t i = 0; i < points.size(); ++i)
            points[i] = vertex_foot(i, points[i].at + points[i].along(offsets[nodes.size() + i]));
        for (std::size_t i = 0; i < nodes.size(); ++i)
            nodes[i] = foot(i, nodes[i].at + nodes[i].along(offsets[i]) + (middle(i) - before[i]));
    }
};

/// Initial positions of boundary nodes: the current ones, or projected chord midpoints, because descent from a folded
/// boundary does not unfold it.
enum class SlideStart : std::uint8_t { as_it_is, from_middles };

template <int D>
Sliding<D> beginning(const RepairState<D>& state, const RepairCavity<D>& cavity, SlideStart start) {
    Sliding<D> at{state, cavity, {}, {}};
    at.points.reserve(cavity.vertices.size());
    for (std::size_t i = 0; i < cavity.vertices.size(); ++i) {
        at.points.push_back({state.moved.points[cavity.vertices[i]]});
        at.points[i] = at.vertex_foot(i, at.points[i].at);
    }
    at.nodes.reserve(cavity.edges.size());
    for (std::size_t i = 0; i < cavity.edges.size(); ++i) {
        const bool from_middle = start == SlideStart::from_middles && at.slides(i);
        at.nodes.push_back(at.foot(i, from_middle ? at.middle(i) : state.moved.nodes[cavity.edges[i]].point));
    }
    return at;
}

/// Returns a cost model that penalises displacements off the geometry. `back`: vector from the point to its target
/// position.
template <int D>
OffsetModel<D> on_geometry(const Slider<D>& slider, const Vec<D>& back, const Sym<D>& hessian) {
    double trace = 0;
    for (int k = 0; k < D; ++k) trace += hessian(k, k);
    return {slider.along(back), slide_weight * hessian + off_weight * trace * slider.normal_projector};
}

template <int D>
OffsetModel<D> node_model(const Sliding<D>& at, std::size_t i) {
    const QuadraticModel<D> model = at.state.model(at.cavity.edges[i]);
    const Slider<D>& node = at.nodes[i];
    if (!at.slides(i)) return {model.centre - node.at, model.hessian};
    return on_geometry(node, at.foot(i, at.middle(i)).at - node.at, model.hessian);
}

template <int D>
OffsetModel<D> vertex_model(const Sliding<D>& at, std::size_t i) {
    const VertexId v = at.cavity.vertices[i];
    const OffsetModel<D> model = model_of(at.state, v);
    const Vec<D> back = at.state.mesh().linear.points[v] - at.points[i].at;
    if (at.state.around_vertices.freedom[v] != VertexFreedom::sliding) return {back, model.hessian};
    return on_geometry(at.points[i], back, model.hessian);
}

template <int D>
JointProblem<D> joint_problem_at(const Sliding<D>& at, ElementId seed, double seed_bound, double share) {
    const RepairState<D>& state = at.state;
    JointProblem<D> problem;
    problem.first_penalty = JointProblem<D>::strong;
    problem.unknowns.reserve(at.unknowns());
    for (std::size_t i = 0; i < at.nodes.size(); ++i) problem.unknowns.push_back(node_model(at, i));
    for (std::size_t i = 0; i < at.points.size(); ++i) problem.unknowns.push_back(vertex_model(at, i));
    const int edges = static_cast<int>(at.nodes.size());
    problem.elements.reserve(at.cavity.elements.size());
    const double bound = state.options.min_scaled_jacobian + slack;
    for (const ElementId e : at.cavity.elements) {
        const double preserved = preserved_jacobian(state, e, seed_bound);
        typename JointProblem<D>::Element element{.bezier = bezier_form(at.element(e)),
                                                  .unknowns = {},
                                                  .floor = e == seed       ? seed_bound
                                                           : state.good(e) ? std::max(preserved, bound)
                                                                           : preserved};
        if (!at.points.empty()) element.least = min_of(state, at.cavity, e, share);
        for (int i = 0; i <= D; ++i) {
            const int vertex = index_in(at.cavity.vertices, state.mesh().linear.elements.vertices[e][i]);
            element.unknowns[i] = vertex < 0 ? JointProblem<D>::fixed : edges + vertex;
        }
        for (int i = 0; i < edges_per_simplex<D>; ++i)
            element.unknowns[D + 1 + i] = index_in(at.cavity.edges, state.mesh().edges.of_elements[e][i]);
        problem.elements.push_back(element);
    }
    return problem;
}

template <int D>
bool within_chords(const Sliding<D>& at) {
    for (std::size_t i = 0; i < at.nodes.size(); ++i) {
        if (!at.slides(i)) continue;
        const Vec<D> middle = at.foot(i, at.middle(i)).at;
        const EdgeId edge = at.cavity.edges[i];
        if (distance(at.nodes[i].at, middle) > farthest * at.chord(i) &&
            distance(at.nodes[i].at, middle) > distance(at.state.moved.nodes[edge].point, middle))
            return false;
    }
    return true;
}

template <int D>
std::optional<Moves<D>> plan_of(const Sliding<D>& at, ElementId seed) {
    const RepairState<D>& state = at.state;
    if (!within_chords(at)) return std::nullopt;
    Moves<D> plan;
    for (const ElementId e : at.cavity.elements) {
        const NodalSimplex<D> next = at.element(e);
        const Verdict now = verdict_of(state, e, next);
        if (is_degraded(state, e, next, now) || (e == seed && now != Verdict::valid)) return std::nullopt;
        if (!preserves_shape(state, e, next, now)) return std::nullopt;
        plan.verdicts.emplace_back(e, now);
    }
    for (std::size_t i = 0; i < at.nodes.size(); ++i) plan.nodes.push_back({at.cavity.edges[i], {at.nodes[i].at}});
    for (std::size_t i = 0; i < at.points.size(); ++i) plan.points.emplace_back(at.cavity.vertices[i], at.points[i].at);
    return plan;
}

}  // namespace

template <int D>
Planned<D> plan_slide_repair(const RepairState<D>& state, const RepairCavity<D>& cavity, ElementId seed,
                             double requested, double max_work) {
    const auto is_volume = [&](EdgeId e) { return state.kinds[e] == EdgeKind::volume; };
    if (std::ranges::all_of(cavity.edges, is_volume)) return {};
    const double seed_bound = std::max<double>(state.options.min_scaled_jacobian, requested) + slack_of_seed;
    Planned<D> planned;
    const auto try_from = [&](SlideStart start, double share) {
        Sliding<D> at = beginning(state, cavity, start);
        for (int step = 0; step < max_slide_steps && planned.work < max_work && !planned.plan; ++step) {
            auto problem = joint_problem_at(at, seed, seed_bound, share);
            problem.max_work = max_work - planned.work;
            const auto solution = solve(problem, std::vector<Vec<D>>(at.unknowns()));
            planned.work += solution.work;
            at.move_nodes(solution.offsets);
            planned.plan = plan_of(at, seed);
        }
    };
    for (const double share : determinant_shares)
        for (const SlideStart start : {SlideStart::as_it_is, SlideStart::from_middles})
            if (!planned.plan && (share == determinant_shares[0] || !cavity.vertices.empty())) try_from(start, share);
    return planned;
}

#define CAMBER_INSTANTIATE(D)                                                \
    template bool repair_element<D>(Trial<D>&, ElementId, EdgeGroup, Steps); \
    template bool put_back<D>(Trial<D>&, EdgeId);                            \
    template Planned<D> plan_slide_repair<D>(const RepairState<D>&, const RepairCavity<D>&, ElementId, double, double);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
