module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>
export module camber.validity:jacobian;
import camber.core;
import camber.bezier;

export namespace camber {

/// An unevaluated sum of two doubles (Dekker 1971): about 104 bits. The compiler must not contract operations (no fused
/// multiply-add).
struct DoubleDouble {
    double high = 0, low = 0;

    constexpr DoubleDouble() = default;
    constexpr DoubleDouble(double x) : high(x) {}  // NOLINT(*-explicit-*): doubles are such numbers
    constexpr DoubleDouble(double h, double l) : high(h), low(l) {}

    /// Returns a + b exactly (Knuth).
    [[nodiscard]] static constexpr DoubleDouble sum(double a, double b) {
        const double s = a + b;
        const double t = s - a;
        return {s, (a - (s - t)) + (b - t)};
    }
    /// Returns a + b exactly, for |a| ≥ |b|.
    [[nodiscard]] static constexpr DoubleDouble quick_sum(double a, double b) {
        const double s = a + b;
        return {s, b - (s - a)};
    }
    /// Returns a · b, exactly except for underflow (Veltkamp, Dekker).
    [[nodiscard]] static constexpr DoubleDouble product(double a, double b) {
        const DoubleDouble x = halves(a);
        const DoubleDouble y = halves(b);
        const double p = a * b;
        return {p, ((x.high * y.high - p) + x.high * y.low + x.low * y.high) + x.low * y.low};
    }

    friend constexpr DoubleDouble operator+(const DoubleDouble& a, const DoubleDouble& b) {
        const DoubleDouble s = sum(a.high, b.high);
        const DoubleDouble t = sum(a.low, b.low);
        const DoubleDouble u = quick_sum(s.high, s.low + t.high);
        return quick_sum(u.high, u.low + t.low);
    }
    friend constexpr DoubleDouble operator-(const DoubleDouble& a) { return {-a.high, -a.low}; }
    friend constexpr DoubleDouble operator-(const DoubleDouble& a, const DoubleDouble& b) { return a + -b; }
    friend constexpr DoubleDouble operator*(const DoubleDouble& a, const DoubleDouble& b) {
        const DoubleDouble p = product(a.high, b.high);
        return quick_sum(p.high, p.low + (a.high * b.low + a.low * b.high));
    }
    constexpr DoubleDouble& operator+=(const DoubleDouble& o) { return *this = *this + o; }
    friend constexpr bool operator<(const DoubleDouble& a, const DoubleDouble& b) {
        return a.high < b.high || (a.high == b.high && a.low < b.low);
    }
    friend constexpr bool operator>(const DoubleDouble& a, const DoubleDouble& b) { return b < a; }

  private:
    /// Splits x into two 26-bit parts.
    [[nodiscard]] static constexpr DoubleDouble halves(double x) {
        const double c = 134217729.0 * x;  // 2²⁷ + 1
        const double h = c - (c - x);
        return {h, x - h};
    }
};

/// Number of coefficients of det J. Its degree is D, because each of its D columns is linear.
template <int D>
inline constexpr int jacobian_coefficients = node_count<D, D>;

template <int D>
inline constexpr const auto& jacobian_indices = multi_indices<D, D>;

/// Indices of the coefficients at the vertices, which are values of det J.
template <int D>
inline constexpr std::array<int, D + 1> corner_coefficients = [] {
    std::array<int, D + 1> corners{};
    for (int i = 0; i <= D; ++i) {
        MultiIndex<D> alpha{};
        alpha[i] = D;
        corners[i] = position<D, D>(alpha);
    }
    return corners;
}();

}  // namespace camber

