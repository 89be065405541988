module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
export module camber.ordering:morton;
import camber.core;

export namespace camber {

/// A box along the axes; without points `low` is above `high`.
template <int D>
struct PointBox {
    Vec<D> low, high;
};

/// Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<PointBox<D>> box_of_points(const Column<Vec<D>>& points, const Execution& execution) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    PointBox<D> nothing;
    for (int c = 0; c < D; ++c) nothing.low[c] = infinity, nothing.high[c] = -infinity;
    const auto join = [](PointBox<D> a, const PointBox<D>& b) {
        for (int c = 0; c < D; ++c) {
            a.low[c] = std::min(a.low[c], b.low[c]);
            a.high[c] = std::max(a.high[c], b.high[c]);
        }
        return a;
    };
    return reduce_each(
        execution, points.size(), nothing,
        [&](PointBox<D>& box, std::size_t v) { box = join(box, {points[v], points[v]}); }, join);
}

/// Place on the Morton curve: the bits of the coordinates within the box, interleaved, the highest first.
template <int D>
[[nodiscard]] std::uint64_t morton_key(const Vec<D>& p, const PointBox<D>& box) {
    constexpr int bits = 63 / D;
    constexpr auto most = static_cast<double>((std::uint64_t{1} << bits) - 1);
    std::array<std::uint64_t, D> cell{};
    for (int c = 0; c < D; ++c) {
        // Halved, since the extent itself may overflow.
        const double extent = 0.5 * box.high[c] - 0.5 * box.low[c];
        if (extent > 0) cell[c] = static_cast<std::uint64_t>((0.5 * p[c] - 0.5 * box.low[c]) / extent * most);
    }
    std::uint64_t key = 0;
    for (int b = bits - 1; b >= 0; --b)
        for (int c = 0; c < D; ++c) key = key << 1U | (cell[c] >> static_cast<unsigned>(b) & 1U);
    return key;
}

}  // namespace camber
