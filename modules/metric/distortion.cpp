module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <span>
#include <utility>
module camber.metric;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

using Lanes = std::array<double, pack_size>;

[[gnu::always_inline]] inline Pack loaded(const Lanes& lanes) {
    Pack p;
    std::memcpy(&p, lanes.data(), sizeof p);
    return p;
}
[[gnu::always_inline]] inline Lanes stored(Pack p) {
    Lanes lanes;
    std::memcpy(lanes.data(), &p, sizeof p);
    return lanes;
}
double sum(const Lanes& x) { return ((x[0] + x[1]) + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7])); }

/// `slopes<D>[e][k]`: component k of the gradient 4 (ξ_j ∇ξ_i + ξ_i ∇ξ_j) of the shape function of edge e = i–j, at the
/// points of `distortion_rule`.
template <int D>
constexpr auto slopes = [] {
    std::array<std::array<Lanes, D>, edges_per_simplex<D>> table{};
    const auto& xi = distortion_rule<D>.xi;
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        const auto [i, j] = local_edges<D>[e];
        for (int k = 0; k < D; ++k)
            for (int q = 0; q < pack_size; ++q)
                table[e][k][q] = 4 * (xi[j][q] * regular_gradients<D>[i][k] + xi[i][q] * regular_gradients<D>[j][k]);
    }
    return table;
}();

template <int D>
struct Sampled {
    MatPack<D> a;
    Pack det{}, square{}, distortion{};
};

template <int D>
[[gnu::always_inline]] inline Sampled<D> sampled(const QuadraticNodes<D>& nodes, const ElementMetric<D>& metric) {
    const Mat<D> straight = straight_jacobian<D>(nodes);
    MatPack<D> j;
    for (int k = 0; k < D; ++k)
        for (int c = 0; c < D; ++c) j(c, k) = packed(straight(c, k));
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        const Vec<D> offset = offset_of<D>(nodes, e);
        for (int k = 0; k < D; ++k) {
            const Pack slope = loaded(slopes<D>[e][k]);
            for (int c = 0; c < D; ++c) j(c, k) += offset[c] * slope;
        }
    }
    Sampled<D> s;
    s.square = packed(0);
    for (int i = 0; i < D; ++i)
        for (int k = 0; k < D; ++k) {
            Pack x = metric.root[i][0] * j(0, k);
            for (int c = 1; c < D; ++c) x += metric.root[i][c] * j(c, k);
            s.a(i, k) = x;
            s.square += x * x;
        }
    s.det = det(s.a);
    const Pack size = abs(s.det);
    if constexpr (D == 2)
        s.distortion = s.square / (2 * size);
    else
        s.distortion = s.square / (3 * exp(log(size) * (2.0 / 3)));
    return s;
}

struct Mean {
    double quality = 0, distortion = 0;
};
/// Weight times distortion η at each quadrature point (one point per lane). `is_positive` or `is_negative` is true if
/// det J has this sign at all points.
struct WeightedDistortion {
    Lanes weighted{};
    bool is_positive = false, is_negative = false;
};
template <int D>
[[gnu::always_inline]] inline WeightedDistortion weighted_distortion(const Sampled<D>& s) {
    return {stored(loaded(distortion_rule<D>.weights) * s.distortion), !any(!(s.det > 0)), !any(!(s.det < 0))};
}
Mean mean_of(const WeightedDistortion& of) {
    if (!of.is_positive && !of.is_negative) return {};
    const double mean = sum(of.weighted);
    if (!(mean >= 0.5 && mean <= std::numeric_limits<double>::max())) return {};
    return {(of.is_positive ? 1 : -1) / mean, mean};
}

}  // namespace

template <int D>
ElementMetric<D> element_metric(const VertexLogMetrics<D>& vertices, Instructions set) {
    std::array<Sym<D>, D + 1> shapes;
    for (int i = 0; i <= D; ++i) shapes[i] = shape_of_log(vertices[i]);
    ElementMetric<D> out;
    with_instructions(set, [&]() __attribute__((always_inline)) {
        SymPack<D> log_metric;
        for (int k = 0; k < sym_size<D>; ++k) {
            log_metric.c[k] = shapes[0].c[k] * loaded(distortion_rule<D>.xi[0]);
            for (int i = 1; i <= D; ++i) log_metric.c[k] += shapes[i].c[k] * loaded(distortion_rule<D>.xi[i]);
        }
        const EigenPack<D> e = eigen_system<D>(log_metric);
        for (int i = 0; i < D; ++i) {
            const Pack root = exp(e.values[i] / 2);
            for (int c = 0; c < D; ++c) out.root[i][c] = root * e.vectors(c, i);
        }
    });
    return out;
}