namespace camber {

/// The following templates also take packs of doubles (core:tensors); therefore they are always inlined.

/// d[a−1][i] = P_{e_i+e_a} − P_{e_i+e_0} for Bézier points P. Column a of J is 2 Σ_i ξ_i d[a−1][i] (a = 1 … D, i = 0 …
/// D).
template <int D, class Real>
using ColumnPoints = std::array<std::array<std::array<Real, D>, D + 1>, D>;

/// Componentwise bounds on |d[a−1][i]| for all i, at least `smallest_bound`.
template <int D, class Real>
using ColumnBounds = std::array<std::array<Real, D>, D>;

/// Index of the node between the local vertices i and j; the vertex if i = j.
template <int D>
inline constexpr auto node_between = [] {
    std::array<std::array<int, D + 1>, D + 1> table{};
    for (int i = 0; i <= D; ++i) table[i][i] = i;
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        const int a = local_edges<D>[e][0];
        const int b = local_edges<D>[e][1];
        table[a][b] = table[b][a] = D + 1 + e;
    }
    return table;
}();

template <class Real>
[[nodiscard, gnu::always_inline]] constexpr std::array<Real, 3> product(const std::array<Real, 3>& u,
                                                                        const std::array<Real, 3>& v) {
    return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}
template <class Real>
[[nodiscard, gnu::always_inline]] constexpr std::array<Real, 1> product(const std::array<Real, 2>& u,
                                                                        const std::array<Real, 2>& v) {
    return {u[0] * v[1] - u[1] * v[0]};
}

/// Σ of d_{D−1}[j] × d_D[k] over the ordered pairs (j, k) with e_j + e_k = β.
template <int D, std::size_t B, class Real>
[[nodiscard, gnu::always_inline]] constexpr auto pair_product(const ColumnPoints<D, Real>& d) {
    constexpr auto jk = [] {
        std::array<int, 2> found{-1, -1};
        for (int i = 0, n = 0; i <= D; ++i)
            for (int m = 0; m < multi_indices<2, D>[B][i]; ++m) found[n++] = i;
        return found;
    }();
    auto sum = product(d[D - 2][jk[0]], d[D - 1][jk[1]]);
    if constexpr (jk[0] != jk[1]) {
        const auto other = product(d[D - 2][jk[1]], d[D - 1][jk[0]]);
        for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += other[c];
    }
    return sum;
}

/// Σ_i d_1[i] · (pair product of α − e_i), times 8 / multinomial(α). This is the mean of 8 det(d_1[i], d_2[j], d_3[k])
/// over the ordered triples with e_i + e_j + e_k = α (Johnen, Remacle, Geuzaine 2013).
template <std::size_t A, class Real, class Pairs>
[[nodiscard, gnu::always_inline]] constexpr Real triple_coefficient(const ColumnPoints<3, Real>& d,
                                                                    const Pairs& pairs) {
    constexpr auto alpha = multi_indices<3, 3>[A];
    Real sum{};
    const auto add = [&]<std::size_t I>(std::integral_constant<std::size_t, I>) __attribute__((always_inline)) {
        if constexpr (alpha[I] > 0) {
            constexpr int beta = [] {
                auto rest = multi_indices<3, 3>[A];
                --rest[I];
                return position<2, 3>(rest);
            }();
            const auto& u = d[0][I];
            const auto& v = pairs[beta];
            sum += u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
        }
    };
    [&]<std::size_t... I>(std::index_sequence<I...>) __attribute__((always_inline)) {
        (add(std::integral_constant<std::size_t, I>{}), ...);
    }(std::make_index_sequence<4>{});
    return sum * (8.0 / multinomial<3>(alpha));
}

template <int D, class Real>
[[nodiscard, gnu::always_inline]] inline std::array<Real, jacobian_coefficients<D>> coefficients_of(
    const ColumnPoints<D, Real>& d) {
    const auto pairs = [&]<std::size_t... B>(std::index_sequence<B...>) __attribute__((always_inline)) {
        return std::array{pair_product<D, B>(d)...};
    }(std::make_index_sequence<node_count<2, D>>{});
    if constexpr (D == 2)
        return [&]<std::size_t... A>(std::index_sequence<A...>) __attribute__((always_inline)) {
            return std::array{pairs[A][0] * (4.0 / multinomial<2>(multi_indices<2, 2>[A]))...};
        }(std::make_index_sequence<6>{});
    else
        return [&]<std::size_t... A>(std::index_sequence<A...>) __attribute__((always_inline)) {
            return std::array{triple_coefficient<A>(d, pairs)...};
        }(std::make_index_sequence<20>{});
}

