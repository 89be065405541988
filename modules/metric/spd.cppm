module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
export module camber.metric:spd;
import camber.core;
import camber.bezier;

export namespace camber {

/// Decomposition A = R diag(values) Rᵀ of a symmetric matrix. The columns of R, `vectors`, are orthonormal. The values
/// have no order.
template <int D>
struct EigenSystem {
    Vec<D> values;
    Mat<D> vectors;
};

template <int D>
inline void jacobi_rotate(Sym<D>& a, Mat<D>& r, int p, int q) {
    const double apq = a(p, q);
    if (apq == 0) return;
    const double theta = (a(q, q) - a(p, p)) / (2 * apq);
    const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1));
    const double c = 1 / std::sqrt(t * t + 1);
    const double s = t * c;
    a(p, p) -= t * apq;
    a(q, q) += t * apq;
    a(p, q) = 0;
    for (int k = 0; k < D; ++k) {
        if (k != p && k != q) {
            const double akp = a(k, p);
            const double akq = a(k, q);
            a(k, p) = c * akp - s * akq;
            a(k, q) = s * akp + c * akq;
        }
        const double rkp = r(k, p);
        const double rkq = r(k, q);
        r(k, p) = c * rkp - s * rkq;
        r(k, q) = s * rkp + c * rkq;
    }
}

/// Decomposes A by cyclic Jacobi rotations, which are accurate for nearly equal eigenvalues, unlike closed forms. The
/// backward error is a few ulps of |A|.
template <int D>
[[nodiscard]] inline EigenSystem<D> eigen_system(Sym<D> a) {
    Mat<D> r = Mat<D>::identity();
    constexpr int sweeps = D == 2 ? 1 : 12;
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        double off = 0;
        double all = 0;
        for (int i = 0; i < D; ++i) {
            all += a(i, i) * a(i, i);
            for (int j = 0; j < i; ++j) off += a(i, j) * a(i, j);
        }
        // Convergence is quadratic: off-diagonal entries below 1e-17 |A| are rounding errors.
        if (off <= 1e-34 * all) break;
        for (int p = 0; p < D - 1; ++p)
            for (int q = p + 1; q < D; ++q) jacobi_rotate(a, r, p, q);
    }
    EigenSystem<D> out{.values = {}, .vectors = r};
    for (int i = 0; i < D; ++i) out.values[i] = a(i, i);
    return out;
}

template <int D>
[[nodiscard]] inline Sym<D> composed(const EigenSystem<D>& e) {
    Sym<D> s;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j) {
            double sum = 0;
            for (int k = 0; k < D; ++k) sum += e.vectors(i, k) * e.values[k] * e.vectors(j, k);
            s(i, j) = sum;
        }
    return s;
}

/// Returns the left singular vectors U and the singular values of A = U Σ Vᵀ, by one-sided Jacobi rotations (Hestenes).
/// Small values are accurate, unlike those from eigenvalues of A Aᵀ.
template <int D>
[[nodiscard]] inline EigenSystem<D> left_singular(const Mat<D>& a) {
    // The rotations U make the columns of Aᵀ U = V Σ orthogonal.
    Mat<D> w = transposed(a);
    Mat<D> u = Mat<D>::identity();
    for (int sweep = 0; sweep < 30; ++sweep) {
        bool rotated = false;
        for (int p = 0; p < D - 1; ++p)
            for (int q = p + 1; q < D; ++q) {
                const double alpha = norm_squared(w.column[p]);
                const double beta = norm_squared(w.column[q]);
                const double gamma = dot(w.column[p], w.column[q]);
                // The relative scalar product of two columns cannot fall below a few ulps, so a lower threshold would
                // never be reached.
                if (std::abs(gamma) <= 1e-15 * std::sqrt(alpha * beta)) continue;
                rotated = true;
                const double zeta = (beta - alpha) / (2 * gamma);
                const double t = std::copysign(1.0, zeta) / (std::abs(zeta) + std::sqrt(zeta * zeta + 1));
                const double c = 1 / std::sqrt(t * t + 1);
                const double s = t * c;
                const auto rotate = [&](Mat<D>& m) {
                    const Vec<D> mp = m.column[p];
                    const Vec<D> mq = m.column[q];
                    m.column[p] = c * mp - s * mq;
                    m.column[q] = s * mp + c * mq;
                };
                rotate(w);
                rotate(u);
            }
        if (!rotated) break;
    }
    EigenSystem<D> out{.values = {}, .vectors = u};
    for (int i = 0; i < D; ++i) out.values[i] = norm(w.column[i]);
    return out;
}

