module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <tuple>
export module camber.solution_metric:optimal_metric;
import camber.core;
import camber.metric;
import :local_model;

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

/// The optimal metric of models at the vertices, of a complexity within 1e-6 of `complexity`, with no size above
/// `largest` (model units; as much as the domain's diameter bounds nothing but where nothing happens). Errors: models
/// that are all zero ("the field is constant"), a complexity that is no more than that of the largest size alone,
/// columns that are not of this mesh, limits of options (usage); stopped.
template <int D>
[[nodiscard]] Outcome<OptimalMetric<D>> optimal_metric(const LinearMesh<D>& mesh, const Column<LocalModel<D>>& models,
                                                       const NormOptions& norm, double complexity, double largest,
                                                       const Execution& execution);

/// Models at the vertices from those of the elements: the log-Euclidean mean over the ball, weighted by volume. Where
/// the axes of an element's model are turned against the mean's (`turn_between`), it is carried along with the turn, so
/// that a layer around which axes turn keeps its anisotropy. Elements are raised first to the largest size that the
/// optimal metric of `complexity` allows them, each by itself, since the log of a model that is zero is −∞. Vertices
/// without elements have the zero model. Errors: those of `optimal_metric`.
template <int D>
[[nodiscard]] Outcome<Column<LocalModel<D>>> models_at_vertices(const LinearMesh<D>& mesh,
                                                                const Incidence<ElementId>& balls,
                                                                const Column<LocalModel<D>>& of_elements,
                                                                const NormOptions& norm, double complexity,
                                                                double largest, const Execution& execution);

/// The diagonal of the box around the vertices.
template <int D>
[[nodiscard]] inline double diameter(const LinearMesh<D>& mesh) {
    Box<D> box;
    for (const Vec<D>& p : mesh.points) box.include(p);
    return box.diagonal();
}

}  // namespace camber