template <int D>
CurvedQuality curved_quality(const QuadraticNodes<D>& nodes, const ElementMetric<D>& metric, Instructions set) {
    WeightedDistortion of;
    Lanes qualities;
    with_instructions(set, [&]() __attribute__((always_inline)) {
        const Sampled<D> s = sampled<D>(nodes, metric);
        of = weighted_distortion(s);
        qualities = stored(select(s.distortion >= 0.5, copysign(1 / s.distortion, s.det), packed(0)));
    });
    return {mean_of(of).quality, std::min(1.0, *std::ranges::min_element(qualities))};
}

template <int D>
CurvedQualityGradient<D> curved_quality_gradient(const QuadraticNodes<D>& nodes, const ElementMetric<D>& metric,
                                                 Instructions set) {
    WeightedDistortion of;
    std::array<std::array<Lanes, D>, D> by_straight{};  // [c][k]: derivative of the weighted η by entry (c, k) of J
                                                        // W⁻¹, one point per lane
    std::array<std::array<Lanes, D>, edges_per_simplex<D>> by_offset{};  // [e][c]: derivative of the weighted η by
                                                                         // coordinate c of the offset of edge e
    with_instructions(set, [&]() __attribute__((always_inline)) {
        const Sampled<D> s = sampled<D>(nodes, metric);
        of = weighted_distortion(s);
        // With A = `metric.root` J W⁻¹: `by_a` is ∂η/∂A = 2 η (A / tr(AᵀA) − A⁻ᵀ/D), times the weight of the point.
        // Then ∂η/∂(J W⁻¹) = rootᵀ ∂η/∂A.
        const Pack factor = 2 * loaded(distortion_rule<D>.weights) * s.distortion;
        const Pack of_square = factor / s.square;
        const Pack of_inverse = factor / (D * s.det);
        MatPack<D> by_a;
        for (int i = 0; i < D; ++i)
            for (int k = 0; k < D; ++k) {
                Pack cofactor;
                if constexpr (D == 2) {
                    cofactor = i == k ? s.a(1 - i, 1 - k) : -s.a(1 - i, 1 - k);
                } else {
                    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
                    cofactor = s.a(i1, k1) * s.a(i2, k2) - s.a(i1, k2) * s.a(i2, k1);
                }
                by_a(i, k) = of_square * s.a(i, k) - of_inverse * cofactor;
            }
        MatPack<D> by_j;
        for (int c = 0; c < D; ++c)
            for (int k = 0; k < D; ++k) {
                Pack x = metric.root[0][c] * by_a(0, k);
                for (int i = 1; i < D; ++i) x += metric.root[i][c] * by_a(i, k);
                by_j(c, k) = x;
                by_straight[c][k] = stored(x);
            }
        for (int e = 0; e < edges_per_simplex<D>; ++e)
            for (int c = 0; c < D; ++c) {
                Pack x = by_j(c, 0) * loaded(slopes<D>[e][0]);
                for (int k = 1; k < D; ++k) x += by_j(c, k) * loaded(slopes<D>[e][k]);
                by_offset[e][c] = stored(x);
            }
    });
    const Mean mean = mean_of(of);
    CurvedQualityGradient<D> out{mean.quality, {}};
    if (mean.quality == 0) return out;
    const double scale = -mean.quality / mean.distortion;  // derivative of the mean quality ±1/η̄ by the mean η̄ of the
                                                           // distortion
    for (int c = 0; c < D; ++c)
        for (int k = 0; k < D; ++k) {
            const double x = scale * sum(by_straight[c][k]);
            for (int i = 0; i <= D; ++i) out.by_node[i][c] += x * regular_gradients<D>[i][k];
        }
    for (int e = 0; e < edges_per_simplex<D>; ++e)
        for (int c = 0; c < D; ++c) {
            const double x = scale * sum(by_offset[e][c]);
            out.by_node[D + 1 + e][c] = x;
            for (const int end : local_edges<D>[e]) out.by_node[end][c] -= x / 2;
        }
    return out;
}

