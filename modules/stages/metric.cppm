// Known solutions, metric sources, sizes by geometry, metric of a solution.
module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>
export module camber.stages:metric;
import camber.core;
import camber.recovery;
import camber.metric;
import camber.edge_optimisation;
import camber.solution_metric;
import camber.surface;
import camber.operation;
import camber.validity;
import camber.curving;

export namespace camber {

/// Known values at the vertices or, for degree 2, at all nodes.
struct WeightedField {
    Column<double> values;
    double weight = 1;  ///< weight of the error, in a unit in which the field's range is about 1
};

/// Fields, or one function known everywhere.
template <int D>
struct SolutionInput {
    std::vector<WeightedField> fields = {};
    FunctionOfPosition<D> function = {};

    [[nodiscard]] bool empty() const { return fields.empty() && !function; }
};

/// Returns the solution in the elements of `curved`, which is `mesh` with other mid nodes. The solution is the function
/// or, for fields on `mesh`, polynomials computed for each material. Errors: those of `element_values`; stopped,
/// memory.
template <int D>
[[nodiscard]] Outcome<KnownSolution<D>> known_solution(const QuadraticMesh<D>& mesh, const SolutionInput<D>& specified,
                                                       const QuadraticMesh<D>& curved, const Execution& execution);

/// A metric with one row per vertex. `make` receives the natural metric, or nothing if `of_natural` is false. For
/// boundaries with noticeable sagitta, `make` is called for the curved mesh, then for the straight one.
template <int D>
struct MetricAtVertices {
    bool of_natural = true;
    std::function<Outcome<Column<LogMetric<D>>>(const Column<LogMetric<D>>& natural, const Execution&)> make;
};

/// A metric field with the mesh on which it is defined.
template <int D>
struct MetricField {
    std::function<Outcome<BackMesh<D>>(const Execution&)> make;
};

template <int D>
using MetricSource = std::variant<MetricAtVertices<D>, MetricField<D>>;

/// `natural`: the metric of the mesh itself, or computed from that metric.
enum class MetricOrigin : std::uint8_t { natural, specified };
template <int D>
[[nodiscard]] MetricOrigin origin_of(const MetricSource<D>& metric) {
    const auto* const at_vertices = std::get_if<MetricAtVertices<D>>(&metric);
    return at_vertices != nullptr && at_vertices->of_natural ? MetricOrigin::natural : MetricOrigin::specified;
}

/// Returns the accuracy options for a metric of this origin. The mesh's own metric is noisy: its gradients are
/// recovered, and `MetricKind::automatic` becomes `natural`.
[[nodiscard]] inline EdgeAccuracyOptions accuracy_for(MetricOrigin origin, const EdgeAccuracyOptions& requested) {
    EdgeAccuracyOptions options = requested;
    const bool is_natural = origin == MetricOrigin::natural;
    options.change = is_natural ? ChangeSource::recovered : ChangeSource::of_ends;
    if (is_natural && options.metric_kind == MetricKind::automatic) options.metric_kind = MetricKind::natural;
    return options;
}

[[nodiscard]] inline bool follows_mesh(const CurveOptions& edges) {
    return edges.aim == CurvingAim::accuracy && edges.metric_kind == MetricKind::natural;
}

/// Repair target for nodes found with these options.
[[nodiscard]] inline JacobianBound recommended_target(const CurveOptions& edges) {
    return JacobianBound::recommended(follows_mesh(edges) ? target_without_metric : default_bound);
}

/// Minimum scaled Jacobian after shifts of nodes in planes, because repair does not undo these shifts to reach its
/// target.
[[nodiscard]] inline double slide_bound(const CurveOptions& edges) {
    return follows_mesh(edges) ? std::max(edges.min_jacobian, target_without_metric) : edges.min_jacobian;
}

/// Metric of the mesh itself (paper §1.2.1).
template <int D>
[[nodiscard]] MetricSource<D> natural_metric() {
    return MetricAtVertices<D>{
        true,
        [](const Column<LogMetric<D>>& natural, const Execution&) -> Outcome<Column<LogMetric<D>>> { return natural; }};
}

template <int D>
[[nodiscard]] MetricSource<D> metric_at_vertices(Column<LogMetric<D>> log_metrics) {
    return MetricAtVertices<D>{
        false, [log_metrics = std::move(log_metrics)](const auto&, const Execution&) -> Outcome<Column<LogMetric<D>>> {
            return log_metrics;
        }};
}

/// Sizes from the geometry of a mesh's boundary.
struct GeometrySizes {
    std::vector<Reference> references = {};  ///< facets that determine sizes; empty: all
    double chord_error = 0, angle = 0;       ///< see ChordOptions
    double normal_ratio = ChordOptions{}.normal_ratio;
    double gap_elements = 0;  ///< across thin parts of the domain, see GapOptions

