module;
#include <array>
#include <cstddef>
module camber.recovery:at_lattice;
import camber.bezier;
import camber.core;
import :element_values;
import :fit;
import :monomials;

namespace camber {

/// A polynomial in y at the lattice of the element whose first vertex and axes these are, in y.
template <int D, int P>
[[nodiscard]] std::array<double, node_count<lattice_degree, D>> values_at_lattice(const Coefficients<D, P>& c,
                                                                                  const Vec<D>& first,
                                                                                  const std::array<Vec<D>, D>& axes) {
    constexpr auto& lattice = multi_indices<lattice_degree, D>;
    std::array<double, node_count<lattice_degree, D>> values{};
    for (std::size_t q = 0; q < lattice.size(); ++q) {
        Vec<D> y = first;
        for (std::size_t a = 0; a < D; ++a) y += lattice[q][a + 1] * (1.0 / lattice_degree) * axes[a];
        std::array<double, monomials_up_to<D>(P)> m{1.0};
        values[q] = c[0];
        for (std::size_t i = 1; i < m.size(); ++i) {
            m[i] = m[monomials<D, P>[i].parent] * y[monomials<D, P>[i].axis];
            values[q] += c[i] * m[i];
        }
    }
    return values;
}

}  // namespace camber
