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

/// A scalar field that is known on a mesh: at its vertices or, then of degree 2, at all of its nodes.
struct WeightedField {
    Column<double> values;
    double weight = 1;  ///< of its error beside those of others, each in a unit in which its range is about 1
};

/// What the objective solution is given: fields, or one function that is known everywhere.
template <int D>
struct GivenSolution {
    std::vector<WeightedField> fields = {};
    FunctionOfPlace<D> function = {};

    [[nodiscard]] bool empty() const { return fields.empty() && !function; }
};

/// What edges' nodes are found by, in the elements of \p curved, which is \p mesh with mid nodes of its own: of fields
/// on \p mesh polynomials, each by nodes of its own material; a function itself. Errors: those of `element_values`;
/// stopped, memory.
template <int D>
[[nodiscard]] Outcome<KnownSolution<D>> known_solution(const QuadraticMesh<D>& mesh, const GivenSolution<D>& given,
                                                       const QuadraticMesh<D>& curved, const Execution& execution);

/// A metric at the vertices of the mesh, one row a vertex. `make` gets the mesh's natural metric, empty where
/// `of_natural` says that it does not look. A mesh whose walls sag asks twice: for the mesh with its curves, and then
/// for the straight one.
template <int D>
struct MetricAtVertices {
    bool of_natural = true;
    std::function<Outcome<Column<LogMetric<D>>>(const Column<LogMetric<D>>& natural, const Execution&)> make;
};

/// A field with a mesh of its own, asked where it lies.
template <int D>
struct MetricField {
    std::function<Outcome<BackMesh<D>>(const Execution&)> make;
};

/// What edges follow.
template <int D>
using MetricSource = std::variant<MetricAtVertices<D>, MetricField<D>>;

/// Whether a metric is the mesh's own, or made of it.
enum class MetricOrigin : std::uint8_t { natural, given };
template <int D>
[[nodiscard]] MetricOrigin origin_of(const MetricSource<D>& metric) {
    const auto* const at_vertices = std::get_if<MetricAtVertices<D>>(&metric);
    return at_vertices != nullptr && at_vertices->of_natural ? MetricOrigin::natural : MetricOrigin::given;
}

/// How nodes for accuracy follow a metric: the mesh's own is noisy, others are taken at their word; a kind that is not
/// stated is known of the mesh's own.
[[nodiscard]] inline EdgeAccuracyOptions accuracy_for(MetricOrigin origin, const EdgeAccuracyOptions& asked) {
    EdgeAccuracyOptions options = asked;
    const bool is_natural = origin == MetricOrigin::natural;
    options.change = is_natural ? ChangeAlong::recovered : ChangeAlong::of_ends;
    if (is_natural && options.metric_kind == MetricKind::automatic) options.metric_kind = MetricKind::natural;
    return options;
}

/// True if nodes are found by the mesh's own metric.
[[nodiscard]] inline bool follows_mesh(const CurveOptions& edges) {
    return edges.aim == CurvingAim::accuracy && edges.metric_kind == MetricKind::natural;
}

/// Returns the recommended target of repair for elements whose nodes were found with these options.
[[nodiscard]] inline JacobianBound recommended_target(const CurveOptions& edges) {
    return JacobianBound::recommended(follows_mesh(edges) ? target_without_metric : default_bound);
}

/// Returns the scaled Jacobian that slides of nodes in planes leave: repair does not move these nodes back for its
/// target.
[[nodiscard]] inline double slide_bound(const CurveOptions& edges) {
    return follows_mesh(edges) ? std::max(edges.min_jacobian, target_without_metric) : edges.min_jacobian;
}

/// The mesh's own (paper §1.2.1).
template <int D>
[[nodiscard]] MetricSource<D> natural_metric() {
    return MetricAtVertices<D>{
        true,
        [](const Column<LogMetric<D>>& natural, const Execution&) -> Outcome<Column<LogMetric<D>>> { return natural; }};
}

/// Given: one row a vertex.
template <int D>
[[nodiscard]] MetricSource<D> metric_at_vertices(Column<LogMetric<D>> log_metrics) {
    return MetricAtVertices<D>{
        false, [log_metrics = std::move(log_metrics)](const auto&, const Execution&) -> Outcome<Column<LogMetric<D>>> {
            return log_metrics;
        }};
}

/// What the geometry of a mesh's boundary asks of sizes by itself.
struct GeometrySizes {
    std::vector<Reference> references = {};  ///< of the facets that ask; empty: all
    double chord_error = 0, angle = 0;       ///< as of ChordOptions
    double normal_ratio = ChordOptions{}.normal_ratio;
    double gap_elements = 0;  ///< across the domain where it is thin, as of GapOptions

