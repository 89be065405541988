// Adaptive refinement of element quadratures.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <sstream>
#include <vector>
module camber.interpolation;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// Points per direction at each level. Higher levels use the last but one of these rules on parts of the element,
/// divided up to `deepest` times.
constexpr std::array<int, 4> points_of_levels{4, 6, 8, 12};
constexpr int divided_rule = 2;
constexpr int deepest = 4;
constexpr int highest_level = static_cast<int>(points_of_levels.size()) - 1 + deepest;
constexpr std::size_t elements_at_once = 64;
/// Limits of the number of field evaluations, because integrals over jumps of the field do not converge.
constexpr double values_an_element = 2000, values_at_least = 1e8;

constexpr int depth_of(int level) { return level + 1 - static_cast<int>(points_of_levels.size()); }

}  // namespace

template <int D>
Rules<D> quadrature_rules() {
    Rules<D> rules;
    for (const int n : points_of_levels) rules.emplace_back(n);
    return rules;
}

template <int D>
Outcome<Done> Quadrature<D>::integrate(const Squares& beside) {
    beside_ = beside;
    std::vector<std::uint32_t> active(elements_.size());
    std::iota(active.begin(), active.end(), 0U);
    while (!active.empty()) {
        if (auto done = refine(active); !done) return done;
        active = unsettled();
        if (affordable(active)) continue;
        unresolved_ += active.size();
        break;
    }
    return Done{};
}

template <int D>
Outcome<Done> Quadrature<D>::refine(const std::vector<std::uint32_t>& active) {
    const Squares enough = enough_of_parts();
    auto done = each_chunk(
        execution_, active.size(),
        [&](std::size_t begin, std::size_t end) {
            Integrator<D> integrator(field_());
            for (std::size_t i = begin; i < end; ++i) refine(active[i], enough, integrator);
        },
        elements_at_once);
    if (!done) return done;
    for (const std::uint32_t row : active)
        for (const double s : states_[row].integrals.squares)
            if (!std::isfinite(s)) return fail(not_finite(row));
    return Done{};
}

template <int D>
void Quadrature<D>::refine(std::uint32_t row, const Squares& enough, Integrator<D>& integrator) {
    State& state = states_[row];
    const Piece<D> piece = piece_of(mesh_, elements_[row], sides_, nodal_, integrator);
    const Integrals before = state.integrals;
    const int depth = depth_of(++state.level);
    if (depth <= 0) {
        const CollapsedRule<D>& rule = rules_[static_cast<std::size_t>(state.level)];
        state.integrals = integrator.integrate(piece, rule);
        state.change = state.level == 0 ? state.integrals.squares : effective_change(state.integrals, before);
        state.evaluations += static_cast<std::uint32_t>(rule.count + quadratic_nodes<D>);
        return;
    }
    const CollapsedRule<D>& rule = rules_[divided_rule];
    const Integrals whole = integrator.integrate(piece, rule);
    const Integrated parts = integrate_parts(piece, whole, enough, depth, rule, integrator);
    state.integrals = parts.integrals;
    state.change = parts.change;
    state.evaluations += static_cast<std::uint32_t>(parts.evaluations + rule.count + quadratic_nodes<D>);
}

template <int D>
bool Quadrature<D>::affordable(const std::vector<std::uint32_t>& active) const {
    auto values = static_cast<double>(evaluations());
    for (const std::uint32_t row : active)
        if (const int depth = depth_of(states_[row].level + 1); depth > 0)
            values += static_cast<double>(rules_[divided_rule].count) * pow(1U << D, depth);
    return values <= values_at_least + values_an_element * static_cast<double>(mesh_.linear.elements.size());
}

template <int D>
std::size_t Quadrature<D>::evaluations() const {
    std::size_t sum = 0;
    for (const State& s : states_) sum += s.evaluations;
    return sum;
}

template <int D>
Squares Quadrature<D>::total() const {
    Squares sum = beside_;
    for (const State& s : states_)
        for (std::size_t q = 0; q < sum.size(); ++q) sum[q] += s.integrals.squares[q];
    return sum;
}

