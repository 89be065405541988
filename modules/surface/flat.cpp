module;
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.surface;
import camber.core;

namespace camber {

namespace {

template <class Measure, int D>
Vec<D> farthest(std::span<const Vec<D>> points, Measure&& measure) {
    Vec<D> best = points[0];
    double most = measure(best);
    for (const Vec<D>& p : points)
        if (const double m = measure(p); m > most) {
            most = m;
            best = p;
        }
    return best;
}

/// From the two or three points that are farthest apart: components that agree bit by bit give an exact zero.
Vec<2> spanned_normal(std::span<const Vec<2>> points) {
    const Vec<2> a = farthest(points, [&](const Vec<2>& p) { return norm_squared(p - points[0]); });
    const Vec<2> b = farthest(points, [&](const Vec<2>& p) { return norm_squared(p - a); });
    return {{-(b[1] - a[1]), b[0] - a[0]}};
}
Vec<3> spanned_normal(std::span<const Vec<3>> points) {
    const Vec<3> a = farthest(points, [&](const Vec<3>& p) { return norm_squared(p - points[0]); });
    const Vec<3> b = farthest(points, [&](const Vec<3>& p) { return norm_squared(p - a); });
    const Vec<3> c = farthest(points, [&](const Vec<3>& p) { return norm_squared(cross(p - a, b - a)); });
    return cross(b - a, c - a);
}

template <int D>
int axis_along(const Vec<D>& unit) {
    for (int i = 0; i < D; ++i) {
        bool alone = unit[i] != 0;
        for (int j = 0; j < D; ++j) alone = alone && (i == j || unit[j] == 0);
        if (alone) return i;
    }
    return -1;
}

}  // namespace

template <int D>
FlatPatch<D> plane_of(std::span<const Vec<D>> points) {
    FlatPatch<D> flat;
    if (points.size() < D) return flat;
    Box<D> box;
    double largest = 0;
    for (const Vec<D>& p : points) {
        box.include(p);
        for (int i = 0; i < D; ++i) largest = std::fmax(largest, std::fabs(p[i]));
    }
    const Vec<D> normal = normalised(spanned_normal(points));
    if (!(norm_squared(normal) > 0)) return flat;
    const double tolerance = flat_tolerance * box.diagonal() + coordinate_ulps * largest;
    for (const Vec<D>& p : points)
        if (!(std::fabs(dot(p - points[0], normal)) <= tolerance)) return flat;
    return {points[0], normal, tolerance, axis_along(normal)};
}

template <int D>
Outcome<Buffer<FlatPatch<D>>> flat_patches(const LinearMesh<D>& mesh, const Features<D>& features,
                                           const Execution& execution) {
    std::vector<std::vector<Vec<D>>> points(features.patch_count);
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        for (const VertexId v : mesh.facets.vertices[f]) points[features.patches[f]].push_back(mesh.points[v]);
    return map_each(execution, points.size(), [&](std::size_t p) { return plane_of<D>(points[p]); }, 1);
}

#define CAMBER_INSTANTIATE(D)                                \
    template FlatPatch<D> plane_of(std::span<const Vec<D>>); \
    template Outcome<Buffer<FlatPatch<D>>> flat_patches(const LinearMesh<D>&, const Features<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
