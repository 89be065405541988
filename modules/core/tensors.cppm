module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
// CAMBER_BASELINE_INSTRUCTIONS builds baseline kernels only, because sanitizer builds take minutes for each copy of a
// large kernel.
#if defined(__x86_64__) && !defined(CAMBER_BASELINE_INSTRUCTIONS)
#define CAMBER_WIDER_INSTRUCTIONS
#endif
/// Vectors, tensors, cubic forms, elementary functions and packs of numbers.
export module camber.core:tensors;

export namespace camber {

/// A point or vector (model units), with component-wise operators.
template <int D>
struct Vec {
    std::array<double, D> c{};

    [[nodiscard]] constexpr double operator[](std::size_t i) const { return c[i]; }
    [[nodiscard]] constexpr double& operator[](std::size_t i) { return c[i]; }
    friend constexpr bool operator==(const Vec&, const Vec&) = default;

    constexpr Vec& operator+=(const Vec& o) {
        for (int i = 0; i < D; ++i) c[i] += o.c[i];
        return *this;
    }
    constexpr Vec& operator-=(const Vec& o) {
        for (int i = 0; i < D; ++i) c[i] -= o.c[i];
        return *this;
    }
    constexpr Vec& operator*=(double s) {
        for (int i = 0; i < D; ++i) c[i] *= s;
        return *this;
    }
};

template <int D>
[[nodiscard]] constexpr Vec<D> operator+(Vec<D> a, const Vec<D>& b) {
    return a += b;
}
template <int D>
[[nodiscard]] constexpr Vec<D> operator-(Vec<D> a, const Vec<D>& b) {
    return a -= b;
}
template <int D>
[[nodiscard]] constexpr Vec<D> operator-(const Vec<D>& a) {
    return a * -1.0;
}
template <int D>
[[nodiscard]] constexpr Vec<D> operator*(Vec<D> a, double s) {
    return a *= s;
}
template <int D>
[[nodiscard]] constexpr Vec<D> operator*(double s, Vec<D> a) {
    return a *= s;
}
template <int D>
[[nodiscard]] constexpr Vec<D> operator/(Vec<D> a, double s) {
    for (int i = 0; i < D; ++i) a.c[i] /= s;
    return a;
}

template <int D>
[[nodiscard]] constexpr double dot(const Vec<D>& a, const Vec<D>& b) {
    double s = 0;
    for (int i = 0; i < D; ++i) s += a.c[i] * b.c[i];
    return s;
}
template <int D>
[[nodiscard]] constexpr double norm_squared(const Vec<D>& a) {
    return dot(a, a);
}
template <int D>
[[nodiscard]] inline double norm(const Vec<D>& a) {
    return std::sqrt(dot(a, a));
}
template <int D>
[[nodiscard]] inline double distance(const Vec<D>& a, const Vec<D>& b) {
    return norm(a - b);
}
/// Returns a / |a|, or zero for the zero vector.
template <int D>
[[nodiscard]] inline Vec<D> normalised(const Vec<D>& a) {
    const double n = norm(a);
    return n > 0 ? a / n : a;
}
template <int D>
[[nodiscard]] constexpr Vec<D> midpoint(const Vec<D>& a, const Vec<D>& b) {
    // The result is exact if a and b are equal, so planes stay exactly planar.
    return (a + b) * 0.5;
}
template <int D>
[[nodiscard]] inline bool is_finite(const Vec<D>& a) {
    for (int i = 0; i < D; ++i)
        if (!std::isfinite(a.c[i])) return false;
    return true;
}

[[nodiscard]] constexpr Vec<3> cross(const Vec<3>& a, const Vec<3>& b) {
    return {{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}};
}
/// Returns a_x b_y − a_y b_x: twice the signed area of the triangle (0, a, b).
[[nodiscard]] constexpr double cross(const Vec<2>& a, const Vec<2>& b) { return a[0] * b[1] - a[1] * b[0]; }

[[nodiscard]] constexpr double det(const Vec<2>& a, const Vec<2>& b) { return cross(a, b); }
[[nodiscard]] constexpr double det(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c) { return dot(a, cross(b, c)); }

/// Axis-aligned box. A new box is empty.
template <int D>
struct Box {
    Vec<D> low, high;

