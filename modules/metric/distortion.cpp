module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
module camber.metric;
import :packs;
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
/// In one order, whatever the instructions.
double sum(const Lanes& x) { return ((x[0] + x[1]) + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7])); }

/// slopes<D>[e][k]: component k of 4 (ξ_j ∇ξ_i + ξ_i ∇ξ_j) of edge i–j at the points of the rule.
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

/// What A comes to at the points of the rule.
template <int D>
struct Sampled {
    MatPack<D> a;
    Pack det{}, square{}, distortion{};  ///< det A, tr(AᵀA), η of |det A|
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
/// What the mean is made of, a point a lane: the weighted η, and whether det J has one sign.
struct WeightedDistortion {
    Lanes weighted{};
    bool is_positive = false, is_negative = false;
};
template <int D>
[[gnu::always_inline]] inline WeightedDistortion weighted_distortion(const Sampled<D>& s) {
    return {stored(loaded(distortion_rule<D>.weights) * s.distortion), !any(!(s.det > 0)), !any(!(s.det < 0))};
}
/// See CurvedQuality.
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
    std::array<std::array<Lanes, D>, D> by_straight{};                   // [c][k]: of J's entry, a point a lane
    std::array<std::array<Lanes, D>, edges_per_simplex<D>> by_offset{};  // [e][c]
    with_instructions(set, [&]() __attribute__((always_inline)) {
        const Sampled<D> s = sampled<D>(nodes, metric);
        of = weighted_distortion(s);
        // ∂η/∂A = 2 η (A / tr(AᵀA) − A⁻ᵀ/D), with the weight; then ∂η/∂(J W⁻¹) = rootᵀ ∂η/∂A.
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
    const double scale = -mean.quality / mean.distortion;  // of 1/η̄, with its sign: −sign/η̄²
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

#define CAMBER_INSTANTIATE(D)                                                                                       \
    template ElementMetric<D> element_metric<D>(const VertexLogMetrics<D>&, Instructions);                          \
    template CurvedQuality curved_quality<D>(const QuadraticNodes<D>&, const ElementMetric<D>&, Instructions);      \
    template CurvedQualityGradient<D> curved_quality_gradient<D>(const QuadraticNodes<D>&, const ElementMetric<D>&, \
                                                                 Instructions);                                     \
    template double quality_at<D>(const QuadraticNodes<D>&, const VertexLogMetrics<D>&, const Barycentric<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
