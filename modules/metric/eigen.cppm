module;
#include <cmath>
#include <cstddef>
#include <utility>
export module camber.metric:eigen;
import camber.core;

export namespace camber {

/// A = R diag(values) Rᵀ; the columns of R are orthonormal eigenvectors. Values are in no particular order.
template <int D>
struct EigenSystem {
    Vec<D> values;
    Mat<D> vectors;
};

/// One Jacobi rotation of rows and columns p, q that zeroes a(p, q); R takes the rotation's columns.
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

/// Eigenvalues and eigenvectors of a symmetric matrix by cyclic Jacobi rotations: unlike closed forms it keeps its
/// digits at near-equal eigenvalues. Backward error a few ulps of |A|.
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
        // Convergence is quadratic: below 1e-17 |A| the rest is rounding.
        if (off <= 1e-34 * all) break;
        for (int p = 0; p < D - 1; ++p)
            for (int q = p + 1; q < D; ++q) jacobi_rotate(a, r, p, q);
    }
    EigenSystem<D> out{.values = {}, .vectors = r};
    for (int i = 0; i < D; ++i) out.values[i] = a(i, i);
    return out;
}

/// R diag(values) Rᵀ.
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

/// The left singular vectors U and singular values of A = U Σ Vᵀ by one-sided Jacobi rotations (Hestenes): small
/// singular values keep their relative digits, which eigenvalues of A Aᵀ would lose.
template <int D>
[[nodiscard]] inline EigenSystem<D> left_singular(const Mat<D>& a) {
    // Orthogonalise the rows of A, that is the columns of Aᵀ: Aᵀ U = V Σ.
    Mat<D> w = transposed(a);
    Mat<D> u = Mat<D>::identity();
    for (int sweep = 0; sweep < 30; ++sweep) {
        bool rotated = false;
        for (int p = 0; p < D - 1; ++p)
            for (int q = p + 1; q < D; ++q) {
                const double alpha = norm_squared(w.column[p]);
                const double beta = norm_squared(w.column[q]);
                const double gamma = dot(w.column[p], w.column[q]);
                // The product of orthogonal columns is known to a few ulps of theirs: less would never be reached.
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

}  // namespace camber
