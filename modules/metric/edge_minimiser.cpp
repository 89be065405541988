module;
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
module camber.metric;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// Armijo's rule with quadratic interpolation along the bounded step. False where no step lowers the objective.
template <int D>
bool line_search(const EdgeObjective<D>& objective, const UnitFrame<D>& frame, const Iterate<D>& from,
                 const Vec<D>& direction, Iterate<D>& next) {
    const double slope = dot(from.gradient, direction);
    double step = 1;
    for (int attempt = 0; attempt < 8; ++attempt) {
        const Vec<D> y = frame.bounded(from.y + step * direction);
        const Iterate<D> trial = evaluated(objective, frame, y);
        if (trial.value < from.value + 1e-4 * step * slope ||
            (trial.value < from.value && norm(y - from.y) < 0.9 * step * norm(direction))) {
            next = trial;
            return true;
        }
        const double curved = -slope * step * step / (2 * (trial.value - from.value - slope * step));
        step = std::clamp(curved, 0.1 * step, 0.5 * step);
    }
    return false;
}

template <int D>
EdgeSearch descend(const EdgeObjective<D>& objective, const UnitFrame<D>& frame, int max_iterations, double tolerance,
                   Iterate<D>& at) {
    Sym<D> inverse_hessian = inverse_of(at.hessian);
    for (int iteration = 0; iteration < max_iterations; ++iteration) {
        Vec<D> direction = -(inverse_hessian * at.gradient);
        const double promise = -dot(at.gradient, direction);
        if (!(promise > tolerance * at.value)) return EdgeSearch::converged;
        Iterate<D> next;
        if (!line_search(objective, frame, at, direction, next)) {
            polish(objective, frame, at);
            return EdgeSearch::polished;
        }
        const double gained = at.value - next.value;
        update_inverse_hessian(inverse_hessian, next.y - at.y, next.gradient - at.gradient);
        at = next;
        if (gained < 0.1 * tolerance * at.value) return EdgeSearch::converged;
    }
    return EdgeSearch::exhausted;
}

/// The energy also evens out the speed along the edge, and where one node cannot serve both it leaves some length: from
/// its minimum, in the regular valley that it has found, the length itself is lowered where that promises enough.
template <int D>
void shorten(const BackMesh<D>& back, EdgeObjective<D> objective, const EdgeMinimiserOptions& options, Vec<D>& node) {
    objective.kind = EdgeObjectiveKind::length;
    const UnitFrame<D> frame = unit_frame(back, objective, options.max_tangential_shift, options.max_offset);
    Iterate<D> at = evaluated(objective, frame, frame.coordinates(node));
    descend(objective, frame, 5, options.length_tolerance, at);
    node = frame.node(at.y);
}

template <int D>
EdgeMinimum<D> minimised(const BackMesh<D>& back, const EdgeObjective<D>& objective, const UnitFrame<D>& frame,
                         Iterate<D> at, const EdgeRules& rules, const EdgeMinimiserOptions& options) {
    EdgeMinimum<D> minimum;
    minimum.search = descend(objective, frame, options.max_iterations, options.tolerance, at);
    minimum.node.point = frame.node(at.y);
    if (objective.kind == EdgeObjectiveKind::energy && options.length_tolerance > 0)
        shorten(back, objective, options, minimum.node.point);
    judge(back, objective, rules.report, minimum);
    return minimum;
}

/// The minimum, or where the search began if that is shorter by the finer rule.
template <int D>
EdgeMinimum<D> no_longer_than(const LagrangeNode<D>& present, const BackMesh<D>& back,
                              const EdgeObjective<D>& objective, const Quadrature& rule, EdgeMinimum<D> minimum) {
    if (present.point == midpoint(objective.p20, objective.p02)) return minimum;
    const EdgeLength length =
        riemannian_length(back, QuadraticEdge<D>{objective.p20, present, objective.p02}, rule, objective.hint);
    if (!(length.length < minimum.length)) return minimum;
    minimum.node = present;
    minimum.length = length.length;
    minimum.shortened = true;
    return minimum;
}

}  // namespace

EdgeRules edge_rules(const EdgeMinimiserOptions& options) {
    return {gauss_legendre(options.quadrature_points), gauss_legendre(report_points)};
}

template <int D>
Vec<D> geodesic_start(const BackMesh<D>& back, const Vec<D>& p20, const Vec<D>& p02, ElementId hint) {
    const Vec<D> middle = midpoint(p20, p02);
    const Vec<D> e = p02 - p20;
    const FieldSample<D> sample = sample_with_recovered_gradient(back, middle, hint);
    const SpectralMetric<D> metric(sample.log_metric);
    // ∂_i M = D exp(L)[∂_i L]; only its products with e are needed: (∂_e M) e and eᵀ(∂_i M) e.
    Sym<D> along;
    for (int i = 0; i < D; ++i) along += e[i] * sample.gradient[i];
    Vec<D> force = exp_derivative(metric, along) * e;
    const Sym<D> adjoint = length_squared_adjoint(metric, e);
    for (int i = 0; i < D; ++i) force[i] -= 0.5 * inner(adjoint, sample.gradient[i]);
    return middle + 0.125 * metric.solve(force);
}

template <int D>
EdgeMinimum<D> minimise_edge(const BackMesh<D>& back, const Vec<D>& p20, const Vec<D>& p02, ElementId hint,
                             const EdgeRules& rules, const EdgeMinimiserOptions& options) {
    const EdgeObjective<D> objective =
        edge_objective(back, rules.objective, options.objective, options.field, p20, p02, hint);
    const UnitFrame<D> frame = unit_frame(back, objective, options.max_tangential_shift, options.max_offset);
    const Vec<D> predicted = frame.coordinates(geodesic_start(back, p20, p02, hint));
    return minimised(back, objective, frame, start(objective, frame, predicted), rules, options);
}

template <int D>
EdgeMinimum<D> minimise_back_edge(const BackMesh<D>& back, VertexId a, VertexId b, const LagrangeNode<D>& present,
                                  std::span<const ElementId> shell, const EdgeRules& rules,
                                  const EdgeMinimiserOptions& options) {
    const EdgeObjective<D> objective =
        edge_objective(back, rules.objective, options.objective, options.field, back->vertex(a).point,
                       back->vertex(b).point, *std::min_element(shell.begin(), shell.end()));
    const UnitFrame<D> frame = unit_frame(back, objective, options.max_tangential_shift, options.max_offset);
    Iterate<D> at = start(objective, frame, best_sector_start(back, objective, frame, a, b, shell));
    if (present.point != midpoint(objective.p20, objective.p02)) {
        const Iterate<D> own = evaluated(objective, frame, frame.bounded(frame.coordinates(present.point)));
        if (own.value < at.value) at = own;
    }
    return no_longer_than(present, back, objective, rules.report,
                          minimised(back, objective, frame, at, rules, options));
}

#define CAMBER_INSTANTIATE(D)                                                                                     \
    template Vec<D> geodesic_start<D>(const BackMesh<D>&, const Vec<D>&, const Vec<D>&, ElementId);               \
    template EdgeMinimum<D> minimise_edge<D>(const BackMesh<D>&, const Vec<D>&, const Vec<D>&, ElementId,         \
                                             const EdgeRules&, const EdgeMinimiserOptions&);                      \
    template EdgeMinimum<D> minimise_back_edge<D>(const BackMesh<D>&, VertexId, VertexId, const LagrangeNode<D>&, \
                                                  std::span<const ElementId>, const EdgeRules&,                   \
                                                  const EdgeMinimiserOptions&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