    [[nodiscard]] static constexpr auto options() {
        using S = GeometrySizes;
        return std::tuple(
            option("references", &S::references, "of the boundary facets that ask; empty: all").count(0, 100000),
            option_of(&ChordOptions::chord_error).as(&S::chord_error), option_of(&ChordOptions::angle).as(&S::angle),
            option_of(&ChordOptions::normal_ratio).as(&S::normal_ratio),
            option("gap_elements", &S::gap_elements,
                   "how many elements there shall be across the domain where it is thin; 0: any number")
                .at_least(0));
    }
    [[nodiscard]] bool are_asked() const { return chord_error > 0 || angle > 0 || gap_elements > 0; }
    friend bool operator==(const GeometrySizes&, const GeometrySizes&) = default;
};

/// The metrics of such sizes at the vertices of the boundary, straight or with its curves; `features` say where it
/// breaks. Gaps are measured between straight facets. No size is above `largest`. Errors (usage): nothing asked, a
/// reference that no facet has; those of `chord_metrics` and `gap_metrics`.
template <int D>
[[nodiscard]] Outcome<std::vector<MetricsAtVertices<D>>> geometry_sizes(const LinearMesh<D>& mesh,
                                                                        const Features<D>& features,
                                                                        const GeometrySizes& asked, double largest,
                                                                        const Execution& execution);
template <int D>
[[nodiscard]] Outcome<std::vector<MetricsAtVertices<D>>> geometry_sizes(const QuadraticMesh<D>& mesh,
                                                                        const Features<D>& features,
                                                                        const GeometrySizes& asked, double largest,
                                                                        const Execution& execution);

/// Error that is expected of a solution's interpolant, as ExpectedErrors: of one field weight · L2 error in the user's
/// unit, of several the root of Σ (weight · L2 error)², each in a unit in which its range is about 1.
struct ExpectedError {
    double l2 = 0;                     ///< 0: not known
    std::vector<double> weights = {};  ///< a field each; none: 1 of all
    friend bool operator==(const ExpectedError&, const ExpectedError&) = default;
};

struct MetricOfSolutionOptions {
    RecoveryOptions recovery = {};
    ModelOptions models = {};
    NormOptions norm = {};
    SolutionMetricOptions metric = {};      ///< an amount of 0: as many elements as the mesh has
    std::vector<ReferenceSize> sizes = {};  ///< that are asked for by reference
    GeometrySizes geometry = {};            ///< that the boundary's own surface asks for
    double ridge_angle = 40;                ///< beyond which the boundary breaks there (degrees)
    ExpectedError expected = {};            ///< of a mesh like the one to be made; see `bounds`
};

/// The metric, and what it was made of.
template <int D>
struct MetricOfSolution {
    SolutionMetric<D> metric;
    std::size_t rows = 0, from_inner_fits = 0,
                lower_degree = 0;  ///< of recovered derivatives, see RecoveredDerivatives
    std::size_t zero_models = 0, floored_models = 0;
    /// Largest distances of the boundary and of interfaces from their geometry, by reference: a boundary as far off
    /// changes the solution by no more than the expected error in L2. None where the error is not known, or the
    /// solution has no derivative along the normals.
    std::vector<DistanceBound> bounds = {};
};

/// The metric of the mesh that interpolates a solution best with elements of degree norm.degree, in the norm, for a
/// complexity. Each field is a column of values at the nodes: at the vertices (degree 1), or at those and the edges'
/// nodes (degree 2), which third derivatives need; each has the same share. Derivatives are one-sided by material.
/// Where the mesh is curved, or has materials, models are those of elements, and see what curves take away of the
/// error; else those of vertices. `given` metrics, one a vertex each, are fixed, as sizes and the geometry's are.
/// Steps: recover, models, fixed, metric. Docs: docs/algorithms/metric-from-solution.md. Errors: those of
/// `recover_derivatives`, `make_solution_metric`; elements of degree 2 for a field of degree 1 (usage); stopped,
/// memory.
template <int D>
[[nodiscard]] Outcome<MetricOfSolution<D>> metric_of_solution(const QuadraticMesh<D>& mesh,
                                                              std::span<const Column<double>> fields,
                                                              std::span<const Column<LogMetric<D>>> given,
                                                              const MetricOfSolutionOptions& options,
                                                              const Around& around);

}  // namespace camber
