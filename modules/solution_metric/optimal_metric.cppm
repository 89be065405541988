module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <tuple>
export module camber.solution_metric:optimal_metric;
import camber.core;
import camber.metric;
import :models;

namespace camber {

/// Where a search for a complexity ended.
struct ScaleFound {
    double at = 0, log_complexity = 0;
    int evaluations = 0;
    bool reached = false;
};

/// t with evaluate(t) = target, for a function that rises, with about `slope` where nothing bounds it: the secant,
/// within what is known to be too little and too much, by halves where it would leave that. Begins at `from`. Errors:
/// those of `evaluate`, an Outcome<double>.
[[nodiscard]] Outcome<ScaleFound> search_scale(double from, double target, double slope, double tolerance,
                                               int most_evaluations, const auto& evaluate) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    double low = -infinity, high = infinity, at = from, before = 0, value_before = 0;
    ScaleFound best;
    double best_miss = infinity;
    for (int i = 1; i <= most_evaluations; ++i) {
        const auto value = evaluate(at);
        if (!value) return fail(value.error());
        const double miss = *value - target;
        if (std::abs(miss) < best_miss) {
            best_miss = std::abs(miss);
            best = {at, *value, i, false};
        }
        best.evaluations = i;
        if (std::abs(miss) <= tolerance) {
            best.reached = true;
            return best;
        }
        (miss < 0 ? low : high) = at;
        // A slope of next to nothing, where all is at its bounds, would lead far off.
        double steepness = i == 1 ? slope : (*value - value_before) / (at - before);
        if (!(steepness > 0.05 * slope)) steepness = std::max(0.25 * slope, 1e-6);
        before = at;
        value_before = *value;
        at -= miss / std::min(steepness, 4 * slope);
        if (!(at > low && at < high)) at = std::isfinite(low) && std::isfinite(high) ? (low + high) / 2 : before - miss;
    }
    return best;
}

}  // namespace camber

export namespace camber {

/// Of what the norm is: of the error itself, L^p, or of its gradient, W^{1,p}.
enum class ErrorOf : std::uint8_t { values, gradients };
[[nodiscard]] constexpr auto words(ErrorOf) {
    return words_of(Word{ErrorOf::values, "values"}, Word{ErrorOf::gradients, "gradients"});
}

/// The norm of the interpolation error that a metric is the best one for.
struct NormOptions {
    int degree = 2;  ///< k of the elements: 1 with models of Hessians, 2 with those of third derivatives
    double p = 2;    ///< 0: the largest error anywhere, p = ∞
    ErrorOf error_of = ErrorOf::values;

    [[nodiscard]] static constexpr auto options() {
        using S = NormOptions;
        return std::tuple(
            option("degree", &S::degree, "degree of the elements that interpolate").at_least(1).at_most(2),
            option("p", &S::p, "exponent of the norm; 0: the largest error anywhere").at_least(0),
            option("error_of", &S::error_of, "the norm is of the error's values or gradients"));
    }
    friend bool operator==(const NormOptions&, const NormOptions&) = default;
};

/// P = p(k + 1), of gradients pk: the P-th power of the size is what the p-th power of the error is like.
[[nodiscard]] inline double power_of(const NormOptions& o) {
    if (o.p == 0) return std::numeric_limits<double>::infinity();
    return o.p * (o.error_of == ErrorOf::values ? o.degree + 1 : o.degree);
}

/// The optimal metric at one place, M = Q'/ε, whose sizes are no larger than `largest`:
///
///     Q' = max(Q, ε/largest²) along the axes of Q,   ε = e^s det(Q')^{1/(P+n)}.
///
/// Without the bound this is M = e^{−s} det(Q)^{−1/(P+n)} Q, the metric of least error ‖·‖_p for its complexity
/// (Loseille and Alauzet, "Continuous mesh framework I", SIAM J. Numer. Anal. 49, 2011); with it the same stationary
/// point, ε^{P/2} ∝ sqrt det M, under the constraint that no size exceeds the largest. So a function of one variable
/// alone has the optimal sizes of one dimension, and one that is constant somewhere the largest size there.
/// s is the scale, one for the whole mesh; P = ∞: ε = e^s.
template <int D>
struct OptimalSizes {
    Vec<D> metric_logs;  ///< log-eigenvalues of M
    double log_epsilon = 0;
};
template <int D>
[[nodiscard]] inline OptimalSizes<D> optimal_sizes(const Vec<D>& model_logs, double scale, double power,
                                                   double largest) {
    std::array<int, D> order{};
    for (int i = 0; i < D; ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](int a, int b) { return model_logs[a] > model_logs[b]; });
    const double least = -2 * log(largest);
    OptimalSizes<D> out;
    // The m largest eigenvalues are free, the others at the bound: Σ log q' = Σ_{i≤m} λ_i + (n − m)(log ε + least).
    for (int m = D; m >= 0; --m) {
        double free = 0;
        for (int i = 0; i < m; ++i) free += model_logs[order[i]];
        out.log_epsilon = std::isinf(power) ? scale : (scale * (power + D) + free + (D - m) * least) / (power + m);
        if (m == 0 || model_logs[order[m - 1]] - out.log_epsilon >= least) break;
    }
    for (int i = 0; i < D; ++i) out.metric_logs[i] = std::max(model_logs[i] - out.log_epsilon, least);
    return out;
}