template <class Real>
[[nodiscard, gnu::always_inline]] constexpr Real magnitude(Real x) {
    return x < 0 ? -x : x;
}
template <class Real>
[[nodiscard, gnu::always_inline]] constexpr Real larger(Real a, Real b) {
    return a > b ? a : b;
}

/// Factor γ of `error_bound`: 32 u for doubles (u = 2⁻⁵³); 32 · 2⁻⁹⁵ for `DoubleDouble`, whose operations err by less
/// than 2⁻¹⁰⁰ (without `rounded`).
template <class Real>
inline constexpr double rounding_factor = 0x1p-48;
template <>
inline constexpr double rounding_factor<DoubleDouble> = 0x1p-90;

/// Added to every column bound w, so that γ w exceeds the underflow of an entry of d, which other columns multiply.
/// Underflow occurs where half an edge between denormal numbers is computed; for `DoubleDouble`, in the low part of any
/// product.
template <class Real>
inline constexpr double smallest_bound = 0x1p-1020;
template <>
inline constexpr double smallest_bound<DoubleDouble> = 0x1p-970;

/// Returns γ · 2^D perm(w), which bounds the error of each coefficient. Requires w ≥ |d| and |error of d| ≤ (2u + u²)
/// w. A coefficient is a mean of products 2^D d_1 d_2 d_3, each at most 2^D perm(w).
///
/// - Each product has 6 relative roundings from d and 10 from arithmetic: pair product 2, sum of pairs 1, times d_1 1,
///   sums over axes 2 and vertices 2, 8/multinomial 2.
/// - These 16 u, second-order terms (16² u²), and at most 14 roundings of w and perm leave half of γ.
/// - Triangles have 4 roundings from d and 3 others.
/// - The bound also holds for det of the straight element: its columns are below 2 w, with one rounding each.
/// - The last term covers underflow: less than 2⁻¹⁰⁷⁰ for each of the 64 products, times |d_1|.
///
/// Large sums come first, so that the bound overflows before any partial sum of a coefficient; then `finite` is false.
template <int D, class Real>
[[nodiscard, gnu::always_inline]] constexpr Real error_bound(const ColumnBounds<D, Real>& w) {
    constexpr double rounding = rounding_factor<Real> * 0x1p-8;
    constexpr double underflow = 0x1p-1060;
    if constexpr (D == 2) {
        return (4 * rounding) * (256 * (w[0][0] * w[1][1] + w[0][1] * w[1][0])) + underflow;
    } else {
        const Real permanent = w[0][0] * (w[1][1] * w[2][2] + w[1][2] * w[2][1]) +
                               w[0][1] * (w[1][2] * w[2][0] + w[1][0] * w[2][2]) +
                               w[0][2] * (w[1][0] * w[2][1] + w[1][1] * w[2][0]);
        return (8 * rounding) * (256 * permanent) + underflow * (1 + w[0][0] + w[0][1] + w[0][2]);
    }
}

template <int D, class Real>
[[nodiscard, gnu::always_inline]] inline Real determinant(const std::array<std::array<Real, D>, D>& columns) {
    if constexpr (D == 2) {
        return product(columns[0], columns[1])[0];
    } else {
        const auto v = product(columns[1], columns[2]);
        return columns[0][0] * v[0] + columns[0][1] * v[1] + columns[0][2] * v[2];
    }
}

}  // namespace camber

