module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
export module camber.metric:packs;
import camber.core;

/// Vectors and matrices of eight items at a time: each entry is a `Pack`, with one lane per item (core:tensors).
namespace camber {

export template <int D>
struct VecPack {
    std::array<Pack, D> c{};
    [[nodiscard, gnu::always_inline]] inline Pack operator[](int i) const { return c[i]; }
    [[nodiscard, gnu::always_inline]] inline Pack& operator[](int i) { return c[i]; }
};

export template <int D>
struct SymPack {
    std::array<Pack, sym_size<D>> c{};
    [[nodiscard, gnu::always_inline]] inline Pack operator()(int i, int j) const { return c[Sym<D>::index(i, j)]; }
    [[nodiscard, gnu::always_inline]] inline Pack& operator()(int i, int j) { return c[Sym<D>::index(i, j)]; }
};

export template <int D>
struct MatPack {
    std::array<VecPack<D>, D> column{};
    [[nodiscard, gnu::always_inline]] inline Pack operator()(int i, int j) const { return column[j][i]; }
    [[nodiscard, gnu::always_inline]] inline Pack& operator()(int i, int j) { return column[j][i]; }
};

/// Returns get(items[begin + lane]) in each lane. Lanes beyond the end of `items` get the last item.
export template <class T, class Get>
[[nodiscard, gnu::always_inline]] inline Pack gathered(std::span<const T> items, std::size_t begin, const Get& get) {
    Pack p{};
    for (std::size_t lane = 0; lane < pack_size; ++lane) p[lane] = get(items[std::min(begin + lane, items.size() - 1)]);
    return p;
}
export template <int D, class T, class Get>
[[nodiscard, gnu::always_inline]] inline VecPack<D> gathered_vec(std::span<const T> items, std::size_t begin,
                                                                 const Get& get) {
    VecPack<D> v;
    for (int i = 0; i < D; ++i)
        v[i] = gathered(items, begin, [&](const T& item) __attribute__((always_inline)) { return get(item)[i]; });
    return v;
}
export template <int D, class T, class Get>
[[nodiscard, gnu::always_inline]] inline SymPack<D> gathered_sym(std::span<const T> items, std::size_t begin,
                                                                 const Get& get) {
    SymPack<D> s;
    for (int i = 0; i < sym_size<D>; ++i)
        s.c[i] = gathered(items, begin, [&](const T& item) __attribute__((always_inline)) { return get(item).c[i]; });
    return s;
}
export template <int D, class T, class Get>
[[nodiscard, gnu::always_inline]] inline MatPack<D> gathered_mat(std::span<const T> items, std::size_t begin,
                                                                 const Get& get) {
    MatPack<D> m;
    for (int j = 0; j < D; ++j)
        m.column[j] = gathered_vec<D>(
            items, begin, [&](const T& item) __attribute__((always_inline)) { return get(item).column[j]; });
    return m;
}

/// Stores each lane as out[begin + lane]; lanes beyond the end of `out` are ignored.
export template <int D>
[[gnu::always_inline]] inline void scatter(const VecPack<D>& v, std::size_t begin, std::span<Vec<D>> out) {
    const std::size_t n = std::min<std::size_t>(pack_size, out.size() - begin);
    for (std::size_t lane = 0; lane < n; ++lane)
        for (int i = 0; i < D; ++i) out[begin + lane][i] = v[i][lane];
}

export template <int D>
[[nodiscard, gnu::always_inline]] inline Pack dot(const VecPack<D>& a, const VecPack<D>& b) {
    Pack s = a[0] * b[0];
    for (int i = 1; i < D; ++i) s += a[i] * b[i];
    return s;
}
/// Returns A v; `times_transposed` returns Aᵀ v.
export template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> times(const MatPack<D>& a, const VecPack<D>& v) {
    VecPack<D> r;
    for (int i = 0; i < D; ++i) {
        r[i] = a(i, 0) * v[0];
        for (int j = 1; j < D; ++j) r[i] += a(i, j) * v[j];
    }
    return r;
}
export template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> times_transposed(const MatPack<D>& a, const VecPack<D>& v) {
    VecPack<D> r;
    for (int i = 0; i < D; ++i) r[i] = dot(a.column[i], v);
    return r;
}
export template <int D>
[[nodiscard, gnu::always_inline]] inline MatPack<D> times(const MatPack<D>& a, const MatPack<D>& b) {
    MatPack<D> r;
    for (int j = 0; j < D; ++j) r.column[j] = times(a, b.column[j]);
    return r;
}
[[nodiscard, gnu::always_inline]] inline Pack det(const MatPack<2>& a) { return a(0, 0) * a(1, 1) - a(1, 0) * a(0, 1); }
[[nodiscard, gnu::always_inline]] inline Pack det(const MatPack<3>& a) {
    return a(0, 0) * (a(1, 1) * a(2, 2) - a(2, 1) * a(1, 2)) + a(1, 0) * (a(2, 1) * a(0, 2) - a(0, 1) * a(2, 2)) +
           a(2, 0) * (a(0, 1) * a(1, 2) - a(1, 1) * a(0, 2));
}
/// Returns Rᵀ S R.
export template <int D>
[[nodiscard, gnu::always_inline]] inline SymPack<D> congruence_transposed(const MatPack<D>& r, const SymPack<D>& s) {
    SymPack<D> out;
    for (int j = 0; j < D; ++j) {
        VecPack<D> column;
        for (int i = 0; i < D; ++i) {
            column[i] = s(i, 0) * r(0, j);
            for (int k = 1; k < D; ++k) column[i] += s(i, k) * r(k, j);
        }
        for (int i = j; i < D; ++i) out(i, j) = dot(r.column[i], column);
    }
    return out;
}
/// Returns R diag(values) Rᵀ.
export template <int D>
[[nodiscard, gnu::always_inline]] inline SymPack<D> composed(const MatPack<D>& r, const VecPack<D>& values) {
    SymPack<D> s;
    for (int j = 0; j < D; ++j) {
        VecPack<D> scaled;
        for (int k = 0; k < D; ++k) scaled[k] = r(j, k) * values[k];
        for (int i = j; i < D; ++i) {
            Pack sum = r(i, 0) * scaled[0];
            for (int k = 1; k < D; ++k) sum += r(i, k) * scaled[k];
            s(i, j) = sum;
        }
    }
    return s;
}

/// Returns the tangent t of a Jacobi rotation: the smaller root of t² + (difference/product) t = 1. Lanes outside
/// `lanes` get 0.
[[nodiscard, gnu::always_inline]] inline Pack rotation_tangent(Pack difference, Pack product, Mask lanes) {
    const Pack twice = 2 * product;
    const Pack denominator = difference + copysign(sqrt(difference * difference + twice * twice), difference);
    return select(lanes & (denominator != 0), twice / denominator, packed(0));
}
export template <int D>
[[gnu::always_inline]] inline void rotate_columns(MatPack<D>& m, int p, int q, Pack c, Pack s) {
    for (int k = 0; k < D; ++k) {
        const Pack mp = m(k, p);
        const Pack mq = m(k, q);
        m(k, p) = c * mp - s * mq;
        m(k, q) = s * mp + c * mq;
    }
}

export template <int D>
struct EigenPack {
    VecPack<D> values;
    MatPack<D> vectors;
};

export template <int D>
[[nodiscard, gnu::always_inline]] inline MatPack<D> identity_pack() {
    MatPack<D> m;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) m(i, j) = packed(i == j ? 1 : 0);
    return m;
}

