module;
#include <optional>
#include <variant>
export module camber.surface:geometry;
import camber.core;
import :analytic;
import :features;
import :surrogate;

export namespace camber {

/// The boundary is what the straight facets are: nothing is curved.
struct StraightGeometry {
    friend bool operator==(const StraightGeometry&, const StraightGeometry&) = default;
};

/// Analytic surfaces on the references that they name, the surrogate on all others.
template <int D>
struct MixedGeometry {
    AnalyticGeometry<D> analytic;
    Surrogate<D> surrogate;  ///< of the whole boundary
};

/// What the boundary of the domain is.
template <int D>
using Geometry = std::variant<StraightGeometry, Surrogate<D>, AnalyticGeometry<D>, MixedGeometry<D>>;

/// The analytic surfaces alone where every facet has one, else with the surrogate for the rest. Errors: those of
/// build_surrogate.
template <int D>
[[nodiscard]] Outcome<Geometry<D>> with_surrogate(AnalyticGeometry<D> analytic, const LinearMesh<D>& mesh,
                                                  const EdgeSet<D>& edges, const Features<D>& features,
                                                  const SurrogateOptions& options, const Execution& execution);

/// The analytic surfaces of a geometry; null where it knows none.
template <int D>
[[nodiscard]] const AnalyticGeometry<D>* analytic_part(const Geometry<D>& geometry);

/// The surrogate of a geometry; null where it has none.
template <int D>
[[nodiscard]] const Surrogate<D>* surrogate_part(const Geometry<D>& geometry);

/// Where to look for the closest point. A surrogate starts at its facet `facet` and walks (local, fast), or without one
/// searches all its facets, those of `reference` alone if that is given. An analytic geometry takes the surface of
/// `reference`. A mixed one asks the surface of the reference, else the surrogate; without a reference that of the
/// surrogate's facet counts, the given one or the nearest.
struct SurfaceHint {
    FacetId facet = {};
    std::optional<Reference> reference = {};
};

/// A point of the geometry, the unit normal there, and how far it is from the point that was projected. `facet` is the
/// surrogate's, invalid on analytic surfaces. Where there is no surface the point stays, with a zero normal.
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
