module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
export module camber.crossing:graph;
import camber.core;
import :net;
import :separation;

/// Pieces that are seen one to one from some side: one triangle, or two with a common edge.
namespace camber {

/// One triangle, its corners named: the edge from `from` to `to` and the apex; on which side of the edge it is laid out.
struct Sheet {
    const Net<3>* net = nullptr;
    int from = 0, to = 1, apex = 2;
    double side = 1;
};

/// dF/ds and dF/dt at the three corners, where the triangle is laid out with its edge from (−1, 0) to (1, 0) and its apex
/// at (lean, ±1), all lengths along s and t then multiplied by numbers of our choice. dF is affine, so in between it is a
/// mean of these.
struct SheetSlopes {
    std::array<Vec<3>, 3> s{}, t{};
    double height = 1;  ///< what t is divided by
};

[[nodiscard]] inline SheetSlopes upright_slopes(const Sheet& sheet) {
    SheetSlopes d;
    const Net<3>& net = *sheet.net;
    for (int i = 0; i < 3; ++i) {
        d.s[i] = net.at(i, sheet.to) - net.at(i, sheet.from);
        d.t[i] = sheet.side * ((net.at(i, sheet.apex) - net.at(i, sheet.from)) +
                               (net.at(i, sheet.apex) - net.at(i, sheet.to)));
    }
    return d;
}

[[nodiscard]] inline Vec<3> mean(const std::array<Vec<3>, 3>& v) { return (v[0] + v[1] + v[2]) / 3.0; }

/// Whether the sheets, laid out side by side, are mapped one to one. Together they fill a convex domain, for |lean| ≤ 1.
/// Between any two points x, y of it (y − x)·A (F(y) − F(x)) = ∫ (y − x)·A dF (y − x), which is positive if
/// A dF + (A dF)ᵀ is positive definite everywhere; dF being affine, at the corners. A, of two rows, is free: along the
/// edge, and across it, weighed against each other. (The sheets need the same Bézier points on their common edge.)
[[nodiscard]] inline bool is_graph(std::span<const Sheet> sheets) {
    std::array<SheetSlopes, 2> slopes{};
    const std::size_t n = sheets.size();
    Vec<3> along, across;
    for (std::size_t k = 0; k < n; ++k) {
        slopes[k] = upright_slopes(sheets[k]);
        along += mean(slopes[k].s);
    }
    const double length = norm(along) / static_cast<double>(n);
    if (!(length > 0)) return false;
    along = normalised(along);
    for (std::size_t k = 0; k < n; ++k) {
        const double lean = std::clamp(dot(along, mean(slopes[k].t)) / length, -1.0, 1.0);
        for (int i = 0; i < 3; ++i) slopes[k].t[i] -= lean * slopes[k].s[i];
        const Vec<3> t = mean(slopes[k].t);
        const Vec<3> upright = t - dot(along, t) * along;
        slopes[k].height = norm(upright);
        if (!(slopes[k].height > 0)) return false;
        across += upright / slopes[k].height;
    }
    if (!(norm_squared(across) > 0)) return false;
    across = normalised(across);

    double shear = 0, twist = 0;
    for (std::size_t k = 0; k < n; ++k)
        for (int i = 0; i < 3; ++i) {
            shear = std::max(shear, std::abs(dot(along, slopes[k].t[i])) / slopes[k].height);
            twist = std::max(twist, std::abs(dot(across, slopes[k].s[i])) / length);
        }
    const double weight = shear > 0 && twist > 0 ? std::clamp(shear / twist, 0x1p-20, 0x1p20) : 1.0;
    // What rounding does to a product of a row and a slope: a slope is a sum of at most six Bézier points.
    const double blur_along = 16 * coordinate_blur * sum_of_sizes(along);
    const double blur_across = 16 * coordinate_blur * sum_of_sizes(across);
    for (std::size_t k = 0; k < n; ++k)
        for (int i = 0; i < 3; ++i) {
            const double height = slopes[k].height;
            const double a = (dot(along, slopes[k].s[i]) - blur_along) / length;
            const double d = weight * ((dot(across, slopes[k].t[i]) - blur_across) / height);
            const double b =
                std::abs(dot(along, slopes[k].t[i]) / height + weight * (dot(across, slopes[k].s[i]) / length)) +
                blur_along / height + weight * (blur_across / length);
            if (!(a > 0 && d > 0 && 4 * a * d > b * b * (1 + 0x1p-40))) return false;
        }
    return true;
}

}  // namespace camber
