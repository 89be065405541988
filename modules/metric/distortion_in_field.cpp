module;
#include <array>
#include <cmath>
#include <cstddef>
module camber.metric;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// η at a point, and its derivative by S.
template <int D>
struct DistortionByShape {
    double distortion = 0;
    Sym<D> by_shape;
};
template <int D>
DistortionByShape<D> distortion_by_shape(const QuadraticNodes<D>& nodes, const VertexLogMetrics<D>& vertices,
                                         const Barycentric<D>& xi) {
    const EigenSystem<D> e = eigen_system(shape_between<D>(vertices, xi));
    const Mat<D> j = regular_jacobian<D>(nodes, xi);
    Mat<D> a;  // along the axes of M, by the roots of its values
    for (int i = 0; i < D; ++i)
        for (int k = 0; k < D; ++k) a(i, k) = exp(e.values[i] / 2) * dot(e.vectors.column[i], j.column[k]);
    const double determinant = det(a);
    const double size = D == 2 ? std::abs(determinant) : cbrt(determinant * determinant);
    // D exp(S)[P] along the axes: (e^x − e^y)/(x − y) P_ab = (A Aᵀ)_ab sinh(h)/h, h = (x − y)/2. The large entries of P
    // never meet the small ones.
    DistortionByShape<D> out;
    Sym<D> along_axes;
    for (int i = 0; i < D; ++i)
        for (int k = 0; k <= i; ++k) {
            double square = 0;
            for (int c = 0; c < D; ++c) square += a(i, c) * a(k, c);
            const double half = (e.values[i] - e.values[k]) / 2;
            along_axes(i, k) = square * (std::abs(half) < 1e-4 ? 1 + half * half / 6 : sinh(half) / half);
            if (i == k) out.distortion += square / (D * size);
        }
    out.by_shape = (1 / (D * size)) * congruence(e.vectors, along_axes);
    return out;
}

}  // namespace

template <int D>
std::array<Sym<D>, D + 1> curved_quality_by_metrics(const QuadraticNodes<D>& nodes,
                                                    const VertexLogMetrics<D>& vertices) {
    std::array<Sym<D>, D + 1> by_metrics{};
    const double quality = curved_quality<D>(nodes, element_metric<D>(vertices)).mean;
    if (quality == 0) return by_metrics;
    const double scale = -quality * std::abs(quality);  // of 1/η̄, with its sign
    for (std::size_t q = 0; q < pack_size; ++q) {
        const double weight = distortion_rule<D>.weights[q];
        if (weight == 0) continue;
        Barycentric<D> xi{};
        for (int i = 0; i <= D; ++i) xi[i] = distortion_rule<D>.xi[i][q];
        const Sym<D> by_shape = shape_of_log<D>({distortion_by_shape<D>(nodes, vertices, xi).by_shape});
        for (int i = 0; i <= D; ++i) by_metrics[i] += (scale * weight * xi[i]) * by_shape;
    }
    return by_metrics;
}

template <int D>
CurvedQualityGradient<D> curved_quality_gradient_in_field(const QuadraticNodes<D>& nodes,
                                                          const VertexLogMetrics<D>& vertices,
                                                          const std::array<LogGradient<D>, D + 1>& gradients) {
    CurvedQualityGradient<D> out = curved_quality_gradient<D>(nodes, element_metric<D>(vertices));
    const auto by_metrics = curved_quality_by_metrics<D>(nodes, vertices);
    for (int i = 0; i <= D; ++i)
        for (int k = 0; k < D; ++k) out.by_node[i][k] += inner(by_metrics[i], gradients[i][k]);
    return out;
}

#define CAMBER_INSTANTIATE(D)                                                                    \
    template std::array<Sym<D>, D + 1> curved_quality_by_metrics<D>(const QuadraticNodes<D>&,    \
                                                                    const VertexLogMetrics<D>&); \
    template CurvedQualityGradient<D> curved_quality_gradient_in_field<D>(                       \
        const QuadraticNodes<D>&, const VertexLogMetrics<D>&, const std::array<LogGradient<D>, D + 1>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
