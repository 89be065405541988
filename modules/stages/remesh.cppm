// Distance from the geometry, and the recipe for remeshing.
module;
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>
export module camber.stages:remesh;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.surface;
import camber.operation;
import camber.adapt;
import camber.curving;
import :curve;
import :metric;

/// Distances between the boundary of a mesh and its geometry: required ones, and those reached.
export namespace camber {

/// Points of a geometry for distances to a boundary: of a CAD model its own, as many as a boundary of this size needs;
/// of all else the points over the mesh. Errors: of samples_over.
template <int D>
[[nodiscard]] Outcome<GeometrySamples<D>> samples_of_geometry(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                              const Geometry<D>& geometry, const Execution& execution);

/// Default bounds of a mesh of this degree, for the facets of each reference without a required bound: a hundredth of
/// the diagonal of the box around these facets, and the share of an edge's length by which an edge that turns by 30
/// degrees (degree 2: by 90) is off a circle.
template <int D>
[[nodiscard]] std::vector<DistanceBound> default_distance_bounds(const LinearMesh<D>& mesh, int degree,
                                                                 std::span<const DistanceBound> required);

/// Facets where the bounds of a goal act.
struct BoundedFacets {
    std::size_t limited = 0;  ///< shorter than the metric requests, and above their bounds if twice as large
    std::size_t far = 0;      ///< above their bounds, as facets of the mesh before
};
/// Errors: stopped.
template <int D>
[[nodiscard]] Outcome<BoundedFacets> bounded_facets(const Adaptation<D>& state, const AdaptationGoal<D>& goal,
                                                    const Execution& execution);

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

/// A mesh between two passes that change it, and what it is brought to.
template <int D>
struct Remeshing {
    Adaptation<D> mesh;
    AdaptationGoal<D> goal;
};

/// By what passes go: the field of the metric, and where inner edges that they make have their nodes (degree 2).
template <int D>
struct RemeshingBy {
    BackMesh<D> field;
    CurveOptions curving = {};                        ///< see accuracy_for
    std::size_t max_elements = max_entities;          ///< see AdaptationGoal
    const EmbeddedCurves<D>* curves = nullptr;        ///< of the mesh that this one was remeshed from; null: its own
    std::vector<DistanceBound> distance_bounds = {};  ///< that all passes keep, see AdaptationGoal
};

/// Before the first pass. Of a mesh of degree 2 `nodes` are those by which its embedded curves are told; empty: they go
/// by the geometry. Errors: those of begin_adaptation and find_embedded_curves.
template <int D>
[[nodiscard]] Outcome<Remeshing<D>> begin_remeshing(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                    const Boundary<D>& boundary, RemeshingBy<D> by,
                                                    const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Remeshing<D>> begin_remeshing(const QuadraticMesh<D>& mesh,
                                                    std::span<const LagrangeNode<D>> nodes, const Boundary<D>& boundary,
                                                    RemeshingBy<D> by, const Execution& execution);

/// A mesh of degree 2 with the mid nodes of its boundary on the geometry.
template <int D>
struct OntoGeometry {
    QuadraticMesh<D> mesh;
    std::size_t nodes = 0;  ///< number of mid nodes that were off the geometry, by more than the default tolerance
    double largest = 0;     ///< the largest distance of one (model units)
};
/// Puts the mid nodes of edges with prescribed surfaces onto these. Nodes that are there already stay, and so do
/// required ones. Elements that are not valid then are repaired; where nothing else helps nodes of the boundary stop
/// short of the geometry. Errors: those of validate and of repair.
template <int D>
[[nodiscard]] Outcome<OntoGeometry<D>> put_nodes_onto_geometry(QuadraticMesh<D> mesh, const Boundary<D>& boundary,
                                                               const Execution& execution);

/// Features of a mesh that was remeshed: it lists all its breaks; its new facets may turn where the surface does not
/// break.
template <int D>
inline constexpr FeatureOptions<D> listed_breaks{.ridge_angle_degrees = 180, .corner_angle_degrees = 180};

}  // namespace camber
