module;
#include <array>
#include <cstddef>
#include <cstdint>
module camber.recovery:monomials;

namespace camber {

/// Monomials in D variables of degree at most p: C(p + D, D).
template <int D>
[[nodiscard]] constexpr int monomials_up_to(int p) {
    return D == 2 ? (p + 1) * (p + 2) / 2 : (p + 1) * (p + 2) * (p + 3) / 6;
}

/// y^α, and how it comes of one of a degree less: that times y_axis.
template <int D>
struct Monomial {
    std::array<int, D> exponents{};
    int degree = 0;
    int parent = 0;
    int axis = 0;
};

/// The place of y^α among all: by degree, then by the exponent of the last variable, and so on. Within a degree that is
/// the order of Vec, Sym and CubicForm.
template <int D>
[[nodiscard]] constexpr int place_of(const std::array<int, D>& exponents) {
    int degree = 0;
    for (const int a : exponents) degree += a;
    int place = degree > 0 ? monomials_up_to<D>(degree - 1) : 0;
    if constexpr (D == 2) return place + exponents[1];
    if constexpr (D == 3) {
        for (int c = 0; c < exponents[2]; ++c) place += degree - c + 1;
        return place + exponents[1];
    }
}

/// All monomials of degree at most P, in that order.
template <int D, int P>
inline constexpr auto monomials = [] {
    std::array<Monomial<D>, monomials_up_to<D>(P)> all{};
    const auto put = [&](const std::array<int, D>& exponents, int degree) {
        Monomial<D>& m = all[place_of<D>(exponents)];
        m.exponents = exponents;
        m.degree = degree;
        if (degree == 0) return;
        std::array<int, D> less = exponents;
        while (less[m.axis] == 0) ++m.axis;
        --less[m.axis];
        m.parent = place_of<D>(less);
    };
    for (int degree = 0; degree <= P; ++degree)
        for (int last = 0; last <= degree; ++last) {
            if constexpr (D == 2) put({degree - last, last}, degree);
            if constexpr (D == 3)
                for (int middle = 0; middle <= degree - last; ++middle)
                    put({degree - last - middle, middle, last}, degree);
        }
    return all;
}();

/// Of each two monomials of degree at most P the place of their product among those of degree 2 P.
template <int D, int P>
inline constexpr auto products = [] {
    constexpr std::size_t n = monomials_up_to<D>(P);
    std::array<std::array<std::uint16_t, n>, n> places{};
    for (std::size_t a = 0; a < n; ++a)
        for (std::size_t b = 0; b < n; ++b) {
            std::array<int, D> sum{};
            for (int i = 0; i < D; ++i) sum[i] = monomials<D, P>[a].exponents[i] + monomials<D, P>[b].exponents[i];
            places[a][b] = static_cast<std::uint16_t>(place_of<D>(sum));
        }
    return places;
}();

}  // namespace camber
