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

struct ScaleFound {
    double at = 0, log_complexity = 0;
    int evaluations = 0;
    bool reached = false;
};

/// Solves evaluate(t) = target for an increasing function, which returns an Outcome<double>. The secant method starts
/// from `from` with the estimated slope `slope`; bisection replaces steps that leave the bracket. Errors: those of
/// `evaluate`.
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
        // If all sizes are at bounds, the slope is almost zero and the step would be far too long.
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

/// Quantity whose error is measured: values (norm L^p) or gradients (norm W^{1,p}).
enum class ErrorQuantity : std::uint8_t { values, gradients };
[[nodiscard]] constexpr auto words(ErrorQuantity) {
    return words_of(Word{ErrorQuantity::values, "values"}, Word{ErrorQuantity::gradients, "gradients"});
}

struct NormOptions {
    int degree = 2;  ///< degree k of the elements: 1 with Hessian models, 2 with third derivatives
    double p = 2;    ///< exponent of the norm; 0: maximum error, p = ∞
    ErrorQuantity error_of = ErrorQuantity::values;

    [[nodiscard]] static constexpr auto options() {
        using S = NormOptions;
        return std::tuple(
            option("degree", &S::degree, "degree of the elements that interpolate the solution").at_least(1).at_most(2),
            option("p", &S::p, "exponent p of the norm L^p; 0: the largest error anywhere").at_least(0),
            option("error_of", &S::error_of, "the norm is of the error's values or gradients"));
    }
    friend bool operator==(const NormOptions&, const NormOptions&) = default;
};

/// Returns P = p(k + 1), or P = pk for gradients: the p-th power of the error scales with the P-th power of the size.
[[nodiscard]] inline double power_of(const NormOptions& o) {
    if (o.p == 0) return std::numeric_limits<double>::infinity();
    return o.p * (o.error_of == ErrorQuantity::values ? o.degree + 1 : o.degree);
}

/// Optimal metric M = Q'/ε at a point with the model Q (docs/algorithms/metric-from-solution.md), for sizes up to
/// `largest`:
///
///     Q' = max(Q, ε/largest²) along the axes of Q, ε = e^s det(Q')^{1/(P+n)}.
///
/// n is the dimension and P the `power`; for P = ∞, ε = e^s. The scale s is the same at all points. M minimises the
/// norm of the error for its complexity (Loseille and Alauzet, "Continuous mesh framework I", SIAM J. Numer. Anal. 49,
/// 2011).
template <int D>
struct OptimalSizes {
    Vec<D> metric_logs;
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
    // The m largest eigenvalues q' of Q' are free, the others are at the bound: Σ log q' = Σ_{i≤m} λ_i + (n − m)(log ε
    // + least).
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
    Column<LogMetric<D>> log_metrics;  ///< one per vertex
    double complexity = 0;
    double scale = 0;  ///< s of `optimal_sizes`
    int evaluations = 0;
};

struct MetricTarget {
    NormOptions norm;
    double complexity = 0;
    /// Largest size, in model units. The domain's diameter as a limit matters only if derivatives vanish.
    double largest = 0;
};

/// Computes the optimal metric for models at the vertices. Its complexity is within 1e-6 (relative) of the target.
/// Errors: all models are zero ("the field is constant"); a complexity not above that of the largest size; columns of
/// another mesh; options out of range (usage); stopped.
template <int D>
[[nodiscard]] Outcome<OptimalMetric<D>> optimal_metric(const LinearMesh<D>& mesh, const Column<LocalModel<D>>& models,
                                                       const MetricTarget& target, const Execution& execution);

/// Returns models at vertices: volume-weighted log-Euclidean means of the models of the elements around each vertex.
/// The axes of the elements' models are rotated to those of the mean (`turn_between`), so that layers with rotating
/// axes keep their anisotropy. Since the log of a zero model is −∞, element models are first raised to the largest size
/// in the target's optimal metric. Vertices without elements have the zero model. Errors: those of `optimal_metric`.
template <int D>
[[nodiscard]] Outcome<Column<LocalModel<D>>> models_at_vertices(const LinearMesh<D>& mesh,
                                                                const Incidence<ElementId>& balls,
                                                                const Column<LocalModel<D>>& of_elements,
                                                                const MetricTarget& target, const Execution& execution);

template <int D>
[[nodiscard]] inline double diameter(const LinearMesh<D>& mesh) {
    Box<D> box;
    for (const Vec<D>& p : mesh.points) box.include(p);
    return box.diagonal();
}

