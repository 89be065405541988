module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
module camber.crossing:parabola;
import camber.core;
import :net;

/// The other side of a curve: a curve of degree 2 lies on a parabola, and tells by its equation what else does not.
/// Arcs one inside the other are told apart by it at once, however much thinner than they bow the gap between them is.
namespace camber {

/// Corners that two pieces have in common.
template <int D>
struct Common {
    int count = 0;
    std::array<int, D> first{}, second{};
};

template <int D>
[[nodiscard]] inline Common<D> common_corners(const Net<D>& first, const Net<D>& second) {
    Common<D> common;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j)
            if (first.corner[i] != 0 && first.corner[i] == second.corner[j] && common.count < D) {
                common.first[common.count] = i;
                common.second[common.count++] = j;
            }
    return common;
}

/// A point's barycentric coordinates in the control triangle of a curve, times twice its area: of the ends, and of the
/// middle. On the parabola middle² = 4 first second.
struct Areas {
    double first = 0, middle = 0, second = 0;
};

/// What rounding does to an area: two products of differences below 2, which err by 2 `coordinate_blur` each.
inline constexpr double area_blur = 20 * coordinate_blur;

[[nodiscard]] inline Areas areas_at(const Net<2>& curve, const Vec<2>& p) {
    const auto& [a, b, m] = curve.control;
    return {cross(m - p, b - p), cross(b - p, a - p), cross(a - p, m - p)};
}

/// A number and what it may err by.
struct Blurred {
    double value = 0, error = 0;
    [[nodiscard]] int sign() const { return value > error ? 1 : value < -error ? -1 : 0; }
    friend Blurred operator+(const Blurred& a, const Blurred& b) { return {a.value + b.value, a.error + b.error}; }
    friend Blurred operator*(double s, const Blurred& a) { return {s * a.value, std::abs(s) * a.error}; }
};

/// The polar form of middle² − 4 first second.
[[nodiscard]] inline Blurred polar(const Areas& p, const Areas& q) {
    const double size = std::abs(p.middle) + std::abs(q.middle) +
                        2 * (std::abs(p.first) + std::abs(q.first) + std::abs(p.second) + std::abs(q.second));
    return {p.middle * q.middle - 2 * (p.first * q.second + p.second * q.first),
            1.1 * area_blur * (size + 8 * area_blur)};
}

/// Whether the curve lies on one side of the other's parabola, ends that are the other's too left out: the equation is
/// a quartic along it, whose Bernstein coefficients have one sign. At a common end the first or last of them is 0.
[[nodiscard]] inline bool beside_parabola(const Net<2>& curve, const Net<2>& other,
                                          const std::array<bool, 2>& is_common) {
    const Areas a = areas_at(other, curve.control[0]), m = areas_at(other, curve.control[2]),
                b = areas_at(other, curve.control[1]);
    const std::array<int, 5> signs{polar(a, a).sign(), polar(a, m).sign(),
                                   ((2.0 / 3) * polar(m, m) + (1.0 / 3) * polar(a, b)).sign(), polar(m, b).sign(),
                                   polar(b, b).sign()};
    const std::size_t begin = is_common[0] ? 1 : 0, end = is_common[1] ? 4 : 5;
    return signs[2] != 0 &&
           std::all_of(signs.begin() + static_cast<std::ptrdiff_t>(begin),
                       signs.begin() + static_cast<std::ptrdiff_t>(end), [&](int sign) { return sign == signs[2]; });
}

[[nodiscard]] inline bool separated_by_parabola(const Net<2>& first, const Net<2>& second, const Common<2>& common) {
    std::array<bool, 2> of_first{}, of_second{};
    for (int k = 0; k < common.count; ++k) of_first[common.first[k]] = of_second[common.second[k]] = true;
    return beside_parabola(first, second, of_first) || beside_parabola(second, first, of_second);
}

}  // namespace camber