/// Riemannian metric: a symmetric positive definite matrix, in 1/length². Its sizes are h_i = λ_i^{-1/2} for the
/// eigenvalues λ_i.
template <int D>
struct Metric {
    Sym<D> m;
    friend bool operator==(const Metric&, const Metric&) = default;
};

/// Logarithm of a metric M, any symmetric matrix. Fields are stored and interpolated in this form (log-Euclidean;
/// paper, §1.2).
template <int D>
struct LogMetric {
    Sym<D> l;
    friend bool operator==(const LogMetric&, const LogMetric&) = default;
};

/// Decomposed metric M = R diag(e^{λ_i}) Rᵀ. It yields accurate squared lengths Σ e^{λ_i} (r_i·v)² (r_i: columns of R).
/// The entries of M, in contrast, lose all digits along the long axis at anisotropy 10^8.
template <int D>
struct SpectralMetric {
    Vec<D> log_values;
    Vec<D> values;  ///< e^{λ_i}
    Mat<D> vectors;

    explicit SpectralMetric(const LogMetric<D>& log_metric) : SpectralMetric(eigen_system(log_metric.l)) {}
    explicit SpectralMetric(const EigenSystem<D>& e) : log_values(e.values), vectors(e.vectors) {
        for (int i = 0; i < D; ++i) values[i] = exp(e.values[i]);
    }

    [[nodiscard]] inline double length_squared(const Vec<D>& v) const {
        double q = 0;
        for (int i = 0; i < D; ++i) {
            const double w = dot(vectors.column[i], v);
            q += values[i] * w * w;
        }
        return q;
    }
    /// Returns M v.
    [[nodiscard]] inline Vec<D> times(const Vec<D>& v) const {
        Vec<D> r;
        for (int i = 0; i < D; ++i) r += values[i] * dot(vectors.column[i], v) * vectors.column[i];
        return r;
    }
    /// Returns M⁻¹ v.
    [[nodiscard]] inline Vec<D> solve(const Vec<D>& v) const {
        Vec<D> r;
        for (int i = 0; i < D; ++i) r += dot(vectors.column[i], v) / values[i] * vectors.column[i];
        return r;
    }
};

/// Returns Φ(a, b) = (e^a − e^b)/(a − b) without cancellation, as e^{(a+b)/2} sinh(δ)/δ with δ = (a − b)/2.
[[nodiscard]] inline double exp_divided_difference(double a, double b) {
    const double delta = (a - b) / 2;
    const double ratio = std::abs(delta) < 1e-4 ? 1 + delta * delta / 6 : sinh(delta) / delta;
    return exp((a + b) / 2) * ratio;
}

/// Returns the same Φ(a, b) for known e^a and e^b.
[[nodiscard]] inline double exp_divided_difference(double a, double b, double exp_a, double exp_b) {
    return std::abs(a - b) > 0.1 ? (exp_a - exp_b) / (a - b) : exp_divided_difference(a, b);
}

