module;
#include <span>
module camber.surface:heights;
import camber.core;

namespace camber {

/// The unit normal of the surface through `origin` and the points around it; degree 0: the points do not tell.
struct FittedNormal {
    Vec<3> normal;
    int degree = 0;
};

/// A jet: the height over the plane of `normal` as a polynomial that vanishes at `origin`, by least squares, weighted
/// towards the near points. Quartic from 18 points on, else cubic from 12, else quadratic from 5, each only where the
/// points determine it (column-pivoted QR of scaled columns; axes and scales are the points' own principal ones, so
/// that thin stencils work as well as round ones). Fitted twice, the second time over the tangent plane found. Error of
/// the normal O(h^degree).
[[nodiscard]] FittedNormal fitted_normal(const Vec<3>& origin, const Vec<3>& normal, std::span<const Vec<3>> points);

/// A point of a surface with its unit normal.
struct PointAndNormal {
    Vec<3> point, normal;
};

/// How far along `normal` a surface is from a point; degree 0: the samples do not tell, or turn away from the plane.
struct FittedHeight {
    double height = 0;
    int degree = 0;
};

/// Least squares on heights and slopes of the samples, of degree 4, else 3: error O(h⁵) but for that of the normals.
[[nodiscard]] FittedHeight fitted_height(const Vec<3>& origin, const Vec<3>& normal,
                                         std::span<const PointAndNormal> samples);

}  // namespace camber
