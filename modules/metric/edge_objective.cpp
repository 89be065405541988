module;
#include <cmath>
#include <cstddef>
module camber.metric;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// Adds one quadrature point's share of q = l'ᵀ M l', with ∂_i l' = 4(1−2t) e_i, ∂_i log M = 4t(1−t) G_i:
/// ∂_i q = 2·4(1−2t) (M l')_i + 4t(1−t) ⟨adjoint, G_i⟩ (paper §2.2.1 through the adjoint of Daletskii–Krein).
template <int D>
void add_point(ObjectiveSample<D>& sum, EdgeObjectiveKind kind, double t, double w, const Vec<D>& derivative,
               const LogMetric<D>& log_metric, const LogGradient<D>& gradient) {
    const SpectralMetric<D> metric(log_metric);
    const double q = metric.length_squared(derivative);
    const Sym<D> adjoint = length_squared_adjoint(metric, derivative);
    const double c = 4 * (1 - 2 * t);
    const double s = 4 * t * (1 - t);
    Vec<D> dq = 2 * c * metric.times(derivative);
    for (int i = 0; i < D; ++i) dq[i] += s * inner(adjoint, gradient[i]);
    // Energy: f = q. Length: f = sqrt(q), f' = 1/(2 sqrt(q)).
    const bool energy = kind == EdgeObjectiveKind::energy;
    const double root = std::sqrt(q);
    sum.value += w * (energy ? q : root);
    const double slope = energy ? 1.0 : root > 0 ? 0.5 / root : 0.0;
    sum.gradient += w * slope * dq;
    const double h = w * slope * 2 * c * c;
    for (int k = 0; k < D; ++k)
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j)
                sum.hessian(i, j) += h * metric.values[k] * metric.vectors(i, k) * metric.vectors(j, k);
}

}  // namespace

template <int D>
double EdgeObjective<D>::value(const Vec<D>& node) const {
    const QuadraticEdge<D> edge{p20, {node}, p02};
    double sum = 0;
    const auto add = [&](std::size_t i, const LogMetric<D>& log_metric) {
        const double q = SpectralMetric<D>(log_metric).length_squared(edge.derivative(rule->t[i]));
        sum += rule->w[i] * (kind == EdgeObjectiveKind::energy ? q : std::sqrt(q));
    };
    if (field == EdgeFieldKind::back) {
        each_value_along(*back, edge, *rule, hint,
                         [&](std::size_t i, const FieldSample<D>& sample) { add(i, sample.log_metric); });
    } else {
        const EdgeField<D> along{l20, sample_value(*back, node, hint).log_metric, l02};
        for (std::size_t i = 0; i < rule->size(); ++i) add(i, along.at(rule->t[i]));
    }
    return sum;
}

template <int D>
ObjectiveSample<D> EdgeObjective<D>::evaluate(const Vec<D>& node) const {
    const QuadraticEdge<D> edge{p20, {node}, p02};
    ObjectiveSample<D> sum;
    const auto add = [&](std::size_t i, const LogMetric<D>& log_metric, const LogGradient<D>& gradient) {
        add_point<D>(sum, kind, rule->t[i], rule->w[i], edge.derivative(rule->t[i]), log_metric, gradient);
    };
    if (field == EdgeFieldKind::back) {
        each_gradient_along(*back, edge, *rule, hint, [&](std::size_t i, const FieldSample<D>& sample) {
            add(i, sample.log_metric, sample.gradient);
        });
    } else {
        const FieldSample<D> mid = sample_with_gradient(*back, node, hint);
        const EdgeField<D> along{l20, mid.log_metric, l02};
        for (std::size_t i = 0; i < rule->size(); ++i) add(i, along.at(rule->t[i]), mid.gradient);
    }
    return sum;
}

template <int D>
EdgeObjective<D> edge_objective(const BackMesh<D>& back, const Quadrature& rule, EdgeObjectiveKind kind,
                                EdgeFieldKind field, const Vec<D>& p20, const Vec<D>& p02, ElementId hint) {
    EdgeObjective<D> objective{&back, &rule, kind, field, p20, p02, {}, {}, hint};
    if (field == EdgeFieldKind::edge) {
        objective.l20 = sample_value(back, p20, hint).log_metric;
        objective.l02 = sample_value(back, p02, hint).log_metric;
    }
    return objective;
}

#define CAMBER_INSTANTIATE(D)                                                                             \
    template struct EdgeObjective<D>;                                                                     \
    template EdgeObjective<D> edge_objective<D>(const BackMesh<D>&, const Quadrature&, EdgeObjectiveKind, \
                                                EdgeFieldKind, const Vec<D>&, const Vec<D>&, ElementId);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