template <int D>
double quality_at(const QuadraticNodes<D>& nodes, const VertexLogMetrics<D>& vertices, const Barycentric<D>& xi) {
    const EigenSystem<D> e = eigen_system(shape_between<D>(vertices, xi));
    const Mat<D> j = regular_jacobian<D>(nodes, xi);
    Mat<D> a;
    double square = 0;
    for (int i = 0; i < D; ++i)
        for (int k = 0; k < D; ++k) {
            a(i, k) = exp(e.values[i] / 2) * dot(e.vectors.column[i], j.column[k]);
            square += a(i, k) * a(i, k);
        }
    const double determinant = det(a);
    const double size = D == 2 ? std::abs(determinant) : cbrt(determinant * determinant);
    const double quality = std::copysign(D * size / square, determinant);
    return std::isfinite(quality) ? quality : 0;
}

namespace {

/// Matrix exponential by scaling and squaring. Since the entries of p are nonnegative, no terms cancel and each entry
/// of the result is accurate.
template <int D>
Mat<D> exponential_of_nonnegative(Mat<D> p) {
    double largest = 0;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) largest = std::max(largest, p(i, j));
    int squarings = 0;
    for (; largest > 0.125 && squarings < 20; largest /= 2) ++squarings;
    for (Vec<D>& column : p.column) column *= std::ldexp(1.0, -squarings);
    Mat<D> sum = Mat<D>::identity();
    Mat<D> term = sum;
    for (int n = 1; n <= 14; ++n) {
        term = term * p;
        for (int j = 0; j < D; ++j) sum.column[j] += term.column[j] *= 1.0 / n;
    }
    for (int i = 0; i < squarings; ++i) sum = sum * sum;
    return sum;
}

/// Part of an element. Jacobians are expressed in a frame T in which the metric M_mid at the centre of the part is the
/// identity: M_mid = Tᵀ T.
template <int D>
struct FramedPart {
    std::array<Mat<D>, D + 1> jacobians;  ///< T J W⁻¹ at the corners of the part; linear in between
    std::array<Sym<D>, D + 1> logs;       ///< log M at the corners, in the basis of the eigenvectors of M_mid
    Vec<D> log_values;
};
template <int D>
using Corners = std::array<Barycentric<D>, D + 1>;

template <int D>
FramedPart<D> framed_part(const QuadraticNodes<D>& nodes, const VertexLogMetrics<D>& vertices,
                          const Corners<D>& corners) {
    Barycentric<D> middle{};
    for (const auto& corner : corners)
        for (int i = 0; i <= D; ++i) middle[i] += corner[i] / (D + 1);
    const EigenSystem<D> e = eigen_system(shape_between<D>(vertices, middle));
    FramedPart<D> part;
    part.log_values = e.values;
    const Mat<D> axes = transposed(e.vectors);
    for (int i = 0; i <= D; ++i) {
        part.jacobians[i] = axes * regular_jacobian<D>(nodes, corners[i]);
        for (Vec<D>& column : part.jacobians[i].column)
            for (int a = 0; a < D; ++a) column[a] *= exp(e.values[a] / 2);
        part.logs[i] = congruence(axes, shape_between<D>(vertices, corners[i]));
    }
    return part;
}

/// Returns upper bounds of the absolute entries of M in the frame T of `part`, from log M at its corners
/// (docs/algorithms/distortion.md).
template <int D>
Sym<D> largest_metric(const FramedPart<D>& part) {
    Mat<D> p;
    for (int a = 0; a < D; ++a)
        for (int b = 0; b < D; ++b) {
            p(a, b) = a == b ? part.logs[0](a, a) : 0;
            for (const Sym<D>& l : part.logs) p(a, b) = std::max(p(a, b), a == b ? l(a, a) : std::abs(l(a, b)));
        }
    double least = p(0, 0);
    for (int a = 1; a < D; ++a) least = std::min(least, p(a, a));
    for (int a = 0; a < D; ++a) p(a, a) -= least;
    const Mat<D> exponential = exponential_of_nonnegative<D>(p);
    Sym<D> m;
    for (int a = 0; a < D; ++a)
        for (int b = 0; b <= a; ++b)
            m(a, b) = exponential(a, b) * exp(least - (part.log_values[a] + part.log_values[b]) / 2);
    return m;
}

/// Returns an upper bound of tr(AᵀA) = Σ_ab M_ab S_ab, with S = (J W⁻¹)(J W⁻¹)ᵀ: the largest Bézier coefficient of this
/// sum. `metric` bounds M.
template <int D>
double largest_square(const FramedPart<D>& part, const Sym<D>& metric) {
    double largest = 0;
    for (int i = 0; i <= D; ++i)
        for (int j = 0; j <= i; ++j) {
            const Mat<D>& x = part.jacobians[i];
            const Mat<D>& y = part.jacobians[j];
            double square = 0;
            for (int a = 0; a < D; ++a)
                for (int b = 0; b <= a; ++b) {
                    double s = 0;
                    for (int k = 0; k < D; ++k) s += (x(a, k) * y(b, k) + x(b, k) * y(a, k)) / 2;
                    // S_aa ≥ 0 everywhere, but its Bézier coefficients may be negative, so they are not replaced by
                    // their absolute values.
                    square += metric(a, b) * (a == b ? s : 2 * std::abs(s));
                }
            largest = std::max(largest, square);
        }
    return largest;
}

