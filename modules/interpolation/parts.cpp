module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
module camber.interpolation;
import camber.core;
import camber.bezier;

namespace camber {

Squares effective_change(const Integrals& now, const Integrals& before) {
    Squares change{};
    for (std::size_t q = 0; q < change.size(); ++q) {
        const double noise = q % 2 == 0 ? now.l2_rounding : now.h1_rounding;
        const double blur = 4 * (noise + std::sqrt(noise * now.squares[q]));
        change[q] = std::max(0.0, std::abs(now.squares[q] - before.squares[q]) - blur);
    }
    if (now.turned || before.turned) change[1] = change[3] = 0;
    return change;
}

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
    bool small = true;
    Squares less{};
    for (std::size_t q = 0; q < less.size(); ++q) {
        small = small && sum.change[q] <= enough[q];
        less[q] = enough[q] / 4;  // some of the parts are as rough as the whole; few of them all
    }
    if (small || depth <= 1) return sum;
    Integrated finer;
    finer.evaluations = sum.evaluations;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
        const Integrated part = integrate_parts(pieces[k], each_of[k], less, depth - 1, rule, integrator);
        finer.integrals += part.integrals;
        finer.evaluations += part.evaluations;
        for (std::size_t q = 0; q < less.size(); ++q) finer.change[q] += part.change[q];
    }
    return finer;
}

#define CAMBER_INSTANTIATE(D)                                                                      \
    template Integrated integrate_parts<D>(const Piece<D>&, const Integrals&, const Squares&, int, \
                                           const CollapsedRule<D>&, Integrator<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
