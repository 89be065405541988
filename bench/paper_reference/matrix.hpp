// Vectors and symmetric matrices of the reference implementation of the paper, and products of functions of one matrix
// with their derivatives. All data is on the stack.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace paper {

struct Vector {
    std::array<double, 3> c{};

    [[nodiscard]] constexpr double operator[](std::size_t i) const { return c[i]; }
    [[nodiscard]] constexpr double& operator[](std::size_t i) { return c[i]; }
};

[[nodiscard]] inline Vector operator+(const Vector& a, const Vector& b) {
    return {{a[0] + b[0], a[1] + b[1], a[2] + b[2]}};
}
[[nodiscard]] inline Vector operator-(const Vector& a, const Vector& b) {
    return {{a[0] - b[0], a[1] - b[1], a[2] - b[2]}};
}
[[nodiscard]] inline Vector operator*(double s, const Vector& a) { return {{s * a[0], s * a[1], s * a[2]}}; }
[[nodiscard]] inline double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
[[nodiscard]] inline Vector cross(const Vector& a, const Vector& b) {
    return {{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}};
}

/// xx, xy, yy, xz, yz, zz.
struct Symmetric {
    std::array<double, 6> c{};

    [[nodiscard]] static constexpr std::size_t index(std::size_t i, std::size_t j) {
        return i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i;
    }
    [[nodiscard]] constexpr double operator()(std::size_t i, std::size_t j) const { return c[index(i, j)]; }
    [[nodiscard]] constexpr double& operator()(std::size_t i, std::size_t j) { return c[index(i, j)]; }
};

[[nodiscard]] inline Symmetric operator*(double s, const Symmetric& a) {
    Symmetric r;
    for (std::size_t i = 0; i < 6; ++i) r.c[i] = s * a.c[i];
    return r;
}
/// a += s b.
inline void add(Symmetric& a, double s, const Symmetric& b) {
    for (std::size_t i = 0; i < 6; ++i) a.c[i] += s * b.c[i];
}
inline void add_to_diagonal(Symmetric& a, double s) {
    a.c[0] += s;
    a.c[2] += s;
    a.c[5] += s;
}
[[nodiscard]] inline double trace(const Symmetric& a) { return a.c[0] + a.c[2] + a.c[5]; }
/// Returns the Frobenius norm, an upper bound of the spectral norm.
[[nodiscard]] inline double norm(const Symmetric& a) {
    const auto& c = a.c;
    return std::sqrt(c[0] * c[0] + c[2] * c[2] + c[5] * c[5] + 2 * (c[1] * c[1] + c[3] * c[3] + c[4] * c[4]));
}
[[nodiscard]] inline Vector operator*(const Symmetric& a, const Vector& v) {
    const auto& c = a.c;
    return {{c[0] * v[0] + c[1] * v[1] + c[3] * v[2], c[1] * v[0] + c[2] * v[1] + c[4] * v[2],
             c[3] * v[0] + c[4] * v[1] + c[5] * v[2]}};
}
/// Returns vᵀ A v.
[[nodiscard]] inline double quadratic_form(const Symmetric& a, const Vector& v) { return dot(v, a * v); }

/// A matrix and its derivatives in N directions (N = 0: the value only, N = 3: by the position).
template <std::size_t N>
struct Jet {
    Symmetric value;
    std::array<Symmetric, N> slope{};
};

template <std::size_t N>
inline void scale(Jet<N>& a, double s) {
    a.value = s * a.value;
    for (Symmetric& d : a.slope) d = s * d;
}
/// a += s b.
template <std::size_t N>
inline void add(Jet<N>& a, double s, const Jet<N>& b) {
    add(a.value, s, b.value);
    for (std::size_t n = 0; n < N; ++n) add(a.slope[n], s, b.slope[n]);
}

/// Returns A B and ∂(A B) = (∂A) B + A (∂B) for functions A and B of one symmetric matrix. A and B commute, so A B and
/// its derivatives are symmetric, although the two terms are not.
template <std::size_t N>
[[nodiscard]] inline Jet<N> product(const Jet<N>& a, const Jet<N>& b) {
    Jet<N> r;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j <= i; ++j) {
            double sum = 0;
            for (std::size_t k = 0; k < 3; ++k) sum += a.value(i, k) * b.value(k, j);
            r.value(i, j) = sum;
        }
    for (std::size_t n = 0; n < N; ++n)
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j <= i; ++j) {
                double sum = 0;
                for (std::size_t k = 0; k < 3; ++k)
                    sum += a.slope[n](i, k) * b.value(k, j) + a.value(i, k) * b.slope[n](k, j);
                r.slope[n](i, j) = sum;
            }
    return r;
}

}  // namespace paper
