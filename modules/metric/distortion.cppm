module;
#include <array>
#include <cstddef>
#include <numbers>
export module camber.metric:distortion;
import camber.core;
import camber.bezier;
import :spd;

/// How far a P2 element is from the regular simplex in a metric, at a point and as a mean, with the mean's gradient.
///
/// At a point, A = M^{1/2} J W⁻¹, J the Jacobian of the element and W that of the regular simplex:
///     distortion η = tr(AᵀA) / (D det(A)^{2/D}) ≥ 1,   quality 1/η, with the sign of det J;
/// tr(ᵗJ M J) over a power of det(ᵗJ M J), as the paper and MFEM have it, seen from W. Between the vertices log M is
/// linear in the reference coordinates; of it the shape alone matters (log M less its trace), since η has no scale.
/// On a straight element in a constant metric η is the same everywhere and 1/η is metric_quality.
export namespace camber {

/// A P2 simplex by its Lagrange nodes: the vertices, then the edges' nodes in the order of `local_edges`.
template <int D>
using QuadraticNodes = std::array<Vec<D>, quadratic_nodes<D>>;
template <int D>
using VertexLogMetrics = std::array<LogMetric<D>, D + 1>;

/// The metric's shape at the points of the rule below: M/det(M)^{1/D} = rootᵀ root, by rows sqrt(λ_i) r_iᵀ. It does
/// not depend on the nodes: whoever moves nodes under given metrics makes it once.
template <int D>
struct ElementMetric {
    std::array<std::array<Pack, D>, D> root{};  ///< root[i][c]: coordinate c of row i, a point a lane
};
template <int D>
[[nodiscard]] ElementMetric<D> element_metric(const VertexLogMetrics<D>& vertices,
                                              Instructions set = widest_instructions());

/// Quality of an element: 1 over the mean of η in the reference element by the rule, and the least 1/η at its points.
/// The mean is 0 where det J is not of one sign at all points (it tends to 0 there), and negative where det J is
/// negative at all; never NaN.
struct CurvedQuality {
    double mean = 0, least = 0;
    friend bool operator==(const CurvedQuality&, const CurvedQuality&) = default;
};
template <int D>
[[nodiscard]] CurvedQuality curved_quality(const QuadraticNodes<D>& nodes, const ElementMetric<D>& metric,
                                           Instructions set = widest_instructions());

/// The mean, and its derivative by each node while the others and the metrics stay: of a vertex while mid nodes stay.
/// Zero where the mean is 0.
template <int D>
struct CurvedQualityGradient {
    double mean = 0;
    QuadraticNodes<D> by_node{};
};
template <int D>
[[nodiscard]] CurvedQualityGradient<D> curved_quality_gradient(const QuadraticNodes<D>& nodes,
                                                               const ElementMetric<D>& metric,
                                                               Instructions set = widest_instructions());

/// 1/η at a point, with the sign of det J: alone, and as exact as the nodes are. 0 where it has no value.
template <int D>
[[nodiscard]] double quality_at(const QuadraticNodes<D>& nodes, const VertexLogMetrics<D>& vertices,
                                const Barycentric<D>& xi);

/// Rules exact to degree 3 with positive weights, one point a lane. Tetrahedra: vertices (1/40) and centroids of faces
/// (9/40). Triangles: vertices (1/20), middles of edges (2/15) and the centroid (9/20); its second lane has no weight.
template <int D>
struct DistortionRule {
    std::array<std::array<double, pack_size>, D + 1> xi{};  ///< xi[i][point]
    std::array<double, pack_size> weights{};
};
template <int D>
inline constexpr DistortionRule<D> distortion_rule = [] {
    DistortionRule<D> rule;
    int n = 0;
    const auto add = [&](const Barycentric<D>& at, double weight) {
        for (int i = 0; i <= D; ++i) rule.xi[i][n] = at[i];
        rule.weights[n++] = weight;
    };
    for (int i = 0; i <= D; ++i) {
        Barycentric<D> at{};
        at[i] = 1;
        add(at, D == 2 ? 1.0 / 20 : 1.0 / 40);
    }
    for (int i = 0; i <= D; ++i) {
        Barycentric<D> at{};
        for (int j = 0; j <= D; ++j) at[j] = j == i ? 0 : 1.0 / D;
        add(at, D == 2 ? 2.0 / 15 : 9.0 / 40);
    }
    if constexpr (D == 2) {
        const double third = 1.0 / 3;
        add({third, third, third}, 9.0 / 20);
        add({third, third, third}, 0);
    }
    return rule;
}();

}  // namespace camber

namespace camber {

/// Derivatives of the barycentric coordinates by those of the regular simplex: rows of W⁻¹, before them less their sum.
template <int D>
inline constexpr std::array<Vec<D>, D + 1> regular_gradients = [] {
    constexpr double a = std::numbers::inv_sqrt3;
    constexpr double b = a * std::numbers::sqrt2 / 2;  // 1/√6
    std::array<Vec<D>, D + 1> rows{};
    if constexpr (D == 2)
        rows = {Vec<2>{}, Vec<2>{{1, -a}}, Vec<2>{{0, 2 * a}}};
    else
        rows = {Vec<3>{}, Vec<3>{{1, -a, -b}}, Vec<3>{{0, 2 * a, -b}}, Vec<3>{{0, 0, 3 * b}}};
    for (int i = 1; i <= D; ++i) rows[0] -= rows[i];
    return rows;
}();

/// J W⁻¹ of the straight element; what the edges' offsets from the middles of their chords add is
/// offset ⊗ 4 (ξ_j ∇ξ_i + ξ_i ∇ξ_j).
template <int D>
[[nodiscard]] constexpr Mat<D> straight_jacobian(const QuadraticNodes<D>& nodes) {
    Mat<D> a;
    for (int i = 1; i <= D; ++i)
        for (int k = 0; k < D; ++k) a.column[k] += regular_gradients<D>[i][k] * (nodes[i] - nodes[0]);
    return a;
}
template <int D>
[[nodiscard]] constexpr Vec<D> offset_of(const QuadraticNodes<D>& nodes, int edge) {
    const auto [i, j] = local_edges<D>[edge];
    return nodes[D + 1 + edge] - midpoint(nodes[i], nodes[j]);
}
template <int D>
[[nodiscard]] constexpr Mat<D> regular_jacobian(const QuadraticNodes<D>& nodes, const Barycentric<D>& xi) {
    Mat<D> a = straight_jacobian<D>(nodes);
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        const auto [i, j] = local_edges<D>[e];
        const Vec<D> slope = 4.0 * (xi[j] * regular_gradients<D>[i] + xi[i] * regular_gradients<D>[j]);
        for (int k = 0; k < D; ++k) a.column[k] += slope[k] * offset_of<D>(nodes, e);
    }
    return a;
}

/// log M less what scales M: its trace is 0.
template <int D>
[[nodiscard]] inline Sym<D> shape_of_log(const LogMetric<D>& log_metric) {
    Sym<D> s = log_metric.l;
    const double mean = trace(s) / D;
    for (int i = 0; i < D; ++i) s(i, i) -= mean;
    return s;
}
template <int D>
[[nodiscard]] inline Sym<D> shape_between(const VertexLogMetrics<D>& vertices, const Barycentric<D>& xi) {
    Sym<D> s;
    for (int i = 0; i <= D; ++i) s += xi[i] * vertices[i].l;
    return shape_of_log<D>({s});
}

}  // namespace camber