    constexpr Box() {
        for (int i = 0; i < D; ++i) {
            low[i] = 1e300;
            high[i] = -1e300;
        }
    }
    constexpr void include(const Vec<D>& p) {
        for (int i = 0; i < D; ++i) {
            if (p[i] < low[i]) low[i] = p[i];
            if (p[i] > high[i]) high[i] = p[i];
        }
    }
    constexpr void include(const Box& b) {
        for (int i = 0; i < D; ++i) {
            if (b.low[i] < low[i]) low[i] = b.low[i];
            if (b.high[i] > high[i]) high[i] = b.high[i];
        }
    }
    [[nodiscard]] constexpr bool contains(const Vec<D>& p) const {
        for (int i = 0; i < D; ++i)
            if (p[i] < low[i] || p[i] > high[i]) return false;
        return true;
    }
    [[nodiscard]] constexpr bool meets(const Box& b) const {
        for (int i = 0; i < D; ++i)
            if (b.high[i] < low[i] || b.low[i] > high[i]) return false;
        return true;
    }
    [[nodiscard]] constexpr double distance_squared(const Vec<D>& p) const {
        double s = 0;
        for (int i = 0; i < D; ++i) {
            const double d = p[i] < low[i] ? low[i] - p[i] : p[i] > high[i] ? p[i] - high[i] : 0.0;
            s += d * d;
        }
        return s;
    }
    [[nodiscard]] inline double diagonal() const { return low[0] > high[0] ? 0.0 : distance(low, high); }
};

template <int D>
inline constexpr int sym_size = D * (D + 1) / 2;

/// Symmetric matrix, stored as the rows of its lower triangle: xx, xy, yy, xz, yz, zz (order of GMF solutions).
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
template <int D>
[[nodiscard]] constexpr double trace(const Sym<D>& a) {
    double s = 0;
    for (int i = 0; i < D; ++i) s += a(i, i);
    return s;
}

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
template <int D>
[[nodiscard]] constexpr Mat<D> transposed(const Mat<D>& a) {
    Mat<D> r;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) r(i, j) = a(j, i);
    return r;
}
template <int D>
[[nodiscard]] constexpr Vec<D> transposed_times(const Mat<D>& a, const Vec<D>& v) {
    Vec<D> r;
    for (int j = 0; j < D; ++j) r[j] = dot(a.column[j], v);
    return r;
}
template <int D>
[[nodiscard]] constexpr double det(const Mat<D>& a) {
    if constexpr (D == 2)
        return det(a.column[0], a.column[1]);
    else
        return det(a.column[0], a.column[1], a.column[2]);
}
/// Returns the rows of a⁻¹ times det a, computed as cross products of the columns of a. Also defined for singular
/// matrices.
template <int D>
[[nodiscard]] constexpr std::array<Vec<D>, D> cofactors(const Mat<D>& a) {
    if constexpr (D == 2)
        return {Vec<2>{{a(1, 1), -a(0, 1)}}, Vec<2>{{-a(1, 0), a(0, 0)}}};
    else
        return {cross(a.column[1], a.column[2]), cross(a.column[2], a.column[0]), cross(a.column[0], a.column[1])};
}
/// Returns a⁻¹; its entries are infinite or NaN if a is singular.
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

template <int D>
inline constexpr int cubic_size = D * (D + 1) * (D + 2) / 6;

/// Symmetric third-order tensor. The entries have indices i ≥ j ≥ k, the last index fastest: xxx, yxx, yyx, yyy, zxx,
/// zyx, zyy, zzx, zzy, zzz.
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

/// Returns the matrix T[v, ·, ·], with the entries Σ_i T_ijk v_i.
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
/// Returns the form T[A·, A·, A·], which is T in coordinates y with x = A y.
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

// Elementary functions with the same result on every processor. C library functions select code by processor, so a mesh
// would depend on the machine. These functions use only IEEE additions, multiplications, divisions and square roots, in
// a fixed order. Special values are those of C (IEEE 754, annex F), without errno. The error is below 0.6 ulp (below 1
// ulp for subnormal results); `tests/core/elementary.cpp` compares them with a wider type.

