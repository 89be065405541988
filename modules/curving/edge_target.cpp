module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>
module camber.curving;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;

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
EdgeSearchWork searched_targets(const QuadraticMesh<D>& mesh, std::span<const EdgeId> edges,
                                const Column<LagrangeNode<D>>& base, const Incidence<ElementId>& shells,
                                const BackMesh<D>& back, const EdgeRules& rules, const CurveOptions& options,
                                std::span<EdgeTarget<D>> targets) {
    std::vector<BackEdge> seen;
    std::vector<LagrangeNode<D>> nodes;
    seen.reserve(edges.size());
    nodes.reserve(edges.size());
    for (const EdgeId e : edges) {
        const auto& [a, b] = mesh.edges.vertices[e];
        seen.push_back({a, b, shells[e]});
        nodes.push_back(base[e]);
    }
    std::vector<EdgeMinimum<D>> minima(edges.size());
    const EdgeSearchWork work = minimise_back_edges<D>(back, seen, nodes, rules, search_options(options), minima);
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
    back->see(edges, ends);
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
void measure(const QuadraticMesh<D>& mesh, const HeldEdge& held, const BackMesh<D>& back, const Quadrature& report,
             EdgeTarget<D>& target) {
    const auto& [a, b] = mesh.edges.vertices[held.edge];
    const Vec<D>& p = mesh.linear.points[a];
    const Vec<D>& q = mesh.linear.points[b];
    const Vec<D> middle = midpoint(p, q);
    const EdgeLength straight = riemannian_length(back, QuadraticEdge<D>{p, {middle}, q}, report, held.holder);
    const bool moved = target.node.point != middle;
    const EdgeLength curved =
        moved ? riemannian_length(back, QuadraticEdge<D>{p, target.node, q}, report, held.holder) : straight;
    target.flags.outside |= straight.outside + curved.outside > 0;
    target.flags.lost |= straight.lost + curved.lost > 0;
    target.straight_length = straight.length;
    target.length = curved.length;
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template EdgeTarget<D> boundary_target<D>(const QuadraticMesh<D>&, EdgeId, const LagrangeNode<D>&);                \
    template EdgeSearchWork searched_targets<D>(                                                                       \
        const QuadraticMesh<D>&, std::span<const EdgeId>, const Column<LagrangeNode<D>>&, const Incidence<ElementId>&, \
        const BackMesh<D>&, const EdgeRules&, const CurveOptions&, std::span<EdgeTarget<D>>);                          \
    template void accurate_offsets<D>(const QuadraticMesh<D>&, std::span<const BackEdge>, const BackMesh<D>&,          \
                                      const EdgeAccuracyOptions&, std::span<Vec<D>>);                                  \
    template EdgeTarget<D> node_target<D>(const QuadraticMesh<D>&, EdgeId, const LagrangeNode<D>&);                    \
    template void measure<D>(const QuadraticMesh<D>&, const HeldEdge&, const BackMesh<D>&, const Quadrature&,          \
                             EdgeTarget<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
