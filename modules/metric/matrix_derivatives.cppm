module;
#include <cmath>
export module camber.metric:matrix_derivatives;
import camber.core;
import :spd;

export namespace camber {

/// Derivatives of exp and log (Daletskii–Krein) in the frame of M's eigenvectors, where they act entry by entry:
/// (Rᵀ D exp(L)[E] R)_ij = Φ_ij (Rᵀ E R)_ij with Φ_ij = (e^{λ_i} − e^{λ_j})/(λ_i − λ_j), and D log divides by Φ_ij.
/// Entries of ∂M in other frames hold fewer digits than those of ∂ log M (the small ones drown in λ_max), so at high
/// anisotropy stay in this frame; `exp_derivative` and `log_derivative` are the same in the coordinates' frame.
template <int D>
[[nodiscard]] inline Sym<D> exp_derivative_in_frame(const SpectralMetric<D>& s, Sym<D> direction) {
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j)
            direction(i, j) *= exp_divided_difference(s.log_values[i], s.log_values[j], s.values[i], s.values[j]);
    return direction;
}

/// (log a − log b)/(a − b) = 1/Φ(log a, log b): well defined and accurate at equal eigenvalues too.
template <int D>
[[nodiscard]] inline Sym<D> log_derivative_in_frame(const SpectralMetric<D>& s, Sym<D> direction) {
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j)
            direction(i, j) /= exp_divided_difference(s.log_values[i], s.log_values[j], s.values[i], s.values[j]);
    return direction;
}

/// D log(M)[E] = R ((Rᵀ E R) / Φ) Rᵀ: how log M changes when M moves by E; the inverse of exp_derivative. `s` is M
/// decomposed. Its error is that of E's entries: ε |E|/λ_min in the block of the small eigenvalues.
template <int D>
[[nodiscard]] inline Sym<D> log_derivative(const SpectralMetric<D>& s, const Sym<D>& direction) {
    return congruence(s.vectors, log_derivative_in_frame(s, congruence(transposed(s.vectors), direction)));
}

/// From the entries of M; for metrics of anisotropy up to about 1e7.
template <int D>
[[nodiscard]] inline Sym<D> log_derivative(const Metric<D>& metric, const Sym<D>& direction) {
    return log_derivative(SpectralMetric<D>(log(metric)), direction);
}

}  // namespace camber