export namespace camber {

/// Bézier coefficients of det J, det of the straight element, and an error bound. `Real` may be a pack of doubles.
template <int D, class Real = double>
struct BoundedJacobian {
    std::array<Real, jacobian_coefficients<D>> coefficients{};
    Real straight{};
    Real error{};  ///< bounds the error of each coefficient and of `straight`
};

/// A P2 element, stored as its Lagrange nodes: vertices, then edge nodes in the order of `local_edges`. Certificates
/// hold for these stored numbers.
template <int D>
struct NodalSimplex {
    std::array<Vec<D>, quadratic_nodes<D>> nodes{};
};

template <int D>
[[nodiscard]] inline NodalSimplex<D> nodal_form(const Column<Vec<D>>& points,
                                                std::span<const LagrangeNode<D>> mid_nodes,
                                                const SimplexVertices<D>& vertices,
                                                const std::array<EdgeId, edges_per_simplex<D>>& edges) {
    NodalSimplex<D> s;
    for (int i = 0; i <= D; ++i) s.nodes[i] = points[vertices[i]];
    for (int e = 0; e < edges_per_simplex<D>; ++e) s.nodes[D + 1 + e] = mid_nodes[edges[e].index()].point;
    return s;
}

/// Returns the Bézier form, with rounding errors. Certificates refer to the nodes.
template <int D>
[[nodiscard]] inline QuadraticSimplex<D, D> bezier_form(const NodalSimplex<D>& s) {
    QuadraticSimplex<D, D> q;
    for (int i = 0; i <= D; ++i) q.control[i] = s.nodes[i];
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        const auto [i, j] = local_edges<D>[e];
        q.control[D + 1 + e] = control_point(s.nodes[i], LagrangeNode<D>{s.nodes[D + 1 + e]}, s.nodes[j]).point;
    }
    return q;
}

}  // namespace camber

namespace camber {

/// Columns d with bounds w, and the edges of the straight element.
template <int D, class Real>
struct JacobianColumns {
    ColumnPoints<D, Real> d;
    ColumnBounds<D, Real> w;
    std::array<std::array<Real, D>, D> straight;
};

/// Computes columns from the Lagrange nodes n_ij (n_ii = vertex i): P_{e_i+e_a} − P_{e_i+e_0} = 2 (n_ia − n_i0) − (p_a
/// − p_0)/2. Only differences of stored numbers occur, so the error is relative to the size of the element.
template <int D, class Real, class Coordinate>
[[nodiscard, gnu::always_inline]] inline JacobianColumns<D, Real> columns_of_nodes(Coordinate&& coordinate) {
    JacobianColumns<D, Real> j;
    for (int a = 1; a <= D; ++a)
        for (int c = 0; c < D; ++c) {
            const Real edge = coordinate(a, c) - coordinate(0, c);
            const Real half = 0.5 * edge;
            Real largest{};
            for (int i = 0; i <= D; ++i) {
                const Real twice = 2 * (coordinate(node_between<D>[i][a], c) - coordinate(node_between<D>[i][0], c));
                j.d[a - 1][i][c] = twice - half;
                largest = larger<Real>(largest, magnitude<Real>(twice));
            }
            j.w[a - 1][c] = largest + magnitude<Real>(half) + smallest_bound<Real>;
            j.straight[a - 1][c] = edge;
        }
    return j;
}

template <int D, class Real, class Coordinate>
[[nodiscard, gnu::always_inline]] inline JacobianColumns<D, Real> columns_of_points(Coordinate&& coordinate) {
    JacobianColumns<D, Real> j;
    for (int a = 1; a <= D; ++a)
        for (int c = 0; c < D; ++c) {
            Real largest{};
            for (int i = 0; i <= D; ++i) {
                j.d[a - 1][i][c] = coordinate(node_between<D>[i][a], c) - coordinate(node_between<D>[i][0], c);
                largest = larger<Real>(largest, magnitude<Real>(j.d[a - 1][i][c]));
            }
            j.straight[a - 1][c] = coordinate(a, c) - coordinate(0, c);
            j.w[a - 1][c] = largest + smallest_bound<Real>;  // straight edges are sums of two entries, thus below 2 w
        }
    return j;
}

template <int D, class Real>
[[nodiscard, gnu::always_inline]] inline BoundedJacobian<D, Real> jacobian_of(const JacobianColumns<D, Real>& j) {
    return {coefficients_of<D, Real>(j.d), determinant<D, Real>(j.straight), error_bound<D, Real>(j.w)};
}
template <int D, class Real, class Coordinate>
[[nodiscard, gnu::always_inline]] inline BoundedJacobian<D, Real> jacobian_of_nodes(Coordinate&& coordinate) {
    return jacobian_of<D, Real>(columns_of_nodes<D, Real>(coordinate));
}
template <int D, class Real, class Coordinate>
[[nodiscard, gnu::always_inline]] inline BoundedJacobian<D, Real> jacobian_of_points(Coordinate&& coordinate) {
    return jacobian_of<D, Real>(columns_of_points<D, Real>(coordinate));
}

/// Rounds to doubles; the error grows by 2⁻⁵¹ of the largest coefficient.
template <int D>
[[nodiscard]] inline BoundedJacobian<D> rounded(const BoundedJacobian<D, DoubleDouble>& j) {
    BoundedJacobian<D> out;
    out.straight = j.straight.high;
    double largest = magnitude(out.straight);
    for (int i = 0; i < jacobian_coefficients<D>; ++i) {
        out.coefficients[i] = j.coefficients[i].high;
        largest = larger(largest, magnitude(out.coefficients[i]));
    }
    out.error = j.error.high + 0x1p-51 * largest;
    return out;
}

}  // namespace camber

