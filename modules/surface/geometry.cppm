module;
#include <optional>
#include <variant>
export module camber.surface:geometry;
import camber.core;
import :analytic;
import :surrogate;

export namespace camber {

/// The boundary is what the straight facets are: nothing is curved.
struct StraightGeometry {
    friend bool operator==(const StraightGeometry&, const StraightGeometry&) = default;
};

/// What the boundary of the domain is.
template <int D>
using Geometry = std::variant<StraightGeometry, Surrogate<D>, AnalyticGeometry<D>>;

/// Where to look for the closest point. A surrogate starts at its facet `facet` and walks (local, fast), or without one
/// searches all its facets, those of `reference` alone if that is given. An analytic geometry takes the surface of
/// `reference`.
struct SurfaceHint {
    FacetId facet = {};
    std::optional<Reference> reference = {};
};

/// A point of the geometry, the unit normal there, and how far it is from the point that was projected. `facet` is the
/// surrogate's, invalid for the other geometries. Where there is no surface the point stays, with a zero normal.
template <int D>
struct SurfacePoint {
    Vec<D> point, normal;
    double distance = 0;
    FacetId facet = {};
};

/// The geometry's point nearest to p.
template <int D>
[[nodiscard]] SurfacePoint<D> project(const Geometry<D>& geometry, const SurfaceHint& hint, const Vec<D>& p);

}  // namespace camber
