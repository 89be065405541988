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

/// Edge lengths and qualities of straight meshes with metrics at the vertices.
export namespace camber {

/// In a unit mesh, edge lengths in the metric are between 1/√2 and √2.
inline constexpr double shortest_unit_edge = 0.70710678118654752;
inline constexpr double longest_unit_edge = 1.4142135623730951;

/// Metric M = rowsᵀ rows for measuring lengths. Its rows are sqrt(λ_i) r_iᵀ for eigenvalues λ_i and eigenvectors r_i.
template <int D>
struct MeasuringMetric {
    std::array<Vec<D>, D> rows{};
    Vec<D> log_sizes;         ///< eigenvalues of log M, ascending
    double density_root = 0;  ///< (sqrt(det M))^(1/(D + 1)); the product over the vertices of an element is the
                              ///< element's mean density

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

/// Length of a straight edge whose lengths in the metrics of its two ends are a and b: ∫ a^(1−t) b^t dt = (a −
/// b)/ln(a/b). Sizes vary geometrically along the edge (Alauzet).
[[nodiscard]] inline double logarithmic_mean(double a, double b) {
    const double sum = a + b;
    if (!(sum > 0)) return 0;
    const double d = (a - b) / sum;
    // The mean is (a + b)/2 · d/artanh d. For small d the series avoids cancellation.
    if (std::abs(d) < 1e-3) return sum / 2 * (1 - d * d / 3);
    return (a - b) / log(a / b);
}
template <int D>
[[nodiscard]] double edge_length(const MeasuringMetric<D>& from, const MeasuringMetric<D>& to, const Vec<D>& edge) {
    return logarithmic_mean(std::sqrt(from.length_squared(edge)), std::sqrt(to.length_squared(edge)));
}

/// Shape of a simplex: the mean ratio to the power D/2, with the sign of the volume. The shape is 36 √12 V/(Σ l²)^(3/2)
/// in 3D and 4 √3 A/Σ l² in 2D. V and A are volume and area times the geometric mean of sqrt(det M) at the vertices. l²
/// is the mean squared length of an edge in the metrics of its two ends. In a constant metric the shape is exact.
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
    // This is (12 (3V)^(2/3)/Σ l²)^(3/2), where V is a sixth of `measure`.
    return 6 * std::sqrt(12.0) * measure / (squares * std::sqrt(squares));
}

/// Returns the mean ratio from a shape: 1 for the regular simplex, negative for inverted ones.
[[nodiscard]] inline double quality_of_shape(double shape, int dimension) {
    return dimension == 2 ? shape : std::copysign(cbrt(shape * shape), shape);
}
[[nodiscard]] inline double shape_of_quality(double quality, int dimension) {
    return dimension == 2 ? quality : std::copysign(std::abs(quality) * std::sqrt(std::abs(quality)), quality);
}
/// Shape of a triangle in space, comparable with that of tetrahedra: (4 √3 A/Σ l²)^(3/2), with l² as in `metric_shape`.
/// A is the geometric mean of the areas in the vertex metrics.
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

template <int D>
struct EdgeEndMetric {
    const LogMetric<D>& log_metric;
    const MeasuringMetric<D>& measure;
};

/// Mean of two metrics with different axes (docs/algorithms/metric-interpolation.md). It has the axes of the mean of
/// their logs, and the means of their sorted eigenvalues `log_sizes_a` and `log_sizes_b`. For angles above 0.6 radians,
/// and for nearly equal sizes, which have no order, it becomes the mean of the logs.
template <int D>
[[nodiscard]] EigenSystem<D> frame_mean(const LogMetric<D>& a, const Vec<D>& log_sizes_a, const LogMetric<D>& b,
                                        const Vec<D>& log_sizes_b) {
    EigenSystem<D> e = eigen_system(0.5 * (a.l + b.l));
    const auto anisotropy_spread = [](const Vec<D>& sizes) {
        double sum = 0, squares = 0;
        for (const double x : sizes.c) sum += x, squares += x * x;
        return std::sqrt(std::max(squares - sum * sum / D, 0.0));
    };
    const double most = (anisotropy_spread(log_sizes_a) + anisotropy_spread(log_sizes_b)) / 2;
    if (!(most > 0)) return e;
    const double share = std::clamp((anisotropy_spread(e.values) / most - 0.5) / 0.3, 0.0, 1.0);
    std::array<int, D> order{};
    for (int i = 0; i < D; ++i) order[i] = i;
    std::ranges::sort(order, {}, [&](int i) { return e.values[i]; });
    for (int i = 0; i < D; ++i)
        e.values[order[i]] += share * ((log_sizes_a[i] + log_sizes_b[i]) / 2 - e.values[order[i]]);
    return e;
}

/// Length of a quadratic edge from the metrics at its ends, in closed form (docs/algorithms/cavity-operator.md).
/// `offset` is the vector from the chord's middle to the edge node. For straight edges between metrics with common
/// axes, the length is the `logarithmic_mean`.
template <int D>
[[nodiscard]] double quadratic_edge_length(const EdgeEndMetric<D>& a, const EdgeEndMetric<D>& b, const Vec<D>& chord,
                                           const Vec<D>& offset) {
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

/// Distortion of quadratic elements in a metric M, at a point and as a mean with its gradient
/// (docs/algorithms/distortion.md). A = M^{1/2} J W⁻¹, with the Jacobian J of the element and W of the regular simplex.
/// Then
///     distortion η = tr(AᵀA) / (D |det A|^{2/D}) ≥ 1, quality 1/η with the sign of det J.
/// For straight elements in a constant metric the quality is `metric_quality`.
export namespace camber {

/// Lagrange nodes of a quadratic simplex: the vertices, then the edge nodes in the order of `local_edges`.
template <int D>
using QuadraticNodes = std::array<Vec<D>, quadratic_nodes<D>>;
template <int D>
using VertexLogMetrics = std::array<LogMetric<D>, D + 1>;

/// Scaled metric M/det(M)^{1/D} = rootᵀ root at the points of `distortion_rule`. The rows of `root` are sqrt(λ_i) r_iᵀ
/// for its eigenvalues λ_i and eigenvectors r_i.
template <int D>
struct ElementMetric {
    std::array<std::array<Pack, D>, D> root{};  ///< root[i][c] is coordinate c of row i, one point per lane
};
template <int D>
[[nodiscard]] ElementMetric<D> element_metric(const VertexLogMetrics<D>& vertices,
                                              Instructions set = widest_instructions());

/// Quality at the points of `distortion_rule`: `least` is its minimum, and `mean` is 1 over the mean of η. The mean is
/// negative if det J is negative at all points, and 0 if det J has no common sign. Neither is ever NaN.
struct CurvedQuality {
    double mean = 0, least = 0;
    friend bool operator==(const CurvedQuality&, const CurvedQuality&) = default;
};
template <int D>
[[nodiscard]] CurvedQuality curved_quality(const QuadraticNodes<D>& nodes, const ElementMetric<D>& metric,
                                           Instructions set = widest_instructions());

/// Mean quality, and its derivatives by the positions of the nodes with fixed metrics. The derivatives are zero if the
/// mean is 0.
template <int D>
struct CurvedQualityGradient {
    double mean = 0;
    QuadraticNodes<D> by_node{};
};
template <int D>
[[nodiscard]] CurvedQualityGradient<D> curved_quality_gradient(const QuadraticNodes<D>& nodes,
                                                               const ElementMetric<D>& metric,
                                                               Instructions set = widest_instructions());

/// Returns the quality at one point; 0 if it is not finite.
template <int D>
[[nodiscard]] double quality_at(const QuadraticNodes<D>& nodes, const VertexLogMetrics<D>& vertices,
                                const Barycentric<D>& xi);

/// Quadrature rule with positive weights, exact to degree 3, one point per lane (docs/algorithms/distortion.md). The
/// rule for triangles has seven points; the weight of lane eight is 0.
template <int D>
struct DistortionRule {
    std::array<std::array<double, pack_size>, D + 1> xi{};
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

/// Returns J W⁻¹ of the straight element. In a curved element, each edge i–j adds its offset ⊗ 4 (ξ_j ∇ξ_i + ξ_i ∇ξ_j),
/// with the gradients in the regular simplex.
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

/// Bounds of the minimum quality of an element. This minimum is at least `bound` (up to rounding), and at most
/// `attained`, a sampled value. If det J is not proven positive, `bound` is −1, below any quality.
struct QualityBound {
    double bound = -1, attained = 1;
    friend bool operator==(const QualityBound&, const QualityBound&) = default;
};

/// Limits of the bisection. It stops when the bound reaches `enough`, or the fraction `share` of the attained quality,
/// or after `bisections` steps.
struct BoundEffort {
    double enough = 1;
    double share = 0.95;
    int bisections = 64;
};
inline constexpr int max_bisections = 128;

/// Bounds the minimum quality of an element by Bézier coefficients (docs/algorithms/distortion.md). The part with the
/// lowest bound is bisected, at most `max_bisections` times. The bound converges to the minimum.
template <int D>
[[nodiscard]] QualityBound bound_quality(const QuadraticNodes<D>& nodes, const VertexLogMetrics<D>& vertices,
                                         const BoundEffort& effort = {});

}  // namespace camber

export namespace camber {

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

/// Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<Buffer<double>> quadratic_edge_lengths(const QuadraticMesh<D>& mesh,
                                                             std::span<const LogMetric<D>> log_metrics,
                                                             const Execution& execution);

struct CurvedMeasures {
    Buffer<double> lengths, qualities;
    Buffer<QualityBound> least;
};

/// Measures all edges and elements. Let q be the lowest attained quality of the mesh. Each bound below q is refined, by
/// at most `bisections`, until it exceeds q or nearly reaches the attained quality of its element. Errors: stopped,
/// memory.
template <int D>
[[nodiscard]] Outcome<CurvedMeasures> measure_curved(const QuadraticMesh<D>& mesh,
                                                     std::span<const LogMetric<D>> log_metrics, int bisections,
                                                     const Execution& execution);

}  // namespace camber