[[nodiscard]] double exp(double x);
[[nodiscard]] double exp2(double x);
[[nodiscard]] double expm1(double x);
[[nodiscard]] double log(double x);
[[nodiscard]] double log2(double x);
[[nodiscard]] double log10(double x);
[[nodiscard]] double log1p(double x);
/// Returns x^y. For y = 2, the result is x·x, correctly rounded.
[[nodiscard]] double pow(double x, double y);
[[nodiscard]] double cbrt(double x);
/// Returns √(x² + y²) without intermediate overflow.
[[nodiscard]] double hypot(double x, double y);

[[nodiscard]] double sinh(double x);
[[nodiscard]] double cosh(double x);
[[nodiscard]] double tanh(double x);
[[nodiscard]] double asinh(double x);
[[nodiscard]] double acosh(double x);
[[nodiscard]] double atanh(double x);

[[nodiscard]] double sin(double x);
[[nodiscard]] double cos(double x);
[[nodiscard]] double tan(double x);
[[nodiscard]] double asin(double x);
[[nodiscard]] double acos(double x);
[[nodiscard]] double atan(double x);
[[nodiscard]] double atan2(double y, double x);

// Kernels over packs of eight numbers. A kernel uses only IEEE operations, selection by lane and the functions below,
// and no operation across lanes. The result of a lane does not depend on the instruction set or on other lanes.
//
// Pack functions must be inlined into the function that is compiled for an instruction set (`with_instructions`). A
// pack function compiled separately would pass packs in other registers than its caller.

/// Numbers in a pack, equal for every instruction set.
inline constexpr int pack_size = 8;

using Pack = double __attribute__((ext_vector_type(8)));
/// Each lane is −1 (true) or 0 (false).
using Mask = std::int64_t __attribute__((ext_vector_type(8)));

[[nodiscard, gnu::always_inline]] inline Pack packed(double x) { return Pack(x); }
[[nodiscard, gnu::always_inline]] inline Pack select(Mask mask, Pack a, Pack b) { return mask ? a : b; }
[[nodiscard, gnu::always_inline]] inline Pack abs(Pack x) { return __builtin_elementwise_abs(x); }
[[nodiscard, gnu::always_inline]] inline Pack sqrt(Pack x) { return __builtin_elementwise_sqrt(x); }
[[nodiscard, gnu::always_inline]] inline Pack copysign(Pack x, Pack y) { return __builtin_elementwise_copysign(x, y); }
/// Returns the minimum in each lane, and b in lanes where a is NaN.
[[nodiscard, gnu::always_inline]] inline Pack min(Pack a, Pack b) { return a < b ? a : b; }
[[nodiscard, gnu::always_inline]] inline Pack max(Pack a, Pack b) { return a > b ? a : b; }
[[nodiscard, gnu::always_inline]] inline bool any(Mask mask) { return __builtin_reduce_or(mask) != 0; }

[[nodiscard, gnu::always_inline]] inline Mask bits_of(Pack x) { return __builtin_bit_cast(Mask, x); }
[[nodiscard, gnu::always_inline]] inline Pack of_bits(Mask bits) { return __builtin_bit_cast(Pack, bits); }

/// Returns e^x within 1.5 ulp. x is limited to ±708, so that finite arguments give no infinities or subnormals.
[[nodiscard, gnu::always_inline]] inline Pack exp(Pack x) {
    constexpr double log2e = 0x1.71547652b82fep+0;
    // ln 2 as the sum of two parts. The products of the first part with the used integers are exact (Cody and Waite).
    constexpr double ln2_high = 0x1.62e42fee00000p-1;
    constexpr double ln2_low = 0x1.a39ef35793c76p-33;
    constexpr double to_integer = 0x1.8p52;  // x + to_integer − to_integer rounds x
    x = x < -708 ? packed(-708) : x;
    x = x > 708 ? packed(708) : x;
    const Pack shifted = x * log2e + to_integer;
    const Pack n = shifted - to_integer;
    const Pack r = (x - n * ln2_high) - n * ln2_low;  // |r| ≤ ln 2 / 2
    // Taylor series; the first omitted term is below 5e-18.
    Pack p = packed(1.0 / 6227020800.0);
    p = p * r + 1.0 / 479001600.0;
    p = p * r + 1.0 / 39916800.0;
    p = p * r + 1.0 / 3628800.0;
    p = p * r + 1.0 / 362880.0;
    p = p * r + 1.0 / 40320.0;
    p = p * r + 1.0 / 5040.0;
    p = p * r + 1.0 / 720.0;
    p = p * r + 1.0 / 120.0;
    p = p * r + 1.0 / 24.0;
    p = p * r + 1.0 / 6.0;
    p = p * r + 0.5;
    const Pack e = 1 + (r + r * r * p);
    // The low bits of `shifted` are the integer n, which is added to the exponent.
    return of_bits(bits_of(e) + (bits_of(shifted) << 52));
}

