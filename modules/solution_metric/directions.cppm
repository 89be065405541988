module;
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
module camber.solution_metric:directions;
import camber.core;

namespace camber {

/// Of yᵀLy the factor of each entry of L.
template <int D>
[[nodiscard]] constexpr std::array<double, sym_size<D>> quadratic_row(const Vec<D>& y) {
    std::array<double, sym_size<D>> row{};
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j) row[Sym<D>::index(i, j)] = (i == j ? 1 : 2) * y[i] * y[j];
    return row;
}

/// Of T[y, y, y] the factor of each entry of T.
template <int D>
[[nodiscard]] constexpr std::array<double, cubic_size<D>> cubic_row(const Vec<D>& y) {
    std::array<double, cubic_size<D>> row{};
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j)
            for (int k = 0; k < D; ++k) row[CubicForm<D>::index(i, j, k)] += y[i] * y[j] * y[k];
    return row;
}

/// Directions, ±y alike, evenly over the sphere. The first n(n+1)/2 of them are the basis to begin with: their yyᵀ are
/// independent and sum to a multiple of the identity (in 2D three at 60 degrees, in 3D the axes of an icosahedron).
template <int D>
struct Directions {
    static constexpr int packs = D == 2 ? 6 : 16;
    static constexpr int count = packs * pack_size;

    std::array<Vec<D>, count> unit;
    std::array<std::array<Pack, sym_size<D>>, packs> quadratic{};
    std::array<std::array<Pack, cubic_size<D>>, packs> cubic{};

    Directions() : unit(evenly()) {
        for (std::size_t i = 0; i < count; ++i) {
            const auto q = quadratic_row(unit[i]);
            const auto c = cubic_row(unit[i]);
            for (std::size_t k = 0; k < q.size(); ++k) quadratic[i / pack_size][k][i % pack_size] = q[k];
            for (std::size_t k = 0; k < c.size(); ++k) cubic[i / pack_size][k][i % pack_size] = c[k];
        }
    }

  private:
    [[nodiscard]] static std::array<Vec<D>, count> evenly() {
        std::array<Vec<D>, count> out;
        if constexpr (D == 2) {
            static_assert(count % 3 == 0);
            int next = 3;
            for (int i = 0; i < count; ++i) {
                const double angle = std::numbers::pi * i / count;
                const bool is_first = i % (count / 3) == 0;
                out[is_first ? i / (count / 3) : next++] = {{cos(angle), sin(angle)}};
            }
        } else {
            const double golden = std::numbers::phi, length = std::sqrt(1 + golden * golden);
            for (int i = 0; i < 3; ++i)
                for (int sign = 0; sign < 2; ++sign) {
                    Vec<3>& y = out[2 * i + sign];
                    y[i] = 1 / length;
                    y[(i + 1) % 3] = (sign == 0 ? golden : -golden) / length;
                }
            // Fibonacci's spiral over half a sphere.
            constexpr int spiral = count - 6;
            for (int i = 0; i < spiral; ++i) {
                const double z = 1 - (i + 0.5) / spiral, r = std::sqrt(1 - z * z);
                const double angle = 2 * std::numbers::pi * (i + 0.5) * golden;
                out[6 + i] = {{r * cos(angle), r * sin(angle), z}};
            }
        }
        return out;
    }
};

}  // namespace camber
