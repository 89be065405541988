module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>
module camber.interpolation;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

constexpr std::size_t quantities = Integrals::quantities;
using Squares = std::array<double, quantities>;

/// Points a direction, from level to level; then the last but one again on parts, divided up to `deepest` times.
constexpr std::array<int, 4> points_a_direction{4, 6, 8, 12};
constexpr int divided_rule = 2;
constexpr int deepest = 4;
constexpr int highest_level = static_cast<int>(points_a_direction.size()) - 1 + deepest;
/// Elements between two of which a new evaluator is made.
constexpr std::size_t elements_at_once = 64;

enum class Sides : std::uint8_t { straight, curved };

/// The element's places and values, as they are to be integrated.
template <int D>
Piece<D> piece_of(const QuadraticMesh<D>& mesh, std::size_t e, Sides sides, Integrator<D>& integrator) {
    constexpr std::size_t corners = D + 1, nodes = quadratic_nodes<D>;
    const SimplexVertices<D>& vertices = mesh.linear.elements.vertices[e];
    std::array<Vec<D>, nodes> at;
    std::array<double, nodes> u{};
    for (std::size_t i = 0; i < corners; ++i) at[i] = mesh.linear.points[vertices[i]];
    Piece<D> piece;
    piece.straight = sides == Sides::straight;
    piece.origin = at[0];
    for (std::size_t i = 0; i < corners; ++i) piece.places.corners[i] = at[i] - at[0];
    for (std::size_t k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        const Vec<D> middle = midpoint(at[static_cast<std::size_t>(i)], at[static_cast<std::size_t>(j)]);
        const EdgeId edge = mesh.edges.of_elements[e][k];
        at[corners + k] = piece.straight ? middle : mesh.mid_nodes[edge].point;
        piece.places.bubbles[k] = at[corners + k] - middle;
    }
    integrator.evaluate(at, u);
    double largest = 0;
    for (std::size_t i = 0; i < nodes; ++i) largest = std::max(largest, std::abs(u[i]));
    for (std::size_t i = 0; i < corners; ++i) piece.values[0].corners[i] = u[i];
    for (std::size_t k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        piece.values[0].bubbles[k] =
            u[corners + k] - (u[static_cast<std::size_t>(i)] + u[static_cast<std::size_t>(j)]) / 2;
    }
    piece.interpolants = piece.straight ? 2 : 1;
    if (piece.straight) piece.values[1].corners = piece.values[0].corners;

    // Values err by their own digits, and by those of the places where they are asked for: by |x_k| times the slope
    // along each axis, which the difference of two values by that of their places bounds from below.
    double slope = 0, distant = 0;
    for (std::size_t i = 1; i < nodes; ++i) slope = std::max(slope, std::abs(u[i] - u[0]) / distance(at[i], at[0]));
    for (int c = 0; c < D; ++c) distant = std::max(distant, std::abs(at[0][c]));
    piece.rounding = std::numeric_limits<double>::epsilon() * (2 * largest + slope * distant);
    return piece;
}

Squares effective_change(const Integrals& now, const Integrals& before) {
    Squares change{};
    for (std::size_t q = 0; q < quantities; ++q) {
        const double noise = q % 2 == 0 ? now.l2_rounding : now.h1_rounding;
        const double blur = 4 * (noise + std::sqrt(noise * now.squares[q]));
        change[q] = std::max(0.0, std::abs(now.squares[q] - before.squares[q]) - blur);
    }
    if (now.turned || before.turned) change[1] = change[3] = 0;
    return change;
}

template <int D>
using Rules = std::vector<CollapsedRule<D>>;

/// The integrals over a piece and by how much they changed at last.
struct Integrated {
    Integrals integrals;
    Squares change{};
    std::size_t evaluations = 0;
};

/// Parts of parts, as deep as told, wherever the parts together differ from the whole by more than `enough`.
template <int D>
Integrated integrate_parts(const Piece<D>& whole, const Integrals& of_whole, const Squares& enough, int depth,
                           const CollapsedRule<D>& rule, Integrator<D>& integrator) {
    const auto pieces = divided<D>(whole);
    std::array<Integrals, (1U << D)> each_of;
    Integrated sum;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
        each_of[k] = integrator.integrate(pieces[k], rule);
        sum.integrals += each_of[k];
        sum.evaluations += rule.count;
    }
    sum.change = effective_change(sum.integrals, of_whole);
    bool done = depth == 1;
    bool small = true;
    Squares less{};
    for (std::size_t q = 0; q < quantities; ++q) {
        small = small && sum.change[q] <= enough[q];
        less[q] = enough[q] / 4;  // some of the parts are as rough as the whole; few of them all
    }
    done = done || small;
    if (done) return sum;
    Integrated finer;
    finer.evaluations = sum.evaluations;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
        const Integrated part = integrate_parts(pieces[k], each_of[k], less, depth - 1, rule, integrator);
        finer.integrals += part.integrals;
        finer.evaluations += part.evaluations;
        for (std::size_t q = 0; q < quantities; ++q) finer.change[q] += part.change[q];
    }
    return finer;
}

