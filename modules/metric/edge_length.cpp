module;
#include <algorithm>
#include <array>
#include <cstddef>
module camber.metric;
import camber.core;
import camber.bezier;

namespace camber {

template <int D>
EdgeLength riemannian_length(const BackMesh<D>& back, const QuadraticEdge<D>& edge, const Quadrature& rule,
                             ElementId hint) {
    EdgeLength out;
    std::array<LogMetric<D>, edge_pack> metrics;
    std::array<Vec<D>, edge_pack> velocities;
    std::array<double, edge_pack> speeds{};
    std::size_t begin = 0, n = 0;
    const auto add = [&] {
        metric_norms<D>({metrics.data(), n}, {velocities.data(), n}, {speeds.data(), n});
        for (std::size_t i = 0; i < n; ++i) out.length += rule.w[begin + i] * speeds[i];
        begin += n;
        n = 0;
    };
    each_value_along(back, edge, rule, hint, [&](std::size_t q, const FieldSample<D>& sample) {
        out.outside += sample.location.placement == Placement::outside;
        out.lost += sample.location.placement == Placement::lost;
        metrics[n] = sample.log_metric;
        velocities[n++] = edge.derivative(rule.t[q]);
        if (n == edge_pack) add();
    });
    add();
    return out;
}

template <int D>
EdgeField<D> edge_field(const BackMesh<D>& back, const QuadraticEdge<D>& edge, ElementId hint) {
    return {sample_value(back, edge.p20, hint).log_metric, sample_value(back, edge.mid.point, hint).log_metric,
            sample_value(back, edge.p02, hint).log_metric};
}

template <int D>
double riemannian_length(const EdgeField<D>& field, const QuadraticEdge<D>& edge, const Quadrature& rule) {
    double length = 0;
    std::array<LogMetric<D>, edge_pack> metrics;
    std::array<Vec<D>, edge_pack> velocities;
    std::array<double, edge_pack> speeds{};
    for (std::size_t begin = 0; begin < rule.size(); begin += edge_pack) {
        const std::size_t n = std::min(edge_pack, rule.size() - begin);
        for (std::size_t i = 0; i < n; ++i) {
            metrics[i] = field.at(rule.t[begin + i]);
            velocities[i] = edge.derivative(rule.t[begin + i]);
        }
        metric_norms<D>({metrics.data(), n}, {velocities.data(), n}, {speeds.data(), n});
        for (std::size_t i = 0; i < n; ++i) length += rule.w[begin + i] * speeds[i];
    }
    return length;
}

#define CAMBER_INSTANTIATE(D)                                                                                \
    template EdgeLength riemannian_length<D>(const BackMesh<D>&, const QuadraticEdge<D>&, const Quadrature&, \
                                             ElementId);                                                     \
    template EdgeField<D> edge_field<D>(const BackMesh<D>&, const QuadraticEdge<D>&, ElementId);             \
    template double riemannian_length<D>(const EdgeField<D>&, const QuadraticEdge<D>&, const Quadrature&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
