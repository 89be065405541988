module;
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>
export module camber.surface:flat;
import camber.core;
import :features;

export namespace camber {

/// A patch that is part of a plane (2D: of a line); `normal` is zero for a patch that is not.
template <int D>
struct FlatPatch {
    Vec<D> point, normal;
    double tolerance = 0;  ///< a point nearer to the plane than this is on it
    int axis = -1;         ///< the axis that the normal lies along exactly: that coordinate is the same everywhere

    [[nodiscard]] inline bool is_flat() const { return norm_squared(normal) > 0; }
    /// Signed distance; 0 within the tolerance.
    [[nodiscard]] inline double height(const Vec<D>& p) const {
        const double h = axis >= 0 ? p[static_cast<std::size_t>(axis)] - point[static_cast<std::size_t>(axis)]
                                   : dot(p - point, normal);
        return std::fabs(h) <= tolerance ? 0 : h;
    }
    /// The closest point of the plane, to the last bit where the normal is along an axis.
    [[nodiscard]] inline Vec<D> snapped(Vec<D> p) const {
        if (axis < 0) return p - dot(p - point, normal) * normal;
        p[static_cast<std::size_t>(axis)] = point[static_cast<std::size_t>(axis)];
        return p;
    }
    friend bool operator==(const FlatPatch&, const FlatPatch&) = default;
};

}  // namespace camber

namespace camber {

/// Distances below this share of a set's size are none; coordinates themselves are known to a few ulps.
inline constexpr double flat_tolerance = 1e-12;
inline constexpr double coordinate_ulps = 1e-15;

/// The plane through points when they are coplanar within rounding: |height| ≤ 1e-12 size + 1e-15 |coordinates|.
template <int D>
[[nodiscard]] FlatPatch<D> plane_of(std::span<const Vec<D>> points);

/// plane_of each patch's vertices. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<FlatPatch<D>>> flat_patches(const LinearMesh<D>& mesh, const Features<D>& features,
                                                         const Execution& execution);

}  // namespace camber