export namespace camber {

template <int D>
[[nodiscard]] inline BoundedJacobian<D> bounded_jacobian(const NodalSimplex<D>& s) {
    return jacobian_of_nodes<D, double>([&](int node, int c) { return s.nodes[node].c[c]; });
}

/// Computes the coefficients from the Bézier points, which are taken as exact.
template <int D>
[[nodiscard]] inline BoundedJacobian<D> bounded_jacobian(const QuadraticSimplex<D, D>& s) {
    return jacobian_of_points<D, double>([&](int node, int c) { return s.control[node].c[c]; });
}

/// Computes the coefficients in double-double arithmetic and rounds them. Their error is relative to the coefficients,
/// not to their summands. About twenty times slower than doubles; for elements that doubles leave undecided.
template <int D>
[[nodiscard]] inline BoundedJacobian<D> double_double_jacobian(const NodalSimplex<D>& s) {
    return rounded<D>(
        jacobian_of_nodes<D, DoubleDouble>([&](int node, int c) { return DoubleDouble(s.nodes[node].c[c]); }));
}
template <int D>
[[nodiscard]] inline BoundedJacobian<D> double_double_jacobian(const QuadraticSimplex<D, D>& s) {
    return rounded<D>(
        jacobian_of_points<D, DoubleDouble>([&](int node, int c) { return DoubleDouble(s.control[node].c[c]); }));
}

/// Returns the Bézier coefficients of det J in the order of multi_indices<D, D> (6 or 20). For a straight element all
/// are equal to det of the edge vectors.
template <int D>
[[nodiscard]] inline std::array<double, jacobian_coefficients<D>> jacobian(const QuadraticSimplex<D, D>& element) {
    return bounded_jacobian(element).coefficients;
}

/// The function gradient · x + offset.
template <int M>
struct AffineFunction {
    Vec<M> gradient;
    double offset = 0;

    [[nodiscard]] constexpr double operator()(const Vec<M>& x) const { return dot(gradient, x) + offset; }
    friend bool operator==(const AffineFunction&, const AffineFunction&) = default;
};

/// Bézier coefficients of det J as functions of x = P − P_0, divided by `scale`; P is the node of one edge, P_0 its
/// current position.
template <int D>
struct AffineJacobian {
    std::array<AffineFunction<D>, jacobian_coefficients<D>> coefficients{};
    double scale = 1;     ///< |det of the straight element|; the largest coefficient if it is flat
    double straight = 0;  ///< |det of the straight element| / scale: 1, or about 0
    double error = 0;     ///< error of the coefficients at P_0, divided by `scale`
};

}  // namespace camber

