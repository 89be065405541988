module;
#include <cstddef>
#include <optional>
#include <span>
export module camber.recipes:geometry_error;
import camber.core;
import camber.adapt;
import camber.bezier;
import camber.operation;
import camber.surface;

/// Distances between the boundary of a mesh and its geometry: required ones, and those reached.
export namespace camber {

/// Points of a geometry for distances to a boundary: of a CAD model its own, as many as a boundary of this size needs;
/// of all else the points over the mesh. Errors: of samples_over.
template <int D>
[[nodiscard]] Outcome<GeometrySamples<D>> samples_of_geometry(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                              const Geometry<D>& geometry, const Execution& execution);

/// The facet whose distance is the largest share of its bound. The distance of a facet is the larger of both ways: from
/// its points to the geometry, and from the points of the geometry that are nearest to it.
template <int D>
struct ReachedDistance {
    double required = 0, reached = 0;  ///< the bound and the distance of that facet (model units)
    std::size_t far_facets = 0;        ///< number of facets that exceed their bounds
    FacetId facet;
    Vec<D> at;  ///< where the distance is that of the facet; its middle, where another facet is farther

    [[nodiscard]] bool is_met() const { return !(reached > required); }
};
/// Errors: those of distances_both_ways.
template <int D>
[[nodiscard]] Outcome<ReachedDistance<D>> reached_distance(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                           const Geometry<D>& geometry,
                                                           std::span<const DistanceBound> bounds,
                                                           const Execution& execution);

/// A mesh that was refined until its boundary keeps the bounds, or until no operation brings it nearer.
template <int D>
struct WithinBounds {
    Adaptation<D> state;
    ToMetricStatistics statistics;  ///< of all passes; `before` and `after` are those of the mesh that came in
    std::optional<ReachedDistance<D>> reached;  ///< none: no facet was far, with the effort near_metric
};
/// Measures the boundary against the goal's geometry (step "distances") and refines it (the steps of bring_to_metric)
/// until every facet keeps the bounds, by such an effort. Errors: those of the passes and of reached_distance.
template <int D>
[[nodiscard]] Outcome<WithinBounds<D>> bring_within(BroughtToMetric<D> brought, const AdaptationGoal<D>& goal,
                                                    std::span<const DistanceBound> bounds,
                                                    const ToMetricOptions& options, BoundaryEffort effort,
                                                    const Around& around);

}  // namespace camber
