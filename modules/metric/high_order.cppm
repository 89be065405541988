module;
#include <array>
#include <cstddef>
export module camber.metric:high_order;
import camber.core;
import camber.bezier;
import :spd;

/// High-order log-Euclidean interpolation on a K-simplex of degree N (paper §2.1), for any N and K. Its three forms:
///   (2) pure Bézier             exp Σ B_α(ξ) log M(P_α)      BezierLogs of the metrics at the control points
///   (3) pure Lagrange           exp Σ φ_α(ξ) log M(P_α^l)    LagrangeLogs
///   (4) Bézier-refactored (3)   exp Σ B_α(ξ) log M_α         virtual_logs(LagrangeLogs), the default
/// (3) and (4) are one field. (2) is another: control points lie off the element, so it sees metrics from elsewhere.
/// The Lagrange functions go negative, so (3) and (4) are affine means, not convex ones: det M lies between those of
/// the *virtual* metrics and may overshoot those at the nodes (log-dets 0, 1, 1 along a P2 edge reach 1.125).
export namespace camber {

/// Log-metrics that Bernstein polynomials weigh, in the order of multi_indices<N, K>: those at the control points for
/// (2), the virtual ones for (4).
template <int N, int K, int D>
struct BezierLogs {
    std::array<LogMetric<D>, node_count<N, K>> logs{};
    friend bool operator==(const BezierLogs&, const BezierLogs&) = default;
};

/// Log-metrics at the Lagrange nodes F(α/N), which lie on the element, in the order of multi_indices<N, K>.
template <int N, int K, int D>
struct LagrangeLogs {
    std::array<LogMetric<D>, node_count<N, K>> logs{};
    friend bool operator==(const LagrangeLogs&, const LagrangeLogs&) = default;
};

/// The virtual log-metrics log M_α of (4): the Lagrange-to-Bézier transformation applied to the log-metrics.
template <int N, int K, int D>
[[nodiscard]] inline BezierLogs<N, K, D> virtual_logs(const LagrangeLogs<N, K, D>& nodes) {
    BezierLogs<N, K, D> out;
    const auto& matrix = lagrange_to_bezier<N, K>;
    for (std::size_t r = 0; r < out.logs.size(); ++r)
        for (std::size_t c = 0; c < out.logs.size(); ++c)
            if (matrix[r][c] != 0) out.logs[r].l += matrix[r][c] * nodes.logs[c].l;
    return out;
}

/// log M(ξ) of (2) or (4).
template <int N, int K, int D>
[[nodiscard]] inline LogMetric<D> interpolated(const BezierLogs<N, K, D>& field, const Barycentric<K>& xi) {
    LogMetric<D> out;
    for (std::size_t a = 0; a < field.logs.size(); ++a)
        out.l += bernstein<K>(multi_indices<N, K>[a], xi) * field.logs[a].l;
    return out;
}

/// log M(ξ) of (3).
template <int N, int K, int D>
[[nodiscard]] inline LogMetric<D> interpolated(const LagrangeLogs<N, K, D>& nodes, const Barycentric<K>& xi) {
    LogMetric<D> out;
    for (std::size_t a = 0; a < nodes.logs.size(); ++a)
        out.l += lagrange<K>(multi_indices<N, K>[a], xi) * nodes.logs[a].l;
    return out;
}

/// ∂ log M/∂ξ_i for i = 1 … K, with ξ_0 = 1 − Σ ξ_i: N Σ_{β ∈ I_{N−1}} B_β (log M_{β+e_i} − log M_{β+e_0}).
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

/// ∂M/∂ξ_i = D exp(log M)[∂ log M/∂ξ_i] (Daletskii–Krein). The paper's exp(Q) ∂Q holds only where Q and ∂Q commute.
template <class Field>
[[nodiscard]] inline auto metric_gradient(const Field& field, const auto& xi) {
    auto gradient = log_gradient(field, xi);
    const SpectralMetric spectral(interpolated(field, xi));
    for (auto& direction : gradient) direction = exp_derivative(spectral, direction);
    return gradient;
}

}  // namespace camber
