module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
module camber.operation:heights;
import camber.core;
import camber.bezier;
import :on_geometry;

/// How low an element may be.
namespace camber {

/// (D − 1)! times the largest face's area (2D: the longest side).
template <int D>
[[nodiscard]] double largest_face(const std::array<Vec<D>, D + 1>& corners) {
    double largest = 0;
    for (int face = 0; face <= D; ++face) {
        const auto local = face_opposite<D>(face);
        std::array<Vec<D>, D> q;
        for (int i = 0; i < D; ++i) q[i] = corners[local[i]];
        largest = std::max(largest, norm_squared(facet_normal(q)));
    }
    return std::sqrt(largest);
}

/// 32 roundings of the largest coordinate: what is not higher than that may be on either side.
template <int D, std::size_t N>
[[nodiscard]] double rounding_of(const std::array<Vec<D>, N>& corners) {
    constexpr double rounding = 32 * std::numeric_limits<double>::epsilon();
    double largest = 0;
    for (const Vec<D>& x : corners)
        for (const double c : x.c) largest = std::max(largest, std::abs(c));
    return rounding * largest;
}

/// A determinant that is not above this is that of an element so low that coordinates, which are known to their
/// rounding only, do not tell on which side its vertices are: height by the largest face.
template <int D>
[[nodiscard]] double rounding_floor(const std::array<Vec<D>, D + 1>& corners) {
    return rounding_of(corners) * largest_face<D>(corners);
}

/// Whether a determinant is above that. Most are above what no face exceeds, the square (2D: length) of the diagonal of
/// the corners' box, and none is looked at.
template <int D>
[[nodiscard]] bool is_above_rounding(double determinant, const std::array<Vec<D>, D + 1>& corners) {
    Vec<D> low = corners[0], high = corners[0];
    for (int i = 1; i <= D; ++i)
        for (int c = 0; c < D; ++c) {
            low[c] = std::min(low[c], corners[i][c]);
            high[c] = std::max(high[c], corners[i][c]);
        }
    const double square = norm_squared(high - low);
    return determinant > rounding_of(std::array{low, high}) * (D == 2 ? std::sqrt(square) : square) ||
           determinant > rounding_floor<D>(corners);
}

/// The same of a triangle in space.
[[nodiscard]] inline bool is_flat(const std::array<Vec<3>, 3>& corners) {
    double longest = 0;
    for (const auto& [a, b] : local_edges<2>) longest = std::max(longest, distance(corners[a], corners[b]));
    return !(norm(facet_normal(corners)) > rounding_of(corners) * longest);
}

}  // namespace camber