namespace camber {

/// Even vertex permutation that puts a local edge last (2–3 of a tetrahedron, 1–2 of a triangle).
template <int D>
[[nodiscard]] constexpr std::array<int, D + 1> edge_last(int edge) {
    const auto [a, b] = local_edges<D>[edge];
    if constexpr (D == 2) {
        const int c = 3 - a - b;
        return (a + 1) % 3 == b ? std::array{c, a, b} : std::array{c, b, a};
    } else {
        std::array<int, 4> order{-1, -1, a, b};
        for (int i = 0, n = 0; i < 4; ++i)
            if (i != a && i != b) order[n++] = i;
        int inversions = 0;
        for (int i = 0; i < 4; ++i)
            for (int j = i + 1; j < 4; ++j) inversions += order[i] > order[j];
        if (inversions % 2 == 1) std::swap(order[0], order[1]);
        return order;
    }
}

/// Derivative of a coefficient by the node P of the last edge, D−1 to D. P occurs in column D of J at vertex D−1 and in
/// column D−1 at vertex D, twice each, times the cofactors of these columns. The cofactors do not depend on P (J = J_0
/// + P ⊗ g).
template <int D, std::size_t A>
[[nodiscard]] constexpr Vec<D> coefficient_gradient(const auto& of_last, const auto& of_other) {
    constexpr auto alpha = jacobian_indices<D>[A];
    Vec<D> gradient;
    const auto add = [&]<int I>(std::integral_constant<int, I>, const auto& cofactors) {
        if constexpr (alpha[I] > 0) {
            constexpr int beta = [] {
                auto rest = jacobian_indices<D>[A];
                --rest[I];
                return position<D - 1, D>(rest);
            }();
            for (int c = 0; c < D; ++c) gradient[c] += cofactors[beta][c];
        }
    };
    add(std::integral_constant<int, D - 1>{}, of_last);
    add(std::integral_constant<int, D>{}, of_other);
    return ((D == 2 ? 8.0 : 16.0) / multinomial<D>(alpha)) * gradient;
}

/// Bézier coefficients, of degree D − 1, of the cofactors of columns D and D−1 of J / 2.
template <int D>
[[nodiscard]] constexpr auto cofactors_of(const ColumnPoints<D, double>& d) {
    constexpr int count = node_count<D - 1, D>;
    std::array<std::array<std::array<double, D>, count>, 2> both{};
    if constexpr (D == 2) {
        for (int m = 0; m <= D; ++m) {
            MultiIndex<2> beta{};
            ++beta[m];
            both[0][position<1, 2>(beta)] = {-d[0][m][1], d[0][m][0]};
            both[1][position<1, 2>(beta)] = {d[1][m][1], -d[1][m][0]};
        }
    } else {
        const ColumnPoints<3, double> last{{{}, d[0], d[1]}};
        const ColumnPoints<3, double> other{{{}, d[2], d[0]}};
        [&]<std::size_t... B>(std::index_sequence<B...>) {
            ((both[0][B] = pair_product<3, B>(last), both[1][B] = pair_product<3, B>(other)), ...);
        }(std::make_index_sequence<count>{});
    }
    return both;
}

}  // namespace camber

