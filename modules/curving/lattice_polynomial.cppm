module;
#include <array>
#include <cstddef>
export module camber.curving:lattice_polynomial;
import camber.core;
import camber.bezier;
import :solution_nodes;

/// A function within an element by a polynomial that is known by its values at a lattice.
namespace camber {

template <int D>
inline constexpr int lattice_size = node_count<known_degree, D>;

/// How many monomials there are up to a degree.
template <int D>
[[nodiscard]] constexpr int monomials(int degree) {
    return D == 2 ? (degree + 1) * (degree + 2) / 2 : (degree + 1) * (degree + 2) * (degree + 3) / 6;
}

/// Exponents of all monomials up to a degree, the first coordinate's fastest.
template <int D, int Degree>
inline constexpr auto exponents = [] {
    std::array<std::array<int, D>, monomials<D>(Degree)> all{};
    int n = 0;
    if constexpr (D == 2) {
        for (int b = 0; b <= Degree; ++b)
            for (int a = 0; a + b <= Degree; ++a) all[n++] = {a, b};
    } else {
        for (int c = 0; c <= Degree; ++c)
            for (int b = 0; b + c <= Degree; ++b)
                for (int a = 0; a + b + c <= Degree; ++a) all[n++] = {a, b, c};
    }
    return all;
}();

/// [coefficient of `exponents`][node of the lattice]: the Lagrange basis in the reference simplex whose vertices are 0
/// and the ends of the axes.
template <int D>
using LatticeBasis = std::array<std::array<double, lattice_size<D>>, lattice_size<D>>;
template <int D>
[[nodiscard]] const LatticeBasis<D>& lattice_basis();

template <int D>
using PackVec = std::array<Pack, D>;

/// A value and the derivatives by the coordinates.
template <int D>
struct PackSlope {
    Pack value;
    PackVec<D> gradient;
};

/// A polynomial by its coefficients, by Horner's rule.
template <int D, int Degree>
struct PackPolynomial {
    std::array<Pack, monomials<D>(Degree)> c;

    [[nodiscard, gnu::always_inline]] PackSlope<D> at(const PackVec<D>& x) const {
        if constexpr (D == 2) {
            return plane(x, monomials<D>(Degree), Degree);
        } else {
            PackSlope<D> sum{packed(0), {packed(0), packed(0), packed(0)}};
            int end = monomials<D>(Degree);
            for (int left = 0; left <= Degree; ++left) {  // degree that is left beside the third coordinate
                const PackSlope<2> in_plane = plane({x[0], x[1]}, end, left);
                sum.gradient[2] = sum.gradient[2] * x[2] + sum.value;
                sum.gradient[0] = sum.gradient[0] * x[2] + in_plane.gradient[0];
                sum.gradient[1] = sum.gradient[1] * x[2] + in_plane.gradient[1];
                sum.value = sum.value * x[2] + in_plane.value;
                end -= monomials<2>(left);
            }
            return sum;
        }
    }

  private:
    /// The polynomial in two coordinates whose coefficients end there.
    [[nodiscard, gnu::always_inline]] PackSlope<2> plane(const PackVec<2>& x, int end, int degree) const {
        PackSlope<2> sum{packed(0), {packed(0), packed(0)}};
        for (int left = 0; left <= degree; ++left) {
            Pack value = c[end - 1];
            Pack slope = packed(0);
            for (int a = left - 1; a >= 0; --a) {
                slope = slope * x[0] + value;
                value = value * x[0] + c[end - 1 - left + a];
            }
            sum.gradient[1] = sum.gradient[1] * x[1] + sum.value;
            sum.gradient[0] = sum.gradient[0] * x[1] + slope;
            sum.value = sum.value * x[1] + value;
            end -= left + 1;
        }
        return sum;
    }
};

}  // namespace camber