    [[nodiscard]] static constexpr auto options() {
        using S = GeometrySizes;
        return std::tuple(
            option("references", &S::references, "references of the boundary facets that determine sizes; empty: all")
                .count(0, 100000),
            option_of(&ChordOptions::chord_error).as(&S::chord_error), option_of(&ChordOptions::angle).as(&S::angle),
            option_of(&ChordOptions::normal_ratio).as(&S::normal_ratio),
            option("gap_elements", &S::gap_elements, "number of elements across thin parts of the domain; 0: no limit")
                .at_least(0));
    }
    [[nodiscard]] bool are_requested() const { return chord_error > 0 || angle > 0 || gap_elements > 0; }
    friend bool operator==(const GeometrySizes&, const GeometrySizes&) = default;
};

/// Returns metrics at the boundary vertices. `features`: breaks of the boundary. Gaps are measured between straight
/// facets. Sizes are at most `largest`. Errors: usage (no size requested, a reference without facets); those of
/// `chord_metrics` and `gap_metrics`.
template <int D>
[[nodiscard]] Outcome<std::vector<MetricsAtVertices<D>>> geometry_sizes(const LinearMesh<D>& mesh,
                                                                        const Features<D>& features,
                                                                        const GeometrySizes& requested, double largest,
                                                                        const Execution& execution);
template <int D>
[[nodiscard]] Outcome<std::vector<MetricsAtVertices<D>>> geometry_sizes(const QuadraticMesh<D>& mesh,
                                                                        const Features<D>& features,
                                                                        const GeometrySizes& requested, double largest,
                                                                        const Execution& execution);

/// Expected interpolation error, see ExpectedErrors.
struct ExpectedError {
    double l2 = 0;                     ///< 0: unknown
    std::vector<double> weights = {};  ///< one per field; empty: all 1
    friend bool operator==(const ExpectedError&, const ExpectedError&) = default;
};

struct MetricOfSolutionOptions {
    RecoveryOptions recovery = {};
    ModelOptions models = {};
    NormOptions norm = {};
    SolutionMetricOptions metric = {};      ///< amount 0: the number of elements of the mesh
    std::vector<ReferenceSize> sizes = {};  ///< sizes prescribed for references
    GeometrySizes geometry = {};
    double ridge_angle = 40;      ///< angle of boundary breaks for `geometry` (degrees)
    ExpectedError expected = {};  ///< expected error on a mesh that follows the target metric; determines
                                  ///< `MetricOfSolution::bounds`
};

template <int D>
struct MetricOfSolution {
    SolutionMetric<D> metric;
    std::size_t rows = 0, from_inner_fits = 0,
                lower_degree = 0;  ///< see RecoveredDerivatives
    std::size_t zero_models = 0, floored_models = 0;
    /// Largest distances of boundaries and interfaces from their geometry, for each reference, that change the solution
    /// by at most the expected L2 error. Empty if that error is unknown or the solution has no normal derivative.
    std::vector<DistanceBound> bounds = {};
};

/// Computes the metric, of the requested complexity, that minimises the interpolation error of a solution in the norm
/// `options.norm`, for elements of degree norm.degree.
///
/// Several fields count equally. Values are at the vertices (degree 1) or all nodes (degree 2, required for third
/// derivatives). Derivatives are computed within each material. On curved meshes and with materials, element models
/// include the effect of curves; otherwise models are at vertices. `specified` metrics, one per vertex, and prescribed
/// sizes are not scaled.
///
/// Steps: recover, models, fixed, metric. See docs/algorithms/metric-from-solution.md. Errors: those of
/// `recover_derivatives` and `make_solution_metric`; degree 2 for a field of degree 1 (usage); stopped, memory.
template <int D>
[[nodiscard]] Outcome<MetricOfSolution<D>> metric_of_solution(const QuadraticMesh<D>& mesh,
                                                              std::span<const Column<double>> fields,
                                                              std::span<const Column<LogMetric<D>>> specified,
                                                              const MetricOfSolutionOptions& options,
                                                              const StepWrapper& around);

}  // namespace camber
