module;
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
module camber.cavity;
import camber.core;
import camber.bezier;
import camber.metric;

namespace camber {

namespace {

/// The energy is ∫ l'ᵀ M l' dt with l' = (P_02 − P_20) + 4(1−2t) o, o the node's offset: in a constant metric it adds
/// (16/3) oᵀ M o. Energy is length squared at constant speed, so half of its share is that of the length.
constexpr double stretch = 16.0 / 3;

/// The model in a metric that is constant along the edge.
template <int D>
EdgeModel<D> model_in(const LogMetric<D>& log_metric, const Vec<D>& chord, const Vec<D>& centre) {
    const SpectralMetric<D> metric(log_metric);
    EdgeModel<D> model{centre, {}};
    const double energy = metric.length_squared(chord);
    for (int k = 0; k < D; ++k) {
        const double weight = stretch * metric.values[k] / energy;
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j) model.hessian(i, j) += weight * metric.vectors(i, k) * metric.vectors(j, k);
    }
    return model;
}

/// Where no element tells of a metric: that of the chord alone.
template <int D>
EdgeModel<D> isotropic_model(const Vec<D>& chord, const Vec<D>& centre) {
    return {centre, (stretch / norm_squared(chord)) * Sym<D>::identity()};
}

template <int D>
bool is_finite(const Sym<D>& s) {
    for (const double x : s.c)
        if (!std::isfinite(x)) return false;
    return true;
}

}  // namespace

template <int D>
Outcome<Buffer<EdgeModel<D>>> edge_models(const QuadraticMesh<D>& mesh, const Column<LagrangeNode<D>>& wanted,
                                          const Incidence<ElementId>& shells, const BackMesh<D>& back,
                                          const Execution& execution) {
    const Quadrature rule = gauss_legendre(4);
    return map_each(execution, mesh.edges.size(), [&](std::size_t e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        const Vec<D>& p20 = mesh.linear.points[a];
        const Vec<D>& p02 = mesh.linear.points[b];
        const Vec<D> centre = wanted[e].point;
        if (shells[e].empty()) return isotropic_model(p02 - p20, centre);
        const auto objective =
            edge_objective(back, rule, EdgeObjectiveKind::energy, EdgeFieldKind::back, p20, p02, shells[e].front());
        const ObjectiveSample<D> sample = objective.evaluate(centre);
        const EdgeModel<D> model{centre, (0.5 / sample.value) * sample.hessian};
        return is_finite(model.hessian) ? model : isotropic_model(p02 - p20, centre);
    });
}

template <int D>
Outcome<Buffer<EdgeModel<D>>> implied_edge_models(const QuadraticMesh<D>& mesh, const Column<LagrangeNode<D>>& wanted,
                                                  const Incidence<ElementId>& shells, const Execution& execution) {
    return map_each(execution, mesh.edges.size(), [&](std::size_t e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        const Vec<D> chord = mesh.linear.points[b] - mesh.linear.points[a];
        LogMetric<D> mean;
        std::size_t n = 0;
        for (const ElementId element : shells[e]) {
            std::array<Vec<D>, D + 1> p;
            for (int i = 0; i <= D; ++i) p[i] = mesh.linear.points[mesh.linear.elements.vertices[element][i]];
            const LogMetric<D> natural = natural_log_metric<D>(p);
            if (!is_finite(natural.l)) continue;  // of a flat element
            mean.l += natural.l;
            ++n;
        }
        if (n == 0) return isotropic_model(chord, wanted[e].point);
        mean.l *= 1.0 / static_cast<double>(n);
        return model_in(mean, chord, wanted[e].point);
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                      \
    template Outcome<Buffer<EdgeModel<D>>> edge_models<D>(const QuadraticMesh<D>&, const Column<LagrangeNode<D>>&, \
                                                          const Incidence<ElementId>&, const BackMesh<D>&,         \
                                                          const Execution&);                                       \
    template Outcome<Buffer<EdgeModel<D>>> implied_edge_models<D>(                                                 \
        const QuadraticMesh<D>&, const Column<LagrangeNode<D>>&, const Incidence<ElementId>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
