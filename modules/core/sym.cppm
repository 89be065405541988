module;
#include <array>
#include <cmath>
#include <cstddef>
export module camber.core:sym;
import :vec;

export namespace camber {

/// Number of independent entries of a symmetric D × D matrix.
template <int D>
inline constexpr int sym_size = D * (D + 1) / 2;

/// A symmetric D × D matrix by its lower triangle, row after row: xx, xy, yy, xz, yz, zz
/// (the order of GMF solution files).
template <int D>
struct Sym {
    std::array<double, sym_size<D>> c{};

    [[nodiscard]] static constexpr int index(int i, int j) {
        return i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i;
    }
    [[nodiscard]] static constexpr Sym identity() {
        Sym s;
        for (int i = 0; i < D; ++i) s(i, i) = 1;
        return s;
    }
    [[nodiscard]] static constexpr Sym diagonal(const Vec<D>& d) {
        Sym s;
        for (int i = 0; i < D; ++i) s(i, i) = d[i];
        return s;
    }
    [[nodiscard]] constexpr double operator()(int i, int j) const { return c[index(i, j)]; }
    [[nodiscard]] constexpr double& operator()(int i, int j) { return c[index(i, j)]; }
    friend constexpr bool operator==(const Sym&, const Sym&) = default;

    constexpr Sym& operator+=(const Sym& o) {
        for (int i = 0; i < sym_size<D>; ++i) c[i] += o.c[i];
        return *this;
    }
    constexpr Sym& operator-=(const Sym& o) {
        for (int i = 0; i < sym_size<D>; ++i) c[i] -= o.c[i];
        return *this;
    }
    constexpr Sym& operator*=(double s) {
        for (double& x : c) x *= s;
        return *this;
    }
};

template <int D>
[[nodiscard]] constexpr Sym<D> operator+(Sym<D> a, const Sym<D>& b) {
    return a += b;
}
template <int D>
[[nodiscard]] constexpr Sym<D> operator-(Sym<D> a, const Sym<D>& b) {
    return a -= b;
}
template <int D>
[[nodiscard]] constexpr Sym<D> operator*(Sym<D> a, double s) {
    return a *= s;
}
template <int D>
[[nodiscard]] constexpr Sym<D> operator*(double s, Sym<D> a) {
    return a *= s;
}
template <int D>
[[nodiscard]] constexpr Vec<D> operator*(const Sym<D>& a, const Vec<D>& v) {
    Vec<D> r;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) r[i] += a(i, j) * v[j];
    return r;
}
/// ⟨A, B⟩ = Σ_ij A_ij B_ij.
template <int D>
[[nodiscard]] constexpr double inner(const Sym<D>& a, const Sym<D>& b) {
    double s = 0;
    for (int i = 0; i < D; ++i) {
        for (int j = 0; j < i; ++j) s += 2 * a(i, j) * b(i, j);
        s += a(i, i) * b(i, i);
    }
    return s;
}
/// Frobenius norm sqrt⟨A, A⟩.
template <int D>
[[nodiscard]] inline double norm(const Sym<D>& a) {
    return std::sqrt(inner(a, a));
}
/// Σ A_ii.
template <int D>
[[nodiscard]] constexpr double trace(const Sym<D>& a) {
    double s = 0;
    for (int i = 0; i < D; ++i) s += a(i, i);
    return s;
}

/// A D × D matrix by its columns.
template <int D>
struct Mat {
    std::array<Vec<D>, D> column{};

    [[nodiscard]] static constexpr Mat identity() {
        Mat m;
        for (int i = 0; i < D; ++i) m(i, i) = 1;
        return m;
    }
    [[nodiscard]] constexpr double operator()(int i, int j) const { return column[j][i]; }
    [[nodiscard]] constexpr double& operator()(int i, int j) { return column[j][i]; }
    friend constexpr bool operator==(const Mat&, const Mat&) = default;
};

template <int D>
[[nodiscard]] constexpr Vec<D> operator*(const Mat<D>& a, const Vec<D>& v) {
    Vec<D> r;
    for (int j = 0; j < D; ++j) r += a.column[j] * v[j];
    return r;
}
template <int D>
[[nodiscard]] constexpr Mat<D> operator*(const Mat<D>& a, const Mat<D>& b) {
    Mat<D> r;
    for (int j = 0; j < D; ++j) r.column[j] = a * b.column[j];
    return r;
}
/// Aᵀ.
template <int D>
[[nodiscard]] constexpr Mat<D> transposed(const Mat<D>& a) {
    Mat<D> r;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) r(i, j) = a(j, i);
    return r;
}
/// aᵀ v, without forming the transpose.
template <int D>
[[nodiscard]] constexpr Vec<D> transposed_times(const Mat<D>& a, const Vec<D>& v) {
    Vec<D> r;
    for (int j = 0; j < D; ++j) r[j] = dot(a.column[j], v);
    return r;
}
/// Determinant of the columns.
template <int D>
[[nodiscard]] constexpr double det(const Mat<D>& a) {
    if constexpr (D == 2)
        return det(a.column[0], a.column[1]);
    else
        return det(a.column[0], a.column[1], a.column[2]);
}
/// Rows of a⁻¹ times det a (the comatrix's columns): well defined for singular matrices too.
template <int D>
[[nodiscard]] constexpr std::array<Vec<D>, D> cofactors(const Mat<D>& a) {
    if constexpr (D == 2)
        return {Vec<2>{{a(1, 1), -a(0, 1)}}, Vec<2>{{-a(1, 0), a(0, 0)}}};
    else
        return {cross(a.column[1], a.column[2]), cross(a.column[2], a.column[0]), cross(a.column[0], a.column[1])};
}
/// a⁻¹; entries are infinite or NaN when a is singular.
template <int D>
[[nodiscard]] constexpr Mat<D> inverse(const Mat<D>& a) {
    const auto rows = cofactors(a);
    const double scale = 1.0 / dot(rows[0], a.column[0]);
    Mat<D> r;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) r(i, j) = rows[i][j] * scale;
    return r;
}
/// R S Rᵀ.
template <int D>
[[nodiscard]] constexpr Sym<D> congruence(const Mat<D>& r, const Sym<D>& s) {
    Sym<D> out;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j) {
            double sum = 0;
            for (int k = 0; k < D; ++k)
                for (int l = 0; l < D; ++l) sum += r(i, k) * s(k, l) * r(j, l);
            out(i, j) = sum;
        }
    return out;
}

}  // namespace camber
