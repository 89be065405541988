module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>
module camber.curving;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.edge_optimisation;
import camber.validity;
import camber.optimisation;

namespace camber {

namespace {

template <int D>
Vec<D> chord_middle(const QuadraticMesh<D>& mesh, EdgeId edge) {
    const auto& [a, b] = mesh.edges.vertices[edge];
    return midpoint(mesh.linear.points[a], mesh.linear.points[b]);
}

template <int D>
EdgeTarget<D> searched_target(const QuadraticMesh<D>& mesh, EdgeId edge, const EdgeMinimum<D>& m) {
    const bool moved = m.node.point != chord_middle(mesh, edge);
    return {.node = m.node,
            .change = moved ? EdgeChange::optimised : EdgeChange::straight,
            .flags = {.volume = 1,
                      .curved = moved,
                      .polished = m.search == EdgeSearch::polished,
                      .exhausted = m.search == EdgeSearch::exhausted,
                      .shortened = m.shortened,
                      .outside = m.outside,
                      .lost = m.lost},
            .straight_length = m.straight_length,
            .length = m.length};
}

}  // namespace

EdgeMinimiserOptions search_options(const CurveOptions& options) {
    auto search = static_cast<const EdgeMinimiserOptions&>(options);
    search.objective = options.aim == CurvingAim::length ? EdgeObjectiveKind::length : EdgeObjectiveKind::energy;
    return search;
}

template <int D>
EdgeTarget<D> boundary_target(const QuadraticMesh<D>& mesh, EdgeId edge, const LagrangeNode<D>& node) {
    const bool moved = node.point != chord_middle(mesh, edge);
    return {.node = node, .change = moved ? EdgeChange::projected : EdgeChange::straight, .flags = {}};
}

template <int D>
EdgeSearchWork searched_targets(const SearchedEdges<D>& searched, const BackMesh<D>& back, const EdgeRules& rules,
                                const CurveOptions& options, std::span<EdgeTarget<D>> targets) {
    const auto& [all, edges, base] = searched;
    const QuadraticMesh<D>& mesh = all.mesh;
    std::vector<BackEdge> back_edges;
    std::vector<LagrangeNode<D>> nodes;
    back_edges.reserve(edges.size());
    nodes.reserve(edges.size());
    for (const EdgeId e : edges) {
        const auto& [a, b] = mesh.edges.vertices[e];
        back_edges.push_back({a, b, all.shells[e]});
        nodes.push_back(base[e]);
    }
    std::vector<EdgeMinimum<D>> minima(edges.size());
    const EdgeSearchWork work =
        minimise_back_edges<D>(back, {back_edges, nodes}, rules, search_options(options), minima);
    for (std::size_t i = 0; i < edges.size(); ++i) targets[i] = searched_target(mesh, edges[i], minima[i]);
    return work;
}

template <int D>
void accurate_offsets(const QuadraticMesh<D>& mesh, std::span<const BackEdge> edges, const BackMesh<D>& back,
                      const EdgeAccuracyOptions& options, std::span<Vec<D>> offsets) {
    std::vector<Vec<D>> chords;
    chords.reserve(edges.size());
    for (const BackEdge& edge : edges) chords.push_back(mesh.linear.points[edge.b] - mesh.linear.points[edge.a]);
    std::vector<EdgeEnds<D>> ends(edges.size());
    back->sample_edges(edges, ends);
    accurate_offsets<D>(chords, ends, options, offsets);
}

template <int D>
EdgeTarget<D> node_target(const QuadraticMesh<D>& mesh, EdgeId edge, const LagrangeNode<D>& node) {
    const bool moved = node.point != chord_middle(mesh, edge);
    return {.node = node,
            .change = moved ? EdgeChange::optimised : EdgeChange::straight,
            .flags = {.volume = 1, .curved = moved}};
}

template <int D>
void measure(const QuadraticMesh<D>& mesh, const EdgeOfElement& source, const BackMesh<D>& back,
             const Quadrature& report, EdgeTarget<D>& target) {
    const auto& [a, b] = mesh.edges.vertices[source.edge];
    const Vec<D>& p = mesh.linear.points[a];
    const Vec<D>& q = mesh.linear.points[b];
    const Vec<D> middle = midpoint(p, q);
    const EdgeLength straight = riemannian_length(back, QuadraticEdge<D>{p, {middle}, q}, report, source.element_at);
    const bool moved = target.node.point != middle;
    const EdgeLength curved =
        moved ? riemannian_length(back, QuadraticEdge<D>{p, target.node, q}, report, source.element_at) : straight;
    target.flags.outside |= straight.outside + curved.outside > 0;
    target.flags.lost |= straight.lost + curved.lost > 0;
    target.straight_length = straight.length;
    target.length = curved.length;
}

namespace {

/// In a constant metric M, the offset o of the node from the chord's middle adds (16/3) oᵀ M o to the energy ∫ l'ᵀ M l'
/// dt of the edge l(t). At constant speed, energy is squared length, so the relative change of the length is half as
/// large.
constexpr double stretch = 16.0 / 3;
/// Weight of motions along the edge, which do not change its length. With it a motion by a tenth of the chord costs
/// 0.13 % of the length.
constexpr double min_weight = 0.05;
constexpr double max_weight = 16;
/// Models are fitted to lengths at offsets for which the energy predicts this relative increase of the length.
constexpr double fitted_loss = 1e-3;

template <int D>
std::array<Vec<D>, D> basis_along(const Sym<D>& h, const Vec<D>& tangent) {
    std::array<Vec<D>, D> basis{tangent};
    for (int k = 0; k < D; ++k) {
        double longest = 0;
        for (int axis = 0; k > 0 && axis < D; ++axis) {
            Vec<D> v{};
            v[axis] = 1 / std::sqrt(h(axis, axis));
            for (int l = 0; l < k; ++l) v -= dot(v, h * basis[l]) * basis[l];
            if (const double length = dot(v, h * v); length > longest) {
                longest = length;
                basis[k] = v;
            }
        }
        basis[k] *= 1 / std::sqrt(dot(basis[k], h * basis[k]));
    }
    return basis;
}

template <int D>
Sym<D> weighted(const Sym<D>& h, const std::array<Vec<D>, D>& basis, const Vec<D>& weights) {
    Sym<D> out;
    for (int k = 0; k < D; ++k) {
        const Vec<D> b = h * basis[k];
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j) out(i, j) += weights[k] * b[i] * b[j];
    }
    return out;
}

template <int D>
Sym<D> with_cheap_slides(const Sym<D>& h, const Vec<D>& tangent) {
    Vec<D> weights;
    weights.c.fill(1);
    weights[0] = min_weight;
    return weighted<D>(h, basis_along(h, tangent), weights);
}

template <int D, class Loss>
Sym<D> fitted(const Sym<D>& h, const Vec<D>& tangent, Loss&& loss) {
    const auto basis = basis_along(h, tangent);
    const double r = std::sqrt(2 * fitted_loss);
    Vec<D> weights;
    for (int k = 0; k < D; ++k) {
        const double lost = 0.5 * (loss(r * basis[k]) + loss(-r * basis[k]));
        weights[k] = std::clamp(lost / fitted_loss, min_weight, max_weight);
    }
    return weighted<D>(h, basis, weights);
}

template <int D>
Sym<D> scaled(const SpectralMetric<D>& metric, double weight) {
    Sym<D> out;
    for (int k = 0; k < D; ++k)
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j)
                out(i, j) += weight * metric.values[k] * metric.vectors(i, k) * metric.vectors(j, k);
    return out;
}

