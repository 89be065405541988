module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>
module camber.repair;
import :trial;
import :moved_mesh;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;

namespace camber {

namespace {

/// What det J of an element is divided by in comparisons: |det straight|, or its largest coefficient if that is flat.
template <int D>
double scale_of(const BoundedJacobian<D>& j) {
    if (std::abs(j.straight) > 2 * j.error) return std::abs(j.straight);
    double largest = std::numeric_limits<double>::min();
    for (const double c : j.coefficients) largest = std::max(largest, std::abs(c));
    return largest;
}

/// An element of a shell along a segment of the edge's node: its scaled coefficients at both ends.
template <int D>
struct Swept {
    ElementId element;
    bool valid = false;
    BoundedJacobian<D> at_0, at_1;
    double scale = 1;
    double min_at_1 = 0;    ///< smallest scaled coefficient at θ = 1
    double min_needed = 0;  ///< scaled coefficients above it make the element valid, rounding included
};

template <int D>
std::vector<Swept<D>> swept_shell(const Trial<D>& trial, EdgeId edge, const LagrangeNode<D>& from,
                                  const LagrangeNode<D>& to) {
    std::vector<Swept<D>> shell;
    for (const ElementId e : trial.state.shells[edge]) {
        Swept<D> s{e, trial.valid(e), jacobian_with(trial, e, edge, from), jacobian_with(trial, e, edge, to), 1, 0, 0};
        s.scale = std::max(scale_of(s.at_0), scale_of(s.at_1));
        s.min_at_1 = *std::min_element(s.at_1.coefficients.begin(), s.at_1.coefficients.end()) / s.scale;
        s.min_needed = trial.state.options.min_scaled_jacobian * (1 + 0x1p-40) +
                       4 * std::max(s.at_0.error, s.at_1.error) / s.scale;
        shell.push_back(s);
    }
    return shell;
}

template <int D>
void append(const Swept<D>& s, double floor, std::vector<AffineConstraint>& constraints) {
    for (int i = 0; i < jacobian_coefficients<D>; ++i)
        constraints.push_back({s.at_0.coefficients[i] / s.scale, s.at_1.coefficients[i] / s.scale, floor});
}

/// The same without the coefficients that do not contain the node: they cap a minimum that it cannot raise.
template <int D>
void append_moving(const Swept<D>& s, std::vector<AffineConstraint>& constraints) {
    for (int i = 0; i < jacobian_coefficients<D>; ++i)
        if (s.at_0.coefficients[i] != s.at_1.coefficients[i])
            constraints.push_back({s.at_0.coefficients[i] / s.scale, s.at_1.coefficients[i] / s.scale, 0});
}

/// What a programme asks of the elements that are not valid: all of them repaired or only one, and how well.
struct Demand {
    bool whole_shell;
    bool to_target;
};
constexpr std::array<Demand, 4> demands{{{true, true}, {false, true}, {true, false}, {false, false}}};

/// Valid elements keep their coefficients, or the target where they have more.
template <int D>
double floor_of(const Trial<D>& trial, const Swept<D>& s, ElementId e, Demand demand) {
    const double target = std::max(trial.state.options.target, s.min_needed);
    if (s.valid) return std::min(target, s.min_at_1);
    if (demand.whole_shell || s.element == e) return demand.to_target ? target : s.min_needed;
    return s.min_at_1;
}

/// A place for a node, and what it is worth: lower is better.
struct Candidate {
    EdgeId edge;
    double theta;
    double rank, loss;
    friend bool operator<(const Candidate& a, const Candidate& b) {
        return std::tuple(a.rank, a.loss, a.edge) < std::tuple(b.rank, b.loss, b.edge);
    }
};

/// How much of the edge's curvature a step to θ takes.
template <int D>
double loss(const Trial<D>& trial, EdgeId edge, double theta) {
    return (1 - theta) * distance(trial.node(edge).point, trial.middle(edge).point) / trial.length(edge);
}

/// The farthest θ that repairs the element, by the first demand that can be met.
template <int D>
std::optional<Candidate> repairing_candidate(const Trial<D>& trial, ElementId e, EdgeId edge,
                                             std::span<const Demand> allowed) {
    const auto shell = swept_shell(trial, edge, trial.middle(edge), trial.node(edge));
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

/// Σ over elements that are not valid and their coefficients of what is missing to the target.
template <int D>
double missing(const Trial<D>& trial, const BoundedJacobian<D>& j) {
    double sum = 0;
    for (const double c : j.coefficients) sum += std::max(0.0, trial.state.options.target - c / scale_of(j));
    return sum;
}

/// The θ with the largest smallest coefficient of the elements that are not valid, while the valid ones hold.
template <int D>
std::optional<Candidate> helping_candidate(const Trial<D>& trial, EdgeId edge) {
    const LagrangeNode<D> middle = trial.middle(edge);
    const auto shell = swept_shell(trial, edge, middle, trial.node(edge));
    std::vector<AffineConstraint> kept, raised;
    for (const auto& s : shell) {
        if (s.valid)
            append(s, floor_of(trial, s, s.element, demands[0]), kept);
        else
            append_moving(s, raised);
    }
    const auto within = feasible(kept);
    if (!within || raised.empty()) return {};
    const double theta = highest_minimum(raised, *within);
    if (!(theta < 1)) return {};
    double before = 0;
    double after = 0;
    const LagrangeNode<D> there = trial.towards_middle(edge, theta);
    for (const auto& s : shell) {
        if (s.valid) continue;
        before += missing(trial, s.at_1);
        after += missing(trial, jacobian_with(trial, s.element, edge, there));
    }
    // Steps that hardly help are not worth the curvature.
    if (!(after < 0.95 * before)) return {};
    return Candidate{edge, theta, after / before, 0};
}

/// Moves the node there unless that breaks a valid element.
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
    for (const EdgeId edge : loose_edges(trial, e, group))
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
    for (const auto& s : swept_shell(trial, edge, from, to)) {
        const double now = *std::min_element(s.at_0.coefficients.begin(), s.at_0.coefficients.end()) / s.scale;
        append(s, std::min(now, std::max(trial.state.options.target, s.min_needed)), constraints);
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

#define CAMBER_INSTANTIATE(D)                                                \
    template bool repair_element<D>(Trial<D>&, ElementId, EdgeGroup, Steps); \
    template bool put_back<D>(Trial<D>&, EdgeId);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