export template <int D>
[[nodiscard, gnu::always_inline]] inline EigenPack<D> eigen_system(SymPack<D> a) {
    MatPack<D> r = identity_pack<D>();
    constexpr int sweeps = D == 2 ? 1 : 12;
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        Pack off = packed(0);
        Pack all = packed(0);
        for (int i = 0; i < D; ++i) {
            all += a(i, i) * a(i, i);
            for (int j = 0; j < i; ++j) off += a(i, j) * a(i, j);
        }
        // Convergence is quadratic: off-diagonal entries below 1e-17 |A| are rounding errors.
        const Mask lanes = off > 1e-34 * all;
        if (!any(lanes)) break;
        for (int p = 0; p < D - 1; ++p)
            for (int q = p + 1; q < D; ++q) {
                const Pack apq = a(p, q);
                const Pack t = rotation_tangent(a(q, q) - a(p, p), apq, lanes);
                const Pack c = 1 / sqrt(t * t + 1);
                const Pack s = t * c;
                a(p, p) -= t * apq;
                a(q, q) += t * apq;
                a(p, q) = select(lanes, packed(0), apq);
                for (int k = 0; k < D; ++k) {
                    if (k == p || k == q) continue;
                    const Pack akp = a(k, p);
                    const Pack akq = a(k, q);
                    a(k, p) = c * akp - s * akq;
                    a(k, q) = s * akp + c * akq;
                }
                rotate_columns(r, p, q, c, s);
            }
    }
    EigenPack<D> out{{}, r};
    for (int i = 0; i < D; ++i) out.values[i] = a(i, i);
    return out;
}

