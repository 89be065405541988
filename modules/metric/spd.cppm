module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
export module camber.metric:spd;
import camber.core;
import :eigen;

export namespace camber {

/// A Riemannian metric at a point: symmetric positive definite, in 1/length². Sizes are h_i = λ_i^{-1/2}.
template <int D>
struct Metric {
    Sym<D> m;
    friend bool operator==(const Metric&, const Metric&) = default;
};

/// log M, any symmetric matrix. Fields are stored and interpolated in this form (paper §1.2, log-Euclidean), and it is
/// a type of its own so that the two are never mixed.
template <int D>
struct LogMetric {
    Sym<D> l;
    friend bool operator==(const LogMetric&, const LogMetric&) = default;
};

/// log M decomposed, ready to measure with: M = R diag(e^{λ_i}) Rᵀ, with λ_i the log-eigenvalues.
/// Every evaluation goes by Σ e^{λ_i} (r_i·v)² and never by the entries of M: with v on the long axis those lose all
/// digits at anisotropy 10^8, the sum none.
template <int D>
struct SpectralMetric {
    Vec<D> log_values;
    Vec<D> values;  ///< e^{λ_i}
    Mat<D> vectors;

    explicit SpectralMetric(const LogMetric<D>& log_metric) : SpectralMetric(eigen_system(log_metric.l)) {}
    explicit SpectralMetric(const EigenSystem<D>& e) : log_values(e.values), vectors(e.vectors) {
        for (int i = 0; i < D; ++i) values[i] = exp(e.values[i]);
    }

    /// vᵀ M v.
    [[nodiscard]] inline double length_squared(const Vec<D>& v) const {
        double q = 0;
        for (int i = 0; i < D; ++i) {
            const double w = dot(vectors.column[i], v);
            q += values[i] * w * w;
        }
        return q;
    }
    /// M v.
    [[nodiscard]] inline Vec<D> times(const Vec<D>& v) const {
        Vec<D> r;
        for (int i = 0; i < D; ++i) r += values[i] * dot(vectors.column[i], v) * vectors.column[i];
        return r;
    }
    /// M⁻¹ v.
    [[nodiscard]] inline Vec<D> solve(const Vec<D>& v) const {
        Vec<D> r;
        for (int i = 0; i < D; ++i) r += dot(vectors.column[i], v) / values[i] * vectors.column[i];
        return r;
    }
};

/// Φ(a, b) = (e^a − e^b)/(a − b), the first divided difference of exp, without cancellation: e^{(a+b)/2} sinh(δ)/δ with
/// δ = (a − b)/2.
[[nodiscard]] inline double exp_divided_difference(double a, double b) {
    const double delta = (a - b) / 2;
    const double ratio = std::abs(delta) < 1e-4 ? 1 + delta * delta / 6 : sinh(delta) / delta;
    return exp((a + b) / 2) * ratio;
}

/// The same from e^a and e^b already at hand; no exponential unless the two are near.
[[nodiscard]] inline double exp_divided_difference(double a, double b, double exp_a, double exp_b) {
    return std::abs(a - b) > 0.1 ? (exp_a - exp_b) / (a - b) : exp_divided_difference(a, b);
}

/// D exp(L)[E] = R (Φ ∘ (Rᵀ E R)) Rᵀ (Daletskii–Krein): how M = exp(L) changes when L moves by E.
template <int D>
[[nodiscard]] inline Sym<D> exp_derivative(const SpectralMetric<D>& s, const Sym<D>& direction) {
    Sym<D> inner_part = congruence(transposed(s.vectors), direction);
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j)
            inner_part(i, j) *= exp_divided_difference(s.log_values[i], s.log_values[j], s.values[i], s.values[j]);
    return congruence(s.vectors, inner_part);
}

/// The adjoint G of L ↦ vᵀ exp(L) v: its change for any ∂L is ⟨G, ∂L⟩, with G = R (Φ ∘ (w wᵀ)) Rᵀ, w = Rᵀ v.
template <int D>
[[nodiscard]] inline Sym<D> length_squared_adjoint(const SpectralMetric<D>& s, const Vec<D>& v) {
    const Vec<D> w = transposed_times(s.vectors, v);
    Sym<D> inner_part;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j)
            inner_part(i, j) =
                w[i] * w[j] * exp_divided_difference(s.log_values[i], s.log_values[j], s.values[i], s.values[j]);
    return congruence(s.vectors, inner_part);
}

/// exp: the metric of a log-metric. Entries of M hold fewer digits than log M: to measure, use SpectralMetric.
template <int D>
[[nodiscard]] inline Metric<D> exp(const LogMetric<D>& log_metric) {
    EigenSystem<D> e = eigen_system(log_metric.l);
    for (int i = 0; i < D; ++i) e.values[i] = exp(e.values[i]);
    return {composed(e)};
}

/// log of a metric whose eigenvalues are all positive (not checked here: see log_metrics_of_tensors).
template <int D>
[[nodiscard]] inline LogMetric<D> log(const Metric<D>& metric) {
    EigenSystem<D> e = eigen_system(metric.m);
    for (int i = 0; i < D; ++i) e.values[i] = log(e.values[i]);
    return {composed(e)};
}

/// The log-metric of sizes h_i along the columns of R: λ_i = −2 log h_i.
template <int D>
[[nodiscard]] inline LogMetric<D> log_metric_of_sizes(const Vec<D>& sizes, const Mat<D>& axes = Mat<D>::identity()) {
    EigenSystem<D> e{.values = {}, .vectors = axes};
    for (int i = 0; i < D; ++i) e.values[i] = -2 * log(sizes[i]);
    return {composed(e)};
}

/// sqrt(λ_max/λ_min) of M.
template <int D>
[[nodiscard]] inline double anisotropy(const LogMetric<D>& log_metric) {
    const Vec<D> values = eigen_system(log_metric.l).values;
    const auto [low, high] = std::minmax_element(values.c.begin(), values.c.end());
    return exp((*high - *low) / 2);
}

}  // namespace camber