template <int D>
struct OptimalMetric {
    Column<LogMetric<D>> log_metrics;  ///< one a vertex
    double complexity = 0;             ///< that it has
    double scale = 0;                  ///< s of `optimal_sizes`
    int evaluations = 0;
};

/// Target of an optimal metric.
struct MetricTarget {
    NormOptions norm;
    double complexity = 0;
    /// Largest size, in model units. The domain's diameter is no bound but where nothing happens.
    double largest = 0;
};

/// The optimal metric of models at the vertices, of a complexity within 1e-6 of the target's. Errors: models that are
/// all zero ("the field is constant"), a complexity that is no more than that of the largest size alone, columns that
/// are not of this mesh, limits of options (usage); stopped.
template <int D>
[[nodiscard]] Outcome<OptimalMetric<D>> optimal_metric(const LinearMesh<D>& mesh, const Column<LocalModel<D>>& models,
                                                       const MetricTarget& target, const Execution& execution);

/// Models at the vertices from those of the elements: the log-Euclidean mean over the ball, weighted by volume. Where
/// the axes of an element's model are turned against the mean's (`turn_between`), it is carried along with the turn, so
/// that a layer around which axes turn keeps its anisotropy. Elements are raised first to the largest size that the
/// optimal metric of the target allows them, each by itself, since the log of a model that is zero is −∞. Vertices
/// without elements have the zero model. Errors: those of `optimal_metric`.
template <int D>
[[nodiscard]] Outcome<Column<LocalModel<D>>> models_at_vertices(const LinearMesh<D>& mesh,
                                                                const Incidence<ElementId>& balls,
                                                                const Column<LocalModel<D>>& of_elements,
                                                                const MetricTarget& target, const Execution& execution);

/// The diagonal of the box around the vertices.
template <int D>
[[nodiscard]] inline double diameter(const LinearMesh<D>& mesh) {
    Box<D> box;
    for (const Vec<D>& p : mesh.points) box.include(p);
    return box.diagonal();
}

/// What is to be so many.
enum class AmountOf : std::uint8_t {
    complexity,  ///< ∫ sqrt det M
    vertices,    ///< of a mesh of unit elements
    elements,
};
[[nodiscard]] constexpr auto words(AmountOf) {
    return words_of(Word{AmountOf::complexity, "complexity"}, Word{AmountOf::vertices, "vertices"},
                    Word{AmountOf::elements, "elements"});
}

