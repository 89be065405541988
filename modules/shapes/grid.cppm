module;
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
module camber.shapes:grid;
import camber.core;
import :random;

namespace camber {

/// Coordinates on the grid: integers in [−2^22, 2^22], so that every predicate fits in 128 bits.
template <int D>
using GridPoint = std::array<std::int64_t, D>;

// NOLINTNEXTLINE(*-pedantic): the one way to exact predicates without a library
__extension__ typedef __int128 Int128;

template <int D>
[[nodiscard]] inline std::vector<GridPoint<D>> grid_points(std::span<const Vec<D>> points) {
    Box<D> box;
    for (const Vec<D>& p : points) box.include(p);
    double extent = 0;
    for (int i = 0; i < D; ++i) extent = std::fmax(extent, box.high[i] - box.low[i]);
    // A power of two: coordinates that are short in binary (lattices) stay exact, and planes planes.
    int exponent = 0;
    std::frexp(extent, &exponent);
    const double steps = std::ldexp(1.0, 23 - exponent);
    std::vector<GridPoint<D>> grid(points.size());
    for (std::size_t v = 0; v < points.size(); ++v)
        for (int i = 0; i < D; ++i) grid[v][i] = std::llround((points[v][i] - midpoint(box.low, box.high)[i]) * steps);
    return grid;
}

template <class T>
[[nodiscard]] inline T determinant3(const std::array<std::array<T, 3>, 3>& m) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

[[nodiscard]] inline int sign(Int128 x) { return (x > 0) - (x < 0); }

/// +1 where the simplex is positively oriented, 0 where it is flat. At most 6 · 2^69.
[[nodiscard]] inline int orientation(const std::array<const GridPoint<2>*, 3>& s) {
    std::array<GridPoint<2>, 2> d{};
    for (int r = 0; r < 2; ++r)
        for (int i = 0; i < 2; ++i) d[r][i] = (*s[r + 1])[i] - (*s[0])[i];
    return sign(Int128{d[0][0]} * d[1][1] - Int128{d[0][1]} * d[1][0]);
}
[[nodiscard]] inline int orientation(const std::array<const GridPoint<3>*, 4>& s) {
    std::array<std::array<Int128, 3>, 3> d{};
    for (int r = 0; r < 3; ++r)
        for (int i = 0; i < 3; ++i) d[r][i] = (*s[r + 1])[i] - (*s[0])[i];
    return sign(determinant3(d));
}

/// +1 where p is inside the circle of a positively oriented triangle, 0 on it.
[[nodiscard]] inline int in_sphere(const std::array<const GridPoint<2>*, 3>& s, const GridPoint<2>& p) {
    std::array<std::array<Int128, 3>, 3> m{};
    for (int r = 0; r < 3; ++r) {
        const std::int64_t x = (*s[r])[0] - p[0], y = (*s[r])[1] - p[1];
        m[r] = {x, y, Int128{x} * x + Int128{y} * y};
    }
    return sign(determinant3(m));
}

/// The lifted 4 × 4 determinant in T, expanded along the column of squares.
template <class T>
[[nodiscard]] inline T lifted(const std::array<std::array<T, 3>, 4>& d, const std::array<T, 4>& squares) {
    const auto minor = [&](int a, int b, int c) { return determinant3<T>({d[a], d[b], d[c]}); };
    return squares[0] * minor(1, 2, 3) - squares[1] * minor(0, 2, 3) + squares[2] * minor(0, 1, 3) -
           squares[3] * minor(0, 1, 2);
}

/// +1 where p is inside the sphere of a positively oriented tetrahedron, 0 on it. In doubles where their error cannot
/// change the sign, else exactly (at most 24 · 2^(69 + 47.6) < 2^122).
[[nodiscard]] inline int in_sphere(const std::array<const GridPoint<3>*, 4>& s, const GridPoint<3>& p) {
    std::array<std::array<double, 3>, 4> d{};
    std::array<double, 4> squares{};
    std::array<double, 3> largest{};
    double largest_square = 0;
    for (int r = 0; r < 4; ++r) {
        for (int i = 0; i < 3; ++i) {
            d[r][i] = static_cast<double>((*s[r])[i] - p[i]);
            squares[r] += d[r][i] * d[r][i];
            largest[i] = std::fmax(largest[i], std::fabs(d[r][i]));
        }
        largest_square = std::fmax(largest_square, squares[r]);
    }
    // 24 products of 4 factors, each with fewer than 16 roundings of 2^−53.
    const double error = 24 * 0x1p-49 * largest[0] * largest[1] * largest[2] * largest_square;
    if (const double value = lifted(d, squares); std::fabs(value) > error) return value > 0 ? 1 : -1;
    std::array<std::array<Int128, 3>, 4> exact{};
    std::array<Int128, 4> exact_squares{};
    for (int r = 0; r < 4; ++r)
        for (int i = 0; i < 3; ++i) {
            exact[r][i] = (*s[r])[i] - p[i];
            exact_squares[r] += exact[r][i] * exact[r][i];
        }
    return sign(lifted(exact, exact_squares));
}

/// The point's place along a Z-curve.
template <int D>
[[nodiscard]] inline std::uint64_t z_order(const GridPoint<D>& p) {
    std::uint64_t key = 0;
    for (int bit = 23; bit >= 3; --bit)  // 21 bits an axis fill 63
        for (int i = 0; i < D; ++i)
            key = key << 1U | (static_cast<std::uint64_t>(p[i] + (std::int64_t{1} << 22)) >> bit & 1U);
    return key;
}

}  // namespace camber
