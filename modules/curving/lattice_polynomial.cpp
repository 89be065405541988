module;
#include <algorithm>
#include <array>
#include <cstddef>
module camber.curving;
import camber.core;
import camber.bezier;
import :lattice_polynomial;
import :solution_nodes;

namespace camber {

namespace {

template <int D>
using Polynomial = std::array<double, lattice_size<D>>;

/// Its place among `exponents`.
template <int D>
std::size_t place_of(const std::array<int, D>& exponent) {
    const auto& all = exponents<D, known_degree>;
    return static_cast<std::size_t>(std::ranges::find(all, exponent) - all.begin());
}

/// p · (slope_1 x_1 + … + constant), p of a degree below the highest.
template <int D>
Polynomial<D> times_linear(const Polynomial<D>& p, const std::array<double, D>& slope, double constant) {
    Polynomial<D> product{};
    for (std::size_t i = 0; i < p.size(); ++i) {
        if (p[i] == 0) continue;
        product[i] += constant * p[i];
        for (std::size_t a = 0; a < D; ++a) {
            auto exponent = exponents<D, known_degree>[i];
            ++exponent[a];
            if (slope[a] != 0) product[place_of<D>(exponent)] += slope[a] * p[i];
        }
    }
    return product;
}

/// φ_α = ∏_i ∏_{m < α_i} (n ξ_i − m)/(m + 1), with ξ_0 = 1 − x_1 − ….
template <int D>
Polynomial<D> lagrange_polynomial(const MultiIndex<D>& alpha) {
    constexpr double n = known_degree;
    Polynomial<D> p{};
    p[0] = 1;
    for (std::size_t i = 0; i <= D; ++i)
        for (int m = 0; m < alpha[i]; ++m) {
            std::array<double, D> slope{};
            if (i == 0)
                slope.fill(-n / (m + 1));
            else
                slope[i - 1] = n / (m + 1);
            p = times_linear<D>(p, slope, ((i == 0 ? n : 0) - m) / (m + 1));
        }
    return p;
}

template <int D>
LatticeBasis<D> made_basis() {
    LatticeBasis<D> basis{};
    for (std::size_t node = 0; node < lattice_size<D>; ++node) {
        const Polynomial<D> p = lagrange_polynomial<D>(multi_indices<known_degree, D>[node]);
        for (std::size_t c = 0; c < p.size(); ++c) basis[c][node] = p[c];
    }
    return basis;
}

}  // namespace

template <int D>
const LatticeBasis<D>& lattice_basis() {
    static const LatticeBasis<D> basis = made_basis<D>();
    return basis;
}

template const LatticeBasis<2>& lattice_basis<2>();
template const LatticeBasis<3>& lattice_basis<3>();

}  // namespace camber