/// Returns a quadratic cost of a node's offset. The cost is high in all directions, also along the edge, and
/// independent of the metric's scale.
template <int D>
QuadraticModel<D> accuracy_model(const LogMetric<D>& log_metric, const Vec<D>& chord, const Vec<D>& centre) {
    const SpectralMetric<D> metric(log_metric);
    return {centre, scaled(metric, stretch / metric.length_squared(chord)), 0};
}

template <int D>
QuadraticModel<D> model_in(const LogMetric<D>& log_metric, const Vec<D>& chord, const Vec<D>& centre) {
    const SpectralMetric<D> metric(log_metric);
    const Sym<D> hessian = scaled(metric, stretch / metric.length_squared(chord));
    return {centre, with_cheap_slides(hessian, chord), 0};
}

template <int D>
QuadraticModel<D> isotropic_model(const Vec<D>& chord, const Vec<D>& centre) {
    return {centre, (stretch / std::max(norm_squared(chord), 1e-300)) * Sym<D>::identity(), 0};
}

template <int D>
bool is_finite(const Sym<D>& s) {
    for (const double x : s.c)
        if (!std::isfinite(x)) return false;
    return true;
}

}  // namespace

template <int D>
QuadraticModel<D> edge_model(const QuadraticMesh<D>& mesh, EdgeId edge, const LagrangeNode<D>& target,
                             std::span<const ElementId> shell, const BackMesh<D>& back, ModelFit fit) {
    const auto& [a, b] = mesh.edges.vertices[edge];
    const Vec<D>& p20 = mesh.linear.points[a];
    const Vec<D>& p02 = mesh.linear.points[b];
    const Vec<D> centre = target.point;
    if (shell.empty()) return isotropic_model(p02 - p20, centre);
    if (fit == ModelFit::accuracy) {
        const auto model =
            accuracy_model(sample_value(back, midpoint(p20, p02), shell.front()).log_metric, p02 - p20, centre);
        return is_finite(model.hessian) ? model : isotropic_model(p02 - p20, centre);
    }
    const Quadrature rule = gauss_legendre(4);
    const auto objective = [&](EdgeObjectiveKind kind) {
        return edge_objective(back, rule, kind, EdgeFieldKind::back, {p20, p02, shell.front()});
    };
    const ObjectiveSample<D> sample = objective(EdgeObjectiveKind::energy).evaluate(centre);
    const Sym<D> energy = (0.5 / sample.value) * sample.hessian;
    const auto length = objective(EdgeObjectiveKind::length);
    const double least = length.value(centre);
    const auto loss = [&](const Vec<D>& o) { return length.value(centre + o) / least - 1; };
    const QuadraticModel<D> model{centre, fitted(energy, p02 - p20, loss), 0};
    return is_finite(model.hessian) ? model : isotropic_model(p02 - p20, centre);
}