/// Elements of a mesh that was brought to a metric of complexity 1, as found (2.4 to 2.8 triangles, 12 to 15
/// tetrahedra: bench/results/solution-metrics.md). Regular simplices of side 1 would be 4/√3 and 6√2, but
/// tetrahedra do not fill space with these, and edges of a mesh are of unit length in the mean.
template <int D>
[[nodiscard]] constexpr double elements_per_complexity() {
    return D == 2 ? 2.6 : 12.5;
}
/// Elements for each vertex of a large mesh: of triangles 2 (Euler), of tetrahedra 5.7 (as found in remeshed meshes).
template <int D>
[[nodiscard]] constexpr double elements_per_vertex() {
    return D == 2 ? 2 : 5.7;
}
/// The complexity of a mesh of so many vertices or elements.
template <int D>
[[nodiscard]] inline double complexity_of(double amount, AmountOf of) {
    const double elements = of == AmountOf::vertices ? amount * elements_per_vertex<D>() : amount;
    return of == AmountOf::complexity ? amount : elements / elements_per_complexity<D>();
}

/// A field that the mesh is to be good for: its models at the vertices, and in which norm.
template <int D>
struct SolutionField {
    Column<LocalModel<D>> models;
    NormOptions norm = {};
    double share = 1;  ///< of the complexity, for its metric before fields are intersected; 0 to 1
};

struct SolutionMetricOptions {
    double amount = 0;
    AmountOf of = AmountOf::complexity;
    double min_size = 0;
    double max_size = 0;        ///< 0: the domain's diameter
    double max_anisotropy = 0;  ///< 0: none
    std::optional<GradationOptions> gradation = {};
    double tolerance = 1e-3;  ///< of the complexity, relative
    int max_evaluations = 12;

    [[nodiscard]] static constexpr auto options() {
        using S = SolutionMetricOptions;
        return std::tuple(
            option("amount", &S::amount, "how fine the mesh is to be").above(0).required(),
            option("of", &S::of, "what the amount is of: complexity, vertices, elements"),
            option("min_size", &S::min_size, "smallest size; 0: none").unit("model units").at_least(0),
            option("max_size", &S::max_size, "largest size; 0: the domain's diameter").unit("model units").at_least(0),
            option("max_anisotropy", &S::max_anisotropy, "largest ratio of sizes; 0: none").at_least(0),
            option("tolerance", &S::tolerance, "relative, of the complexity").at_least(1e-8).at_most(0.5),
            option("max_evaluations", &S::max_evaluations, "largest number of complexities that are tried")
                .at_least(1)
                .at_most(1000));
    }
};

/// The metric, and how it came about.
template <int D>
struct SolutionMetric {
    Column<LogMetric<D>> log_metrics;  ///< one a vertex
    double asked = 0, reached = 0;     ///< complexities
    double of_fixed = 0;               ///< complexity of all but the fields: fixed metrics, largest size, gradation
    /// The fixed part alone has the complexity asked for, or more: `log_metrics` is that part, and fields have no say.
    bool is_fixed_alone = false;
    bool is_reached = false;        ///< within the tolerance
    bool is_graded = true;          ///< false: a gradation ended before its time
    int evaluations = 0;            ///< complexities tried, those of gradations too
    int gradations = 0;             ///< that were done
    double at_min = 0, at_max = 0;  ///< shares of the vertices with a size at the smallest, and at the largest
};

/// A metric for one or more fields, of a complexity N, in this order:
///
///  1. each field's optimal metric (`optimal_metric`) with its share of N,
///  2. intersected with one another,
///  3. with `fixed` (one a vertex, `fixed_metric`; empty: none), and within the bounds,
///  4. graded;
///
/// and the fields' part is scaled (all their scales s by the same −t) until what comes out of 4. has complexity N, by
/// the secant on logarithms: what is fixed stays. The search begins where the metric before gradation has N, so that
/// few gradations are needed. Errors: those of `optimal_metric` and `apply_gradation`, models and metrics that are not
/// of this mesh, limits of options, no field (usage); stopped.
template <int D>
[[nodiscard]] Outcome<SolutionMetric<D>> make_solution_metric(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                              std::span<const SolutionField<D>> fields,
                                                              const Column<LogMetric<D>>& fixed,
                                                              const SolutionMetricOptions& options,
                                                              const Execution& execution);

}  // namespace camber