/// What is known of one element.
struct State {
    Integrals integrals;
    Squares change{};  ///< by the last refinement
    std::uint32_t evaluations = 0;
    std::int8_t level = -1;
};

/// The integrals over all elements, straight or curved.
template <int D>
class Quadrature {
  public:
    Quadrature(const QuadraticMesh<D>& mesh, const ScalarField<D>& field, const Rules<D>& rules, Sides sides,
               double tolerance, const Execution& execution)
        : mesh_(mesh),
          field_(field),
          rules_(rules),
          sides_(sides),
          tolerance_(tolerance),
          execution_(execution),
          states_(mesh.linear.elements.size()) {}

    /// Level after level, until what the last refinements changed is small in all. `active`: the elements to look at.
    Outcome<Done> integrate(std::vector<std::uint32_t> active) {
        for (State& s : states_) s = State{};
        while (!active.empty()) {
            if (auto done = refine(active); !done) return done;
            active = unsettled();
        }
        return Done{};
    }

    [[nodiscard]] const Buffer<State>& states() const { return states_; }
    [[nodiscard]] std::size_t unresolved() const { return unresolved_; }
    void take_over(std::size_t e, const State& state) { states_[e] = state; }

  private:
    Outcome<Done> refine(const std::vector<std::uint32_t>& active) {
        const Squares enough = enough_of_parts();
        auto done = each_chunk(
            execution_, active.size(),
            [&](std::size_t begin, std::size_t end) {
                Integrator<D> integrator(field_());
                for (std::size_t i = begin; i < end; ++i) refine(active[i], enough, integrator);
            },
            elements_at_once);
        if (!done) return done;
        for (const std::uint32_t e : active)
            for (const double s : states_[e].integrals.squares)
                if (!std::isfinite(s)) return fail(not_finite(e));
        return Done{};
    }

