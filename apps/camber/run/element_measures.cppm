module;
#include <algorithm>
#include <cmath>
#include <cstddef>
module camber.run:element_measures;
import camber.core;
import camber.soundness;
import camber.validity;
import :check_parts;

namespace camber::run {

/// Of a straight element, or a triangle of a surface alone: the mean ratio.
template <int D>
[[nodiscard]] inline double quality_of(const LinearMesh<D>& mesh, std::size_t e) {
    if constexpr (D == 3)
        if (is_surface_alone(mesh)) {
            const auto p = triangle_corners(mesh, e);
            const double l1 = distance(p[0], p[1]), l2 = distance(p[1], p[2]), l3 = distance(p[2], p[0]);
            const double unit = std::max({l1, l2, l3});
            if (!(unit > 0) || !std::isfinite(unit)) return 0;
            const double twice = norm(cross((p[1] - p[0]) / unit, (p[2] - p[0]) / unit));
            return 2 * std::sqrt(3.0) * twice / ((l1 * l1 + l2 * l2 + l3 * l3) / (unit * unit));
        }
    return mean_ratio<D>(corners_of(mesh, e));
}
/// Its volume or area, with sign but for a surface.
template <int D>
[[nodiscard]] inline double measure_of(const LinearMesh<D>& mesh, std::size_t e) {
    if constexpr (D == 3)
        if (is_surface_alone(mesh)) {
            const auto p = triangle_corners(mesh, e);
            return norm(cross(p[1] - p[0], p[2] - p[0])) / 2;
        }
    return signed_measure<D>(corners_of(mesh, e));
}

}  // namespace camber::run