/// Returns the smallest Bézier coefficient of det(T J W⁻¹): a mean of determinants with columns from different corners.
template <int D>
double min_determinant(const FramedPart<D>& part) {
    const auto& m = part.jacobians;
    double least = det(m[0]);
    if constexpr (D == 2) {
        for (int i = 0; i <= 2; ++i)
            for (int j = 0; j <= i; ++j)
                least =
                    std::min(least, (det(m[i].column[0], m[j].column[1]) + det(m[j].column[0], m[i].column[1])) / 2);
    } else {
        for (int i = 0; i <= 3; ++i)
            for (int j = 0; j <= i; ++j)
                for (int k = 0; k <= j; ++k) {
                    const auto term = [&](int a, int b, int c) {
                        return det(m[a].column[0], m[b].column[1], m[c].column[2]);
                    };
                    least = std::min(least, (term(i, j, k) + term(j, k, i) + term(k, i, j) + term(i, k, j) +
                                             term(k, j, i) + term(j, i, k)) /
                                                6);
                }
    }
    return least;
}

template <int D>
double change_along(const FramedPart<D>& part, int i, int j) {
    double of_a = 0, size = 0, of_m = 0;
    for (int a = 0; a < D; ++a)
        for (int b = 0; b < D; ++b) {
            const double x = part.jacobians[i](a, b);
            const double y = part.jacobians[j](a, b);
            of_a += (x - y) * (x - y);
            size += x * x + y * y;
            // Entry (a, b) of M changes by the derivative of exp (see `exp_derivative_in_frame`).
            const double half = (part.log_values[a] - part.log_values[b]) / 2;
            const double change =
                (part.logs[i](a, b) - part.logs[j](a, b)) * (std::abs(half) < 1e-4 ? 1 : sinh(half) / half);
            of_m += change * change;
        }
    return (size > 0 ? of_a / size : 0) + of_m / D;
}
template <int D>
int bent_edge(const FramedPart<D>& part) {
    double largest = -1;
    int bent = 0;
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        const auto [i, j] = local_edges<D>[e];
        const double change = change_along<D>(part, i, j);
        if (change > largest) {
            largest = change;
            bent = e;
        }
    }
    return bent;
}

template <int D>
struct Part {
    Corners<D> corners{};
    double bound = -1;
    int edge = 0;
};

template <int D>
Part<D> bounded(const QuadraticNodes<D>& nodes, const VertexLogMetrics<D>& vertices, const Corners<D>& corners) {
    const FramedPart<D> part = framed_part<D>(nodes, vertices, corners);
    const double least = min_determinant<D>(part);
    const double square = largest_square<D>(part, largest_metric<D>(part));
    const double size = D == 2 ? least : cbrt(least * least);
    const double bound = D * size / square;
    return {corners, least > 0 && bound >= 0 ? bound : -1, bent_edge<D>(part)};
}

}  // namespace

template <int D>
QualityBound bound_quality(const QuadraticNodes<D>& nodes, const VertexLogMetrics<D>& vertices,
                           const BoundEffort& effort) {
    QualityBound found;
    const auto look = [&](const Barycentric<D>& at) {
        found.attained = std::min(found.attained, quality_at<D>(nodes, vertices, at));
    };
    std::array<Part<D>, max_bisections + 1> parts;  // heap; the first part has the lowest bound
    std::size_t n = 0;
    const auto higher = [](const Part<D>& a, const Part<D>& b) { return a.bound > b.bound; };
    const auto add = [&](const Corners<D>& corners) {
        parts[n++] = bounded<D>(nodes, vertices, corners);
        std::push_heap(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(n), higher);
    };
    Corners<D> whole{};
    for (int i = 0; i <= D; ++i) {
        whole[i][i] = 1;
        look(whole[i]);
    }
    add(whole);
    const int most = std::min(effort.bisections, max_bisections);
    for (int i = 0; i < most; ++i) {
        // If 1/η ≤ 0 at a sampled point, more bisections cannot give a positive bound.
        if (found.attained <= 0 || parts[0].bound >= std::min(effort.enough, effort.share * found.attained)) break;
        std::pop_heap(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(n), higher);
        const Part<D> part = parts[--n];
        const auto [a, b] = local_edges<D>[part.edge];
        Barycentric<D> middle;
        for (int k = 0; k <= D; ++k) middle[k] = (part.corners[a][k] + part.corners[b][k]) / 2;
        look(middle);
        for (const int end : {a, b}) {
            Corners<D> corners = part.corners;
            corners[end] = middle;
            add(corners);
        }
    }
    found.bound = std::min(parts[0].bound, found.attained);
    return found;
}

