module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
export module camber.metric:unit_mesh;
import camber.core;
import camber.bezier;
import :spd;

/// How near to unit the edges and elements of a straight mesh are, in a metric that is known at its vertices.
export namespace camber {

/// The edges of a unit mesh are between 1/√2 and √2.
inline constexpr double shortest_unit_edge = 0.70710678118654752;
inline constexpr double longest_unit_edge = 1.4142135623730951;

/// A metric ready to measure with: M = rowsᵀ rows, rows sqrt(λ_i) r_iᵀ, so that lengths keep their digits at any
/// anisotropy (see SpectralMetric).
template <int D>
struct MeasuringMetric {
    std::array<Vec<D>, D> rows{};
    Vec<D> log_sizes;         ///< eigenvalues of log M, rising
    double density_root = 0;  ///< (sqrt(det M))^(1/(D + 1)): their product over an element is the volume's factor

    MeasuringMetric() = default;
    explicit MeasuringMetric(const LogMetric<D>& log_metric) {
        const EigenSystem<D> e = eigen_system(log_metric.l);
        double trace = 0;
        for (int i = 0; i < D; ++i) {
            rows[i] = exp(e.values[i] / 2) * e.vectors.column[i];
            trace += e.values[i];
        }
        density_root = exp(trace / (2 * (D + 1)));
        log_sizes = e.values;
        std::ranges::sort(log_sizes.c);
    }
    /// vᵀ M v.
    [[nodiscard]] double length_squared(const Vec<D>& v) const {
        double sum = 0;
        for (const Vec<D>& row : rows) {
            const double w = dot(row, v);
            sum += w * w;
        }
        return sum;
    }
    friend bool operator==(const MeasuringMetric&, const MeasuringMetric&) = default;
};

/// The length of a straight edge whose ends have lengths a and b of it: ∫ a^(1−t) b^t dt = (a − b)/ln(a/b), sizes
/// between the ends being geometric means (Alauzet).
[[nodiscard]] inline double logarithmic_mean(double a, double b) {
    const double sum = a + b;
    if (!(sum > 0)) return 0;
    const double d = (a - b) / sum;
    // (a + b)/2 · d/artanh d, with its series where that cancels.
    if (std::abs(d) < 1e-3) return sum / 2 * (1 - d * d / 3);
    return (a - b) / log(a / b);
}
template <int D>
[[nodiscard]] double edge_length(const MeasuringMetric<D>& from, const MeasuringMetric<D>& to, const Vec<D>& edge) {
    return logarithmic_mean(std::sqrt(from.length_squared(edge)), std::sqrt(to.length_squared(edge)));
}

/// How far an element is from the regular simplex in the metric, with the sign of its volume: the power D/2 of
/// metric_quality, which needs no root of the volume: 36 √12 V/(Σ l²)^(3/2), in 2D 4 √3 A / Σ l². V is the volume by
/// the geometric mean of the vertices' densities, l² of an edge the mean of its ends'; in a constant metric both are
/// exact.
template <int D>
[[nodiscard]] double metric_shape(const std::array<Vec<D>, D + 1>& corners,
                                  const std::array<const MeasuringMetric<D>*, D + 1>& metrics) {
    Mat<D> sides;
    for (int i = 0; i < D; ++i) sides.column[i] = corners[i + 1] - corners[0];
    double density = 1;
    for (const auto* m : metrics) density *= m->density_root;
    double squares = 0;
    for (const auto& [a, b] : local_edges<D>) {
        const Vec<D> edge = corners[b] - corners[a];
        squares += metrics[a]->length_squared(edge) + metrics[b]->length_squared(edge);
    }
    squares /= 2;
    if (!(squares > 0)) return 0;
    const double measure = det(sides) * density;
    if constexpr (D == 2) return 2 * std::sqrt(3.0) * measure / squares;
    // 12 (3V)^(2/3) to the power 3/2, V a sixth of the determinant.
    return 6 * std::sqrt(12.0) * measure / (squares * std::sqrt(squares));
}

/// Mean ratio in the metric, with the sign of the volume: 12 (3V)^(2/3) / Σ l², in 2D 4 √3 A / Σ l²; 1 for the regular
/// simplex. See metric_shape.
[[nodiscard]] inline double quality_of_shape(double shape, int dimension) {
    return dimension == 2 ? shape : std::copysign(cbrt(shape * shape), shape);
}
[[nodiscard]] inline double shape_of_quality(double quality, int dimension) {
    return dimension == 2 ? quality : std::copysign(std::abs(quality) * std::sqrt(std::abs(quality)), quality);
}
/// Of a triangle in space, in the metric on its plane, as metric_shape of a tetrahedron: the power 3/2 of its mean
/// ratio 4 √3 A / Σ l²; the area is the geometric mean of those in the metrics of its vertices.
[[nodiscard]] inline double triangle_shape(const std::array<Vec<3>, 3>& corners,
                                           const std::array<const MeasuringMetric<3>*, 3>& metrics) {
    double areas = 1, squares = 0;
    for (const auto* m : metrics) {
        std::array<Vec<3>, 2> sides{};
        for (int i = 0; i < 2; ++i)
            for (int k = 0; k < 3; ++k) sides[i][k] = dot(m->rows[k], corners[i + 1] - corners[0]);
        areas *= norm(cross(sides[0], sides[1]));
    }
    for (const auto& [a, b] : local_edges<2>) {
        const Vec<3> edge = corners[b] - corners[a];
        squares += metrics[a]->length_squared(edge) + metrics[b]->length_squared(edge);
    }
    squares /= 2;
    return squares > 0 ? shape_of_quality(2 * std::sqrt(3.0) * cbrt(areas) / squares, 3) : 0;
}
template <int D>
[[nodiscard]] double metric_quality(const std::array<Vec<D>, D + 1>& corners,
                                    const std::array<const MeasuringMetric<D>*, D + 1>& metrics) {
    return quality_of_shape(metric_shape<D>(corners, metrics), D);
}

/// A metric at an end of an edge, as it is given and ready to measure with.
template <int D>
struct BentEnd {
    const LogMetric<D>& log_metric;
    const MeasuringMetric<D>& measure;
};

/// The mean of two metrics whose axes may be turned against each other by an angle α: axes of the mean of both logs,
/// and of the log sizes the mean of both in their order. The mean of the logs alone damps unlike axes by cos α. Where
/// that is much (α above 0.6, or axes that are nearly alike and have no order), it is the mean of the logs again.
template <int D>
[[nodiscard]] EigenSystem<D> frame_mean(const LogMetric<D>& a, const Vec<D>& log_sizes_a, const LogMetric<D>& b,
                                        const Vec<D>& log_sizes_b) {
    EigenSystem<D> e = eigen_system(0.5 * (a.l + b.l));
    const auto unlikeness = [](const Vec<D>& sizes) {
        double sum = 0, squares = 0;
        for (const double x : sizes.c) sum += x, squares += x * x;
        return std::sqrt(std::max(squares - sum * sum / D, 0.0));
    };
    const double most = (unlikeness(log_sizes_a) + unlikeness(log_sizes_b)) / 2;
    if (!(most > 0)) return e;
    const double share = std::clamp((unlikeness(e.values) / most - 0.5) / 0.3, 0.0, 1.0);
    std::array<int, D> order{};
    for (int i = 0; i < D; ++i) order[i] = i;
    std::ranges::sort(order, {}, [&](int i) { return e.values[i]; });
    for (int i = 0; i < D; ++i)
        e.values[order[i]] += share * ((log_sizes_a[i] + log_sizes_b[i]) / 2 - e.values[order[i]]);
    return e;
}

/// The length of an edge of degree 2 whose node is `offset` from the middle of its chord, in a metric that is known at
/// its ends, where its axes may be turned against each other: by the speeds l_a = |e + 4d|_a, l_b = |e − 4d|_b at the
/// ends and l_m = |e|_m in the middle,
///
///   (l_a − l_b)/ln(l_a/l_b) + ⅔ (l_m − sqrt(l_a l_b)).
///
/// The first part is the length of a straight edge along common axes, for which l_m = sqrt(l_a l_b); the second what
/// Simpson's rule makes of a middle that is another.
template <int D>
[[nodiscard]] double bent_length(const BentEnd<D>& a, const BentEnd<D>& b, const Vec<D>& chord, const Vec<D>& offset) {
    const double l_a = std::sqrt(a.measure.length_squared(chord + 4.0 * offset));
    const double l_b = std::sqrt(b.measure.length_squared(chord - 4.0 * offset));
    const EigenSystem<D> middle = frame_mean(a.log_metric, a.measure.log_sizes, b.log_metric, b.measure.log_sizes);
    double l_m = 0;
    for (int i = 0; i < D; ++i) {
        const double along = dot(middle.vectors.column[i], chord);
        l_m += exp(middle.values[i]) * along * along;
    }
    l_m = std::sqrt(l_m);
    return logarithmic_mean(l_a, l_b) + 2.0 / 3.0 * (l_m - std::sqrt(l_a * l_b));
}

}  // namespace camber

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