template <int D>
EdgeModels<D> edge_models(CurvingAim aim, const QuadraticMesh<D>& mesh, const Column<LagrangeNode<D>>& target,
                          const Incidence<ElementId>& shells, const BackMesh<D>& back) {
    const ModelFit fit = aim == CurvingAim::accuracy ? ModelFit::accuracy : ModelFit::length;
    return [=](EdgeId edge) { return edge_model(mesh, edge, target[edge], shells[edge], back, fit); };
}

template <int D>
QuadraticModel<D> implied_edge_model(const QuadraticMesh<D>& mesh, EdgeId edge, const LagrangeNode<D>& target,
                                     std::span<const ElementId> shell) {
    const auto& [a, b] = mesh.edges.vertices[edge];
    const Vec<D> chord = mesh.linear.points[b] - mesh.linear.points[a];
    LogMetric<D> mean;
    std::size_t n = 0;
    for (const ElementId element : shell) {
        std::array<Vec<D>, D + 1> p;
        for (int i = 0; i <= D; ++i) p[i] = mesh.linear.points[mesh.linear.elements.vertices[element][i]];
        const LogMetric<D> natural = natural_log_metric<D>(p);
        if (!is_finite(natural.l)) continue;  // flat element
        mean.l += natural.l;
        ++n;
    }
    if (n == 0) return isotropic_model(chord, target.point);
    mean.l *= 1.0 / static_cast<double>(n);
    const auto model = model_in(mean, chord, target.point);
    return is_finite(model.hessian) ? model : isotropic_model(chord, target.point);
}

template <int D>
EdgeModels<D> implied_edge_models(const QuadraticMesh<D>& mesh, const Column<LagrangeNode<D>>& target,
                                  const Incidence<ElementId>& shells) {
    return [=](EdgeId edge) { return implied_edge_model(mesh, edge, target[edge], shells[edge]); };
}

#define CAMBER_INSTANTIATE(D)                                                                                      \
    template EdgeTarget<D> boundary_target<D>(const QuadraticMesh<D>&, EdgeId, const LagrangeNode<D>&);            \
    template EdgeSearchWork searched_targets<D>(const SearchedEdges<D>&, const BackMesh<D>&, const EdgeRules&,     \
                                                const CurveOptions&, std::span<EdgeTarget<D>>);                    \
    template void accurate_offsets<D>(const QuadraticMesh<D>&, std::span<const BackEdge>, const BackMesh<D>&,      \
                                      const EdgeAccuracyOptions&, std::span<Vec<D>>);                              \
    template EdgeTarget<D> node_target<D>(const QuadraticMesh<D>&, EdgeId, const LagrangeNode<D>&);                \
    template void measure<D>(const QuadraticMesh<D>&, const EdgeOfElement&, const BackMesh<D>&, const Quadrature&, \
                             EdgeTarget<D>&);                                                                      \
    template QuadraticModel<D> edge_model<D>(const QuadraticMesh<D>&, EdgeId, const LagrangeNode<D>&,              \
                                             std::span<const ElementId>, const BackMesh<D>&, ModelFit);            \
    template EdgeModels<D> edge_models<D>(CurvingAim, const QuadraticMesh<D>&, const Column<LagrangeNode<D>>&,     \
                                          const Incidence<ElementId>&, const BackMesh<D>&);                        \
    template QuadraticModel<D> implied_edge_model<D>(const QuadraticMesh<D>&, EdgeId, const LagrangeNode<D>&,      \
                                                     std::span<const ElementId>);                                  \
    template EdgeModels<D> implied_edge_models<D>(const QuadraticMesh<D>&, const Column<LagrangeNode<D>>&,         \
                                                  const Incidence<ElementId>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