template <int D>
Outcome<Buffer<double>> quadratic_edge_lengths(const QuadraticMesh<D>& mesh, std::span<const LogMetric<D>> log_metrics,
                                               const Execution& execution) {
    const auto metrics = map_each(part_of(execution, 0, 0.5), log_metrics.size(),
                                  [&](std::size_t v) { return MeasuringMetric<D>(log_metrics[v]); });
    if (!metrics) return fail(metrics.error());
    const auto end = [&](VertexId v) { return EdgeEndMetric<D>{log_metrics[v.index()], (*metrics)[v.index()]}; };
    return map_each(part_of(execution, 0.5, 1), mesh.edges.size(), [&](std::size_t e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        const Vec<D>& p = mesh.linear.points[a];
        const Vec<D>& q = mesh.linear.points[b];
        return quadratic_edge_length<D>(end(a), end(b), q - p, mesh.mid_nodes[e].point - midpoint(p, q));
    });
}

template <int D>
Outcome<CurvedMeasures> measure_curved(const QuadraticMesh<D>& mesh, std::span<const LogMetric<D>> log_metrics,
                                       int bisections, const Execution& execution) {
    auto lengths = quadratic_edge_lengths(mesh, log_metrics, part_of(execution, 0, 0.1));
    if (!lengths) return fail(lengths.error());
    const std::size_t n = mesh.linear.elements.size();
    auto qualities = map_each(part_of(execution, 0.1, 0.2), n, [&](std::size_t e) {
        const ElementInMetric<D> element = element_in_metric<D>(mesh, log_metrics, ElementId(e));
        return curved_quality<D>(element.nodes, element_metric<D>(element.metrics));
    });
    if (!qualities) return fail(qualities.error());
    const auto look = [&](std::size_t e, const BoundEffort& effort) {
        const ElementInMetric<D> element = element_in_metric<D>(mesh, log_metrics, ElementId(e));
        QualityBound found = bound_quality<D>(element.nodes, element.metrics, effort);
        found.attained = std::min(found.attained, (*qualities)[e].least);
        found.bound = std::min(found.bound, found.attained);
        return found;
    };
    auto least =
        map_each(part_of(execution, 0.2, 0.5), n, [&](std::size_t e) { return look(e, BoundEffort{.bisections = 0}); });
    if (!least) return fail(least.error());
    double lowest = 1;
    for (const QualityBound& found : *least) lowest = std::min(lowest, found.attained);
    auto refined = each(part_of(execution, 0.5, 1), n, [&](std::size_t e) {
        QualityBound& found = (*least)[e];
        if (lowest > 0 && found.bound < lowest) found = look(e, {.enough = lowest, .bisections = bisections});
    });
    if (!refined) return fail(refined.error());
    auto means = map_each(without_progress(execution), n, [&](std::size_t e) { return (*qualities)[e].mean; });
    if (!means) return fail(means.error());
    return CurvedMeasures{std::move(*lengths), std::move(*means), std::move(*least)};
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template ElementMetric<D> element_metric<D>(const VertexLogMetrics<D>&, Instructions);                             \
    template CurvedQuality curved_quality<D>(const QuadraticNodes<D>&, const ElementMetric<D>&, Instructions);         \
    template CurvedQualityGradient<D> curved_quality_gradient<D>(const QuadraticNodes<D>&, const ElementMetric<D>&,    \
                                                                 Instructions);                                        \
    template double quality_at<D>(const QuadraticNodes<D>&, const VertexLogMetrics<D>&, const Barycentric<D>&);        \
    template QualityBound bound_quality<D>(const QuadraticNodes<D>&, const VertexLogMetrics<D>&, const BoundEffort&);  \
    template Outcome<Buffer<double>> quadratic_edge_lengths<D>(const QuadraticMesh<D>&, std::span<const LogMetric<D>>, \
                                                               const Execution&);                                      \
    template Outcome<CurvedMeasures> measure_curved<D>(const QuadraticMesh<D>&, std::span<const LogMetric<D>>, int,    \
                                                       const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
