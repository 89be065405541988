module;
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
export module camber.core:cubic_form;
import :sym;
import :vec;

export namespace camber {

/// Number of independent entries of a symmetric tensor of third order in D dimensions.
template <int D>
inline constexpr int cubic_size = D * (D + 1) * (D + 2) / 6;

/// A symmetric tensor of third order, as third derivatives are: its entries ijk with i ≥ j ≥ k, the last fastest:
/// xxx, yxx, yyx, yyy, zxx, zyx, zyy, zzx, zzy, zzz.
template <int D>
struct CubicForm {
    std::array<double, cubic_size<D>> c{};

    [[nodiscard]] static constexpr int index(int i, int j, int k) {
        if (i < j) std::swap(i, j);
        if (j < k) std::swap(j, k);
        if (i < j) std::swap(i, j);
        return i * (i + 1) * (i + 2) / 6 + j * (j + 1) / 2 + k;
    }
    [[nodiscard]] constexpr double operator()(int i, int j, int k) const { return c[index(i, j, k)]; }
    [[nodiscard]] constexpr double& operator()(int i, int j, int k) { return c[index(i, j, k)]; }
    friend constexpr bool operator==(const CubicForm&, const CubicForm&) = default;

    constexpr CubicForm& operator+=(const CubicForm& o) {
        for (int i = 0; i < cubic_size<D>; ++i) c[i] += o.c[i];
        return *this;
    }
    constexpr CubicForm& operator*=(double s) {
        for (double& x : c) x *= s;
        return *this;
    }
};

template <int D>
[[nodiscard]] constexpr CubicForm<D> operator+(CubicForm<D> a, const CubicForm<D>& b) {
    return a += b;
}
template <int D>
[[nodiscard]] constexpr CubicForm<D> operator*(double s, CubicForm<D> a) {
    return a *= s;
}

/// T[v, ·, ·].
template <int D>
[[nodiscard]] constexpr Sym<D> contracted(const CubicForm<D>& t, const Vec<D>& v) {
    Sym<D> s;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j)
            for (int k = 0; k < D; ++k) s(i, j) += t(i, j, k) * v[k];
    return s;
}
/// T[a, b, c] = Σ_ijk T_ijk a_i b_j c_k.
template <int D>
[[nodiscard]] constexpr double trilinear(const CubicForm<D>& t, const Vec<D>& a, const Vec<D>& b, const Vec<D>& c) {
    return dot(a, contracted(t, c) * b);
}
/// T[A·, A·, A·]: the form in coordinates y with x = A y.
template <int D>
[[nodiscard]] constexpr CubicForm<D> pulled_back(const CubicForm<D>& t, const Mat<D>& a) {
    CubicForm<D> r;
    for (int k = 0; k < D; ++k) {
        const Sym<D> along = congruence(transposed(a), contracted(t, a.column[k]));
        for (int i = k; i < D; ++i)
            for (int j = k; j <= i; ++j) r(i, j, k) = along(i, j);
    }
    return r;
}
/// sqrt(Σ_ijk T_ijk²).
template <int D>
[[nodiscard]] inline double norm(const CubicForm<D>& t) {
    double sum = 0;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j)
            for (int k = 0; k < D; ++k) sum += t(i, j, k) * t(i, j, k);
    return std::sqrt(sum);
}

}  // namespace camber
