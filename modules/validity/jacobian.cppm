module;
#include <array>
#include <span>
export module camber.validity:jacobian;
import camber.core;
import camber.bezier;
import :coefficients;
import :twice;

export namespace camber {

/// Bézier coefficients of det J of one element with what is needed to judge them. `Real` may be a pack of doubles.
template <int D, class Real = double>
struct BoundedJacobian {
    std::array<Real, jacobian_coefficients<D>> coefficients{};  ///< in the order of jacobian_indices<D>
    Real straight{};                                            ///< det of the straight element with the same vertices
    Real error{};  ///< bounds the rounding error of every coefficient and of `straight`
};

/// A P2 element by its Lagrange nodes, as the mesh stores them: the vertices, then the edges' nodes in the order of
/// `local_edges`. What is certified of it holds for the stored numbers (no rounded control point comes in between).
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

/// The element in Bézier form, as far as rounding goes: what is certified is certified of the nodes.
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

/// The columns of J, their bounds, and the edges of the straight element.
template <int D, class Real>
struct JacobianColumns {
    ColumnPoints<D, Real> d;
    ColumnBounds<D, Real> w;
    std::array<std::array<Real, D>, D> straight;
};

/// From the Lagrange nodes n_ij (n_ii = vertex i) given by coordinate(node, axis):
/// P_{e_i+e_a} − P_{e_i+e_0} = 2 (n_ia − n_i0) − (p_a − p_0)/2, in which only differences of stored numbers occur, so
/// that the error is relative to the element's size and not to its distance from the origin.
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

/// From the Bézier points.
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
            j.w[a - 1][c] = largest + smallest_bound<Real>;  // the edge is the sum of two of them: below 2 w
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

/// To doubles: the factor and the last rounding err by 2⁻⁵² of the coefficient.
template <int D>
[[nodiscard]] inline BoundedJacobian<D> rounded(const BoundedJacobian<D, Twice>& j) {
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

/// Of the element with these stored nodes.
template <int D>
[[nodiscard]] inline BoundedJacobian<D> bounded_jacobian(const NodalSimplex<D>& s) {
    return jacobian_of_nodes<D, double>([&](int node, int c) { return s.nodes[node].c[c]; });
}

/// Of the element with exactly these Bézier points.
template <int D>
[[nodiscard]] inline BoundedJacobian<D> bounded_jacobian(const QuadraticSimplex<D, D>& s) {
    return jacobian_of_points<D, double>([&](int node, int c) { return s.control[node].c[c]; });
}

/// The same in numbers of twice the digits, rounded at the end: the error is then relative to the coefficients and no
/// longer to the products that they are sums of. Some twenty times as dear; for what plain doubles leave undecided.
template <int D>
[[nodiscard]] inline BoundedJacobian<D> sharp_jacobian(const NodalSimplex<D>& s) {
    return rounded<D>(jacobian_of_nodes<D, Twice>([&](int node, int c) { return Twice(s.nodes[node].c[c]); }));
}
template <int D>
[[nodiscard]] inline BoundedJacobian<D> sharp_jacobian(const QuadraticSimplex<D, D>& s) {
    return rounded<D>(jacobian_of_points<D, Twice>([&](int node, int c) { return Twice(s.control[node].c[c]); }));
}

/// Bézier coefficients of det J in the order of multi_indices<D, D>: 6 on a triangle, 20 on a tetrahedron. They all
/// equal det of the edge vectors on a straight element.
template <int D>
[[nodiscard]] inline std::array<double, jacobian_coefficients<D>> jacobian(const QuadraticSimplex<D, D>& element) {
    return bounded_jacobian(element).coefficients;
}

}  // namespace camber