    void refine(std::uint32_t e, const Squares& enough, Integrator<D>& integrator) const {
        State& state = states_[e];
        const Piece<D> piece = piece_of(mesh_, e, sides_, integrator);
        const Integrals before = state.integrals;
        const int depth = ++state.level - static_cast<int>(points_a_direction.size()) + 1;
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

    [[nodiscard]] Squares total() const {
        Squares sum{};
        for (const State& s : states_)
            for (std::size_t q = 0; q < quantities; ++q) sum[q] += s.integrals.squares[q];
        return sum;
    }

    /// What parts of an element may differ by: a share of that which an element has on average.
    [[nodiscard]] Squares enough_of_parts() const {
        Squares share = total();
        for (double& s : share) s *= tolerance_ / 4 / static_cast<double>(std::max<std::size_t>(1, states_.size()));
        return share;
    }

    /// The elements to be refined: for each quantity those with the largest changes, as many as leave the others'
    /// changes small in sum. Nothing is left to do where all changes are.
    [[nodiscard]] std::vector<std::uint32_t> unsettled() {
        const Squares all = total();
        Squares threshold{};
        for (std::size_t q = 0; q < quantities; ++q) threshold[q] = threshold_of(q, 2 * tolerance_ * all[q]);
        std::vector<std::uint32_t> chosen;
        unresolved_ = 0;
        for (std::size_t e = 0; e < states_.size(); ++e) {
            bool wanted = false;
            for (std::size_t q = 0; q < quantities; ++q) wanted = wanted || states_[e].change[q] > threshold[q];
            if (!wanted) continue;
            if (states_[e].level < highest_level)
                chosen.push_back(static_cast<std::uint32_t>(e));
            else
                ++unresolved_;
        }
        return chosen;
    }

    /// The change beyond which elements are refined, so that the others' come to half of what is allowed; none when
    /// all of them are allowed already.
    [[nodiscard]] double threshold_of(std::size_t q, double allowed) const {
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

    /// Why an element's integrals are no numbers.
    [[nodiscard]] Error not_finite(std::uint32_t e) const {
        Integrator<D> integrator(field_());
        static_cast<void>(integrator.integrate(piece_of(mesh_, e, sides_, integrator), rules_[0]));
        const Entity element{simplex_name<D>, e + 1U};
        const auto told = [&](const Vec<D>& x, double value) {
            std::ostringstream text;
            text.precision(10);
            text << "the field is " << value << " at ";
            for (int c = 0; c < D; ++c) text << (c > 0 ? ", " : "(") << x[c];
            text << ')';
            return Error{ErrorKind::usage, text.str(), {}, element, "it must be finite wherever the mesh is"};
        };
        std::optional<Error> found;
        const auto look = [&](std::span<const Vec<D>> points, std::span<const double> values) {
            for (std::size_t p = 0; p < points.size() && !found; ++p)
                if (!std::isfinite(values[p])) found = told(points[p], values[p]);
        };
        std::array<Vec<D>, quadratic_nodes<D>> nodes;
        std::array<double, quadratic_nodes<D>> u{};
        for (std::size_t i = 0; i <= D; ++i) nodes[i] = mesh_.linear.points[mesh_.linear.elements.vertices[e][i]];
        for (std::size_t k = 0; k < edges_per_simplex<D>; ++k) {
            const auto [i, j] = local_edges<D>[k];
            nodes[D + 1 + k] = sides_ == Sides::curved
                                   ? mesh_.mid_nodes[mesh_.edges.of_elements[e][k]].point
                                   : midpoint(nodes[static_cast<std::size_t>(i)], nodes[static_cast<std::size_t>(j)]);
        }
        integrator.evaluate(nodes, u);
        look(nodes, u);
        for (const CollapsedRule<D>& rule : rules_) {
            if (found) break;
            static_cast<void>(integrator.integrate(piece_of(mesh_, e, sides_, integrator), rule));
            look(integrator.points(), integrator.values());
        }
        if (found) return *found;
        return Error{ErrorKind::usage,
                     "the squares of the field's error are beyond the range of numbers",
                     {},
                     element,
                     "scale the field, or the mesh"};
    }

    const QuadraticMesh<D>& mesh_;
    const ScalarField<D>& field_;
    const Rules<D>& rules_;
    Sides sides_;
    double tolerance_;
    const Execution& execution_;
    mutable Buffer<State> states_;
    std::size_t unresolved_ = 0;
};

/// Sum, uncertainty and column of one quantity.
ErrorNorm norm_of(const Buffer<State>& states, std::size_t q) {
    ErrorNorm norm;
    Buffer<double> squares(states.size());
    double sum = 0, change = 0, rounding = 0;
    for (std::size_t e = 0; e < states.size(); ++e) {
        squares[e] = states[e].integrals.squares[q];
        sum += squares[e];
        change += states[e].change[q];
        rounding += q % 2 == 0 ? states[e].integrals.l2_rounding : states[e].integrals.h1_rounding;
    }
    norm.value = std::sqrt(sum);
    norm.uncertainty = sum > 0 ? change / sum / 2 : 0;
    norm.rounding = std::sqrt(rounding);
    norm.squares = std::move(squares);
    return norm;
}

std::size_t turned(const Buffer<State>& states) {
    return static_cast<std::size_t>(
        std::count_if(states.begin(), states.end(), [](const State& s) { return s.integrals.turned; }));
}

/// Every node exactly in the middle of its edge.
template <int D>
bool is_straight(const QuadraticMesh<D>& mesh, std::size_t e) {
    const auto& edges = mesh.edges.of_elements[e];
    return std::all_of(edges.begin(), edges.end(), [&](EdgeId edge) {
        const auto& [a, b] = mesh.edges.vertices[edge];
        return mesh.mid_nodes[edge].point == midpoint(mesh.linear.points[a], mesh.linear.points[b]);
    });
}

template <int D>
Outcome<InterpolationError> errors_of(const QuadraticMesh<D>& mesh, const ScalarField<D>& field,
                                      const InterpolationOptions& options, const Execution& execution) {
    if (auto sound = check_limits(options); !sound) return fail(sound.error());
    const std::size_t elements = mesh.linear.elements.size();
    Rules<D> rules;
    for (const int n : points_a_direction) rules.emplace_back(n);
    std::vector<std::uint32_t> all(elements), bent;
    for (std::size_t e = 0; e < elements; ++e) {
        all[e] = static_cast<std::uint32_t>(e);
        if (!is_straight(mesh, e)) bent.push_back(all[e]);
    }
    Quadrature<D> straight(mesh, field, rules, Sides::straight, options.tolerance, execution);
    if (auto done = straight.integrate(std::move(all)); !done) return fail(done.error());
    Quadrature<D> curved(mesh, field, rules, Sides::curved, options.tolerance, execution);
    if (auto done = curved.integrate(bent); !done) return fail(done.error());

    InterpolationError error;
    for (const auto* states : {&straight.states(), &curved.states()})
        for (const State& s : *states) error.evaluations += s.evaluations;
    error.unresolved = straight.unresolved() + curved.unresolved();
    for (std::size_t e = 0, next = 0; e < elements; ++e) {
        if (next < bent.size() && bent[next] == e)
            ++next;
        else
            curved.take_over(e, straight.states()[e]);
    }
    error.straight = {norm_of(straight.states(), 0), norm_of(straight.states(), 1)};
    error.linear = {norm_of(straight.states(), 2), norm_of(straight.states(), 3)};
    error.curved = {norm_of(curved.states(), 0), norm_of(curved.states(), 1)};
    error.straight_turned = turned(straight.states());
    error.curved_turned = turned(curved.states());
    return error;
}

}  // namespace

template <int D>
Outcome<InterpolationError> interpolation_error(const QuadraticMesh<D>& mesh, const ScalarField<D>& field,
                                                const InterpolationOptions& options, const Execution& execution) {
    return guarded([&] { return errors_of(mesh, field, options, execution); });
}

template Outcome<InterpolationError> interpolation_error<2>(const QuadraticMesh<2>&, const ScalarField<2>&,
                                                            const InterpolationOptions&, const Execution&);
template Outcome<InterpolationError> interpolation_error<3>(const QuadraticMesh<3>&, const ScalarField<3>&,
                                                            const InterpolationOptions&, const Execution&);

}  // namespace camber
