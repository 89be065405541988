module;
#include <cmath>
#include <cstddef>
module camber.metric;
import camber.core;
import camber.bezier;

namespace camber {

template <int D>
EdgeLength riemannian_length(const BackMesh<D>& back, const QuadraticEdge<D>& edge, const Quadrature& rule,
                             ElementId hint) {
    EdgeLength out;
    each_value_along(back, edge, rule, hint, [&](std::size_t q, const FieldSample<D>& sample) {
        out.outside += sample.location.placement == Placement::outside;
        out.lost += sample.location.placement == Placement::lost;
        const SpectralMetric<D> metric(sample.log_metric);
        out.length += rule.w[q] * std::sqrt(metric.length_squared(edge.derivative(rule.t[q])));
    });
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
    for (std::size_t q = 0; q < rule.size(); ++q) {
        const SpectralMetric<D> metric(field.at(rule.t[q]));
        length += rule.w[q] * std::sqrt(metric.length_squared(edge.derivative(rule.t[q])));
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