enum class TargetQuantity : std::uint8_t {
    complexity,  ///< complexity ∫ sqrt det M
    vertices,    ///< vertices of a unit mesh
    elements,
};
[[nodiscard]] constexpr auto words(TargetQuantity) {
    return words_of(Word{TargetQuantity::complexity, "complexity"}, Word{TargetQuantity::vertices, "vertices"},
                    Word{TargetQuantity::elements, "elements"});
}

/// Number of elements divided by the complexity, measured on adapted meshes: 2.4 to 2.8 triangles, 12 to 15 tetrahedra
/// (bench/results/solution-metrics.md). Regular unit simplices would give 4/√3 and 6√2, but regular tetrahedra do not
/// fill space.
template <int D>
[[nodiscard]] constexpr double elements_per_complexity() {
    return D == 2 ? 2.6 : 12.5;
}
/// Number of elements divided by vertices in a large mesh: 2 triangles (Euler), 5.7 tetrahedra (measured).
template <int D>
[[nodiscard]] constexpr double elements_per_vertex() {
    return D == 2 ? 2 : 5.7;
}
template <int D>
[[nodiscard]] inline double complexity_of(double amount, TargetQuantity of) {
    const double elements = of == TargetQuantity::vertices ? amount * elements_per_vertex<D>() : amount;
    return of == TargetQuantity::complexity ? amount : elements / elements_per_complexity<D>();
}

template <int D>
struct SolutionField {
    Column<LocalModel<D>> models;
    NormOptions norm = {};
    double share = 1;  ///< share of this field in the complexity, before the intersection; 0 to 1
};

struct SolutionMetricOptions {
    double amount = 0;
    TargetQuantity of = TargetQuantity::complexity;
    double min_size = 0;
    double max_size = 0;        ///< 0: the domain's diameter
    double max_anisotropy = 0;  ///< largest ratio of sizes; 0: unlimited
    std::optional<GradationOptions> gradation = {};
    double tolerance = 1e-3;  ///< relative tolerance of the complexity
    int max_evaluations = 12;

    [[nodiscard]] static constexpr auto options() {
        using S = SolutionMetricOptions;
        return std::tuple(
            option("amount", &S::amount, "target amount of the quantity in the option of").above(0).required(),
            option("of", &S::of,
                   "quantity that amount prescribes: complexity of the metric, number of vertices, or "
                   "number of elements"),
            option("min_size", &S::min_size, "smallest size; 0: none").unit("model units").at_least(0),
            option("max_size", &S::max_size, "largest size; 0: the domain's diameter").unit("model units").at_least(0),
            option("max_anisotropy", &S::max_anisotropy, "largest ratio of sizes; 0: none").at_least(0),
            option("tolerance", &S::tolerance, "relative tolerance of the complexity").at_least(1e-8).at_most(0.5),
            option("max_evaluations", &S::max_evaluations, "largest number of evaluations of the complexity")
                .at_least(1)
                .at_most(1000));
    }
};

template <int D>
struct SolutionMetric {
    Column<LogMetric<D>> log_metrics;   ///< one per vertex
    double requested = 0, reached = 0;  ///< target and reached complexity
    double fixed_complexity = 0;  ///< complexity without any field, from fixed metrics, largest size and gradation
    /// True if the metric without any field reaches the target complexity; it is then the result.
    bool is_fixed_sufficient = false;
    bool is_reached = false;
    bool is_graded = true;  ///< false if a gradation stopped early
    int evaluations = 0;
    int gradations = 0;
    double at_min = 0, at_max = 0;  ///< fractions of vertices at the smallest and at the largest size
};

/// Composes a metric of complexity N for one or more fields:
///
///  1. each field's `optimal_metric` with its share of N,
///  2. their intersection,
///  3. intersection with `fixed` (one metric per vertex, see `fixed_metric`; may be empty) and the bounds,
///  4. gradation.
///
/// The scales s of all fields are shifted by the same −t until step 4 gives the complexity N. The secant method on
/// logarithms determines t, starting from the t with which step 3 gives N. Errors: those of `optimal_metric` and
/// `apply_gradation`; models and metrics of another mesh; options out of range; no field (usage); stopped.
template <int D>
[[nodiscard]] Outcome<SolutionMetric<D>> make_solution_metric(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                              std::span<const SolutionField<D>> fields,
                                                              const Column<LogMetric<D>>& fixed,
                                                              const SolutionMetricOptions& options,
                                                              const Execution& execution);

}  // namespace camber
