// Distance from the geometry, and remeshing.
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

export namespace camber {

/// Returns sample points of the geometry: on a CAD model, as many as the size of the boundary needs; otherwise over the
/// mesh. Errors: those of sample_over_mesh.
template <int D>
[[nodiscard]] Outcome<GeometrySamples<D>> samples_of_geometry(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                              const Geometry<D>& geometry, const Execution& execution);

/// Returns bounds for references without a required bound: a hundredth of the bounding box diagonal of their facets,
/// and a share of the edge length. That share is the distance of a chord from a circle for a turn of 30 degrees (degree
/// 2: 90).
template <int D>
[[nodiscard]] std::vector<DistanceBound> default_distance_bounds(const LinearMesh<D>& mesh, int degree,
                                                                 std::span<const DistanceBound> required);

struct BoundedFacets {
    std::size_t limited = 0;  ///< facets smaller than requested that would exceed their bounds at twice the size
    std::size_t far = 0;      ///< facets that exceed their bounds
};
/// Counts facets that distance bounds limit. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<BoundedFacets> bounded_facets(const Adaptation<D>& state, const AdaptationGoal<D>& goal,
                                                    const Execution& execution);

/// Facet with the largest two-sided distance relative to its bound: from its points to the geometry, and from the
/// nearest geometry points to the facet.
template <int D>
struct ReachedDistance {
    double required = 0, reached = 0;  ///< bound and distance (model units)
    std::size_t far_facets = 0;        ///< facets that exceed their bounds
    FacetId facet;
    Vec<D> at;  ///< farthest point; the facet's middle if another facet is farther

    [[nodiscard]] bool is_met() const { return !(reached > required); }
};
/// Errors: those of two_sided_distances.
template <int D>
[[nodiscard]] Outcome<ReachedDistance<D>> reached_distance(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                           const Geometry<D>& geometry,
                                                           std::span<const DistanceBound> bounds,
                                                           const Execution& execution);

/// A mesh refined until its boundary is within bounds, or no operation improves it.
template <int D>
struct WithinBounds {
    Adaptation<D> state;
    ToMetricStatistics statistics;  ///< sums over all passes; `before` and `after` are copied from the input `adapted`
    std::optional<ReachedDistance<D>> reached;  ///< none if no facet was far and the effort was near_metric
};
/// Measures the boundary (step "distances") and refines it (steps of remesh_to_metric) until every facet is within its
/// bound. Errors: those of the passes and of reached_distance.
template <int D>
[[nodiscard]] Outcome<WithinBounds<D>> refine_within(RemeshResult<D> adapted, const AdaptationGoal<D>& goal,
                                                     std::span<const DistanceBound> bounds,
                                                     const ToMetricOptions& options, BoundaryEffort effort,
                                                     const StepWrapper& around);

template <int D>
struct Remeshing {
    Adaptation<D> mesh;
    AdaptationGoal<D> goal;
};

/// Metric field, and options for nodes of new inner edges (degree 2).
template <int D>
struct RemeshingBy {
    BackMesh<D> field;
    CurveOptions curving = {};                        ///< see accuracy_for
    std::size_t max_elements = max_entities;          ///< see AdaptationGoal
    const EmbeddedCurves<D>* curves = nullptr;        ///< curves of the mesh before remeshing; null: of the mesh itself
    std::vector<DistanceBound> distance_bounds = {};  ///< see AdaptationGoal
};

/// Starts remeshing. `nodes` determine embedded curves; if they are empty, the geometry does. Errors: those of
/// begin_adaptation and find_embedded_curves.
template <int D>
[[nodiscard]] Outcome<Remeshing<D>> begin_remeshing(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                    const Boundary<D>& boundary, RemeshingBy<D> by,
                                                    const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Remeshing<D>> begin_remeshing(const QuadraticMesh<D>& mesh,
                                                    std::span<const LagrangeNode<D>> nodes, const Boundary<D>& boundary,
                                                    RemeshingBy<D> by, const Execution& execution);

template <int D>
struct OntoGeometry {
    QuadraticMesh<D> mesh;
    std::size_t nodes = 0;  ///< mid nodes that were off the geometry by more than the default tolerance
    double largest = 0;     ///< largest distance (model units)
};
/// Puts mid nodes onto their prescribed surfaces, except required ones. Repairs invalid elements; as a last resort,
/// boundary nodes do not fully reach the geometry. Errors: those of validate and repair.
template <int D>
[[nodiscard]] Outcome<OntoGeometry<D>> put_nodes_onto_geometry(QuadraticMesh<D> mesh, const Boundary<D>& boundary,
                                                               const Execution& execution);

/// Options for a remeshed mesh, which lists all its breaks: new facets may turn without a break.
template <int D>
inline constexpr FeatureOptions<D> listed_breaks{.ridge_angle_degrees = 180, .corner_angle_degrees = 180};

}  // namespace camber
