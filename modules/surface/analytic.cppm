module;
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
export module camber.surface:analytic;
import camber.core;
import :plane;

export namespace camber {

/// A circle in 2D. Here and below directions need not be unit vectors, and radii are positive.
template <int D>
struct Sphere {
    Vec<D> centre;
    double radius = 1;
    friend bool operator==(const Sphere&, const Sphere&) = default;
};
/// An infinite circular cylinder.
struct Cylinder {
    Vec<3> point, axis;
    double radius = 1;
    friend bool operator==(const Cylinder&, const Cylinder&) = default;
};
/// The tube of the minor radius around the circle of the major radius about the axis.
struct Torus {
    Vec<3> centre, axis;
    double major_radius = 1, minor_radius = 0.25;
    friend bool operator==(const Torus&, const Torus&) = default;
};

/// Any of the surfaces above that the dimension has.
template <int D>
using AnalyticSurface =
    std::conditional_t<D == 2, std::variant<Plane<2>, Sphere<2>>, std::variant<Plane<D>, Sphere<D>, Cylinder, Torus>>;

/// The surface of each facet reference; the first pair of a reference counts.
template <int D>
struct AnalyticGeometry {
    std::vector<std::pair<Reference, AnalyticSurface<D>>> surfaces;
    friend bool operator==(const AnalyticGeometry&, const AnalyticGeometry&) = default;
};

/// The surface of a reference; null where it has none.
template <int D>
[[nodiscard]] const AnalyticSurface<D>* surface_of(const AnalyticGeometry<D>& geometry, Reference reference);

/// The point of the surface that is nearest to p.
template <int D>
[[nodiscard]] SurfaceFoot<D> closest_point(const AnalyticSurface<D>& surface, const Vec<D>& p);

/// Checks that the surfaces are those of the mesh. Errors (usage): a reference with two surfaces, or of no facet; a
/// radius that is no number, negative, or beyond 1e8 times the size of the boundary. Errors (input): too many vertices
/// of a surface are off (VertexFit), or one by more than half of its longest edge; the farthest is named. Stopped.
template <int D>
[[nodiscard]] Outcome<Done> check_fit(const LinearMesh<D>& mesh, const AnalyticGeometry<D>& geometry,
                                      const Execution& execution);

}  // namespace camber
