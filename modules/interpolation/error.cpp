module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.interpolation;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// Sum, uncertainty and column of one quantity.
ErrorNorm norm_of(const std::vector<State>& states, std::size_t q) {
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

std::size_t turned(const std::vector<State>& states) {
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
    const Rules<D> rules = quadrature_rules<D>();
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

#define CAMBER_INSTANTIATE(D)                                                                                   \
    template Outcome<InterpolationError> interpolation_error<D>(const QuadraticMesh<D>&, const ScalarField<D>&, \
                                                                const InterpolationOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