/// Derivative of exp at L = R diag(λ_i) Rᵀ in the direction E (Daletskii–Krein): D exp(L)[E] = R (Φ ∘ (Rᵀ E R)) Rᵀ,
/// with Φ_ij = Φ(λ_i, λ_j) and the entrywise product ∘.
template <int D>
[[nodiscard]] inline Sym<D> exp_derivative(const SpectralMetric<D>& s, const Sym<D>& direction) {
    Sym<D> inner_part = congruence(transposed(s.vectors), direction);
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j)
            inner_part(i, j) *= exp_divided_difference(s.log_values[i], s.log_values[j], s.values[i], s.values[j]);
    return congruence(s.vectors, inner_part);
}

/// Returns the symmetric matrix G with d(vᵀ exp(L) v) = ⟨G, dL⟩, that is G = R (Φ ∘ (w wᵀ)) Rᵀ with w = Rᵀ v (notation
/// of `exp_derivative`).
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

template <int D>
[[nodiscard]] inline Metric<D> exp(const LogMetric<D>& log_metric) {
    EigenSystem<D> e = eigen_system(log_metric.l);
    for (int i = 0; i < D; ++i) e.values[i] = exp(e.values[i]);
    return {composed(e)};
}

/// Requires positive eigenvalues, which are not checked (see `log_metrics_of_tensors`).
template <int D>
[[nodiscard]] inline LogMetric<D> log(const Metric<D>& metric) {
    EigenSystem<D> e = eigen_system(metric.m);
    for (int i = 0; i < D; ++i) e.values[i] = log(e.values[i]);
    return {composed(e)};
}

/// Log-metric with sizes h_i along the columns of `axes`: λ_i = −2 log h_i.
template <int D>
[[nodiscard]] inline LogMetric<D> log_metric_of_sizes(const Vec<D>& sizes, const Mat<D>& axes = Mat<D>::identity()) {
    EigenSystem<D> e{.values = {}, .vectors = axes};
    for (int i = 0; i < D; ++i) e.values[i] = -2 * log(sizes[i]);
    return {composed(e)};
}

template <int D>
[[nodiscard]] inline double anisotropy(const LogMetric<D>& log_metric) {
    const Vec<D> values = eigen_system(log_metric.l).values;
    const auto [low, high] = std::minmax_element(values.c.begin(), values.c.end());
    return exp((*high - *low) / 2);
}

}  // namespace camber

/// Functions that process many metrics in packs (core:tensors). All spans of a call have equal sizes. Each result is
/// bitwise independent of the other items and of the instruction set.
export namespace camber {

template <int D>
void metric_norms(std::span<const LogMetric<D>> metrics, std::span<const Vec<D>> vectors, std::span<double> norms,
                  Instructions set = widest_instructions());

template <int D>
void natural_log_metrics(std::span<const std::array<Vec<D>, D + 1>> simplices, std::span<LogMetric<D>> metrics,
                         Instructions set = widest_instructions());

template <int D>
struct PulledBackMetric {
    LogMetric<D> log_metric;           ///< logarithm of the metric M̂ = Fᵀ M F
    Mat<D> axes = Mat<D>::identity();  ///< orthogonal matrix M^{1/2} F M̂^{-1/2}; maps the frame of M̂ to that of M
    friend bool operator==(const PulledBackMetric&, const PulledBackMetric&) = default;
};
/// Pulls each metric M back by its Jacobian F. Singular values make the result accurate for needles. If F is singular,
/// M̂ is M.
template <int D>
void pull_back_metrics(std::span<const LogMetric<D>> metrics, std::span<const Mat<D>> jacobians,
                       std::span<PulledBackMetric<D>> pulled_back, Instructions set = widest_instructions());

/// Derivative of exp in the frame R of the eigenvectors of M: each entry (i, j) of `direction` = Rᵀ E R is multiplied
/// by Φ_ij = (e^{λ_i} − e^{λ_j})/(λ_i − λ_j). In other frames (`exp_derivative`, `log_derivative`), rounding errors of
/// large entries hide small ones at high anisotropy.
template <int D>
[[nodiscard]] inline Sym<D> exp_derivative_in_frame(const SpectralMetric<D>& s, Sym<D> direction) {
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j)
            direction(i, j) *= exp_divided_difference(s.log_values[i], s.log_values[j], s.values[i], s.values[j]);
    return direction;
}