/// Singular value decomposition of A: `vectors` are the right singular vectors V, `columns` is A V, and the lengths of
/// its columns are the singular values. One-sided Jacobi rotations (Hestenes) keep small values accurate.
template <int D>
struct RightSingularPack {
    MatPack<D> columns;
    MatPack<D> vectors;
};
/// On entry, `out.vectors` must be an orthogonal matrix V₀, and `out.columns` must be A V₀.
template <int D>
[[nodiscard, gnu::always_inline]] inline RightSingularPack<D> right_singular_from(RightSingularPack<D> out) {
    MatPack<D>& w = out.columns;
    for (int sweep = 0; sweep < 30; ++sweep) {
        Mask rotated{};
        for (int p = 0; p < D - 1; ++p)
            for (int q = p + 1; q < D; ++q) {
                const Pack alpha = dot(w.column[p], w.column[p]);
                const Pack beta = dot(w.column[q], w.column[q]);
                const Pack gamma = dot(w.column[p], w.column[q]);
                // The relative scalar product of two columns cannot fall below a few ulps, so a lower threshold would
                // never be reached.
                const Mask lanes = abs(gamma) > 1e-15 * sqrt(alpha * beta);
                rotated |= lanes;
                if (!any(lanes)) continue;
                const Pack t = rotation_tangent(beta - alpha, gamma, lanes);
                const Pack c = 1 / sqrt(t * t + 1);
                const Pack s = t * c;
                rotate_columns(w, p, q, c, s);
                rotate_columns(out.vectors, p, q, c, s);
            }
        if (!any(rotated)) break;
    }
    return out;
}
template <int D>
[[nodiscard, gnu::always_inline]] inline RightSingularPack<D> right_singular(const MatPack<D>& a) {
    return right_singular_from<D>({a, identity_pack<D>()});
}

/// Returns Bᵀ, for B = J J_ref⁻¹ of `natural_log_metric`; `reference` is J_ref⁻¹. The right singular vectors of Bᵀ are
/// the left ones of B.
template <int D>
[[nodiscard, gnu::always_inline]] inline MatPack<D> natural_frame(const std::array<VecPack<D>, D + 1>& p,
                                                                  const Mat<D>& reference) {
    MatPack<D> transposed;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) {
            transposed(j, i) = packed(0);
            for (int k = 0; k < D; ++k) transposed(j, i) += (p[k + 1][i] - p[0][i]) * reference(k, j);
        }
    return transposed;
}
template <int D>
[[nodiscard, gnu::always_inline]] inline SymPack<D> natural_log_metric(const RightSingularPack<D>& s) {
    VecPack<D> logs;
    for (int i = 0; i < D; ++i) logs[i] = -log(dot(s.columns.column[i], s.columns.column[i]));
    return composed(s.vectors, logs);
}

export template <int D>
struct PulledBackPack {
    SymPack<D> log_metric;
    MatPack<D> axes;
};
/// Returns log M̂ of M̂ = FᵀMF, for the Jacobian F. With M = R Λ Rᵀ, the function decomposes Λ^{1/2} Rᵀ F = V Σ Uᵀ,
/// which is accurate for needles. Then M̂ = U Σ² Uᵀ, and `axes` is R V Uᵀ. If F is singular, the function returns log M
/// and the identity.
export template <int D>
[[nodiscard, gnu::always_inline]] inline PulledBackPack<D> pull_back_pack(const SymPack<D>& log_metric,
                                                                          const EigenPack<D>& metric,
                                                                          const MatPack<D>& jacobian) {
    MatPack<D> factor;
    for (int i = 0; i < D; ++i) {
        const Pack root = exp(metric.values[i] / 2);
        for (int j = 0; j < D; ++j) factor(i, j) = root * dot(metric.vectors.column[i], jacobian.column[j]);
    }
    const RightSingularPack<D> s = right_singular<D>(factor);
    VecPack<D> logs;
    MatPack<D> turned;
    Pack sum = packed(0);
    for (int i = 0; i < D; ++i) {
        const Pack square = dot(s.columns.column[i], s.columns.column[i]);
        logs[i] = log(square);
        sum += logs[i];
        turned.column[i] = times(metric.vectors, s.columns.column[i]);
        const Pack scale = 1 / sqrt(square);
        for (int k = 0; k < D; ++k) turned(k, i) *= scale;
    }
    const Mask lanes = abs(sum) < 1e300;
    PulledBackPack<D> pulled_back{composed(s.vectors, logs), {}};
    for (int k = 0; k < sym_size<D>; ++k)
        pulled_back.log_metric.c[k] = select(lanes, pulled_back.log_metric.c[k], log_metric.c[k]);
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) {
            Pack axis = turned(i, 0) * s.vectors(j, 0);
            for (int k = 1; k < D; ++k) axis += turned(i, k) * s.vectors(j, k);
            pulled_back.axes(i, j) = select(lanes, axis, packed(i == j ? 1 : 0));
        }
    return pulled_back;
}
export template <int D>
[[nodiscard, gnu::always_inline]] inline PulledBackPack<D> pull_back_pack(const SymPack<D>& log_metric,
                                                                          const MatPack<D>& jacobian) {
    return pull_back_pack<D>(log_metric, eigen_system<D>(log_metric), jacobian);
}

}  // namespace camber