export namespace camber {

/// Returns the coefficients as functions of the node of `edge`, in the order of the element with this edge last.
template <int D>
[[nodiscard]] inline AffineJacobian<D> affine_jacobian(const NodalSimplex<D>& s, int edge) {
    const auto order = edge_last<D>(edge);
    const auto node = [&](int i, int j) -> const Vec<D>& { return s.nodes[node_between<D>[order[i]][order[j]]]; };
    ColumnPoints<D, double> d;
    ColumnBounds<D, double> w{};
    std::array<std::array<double, D>, D> straight;
    for (int a = 1; a <= D; ++a)
        for (int c = 0; c < D; ++c) {
            straight[a - 1][c] = node(a, a)[c] - node(0, 0)[c];
            const double half = 0.5 * straight[a - 1][c];
            double largest = 0;
            for (int i = 0; i <= D; ++i) {
                const double twice = 2 * (node(i, a)[c] - node(i, 0)[c]);
                d[a - 1][i][c] = twice - half;
                largest = larger(largest, magnitude(twice));
            }
            w[a - 1][c] = largest + magnitude(half);
        }
    const auto values = coefficients_of<D, double>(d);
    const auto cofactors = cofactors_of<D>(d);
    const double error = error_bound<D, double>(w);
    const double volume = std::abs(determinant<D, double>(straight));

    AffineJacobian<D> j;
    j.scale = volume;
    if (!(volume > 2 * error)) {
        j.scale = std::numeric_limits<double>::min();
        for (const double v : values) j.scale = std::max(j.scale, std::abs(v));
    }
    j.straight = volume / j.scale;
    j.error = error / j.scale;
    [&]<std::size_t... A>(std::index_sequence<A...>) {
        ((j.coefficients[A] = {coefficient_gradient<D, A>(cofactors[0], cofactors[1]) / j.scale, values[A] / j.scale}),
         ...);
    }(std::make_index_sequence<jacobian_coefficients<D>>{});
    return j;
}

/// Eight elements, one per lane. All nodes of an unset lane are at one point.
template <int D>
struct NodalPack {
    alignas(64) std::array<std::array<std::array<double, pack_size>, D>, quadratic_nodes<D>> nodes{};

    void set(std::size_t lane, const NodalSimplex<D>& s) {
        for (int n = 0; n < quadratic_nodes<D>; ++n)
            for (int c = 0; c < D; ++c) nodes[n][c][lane] = s.nodes[n][c];
    }
};

struct JacobianSummary {
    double lowest = 0;
    double straight = 0;
    double error = 0;
    double sum_of_absolute = 0;  ///< finite if no coefficient is infinite or NaN

    [[nodiscard]] bool is_finite() const { return std::isfinite(error + straight + sum_of_absolute); }
};

[[nodiscard]] inline JacobianSummary jacobian_summary(const BoundedJacobian<2>& jacobian) {
    JacobianSummary low{jacobian.coefficients[0], jacobian.straight, jacobian.error, 0};
    for (const double c : jacobian.coefficients) {
        low.lowest = c < low.lowest ? c : low.lowest;
        low.sum_of_absolute += std::abs(c);
    }
    return low;
}

/// Computes summaries of the coefficients of eight elements, bitwise equal to the results of `bounded_jacobian` for any
/// instruction set.
template <int D>
[[nodiscard]] std::array<JacobianSummary, pack_size> jacobian_summaries(const NodalPack<D>& elements,
                                                                        Instructions set = widest_instructions());

/// True if the element is certainly valid (`decide_by_coefficients`) and not `blurred`.
[[nodiscard]] bool is_clear(const JacobianSummary& jacobian, double bound);

[[nodiscard]] double smallest_scaled_coefficient(const JacobianSummary& jacobian);

template <int D, class Element, class Visit>
void each_jacobian_summary(std::size_t begin, std::size_t end, const Element& element, const Visit& visit) {
    NodalPack<D> pack;
    for (std::size_t first = begin; first < end; first += pack_size) {
        const std::size_t lanes = end - first < pack_size ? end - first : pack_size;
        for (std::size_t lane = 0; lane < lanes; ++lane) pack.set(lane, element(first + lane));
        const auto jacobians = jacobian_summaries(pack);
        for (std::size_t lane = 0; lane < lanes; ++lane) visit(first + lane, jacobians[lane]);
    }
}

/// D! times the volume of a straight simplex. The sign is certain; the value is 0 if double-double arithmetic does not
/// determine the sign.
template <int D>
[[nodiscard]] double signed_volume(const std::array<Vec<D>, D + 1>& corners);

/// Mean of det J over the reference element. If the sign is not certain: the value for the straight element.
template <int D>
[[nodiscard]] double signed_volume(const NodalSimplex<D>& element);

}  // namespace camber
