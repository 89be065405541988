module;
#include <optional>
module camber.surface:meeting;
import camber.core;
import :plane;

namespace camber {

/// The point of both tangent planes that is nearest to p: p + α n_a + β n_b. Nothing where the planes are nearly
/// parallel.
[[nodiscard]] inline std::optional<Vec<3>> nearest_on_both(const SurfaceFoot<3>& a, const SurfaceFoot<3>& b,
                                                           const Vec<3>& p) {
    constexpr double min_sine_squared = 0.003;
    const double c = dot(a.normal, b.normal);
    const double determinant = 1 - c * c;
    if (determinant < min_sine_squared) return std::nullopt;
    const double to_a = dot(a.point - p, a.normal), to_b = dot(b.point - p, b.normal);
    const double alpha = (to_a - c * to_b) / determinant, beta = (to_b - c * to_a) / determinant;
    return p + alpha * a.normal + beta * b.normal;
}

/// The point nearest to p on the curve where two surfaces meet, each known by its closest points alone: `foot_a(x)` and
/// `foot_b(x)` give a SurfaceFoot. p is projected onto the meet of the tangent planes, again and again, and the last
/// steps restore the surfaces alone. Nothing where they are nearly tangent (below about 3°) or do not meet near p.
template <class FootA, class FootB>
[[nodiscard]] std::optional<Vec<3>> nearest_where_they_meet(FootA&& foot_a, FootB&& foot_b, const Vec<3>& p) {
    constexpr int max_steps = 60;
    constexpr int restoring_steps = 3;
    Vec<3> x = p;
    double first_step = 0;
    for (int step = 0; step < max_steps; ++step) {
        const auto next = nearest_on_both(foot_a(x), foot_b(x), p);
        if (!next || !is_finite(*next)) return std::nullopt;
        const double moved_by = distance(*next, x);
        if (step == 0) first_step = moved_by;
        x = *next;
        if (moved_by <= 1e-15 * (first_step + norm(x))) break;
    }
    for (int step = 0; step < restoring_steps; ++step) {
        const auto next = nearest_on_both(foot_a(x), foot_b(x), x);
        if (!next) return std::nullopt;
        x = *next;
    }
    const double off = distance(foot_a(x).point, x) + distance(foot_b(x).point, x);
    if (!(off <= 1e-9 * (first_step + norm(x)))) return std::nullopt;
    return x;
}

}  // namespace camber
