module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
module camber.crossing:graph;
import camber.core;
import :net;
import :separation;

/// Pieces that are seen one to one from some side: one triangle, or two with a common edge.
namespace camber {

/// One triangle, its corners named: the edge from `from` to `to` and the apex; on which side of the edge it is laid
/// out.
struct Sheet {
    const Net<3>* net = nullptr;
    int from = 0, to = 1, apex = 2;
    double side = 1;
};

/// dF/ds and dF/dt at the three corners, where the triangle is laid out with its edge from (−1, 0) to (1, 0) and its
/// apex at (lean, ±1), all lengths along s and t then multiplied by numbers of our choice. dF is affine, so in between
/// it is a mean of these.
struct SheetSlopes {
    std::array<Vec<3>, 3> s{}, t{};
};

/// The triangle alone, on its longest edge.
[[nodiscard]] inline Sheet sheet_of(const Net<3>& net) {
    Sheet longest{&net, 0, 1, 2, 1};
    for (int i = 1; i < 3; ++i) {
        const Sheet other{&net, i, (i + 1) % 3, (i + 2) % 3, 1};
        const auto length = [&](const Sheet& s) { return distance(net.control[s.from], net.control[s.to]); };
        if (length(other) > length(longest)) longest = other;
    }
    return longest;
}

[[nodiscard]] inline SheetSlopes upright_slopes(const Sheet& sheet) {
    SheetSlopes d;
    const Net<3>& net = *sheet.net;
    for (int i = 0; i < 3; ++i) {
        d.s[i] = net.at(i, sheet.to) - net.at(i, sheet.from);
        d.t[i] = sheet.side *
                 ((net.at(i, sheet.apex) - net.at(i, sheet.from)) + (net.at(i, sheet.apex) - net.at(i, sheet.to)));
    }
    return d;
}

[[nodiscard]] inline Vec<3> mean(const std::array<Vec<3>, 3>& v) { return (v[0] + v[1] + v[2]) / 3.0; }

/// What is left of v without its part along the unit vector n; v where n is 0.
[[nodiscard]] inline Vec<3> seen_along(const Vec<3>& n, const Vec<3>& v) { return v - dot(n, v) * n; }

/// The rows of A, and what they are weighed with.
struct Layout {
    Vec<3> along, across;
    double length = 0, weight = 1;
    std::array<double, 2> height{};
    bool fits = false;
};

/// Chooses lengths, leans (which it takes off the slopes) and rows for the sheets as they are seen in the direction
/// `view`; from nowhere if it is 0. What it chooses is good or bad, not right or wrong.
[[nodiscard]] inline Layout laid_out(std::span<SheetSlopes> slopes, const Vec<3>& view) {
    Layout out;
    for (const SheetSlopes& d : slopes) out.along += seen_along(view, mean(d.s));
    out.length = norm(out.along) / static_cast<double>(slopes.size());
    if (!(out.length > 0)) return out;
    out.along = normalised(out.along);
    for (std::size_t k = 0; k < slopes.size(); ++k) {
        SheetSlopes& d = slopes[k];
        const double lean = std::clamp(dot(out.along, mean(d.t)) / out.length, -1.0, 1.0);
        for (int i = 0; i < 3; ++i) d.t[i] -= lean * d.s[i];
        const Vec<3> upright = seen_along(out.along, seen_along(view, mean(d.t)));
        out.height[k] = norm(upright);
        if (!(out.height[k] > 0)) return out;
        out.across += upright / out.height[k];
    }
    if (!(norm_squared(out.across) > 0)) return out;
    out.across = normalised(out.across);
    double shear = 0, twist = 0;
    for (std::size_t k = 0; k < slopes.size(); ++k)
        for (int i = 0; i < 3; ++i) {
            shear = std::max(shear, std::abs(dot(out.along, slopes[k].t[i])) / out.height[k]);
            twist = std::max(twist, std::abs(dot(out.across, slopes[k].s[i])) / out.length);
        }
    if (shear > 0 && twist > 0) out.weight = std::clamp(shear / twist, 0x1p-40, 0x1p40);
    out.fits = true;
    return out;
}

/// A dF + (A dF)ᵀ is positive definite at all corners, rounding included: a slope is a sum of at most six Bézier
/// points.
[[nodiscard]] inline bool is_definite(std::span<const SheetSlopes> slopes, const Layout& layout) {
    const auto& [along, across, length, weight, heights, fits] = layout;
    const double blur_along = 16 * coordinate_blur * sum_of_sizes(along);
    const double blur_across = 16 * coordinate_blur * sum_of_sizes(across);
    for (std::size_t k = 0; k < slopes.size(); ++k)
        for (int i = 0; i < 3; ++i) {
            const Vec<3>& s = slopes[k].s[i];
            const Vec<3>& t = slopes[k].t[i];
            const double a = (dot(along, s) - blur_along) / length;
            const double d = weight * ((dot(across, t) - blur_across) / heights[k]);
            const double b = std::abs(dot(along, t) / heights[k] + weight * (dot(across, s) / length)) +
                             blur_along / heights[k] + weight * (blur_across / length);
            if (!(a > 0 && d > 0 && 4 * a * d > b * b * (1 + 0x1p-40))) return false;
        }
    return true;
}

/// The direction in which slopes differ most from their means: that in which the sheets are bent.
[[nodiscard]] inline Vec<3> bent_direction(std::span<const SheetSlopes> slopes) {
    Vec<3> most;
    for (const SheetSlopes& d : slopes)
        for (const auto& of : {d.s, d.t}) {
            const Vec<3> middle = mean(of);
            for (const Vec<3>& v : of)
                if (norm_squared(v - middle) > norm_squared(most)) most = v - middle;
        }
    return normalised(most);
}

/// Whether the sheets, laid out side by side, are mapped one to one. Together they fill a convex domain, for |lean|
/// ≤ 1. Between any two points x, y of it (y − x)·A (F(y) − F(x)) = ∫ (y − x)·A dF (y − x), which is positive if A dF +
/// (A dF)ᵀ is positive definite everywhere; dF being affine, at the corners. A, of two rows, is free: along the edge,
/// and across it, weighed against each other. (The sheets need the same Bézier points on their common edge.)
[[nodiscard]] inline bool is_graph(std::span<const Sheet> sheets) {
    std::array<SheetSlopes, 2> slopes{}, leaning{};
    for (std::size_t k = 0; k < sheets.size(); ++k) slopes[k] = upright_slopes(sheets[k]);
    const std::span<const SheetSlopes> all(slopes.data(), sheets.size());
    const auto from = [&](const Vec<3>& view) {
        leaning = slopes;
        const std::span<SheetSlopes> copy(leaning.data(), sheets.size());
        const Layout layout = laid_out(copy, view);
        return layout.fits && is_definite(copy, layout);
    };
    return from(Vec<3>{}) || from(bent_direction(all));
}

}  // namespace camber