/// Derivative of log in the frame R: each entry is divided by Φ_ij. The result is accurate also for equal eigenvalues.
template <int D>
[[nodiscard]] inline Sym<D> log_derivative_in_frame(const SpectralMetric<D>& s, Sym<D> direction) {
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j)
            direction(i, j) /= exp_divided_difference(s.log_values[i], s.log_values[j], s.values[i], s.values[j]);
    return direction;
}

/// Derivative of log at M, decomposed in `s`, and inverse of `exp_derivative`: D log(M)[E] = R ((Rᵀ E R) / Φ) Rᵀ.
/// Relative rounding errors ε of E cause errors ε |E|/λ_min in the block of small eigenvalues.
template <int D>
[[nodiscard]] inline Sym<D> log_derivative(const SpectralMetric<D>& s, const Sym<D>& direction) {
    return congruence(s.vectors, log_derivative_in_frame(s, congruence(transposed(s.vectors), direction)));
}

template <int D>
[[nodiscard]] inline Sym<D> log_derivative(const Metric<D>& metric, const Sym<D>& direction) {
    return log_derivative(SpectralMetric<D>(log(metric)), direction);
}

}  // namespace camber

/// High-order log-Euclidean interpolation of metrics on a K-simplex of degree N
/// (docs/algorithms/metric-interpolation.md). Three forms have the numbers of the paper (§2.1):
///     (2) Bernstein polynomials B_α with log-metrics at the control points: BezierLogs
///     (3) Lagrange functions with log-metrics at the nodes: LagrangeLogs
///     (4) B_α with virtual log-metrics, computed by virtual_logs(LagrangeLogs); the default
/// (3) and (4) are the same function. (2) is another one, since control points lie off the element.
export namespace camber {

/// Bézier coefficients in the order of multi_indices<N, K>: log-metrics at control points in form (2), virtual
/// log-metrics in form (4).
template <int N, int K, int D>
struct BezierLogs {
    std::array<LogMetric<D>, node_count<N, K>> logs{};
    friend bool operator==(const BezierLogs&, const BezierLogs&) = default;
};

/// Log-metrics at the Lagrange nodes of the element, in the order of multi_indices<N, K>.
template <int N, int K, int D>
struct LagrangeLogs {
    std::array<LogMetric<D>, node_count<N, K>> logs{};
    friend bool operator==(const LagrangeLogs&, const LagrangeLogs&) = default;
};

template <int N, int K, int D>
[[nodiscard]] inline BezierLogs<N, K, D> virtual_logs(const LagrangeLogs<N, K, D>& nodes) {
    BezierLogs<N, K, D> out;
    const auto& matrix = lagrange_to_bezier<N, K>;
    for (std::size_t r = 0; r < out.logs.size(); ++r)
        for (std::size_t c = 0; c < out.logs.size(); ++c)
            if (matrix[r][c] != 0) out.logs[r].l += matrix[r][c] * nodes.logs[c].l;
    return out;
}

template <int N, int K, int D>
[[nodiscard]] inline LogMetric<D> interpolated(const BezierLogs<N, K, D>& field, const Barycentric<K>& xi) {
    LogMetric<D> out;
    for (std::size_t a = 0; a < field.logs.size(); ++a)
        out.l += bernstein<K>(multi_indices<N, K>[a], xi) * field.logs[a].l;
    return out;
}

template <int N, int K, int D>
[[nodiscard]] inline LogMetric<D> interpolated(const LagrangeLogs<N, K, D>& nodes, const Barycentric<K>& xi) {
    LogMetric<D> out;
    for (std::size_t a = 0; a < nodes.logs.size(); ++a)
        out.l += lagrange<K>(multi_indices<N, K>[a], xi) * nodes.logs[a].l;
    return out;
}

/// Returns ∂ log M/∂ξ_i for i = 1 … K, with ξ_0 = 1 − Σ ξ_i.
template <int N, int K, int D>
[[nodiscard]] inline std::array<Sym<D>, K> log_gradient(const BezierLogs<N, K, D>& field, const Barycentric<K>& xi) {
    std::array<Sym<D>, K> out{};
    for (const MultiIndex<K>& beta : multi_indices<N - 1, K>) {
        const double weight = N * bernstein<K>(beta, xi);
        const auto at = [&](int raised) -> const Sym<D>& {
            MultiIndex<K> alpha = beta;
            ++alpha[static_cast<std::size_t>(raised)];
            return field.logs[static_cast<std::size_t>(position<N, K>(alpha))].l;
        };
        for (int i = 0; i < K; ++i) out[static_cast<std::size_t>(i)] += weight * (at(i + 1) - at(0));
    }
    return out;
}
template <int N, int K, int D>
[[nodiscard]] inline std::array<Sym<D>, K> log_gradient(const LagrangeLogs<N, K, D>& nodes, const Barycentric<K>& xi) {
    return log_gradient(virtual_logs(nodes), xi);
}

/// Returns ∂M/∂ξ_i = D exp(Q)[∂Q/∂ξ_i] with Q = log M. The paper's formula exp(Q) ∂Q holds only if Q and ∂Q commute.
template <class Field>
[[nodiscard]] inline auto metric_gradient(const Field& field, const auto& xi) {
    auto gradient = log_gradient(field, xi);
    const SpectralMetric spectral(interpolated(field, xi));
    for (auto& direction : gradient) direction = exp_derivative(spectral, direction);
    return gradient;
}

/// Returns the intersection M of the metrics M_1 (`a`) and M_2 (`b`) by simultaneous reduction: the metric with the
/// largest sizes for which vᵀMv ≥ vᵀM_i v for all v. If M_1 or M_2 satisfies this, it is returned bitwise. Along shared
/// axes the result is exact. Otherwise its relative error is a few ulps times the anisotropy (1e-9 at 1e6).
template <int D>
[[nodiscard]] inline EigenSystem<D> intersection(const EigenSystem<D>& a, const EigenSystem<D>& b) {
    // M_i = R_i Λ_i R_iᵀ, and C = Λ_2^{1/2} R_2ᵀ R_1 Λ_1^{-1/2} = U Σ Vᵀ. The variable `c` is Cᵀ, with the left
    // singular vectors V. Entries of M_1⁻¹ M_2 would cancel at high anisotropy.
    Mat<D> c;
    for (int j = 0; j < D; ++j)
        for (int i = 0; i < D; ++i)
            c(i, j) = exp((b.values[j] - a.values[i]) / 2) * dot(a.vectors.column[i], b.vectors.column[j]);
    const EigenSystem<D> s = left_singular(c);
    const auto [low, high] = std::minmax_element(s.values.c.begin(), s.values.c.end());
    if (*high <= 1) return a;
    if (*low >= 1) return b;
    // M = FᵀF with Fᵀ = R_1 Λ_1^{1/2} V max(1, Σ). The eigenvalues of log M are twice the logs of the singular values
    // of F.
    Mat<D> f;
    for (int j = 0; j < D; ++j)
        for (int i = 0; i < D; ++i)
            f.column[j] += exp(a.values[i] / 2) * s.vectors(i, j) * std::max(1.0, s.values[j]) * a.vectors.column[i];
    EigenSystem<D> out = left_singular(f);
    for (double& x : out.values.c) x = 2 * log(x);
    return out;
}

template <int D>
[[nodiscard]] inline LogMetric<D> intersection(const LogMetric<D>& a, const LogMetric<D>& b) {
    if (a == b) return a;
    return {composed(intersection(eigen_system(a.l), eigen_system(b.l)))};
}

/// Returns the maximum over v of ½ log(vᵀM_outer v/vᵀM_inner v). It is at most 0 if `inner` requests the smaller size
/// in each direction, and log 2 if `outer` requests half the size in some direction.
template <int D>
[[nodiscard]] inline double size_excess(const EigenSystem<D>& inner, const EigenSystem<D>& outer) {
    Mat<D> c;
    for (int j = 0; j < D; ++j)
        for (int i = 0; i < D; ++i)
            c(i, j) =
                exp((outer.values[j] - inner.values[i]) / 2) * dot(inner.vectors.column[i], outer.vectors.column[j]);
    const Vec<D> values = left_singular(c).values;
    return log(*std::max_element(values.c.begin(), values.c.end()));
}
template <int D>
[[nodiscard]] inline double size_excess(const LogMetric<D>& inner, const LogMetric<D>& outer) {
    return size_excess(eigen_system(inner.l), eigen_system(outer.l));
}

/// Rotation. In 3D, `about` is the rotation vector: axis times angle in radians. In 2D, its first entry is the angle.
template <int D>
struct AxesTurn {
    Vec<3> about;

