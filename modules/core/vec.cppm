module;
#include <array>
#include <cmath>
#include <cstddef>
export module camber.core:vec;

export namespace camber {

/// A point or a vector of D coordinates (model units). A plain value; operators are component-wise.
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

/// Σ a_i b_i.
template <int D>
[[nodiscard]] constexpr double dot(const Vec<D>& a, const Vec<D>& b) {
    double s = 0;
    for (int i = 0; i < D; ++i) s += a.c[i] * b.c[i];
    return s;
}
/// |a|².
template <int D>
[[nodiscard]] constexpr double norm_squared(const Vec<D>& a) {
    return dot(a, a);
}
/// |a|.
template <int D>
[[nodiscard]] inline double norm(const Vec<D>& a) {
    return std::sqrt(dot(a, a));
}
/// |a − b|.
template <int D>
[[nodiscard]] inline double distance(const Vec<D>& a, const Vec<D>& b) {
    return norm(a - b);
}
/// a / |a|; the zero vector stays zero.
template <int D>
[[nodiscard]] inline Vec<D> normalised(const Vec<D>& a) {
    const double n = norm(a);
    return n > 0 ? a / n : a;
}
/// (a + b)/2.
template <int D>
[[nodiscard]] constexpr Vec<D> midpoint(const Vec<D>& a, const Vec<D>& b) {
    // (a + b) / 2 is exact where a and b agree: planes stay planes to the last bit.
    return (a + b) * 0.5;
}
/// No coordinate is infinite or NaN.
template <int D>
[[nodiscard]] inline bool is_finite(const Vec<D>& a) {
    for (int i = 0; i < D; ++i)
        if (!std::isfinite(a.c[i])) return false;
    return true;
}

/// a × b.
[[nodiscard]] constexpr Vec<3> cross(const Vec<3>& a, const Vec<3>& b) {
    return {{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}};
}
/// a_x b_y − a_y b_x: twice the signed area of (0, a, b).
[[nodiscard]] constexpr double cross(const Vec<2>& a, const Vec<2>& b) { return a[0] * b[1] - a[1] * b[0]; }

/// Determinant of the matrix whose columns are the arguments.
[[nodiscard]] constexpr double det(const Vec<2>& a, const Vec<2>& b) { return cross(a, b); }
[[nodiscard]] constexpr double det(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c) { return dot(a, cross(b, c)); }

/// Axis-aligned box; empty until something is included.
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
    /// The boxes have a point in common.
    [[nodiscard]] constexpr bool meets(const Box& b) const {
        for (int i = 0; i < D; ++i)
            if (b.high[i] < low[i] || b.low[i] > high[i]) return false;
        return true;
    }
    /// Squared distance from p to the box; 0 inside.
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

}  // namespace camber
