module;
#include <algorithm>
export module camber.metric:intersection;
import camber.core;
import :eigen;
import :spd;

export namespace camber {

/// The intersection of two metrics by simultaneous reduction: the metric of the largest sizes that asks for at least
/// what both ask for, vᵀMv ≥ vᵀM_i v for every v, exact along the axes that both share.
///
/// Entries of M_1⁻¹ M_2 cancel at high anisotropy, so the reduction goes by factors. With M_i = R_i Λ_i R_iᵀ,
///     C = Λ_2^{1/2} R_2ᵀ R_1 Λ_1^{-1/2} = U Σ Vᵀ,   M = FᵀF,   F = max(1, Σ) Vᵀ Λ_1^{1/2} R_1ᵀ,
/// and log M = 2 log of the singular values of F. Where one metric asks for more everywhere, it is the result, to the
/// last bit. Conditioning: metrics of anisotropy a that are turned by δ against one another intersect to sizes smaller
/// by a share of a δ, so the result is known to a few a ε (1e-9 at anisotropy 1e6).
template <int D>
[[nodiscard]] inline EigenSystem<D> intersection(const EigenSystem<D>& a, const EigenSystem<D>& b) {
    // Cᵀ = Λ_1^{-1/2} R_1ᵀ R_2 Λ_2^{1/2}, whose left singular vectors are V.
    Mat<D> c;
    for (int j = 0; j < D; ++j)
        for (int i = 0; i < D; ++i)
            c(i, j) = exp((b.values[j] - a.values[i]) / 2) * dot(a.vectors.column[i], b.vectors.column[j]);
    const EigenSystem<D> s = left_singular(c);
    const auto [low, high] = std::minmax_element(s.values.c.begin(), s.values.c.end());
    if (*high <= 1) return a;
    if (*low >= 1) return b;
    // Fᵀ = R_1 Λ_1^{1/2} V max(1, Σ).
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

/// By how much `inner` asks for less than `outer` somewhere: the largest ½ log of vᵀM_outer v/vᵀM_inner v, so at most 0
/// where inner contains all that outer asks for, and log 2 where an edge should be half as long.
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

}  // namespace camber
