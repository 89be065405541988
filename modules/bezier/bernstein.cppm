module;
#include <array>
#include <cstddef>
export module camber.bezier:bernstein;
import camber.core;

export namespace camber {

/// α: K + 1 non-negative integers; its sum is the degree (paper §1.4).
template <int K>
using MultiIndex = std::array<int, K + 1>;

/// Barycentric coordinates on the reference K-simplex.
template <int K>
using Barycentric = std::array<double, K + 1>;

/// n over k; 0 outside 0 ≤ k ≤ n.
[[nodiscard]] constexpr int binomial(int n, int k) {
    int b = 1;
    for (int i = 1; i <= k; ++i) b = b * (n - k + i) / i;
    return b;
}

/// |I_N^K| = (N + K choose K): nodes of a K-simplex of degree N.
template <int N, int K>
inline constexpr int node_count = binomial(N + K, K);

/// I_N^K in reverse lexicographic order: (N,0,…) first, (…,0,N) last.
template <int N, int K>
inline constexpr std::array<MultiIndex<K>, node_count<N, K>> multi_indices = [] {
    std::array<MultiIndex<K>, node_count<N, K>> all{};
    MultiIndex<K> alpha{};
    alpha[0] = N;
    for (auto& slot : all) {
        slot = alpha;
        // The successor: take one from the last non-zero entry before the end, give it and the tail to the next entry.
        int i = K - 1;
        while (i >= 0 && alpha[i] == 0) --i;
        if (i < 0) break;
        const int tail = alpha[K];
        alpha[K] = 0;
        --alpha[i];
        alpha[i + 1] = tail + 1;
    }
    return all;
}();

/// Position of α in multi_indices<N, K>; −1 if it is not there.
template <int N, int K>
[[nodiscard]] constexpr int position(const MultiIndex<K>& alpha) {
    for (int i = 0; i < node_count<N, K>; ++i)
        if (multi_indices<N, K>[i] == alpha) return i;
    return -1;
}

/// n! / ∏ α_i!, with n the sum of α.
template <int K>
[[nodiscard]] constexpr double multinomial(const MultiIndex<K>& alpha) {
    int sum = 0;
    double m = 1;
    for (const int a : alpha) {
        sum += a;
        m *= binomial(sum, a);
    }
    return m;
}

/// x^n for n ≥ 0.
[[nodiscard]] constexpr double power(double x, int n) {
    double p = 1;
    for (int i = 0; i < n; ++i) p *= x;
    return p;
}

/// B_α^n(ξ) = n!/∏α_i! ∏ξ_i^{α_i} (paper §1.4).
template <int K>
[[nodiscard]] constexpr double bernstein(const MultiIndex<K>& alpha, const Barycentric<K>& xi) {
    double b = multinomial<K>(alpha);
    for (int i = 0; i <= K; ++i) b *= power(xi[i], alpha[i]);
    return b;
}

/// φ_α^n(ξ) = ∏_i ∏_{m < α_i} (n ξ_i − m)/(m + 1): the Lagrange basis on the regular lattice α/n.
template <int K>
[[nodiscard]] constexpr double lagrange(const MultiIndex<K>& alpha, const Barycentric<K>& xi) {
    int n = 0;
    for (const int a : alpha) n += a;
    double value = 1;
    for (int i = 0; i <= K; ++i)
        for (int m = 0; m < alpha[i]; ++m) value *= (n * xi[i] - m) / (m + 1);
    return value;
}

/// An N × N matrix by its rows.
template <std::size_t N>
using SquareMatrix = std::array<std::array<double, N>, N>;

/// Bézier → Lagrange: row β holds B_α^N(β/N).
template <int N, int K>
inline constexpr auto bezier_to_lagrange = [] {
    SquareMatrix<node_count<N, K>> m{};
    for (int r = 0; r < node_count<N, K>; ++r) {
        Barycentric<K> xi{};
        for (int i = 0; i <= K; ++i) xi[i] = static_cast<double>(multi_indices<N, K>[r][i]) / N;
        for (int c = 0; c < node_count<N, K>; ++c) m[r][c] = bernstein<K>(multi_indices<N, K>[c], xi);
    }
    return m;
}();

/// Gauss–Jordan with partial pivoting.
template <std::size_t N>
[[nodiscard]] constexpr SquareMatrix<N> inverted(SquareMatrix<N> a) {
    SquareMatrix<N> inverse{};
    for (std::size_t i = 0; i < N; ++i) inverse[i][i] = 1;
    const auto magnitude = [](double x) { return x < 0 ? -x : x; };
    for (std::size_t p = 0; p < N; ++p) {
        std::size_t pivot = p;
        for (std::size_t r = p + 1; r < N; ++r)
            if (magnitude(a[r][p]) > magnitude(a[pivot][p])) pivot = r;
        const auto swapped_a = a[p];
        a[p] = a[pivot];
        a[pivot] = swapped_a;
        const auto swapped_inverse = inverse[p];
        inverse[p] = inverse[pivot];
        inverse[pivot] = swapped_inverse;
        const double scale = 1 / a[p][p];
        for (std::size_t c = 0; c < N; ++c) {
            a[p][c] *= scale;
            inverse[p][c] *= scale;
        }
        for (std::size_t r = 0; r < N; ++r) {
            if (r == p) continue;
            const double factor = a[r][p];
            for (std::size_t c = 0; c < N; ++c) {
                a[r][c] -= factor * a[p][c];
                inverse[r][c] -= factor * inverse[p][c];
            }
        }
    }
    return inverse;
}

/// Lagrange → Bézier (paper §1.4), for values and for log-metrics alike.
template <int N, int K>
inline const SquareMatrix<node_count<N, K>> lagrange_to_bezier = inverted(bezier_to_lagrange<N, K>);

/// Applies a basis change to values of any linear type.
template <std::size_t N, class T>
[[nodiscard]] constexpr std::array<T, N> transformed(const std::array<std::array<double, N>, N>& matrix,
                                                     const std::array<T, N>& values) {
    std::array<T, N> out{};
    for (std::size_t r = 0; r < N; ++r)
        for (std::size_t c = 0; c < N; ++c) out[r] = out[r] + values[c] * matrix[r][c];
    return out;
}

}  // namespace camber