/// Returns ln x within 2 ulp for normal x > 0, and NaN for x ≤ 0 and NaN.
[[nodiscard, gnu::always_inline]] inline Pack log(Pack x) {
    constexpr double ln2_high = 0x1.62e42fee00000p-1;
    constexpr double ln2_low = 0x1.a39ef35793c76p-33;
    constexpr std::int64_t half_sqrt2 = 0x3fe6a09e667f3bcd;  // bits of √½
    // x = 2^n m, with √½ ≤ m < √2.
    const Mask bits = bits_of(x);
    const Mask n = (bits - half_sqrt2) >> 52;
    const Pack m = of_bits(bits - (n << 52));
    const Pack exponent = __builtin_convertvector(n, Pack);
    // ln m = 2 artanh s.
    const Pack s = (m - 1) / (m + 1);
    const Pack z = s * s;
    Pack p = packed(2.0 / 23);
    p = p * z + 2.0 / 21;
    p = p * z + 2.0 / 19;
    p = p * z + 2.0 / 17;
    p = p * z + 2.0 / 15;
    p = p * z + 2.0 / 13;
    p = p * z + 2.0 / 11;
    p = p * z + 2.0 / 9;
    p = p * z + 2.0 / 7;
    p = p * z + 2.0 / 5;
    p = p * z + 2.0 / 3;
    const Pack ln = exponent * ln2_high + (2 * s + (s * z * p + exponent * ln2_low));
    return x > 0 ? ln : packed(__builtin_nan(""));
}

enum class Instructions : std::uint8_t {
    baseline,  ///< instruction set of the build (SSE2 on x86-64)
    avx2,
    avx512,
};

/// True if the processor and the build support the instruction set.
[[nodiscard]] inline bool has(Instructions set) {
#ifdef CAMBER_WIDER_INSTRUCTIONS
    switch (set) {
        case Instructions::avx512: return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq");
        case Instructions::avx2: return __builtin_cpu_supports("avx2") != 0;
        case Instructions::baseline: return true;
    }
#endif
    return set == Instructions::baseline;
}
[[nodiscard]] inline Instructions widest_instructions() {
    static const Instructions widest = has(Instructions::avx512) ? Instructions::avx512
                                       : has(Instructions::avx2) ? Instructions::avx2
                                                                 : Instructions::baseline;
    return widest;
}

#ifdef CAMBER_WIDER_INSTRUCTIONS
template <class Kernel>
[[gnu::target("avx512f,avx512dq")]] void with_avx512(const Kernel& kernel) {
    kernel();
}
template <class Kernel>
[[gnu::target("avx2")]] void with_avx2(const Kernel& kernel) {
    kernel();
}
#endif

/// Calls kernel() without inlining, to keep callers of several kernels small.
template <class Kernel>
[[gnu::noinline]] void with_baseline(const Kernel& kernel) {
    kernel();
}

/// Runs kernel() compiled for the instruction set, which the processor must support. Kernel: `[&]()
/// __attribute__((always_inline)) { … }`.
template <class Kernel>
void with_instructions([[maybe_unused]] Instructions set, const Kernel& kernel) {
#ifdef CAMBER_WIDER_INSTRUCTIONS
    if (set == Instructions::avx512) return with_avx512(kernel);
    if (set == Instructions::avx2) return with_avx2(kernel);
#endif
    with_baseline(kernel);
}

}  // namespace camber
