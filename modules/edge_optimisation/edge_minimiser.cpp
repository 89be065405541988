module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
module camber.edge_optimisation;
import camber.core;
import camber.bezier;
import camber.metric;

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

namespace {

template <int D>
struct EdgePoint {
    double t, weight;
    Vec<D> derivative;  ///< l'(t)
};

/// Adds a quadrature point. With q = l'ᵀ M l': ∂_i q = 2·4(1−2t) (M l')_i + 4t(1−t) ⟨adjoint, G_i⟩, where ∂_i log M =
/// 4t(1−t) G_i (paper §2.2.1, adjoint of Daletskii–Krein).
template <int D>
void add_point(ObjectiveSample<D>& sum, EdgeObjectiveKind kind, const EdgePoint<D>& point,
               const LogMetric<D>& log_metric, const LogGradient<D>& gradient) {
    const auto& [t, w, derivative] = point;
    const SpectralMetric<D> metric(log_metric);
    const double q = metric.length_squared(derivative);
    const Sym<D> adjoint = length_squared_adjoint(metric, derivative);
    const double c = 4 * (1 - 2 * t);
    const double s = 4 * t * (1 - t);
    Vec<D> dq = 2 * c * metric.times(derivative);
    for (int i = 0; i < D; ++i) dq[i] += s * inner(adjoint, gradient[i]);
    // The integrand is q for the energy and sqrt(q) for the length.
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
        add_point<D>(sum, kind, {rule->t[i], rule->w[i], edge.derivative(rule->t[i])}, log_metric, gradient);
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
                                EdgeFieldKind field, const Chord<D>& chord) {
    const auto& [p20, p02, hint] = chord;
    EdgeObjective<D> objective{&back, &rule, kind, field, p20, p02, {}, {}, hint};
    if (field == EdgeFieldKind::edge) {
        objective.l20 = sample_value(back, p20, hint).log_metric;
        objective.l02 = sample_value(back, p02, hint).log_metric;
    }
    return objective;
}

namespace {

/// Uses Armijo's rule with quadratic interpolation; false if no step succeeds.
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

/// Minimises the length, starting from the minimum of the energy. That minimum also equalises the speed, so its edge
/// may be longer.
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
    // ∂_i M = D exp(L)[∂_i L]; only (∂_e M) e and eᵀ(∂_i M) e are required.
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
        edge_objective(back, rules.objective, options.objective, options.field, {p20, p02, hint});
    const UnitFrame<D> frame = unit_frame(back, objective, options.max_tangential_shift, options.max_offset);
    const Vec<D> predicted = frame.coordinates(geodesic_start(back, p20, p02, hint));
    return minimised(back, objective, frame, start(objective, frame, predicted), rules, options);
}

template <int D>
EdgeMinimum<D> minimise_back_edge(const BackMesh<D>& back, const BackEdge& edge, const LagrangeNode<D>& present,
                                  const EdgeRules& rules, const EdgeMinimiserOptions& options) {
    const auto& [a, b, shell] = edge;
    const EdgeObjective<D> objective =
        edge_objective(back, rules.objective, options.objective, options.field,
                       {back->vertex(a).point, back->vertex(b).point, *std::min_element(shell.begin(), shell.end())});
    const UnitFrame<D> frame = unit_frame(back, objective, options.max_tangential_shift, options.max_offset);
    Iterate<D> at = start(objective, frame, best_sector_start(back, objective, frame, a, b, shell));
    if (present.point != midpoint(objective.p20, objective.p02)) {
        const Iterate<D> own = evaluated(objective, frame, frame.bounded(frame.coordinates(present.point)));
        if (own.value < at.value) at = own;
    }
    return no_longer_than(present, back, objective, rules.report,
                          minimised(back, objective, frame, at, rules, options));
}

#define CAMBER_INSTANTIATE(D)                                                                                  \
    template EdgeLength riemannian_length<D>(const BackMesh<D>&, const QuadraticEdge<D>&, const Quadrature&,   \
                                             ElementId);                                                       \
    template EdgeField<D> edge_field<D>(const BackMesh<D>&, const QuadraticEdge<D>&, ElementId);               \
    template double riemannian_length<D>(const EdgeField<D>&, const QuadraticEdge<D>&, const Quadrature&);     \
    template struct EdgeObjective<D>;                                                                          \
    template EdgeObjective<D> edge_objective<D>(const BackMesh<D>&, const Quadrature&, EdgeObjectiveKind,      \
                                                EdgeFieldKind, const Chord<D>&);                               \
    template Vec<D> geodesic_start<D>(const BackMesh<D>&, const Vec<D>&, const Vec<D>&, ElementId);            \
    template EdgeMinimum<D> minimise_edge<D>(const BackMesh<D>&, const Vec<D>&, const Vec<D>&, ElementId,      \
                                             const EdgeRules&, const EdgeMinimiserOptions&);                   \
    template EdgeMinimum<D> minimise_back_edge<D>(const BackMesh<D>&, const BackEdge&, const LagrangeNode<D>&, \
                                                  const EdgeRules&, const EdgeMinimiserOptions&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
