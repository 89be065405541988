module;
#include <array>
module camber.surface:analytic_parameters;
import camber.core;
import :analytic;
import :geometry_places;

namespace camber {

/// The coordinates of a point on a surface. Plane: lengths along two perpendicular directions (2D: one); circle: the
/// angle; sphere: longitude and latitude; cylinder: the angle and the length along the axis; torus: the angles about
/// the axis and about the tube.
template <int D>
[[nodiscard]] GeometryParameters parameters_of(const AnalyticSurface<D>& surface, const Vec<D>& p);

/// The point with these coordinates.
template <int D>
[[nodiscard]] EntityPoint<D> point_of_parameters(const AnalyticSurface<D>& surface,
                                                 const GeometryParameters& parameters);

/// After how much each coordinate is at the same point again; 0: never.
template <int D>
[[nodiscard]] std::array<double, 2> periods_of(const AnalyticSurface<D>& surface);

}  // namespace camber
