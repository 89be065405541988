module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
export module camber.soundness:mean_ratio;
import camber.core;

export namespace camber {

/// Volume of a straight simplex with its sign, area in 2D.
template <int D>
[[nodiscard]] double signed_measure(const std::array<Vec<D>, D + 1>& p) {
    if constexpr (D == 2)
        return det(p[1] - p[0], p[2] - p[0]) / 2;
    else
        return det(p[1] - p[0], p[2] - p[0], p[3] - p[0]) / 6;
}

/// Mean ratio of a straight simplex with the sign of its volume: 12 (3V)^(2/3) / Σ l², in 2D 4 √3 A / Σ l². 1 for the
/// regular one, 0 for a flat one.
template <int D>
[[nodiscard]] double mean_ratio(const std::array<Vec<D>, D + 1>& corners) {
    double longest = 0;
    for (const auto& [a, b] : local_edges<D>)
        longest =
            std::max(longest, distance(corners[static_cast<std::size_t>(a)], corners[static_cast<std::size_t>(b)]));
    if (!(longest > 0) || !std::isfinite(longest)) return 0;
    // In units of the longest edge, so that nothing overflows.
    std::array<Vec<D>, D + 1> p;
    for (int i = 0; i <= D; ++i) p[i] = (corners[i] - corners[0]) / longest;
    double squares = 0;
    for (const auto& [a, b] : local_edges<D>)
        squares += norm_squared(p[static_cast<std::size_t>(a)] - p[static_cast<std::size_t>(b)]);
    const double measure = signed_measure<D>(p);
    if constexpr (D == 2) return 4 * std::sqrt(3.0) * measure / squares;
    return std::copysign(12 * pow(3 * std::abs(measure), 2.0 / 3) / squares, measure);
}

}  // namespace camber