    [[nodiscard]] Vec<D> operator()(const Vec<D>& v) const {
        if constexpr (D == 2) {
            const double c = cos(about[0]), s = sin(about[0]);
            return {{c * v[0] - s * v[1], s * v[0] + c * v[1]}};
        } else {
            const double angle = norm(about);
            if (!(angle > 0)) return v;
            const Vec<3> axis = about / angle;
            return cos(angle) * v + sin(angle) * cross(axis, v) + ((1 - cos(angle)) * dot(axis, v)) * axis;
        }
    }
    [[nodiscard]] AxesTurn by(double share) const { return {share * about}; }
    [[nodiscard]] bool is_none() const { return about == Vec<3>{}; }
};

/// Returns the rotation of a metric's axes between two places with the log-metrics `from` and `to`
/// (docs/algorithms/metric-interpolation.md). Rotations in one plane are exact except for two damping factors. The
/// rotation vanishes for equal sizes, which have no axes, and beyond about 0.8 radians, where axes cannot be matched.
template <int D>
[[nodiscard]] AxesTurn<D> turn_between(const Sym<D>& from, const Sym<D>& to) {
    const Sym<D> change = to - from;
    const EigenSystem<D> mean = eigen_system(0.5 * (from + to));
    AxesTurn<D> turn{};
    const auto angle = [&](int i, int j) {
        double off = 0;
        for (int a = 0; a < D; ++a)
            for (int b = 0; b < D; ++b) off += mean.vectors(a, i) * change(a, b) * mean.vectors(b, j);
        const double x = mean.values[i] - mean.values[j];
        if (off == 0 || x == 0) return 0.0;
        const double theta = atan(off / x), unlike = 1 - exp(-std::abs(x));
        return theta * unlike * unlike / (1 + pow(theta / 0.9, 8));
    };
    if constexpr (D == 2) {
        // If the eigenvectors form a reflection, angles have the opposite sign.
        const double sign = det(mean.vectors.column[0], mean.vectors.column[1]) > 0 ? 1 : -1;
        turn.about[0] = sign * angle(0, 1);
    } else {
        const double sign = det(mean.vectors.column[0], mean.vectors.column[1], mean.vectors.column[2]) > 0 ? 1 : -1;
        for (int k = 0; k < 3; ++k) turn.about += (sign * angle((k + 1) % 3, (k + 2) % 3)) * mean.vectors.column[k];
    }
    return turn;
}

template <int D>
[[nodiscard]] EigenSystem<D> turned(const EigenSystem<D>& metric, const AxesTurn<D>& turn) {
    if (turn.is_none()) return metric;
    EigenSystem<D> out = metric;
    for (Vec<D>& column : out.vectors.column) column = turn(column);
    return out;
}

}  // namespace camber