/// Returns the tolerance for parts of an element, a fraction of the mean squared error per element.
template <int D>
Squares Quadrature<D>::enough_of_parts() const {
    Squares share = total();
    for (double& s : share)
        s *= tolerance_ / 4 / static_cast<double>(std::max<std::size_t>(1, mesh_.linear.elements.size()));
    return share;
}

/// Returns the elements to refine. For each quantity these are the elements with the largest changes; the changes of
/// all others have a small sum.
template <int D>
std::vector<std::uint32_t> Quadrature<D>::unsettled() {
    const Squares all = total();
    Squares threshold{};
    for (std::size_t q = 0; q < threshold.size(); ++q) threshold[q] = threshold_of(q, 2 * tolerance_ * all[q]);
    std::vector<std::uint32_t> chosen;
    unresolved_ = 0;
    for (std::size_t row = 0; row < states_.size(); ++row) {
        bool needs_refinement = false;
        for (std::size_t q = 0; q < threshold.size(); ++q)
            needs_refinement = needs_refinement || states_[row].change[q] > threshold[q];
        if (!needs_refinement) continue;
        if (states_[row].level < highest_level)
            chosen.push_back(static_cast<std::uint32_t>(row));
        else
            ++unresolved_;
    }
    return chosen;
}

/// Returns the change of quantity q above which an element is refined. Smaller changes have a sum of at most half of
/// `allowed`. Infinite if the sum of all changes is at most `allowed`.
template <int D>
double Quadrature<D>::threshold_of(std::size_t q, double allowed) const {
    std::vector<double> changes;
    double sum = 0;
    for (const State& s : states_) {
        sum += s.change[q];
        if (s.change[q] > 0) changes.push_back(s.change[q]);
    }
    if (sum <= allowed) return std::numeric_limits<double>::infinity();
    std::sort(changes.begin(), changes.end());
    double small = 0;
    for (const double change : changes) {
        small += change;
        if (small > allowed / 2) return std::nextafter(change, 0.0);
    }
    return 0;
}

template <int D>
Error Quadrature<D>::not_finite(std::uint32_t row) const {
    Integrator<D> integrator(field_());
    return find_not_finite(mesh_, elements_[row], sides_, rules_, integrator);
}

template <int D>
Error find_not_finite(const QuadraticMesh<D>& mesh, std::size_t e, Sides sides, const Rules<D>& rules,
                      Integrator<D>& integrator) {
    const Entity element{simplex_name<D>, e + 1U};
    constexpr const char* remedy = "it must be finite in the whole mesh";
    const auto look = [&](std::span<const Vec<D>> points, std::span<const double> values) -> std::optional<Error> {
        for (std::size_t p = 0; p < points.size(); ++p) {
            if (std::isfinite(values[p])) continue;
            std::ostringstream text;
            text.precision(10);
            text << "the field is " << values[p] << " at ";
            for (int c = 0; c < D; ++c) text << (c > 0 ? ", " : "(") << points[p][c];
            text << ')';
            return Error{ErrorKind::usage, text.str(), {}, element, remedy};
        }
        return {};
    };
    const auto nodes = nodes_of(mesh, e, sides);
    std::array<double, quadratic_nodes<D>> u{};
    integrator.evaluate(nodes, u);
    if (auto found = look(nodes, u)) return *found;
    for (const CollapsedRule<D>& rule : rules) {
        static_cast<void>(integrator.integrate(piece_of(mesh, e, sides, {}, integrator), rule));
        if (auto found = look(integrator.points(), integrator.values())) return *found;
    }
    return Error{ErrorKind::usage,
                 "the field or the square of its error is too large for a floating-point number",
                 {},
                 element,
                 remedy};
}

#define CAMBER_INSTANTIATE(D)                \
    template Rules<D> quadrature_rules<D>(); \
    template class Quadrature<D>;            \
    template Error find_not_finite<D>(const QuadraticMesh<D>&, std::size_t, Sides, const Rules<D>&, Integrator<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