export namespace camber {

/// What is known of the least 1/η (see above) of an element: it is at least `bound` (to rounding), and 1/η is
/// `attained` at a point that was looked at. The bound is −1, below which no quality is, where det J is not known to
/// be positive.
struct LeastQuality {
    double bound = -1, attained = 1;
    friend bool operator==(const LeastQuality&, const LeastQuality&) = default;
};

/// How long to look: until the bound is `enough`, or `share` of what is attained, or after so many bisections.
struct BoundEffort {
    double enough = 1;
    double share = 0.95;
    int bisections = 64;
};
inline constexpr int max_bisections = 128;

/// Bounds of det A by its Bézier coefficients and of tr(AᵀA) by its own, with the range of the metric, on parts of the
/// element: the part of the lowest bound is bisected again and again, along the edge on which A and M change most. The
/// bound converges to the least quality with the size of the parts. On a straight element in a constant metric it is
/// the quality at once. Bisections beyond `max_bisections` are not made.
template <int D>
[[nodiscard]] LeastQuality bound_quality(const QuadraticNodes<D>& nodes, const VertexLogMetrics<D>& vertices,
                                         const BoundEffort& effort = {});

}  // namespace camber

/// How near to unit the curves and the curved elements of a mesh of degree 2 are, in a metric that is known at its
/// vertices.
export namespace camber {

/// Element e by its nodes, and the metric at its vertices.
template <int D>
struct ElementInMetric {
    QuadraticNodes<D> nodes;
    VertexLogMetrics<D> metrics;
};
template <int D>
[[nodiscard]] inline ElementInMetric<D> element_in_metric(const QuadraticMesh<D>& mesh,
                                                          std::span<const LogMetric<D>> log_metrics, ElementId e) {
    ElementInMetric<D> element;
    const auto& vertices = mesh.linear.elements.vertices[e];
    for (int i = 0; i <= D; ++i) {
        element.nodes[i] = mesh.linear.points[vertices[i]];
        element.metrics[i] = log_metrics[vertices[i].index()];
    }
    for (int k = 0; k < edges_per_simplex<D>; ++k)
        element.nodes[D + 1 + k] = mesh.mid_nodes[mesh.edges.of_elements[e][k]].point;
    return element;
}

/// Lengths along the edges, one each (bent_length). Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<Buffer<double>> bent_lengths(const QuadraticMesh<D>& mesh,
                                                   std::span<const LogMetric<D>> log_metrics,
                                                   const Execution& execution);

/// Lengths along the edges, one each; mean qualities (CurvedQuality) of the elements and bounds of their least.
struct CurvedMeasures {
    Buffer<double> lengths, qualities;
    Buffer<LeastQuality> least;
};

/// The bounds are refined where they might be the mesh's lowest: by `bisections` at most, until they are above the
/// lowest quality attained anywhere or near their own. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<CurvedMeasures> measure_curved(const QuadraticMesh<D>& mesh,
                                                     std::span<const LogMetric<D>> log_metrics, int bisections,
                                                     const Execution& execution);

}  // namespace camber
