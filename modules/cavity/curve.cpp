module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
module camber.cavity;
import camber.core;
import camber.bezier;
import camber.metric;

namespace camber {

namespace {

template <int D>
struct CurvedEdge {
    LagrangeNode<D> node;
    EdgeChange change = EdgeChange::straight;
    double straight_length = 0, length = 0;
};

/// Flags of one edge's search, summed up into CurveStatistics.
struct SearchFlags {
    std::uint8_t volume = 0, curved = 0, polished = 0, exhausted = 0, shortened = 0, outside = 0, lost = 0;
};

template <int D>
Outcome<Done> check_columns(const QuadraticMesh<D>& mesh, std::size_t kinds, std::size_t nodes) {
    if (kinds == mesh.edges.size() && nodes == mesh.edges.size()) return Done{};
    return fail(ErrorKind::internal, "curve needs a kind and a boundary node for each of the " +
                                         std::to_string(mesh.edges.size()) + " edges, not " + std::to_string(kinds) +
                                         " and " + std::to_string(nodes));
}

template <int D>
CurvedEdge<D> boundary_edge(const QuadraticMesh<D>& mesh, std::size_t e, const LagrangeNode<D>& node) {
    const auto& [a, b] = mesh.edges.vertices[e];
    const bool moved = node.point != midpoint(mesh.linear.points[a], mesh.linear.points[b]);
    return {.node = node, .change = moved ? EdgeChange::projected : EdgeChange::straight};
}

template <int D>
CurveStatistics summed(const Buffer<SearchFlags>& flags) {
    CurveStatistics s;
    for (const SearchFlags& f : flags) {
        s.volume_edges += f.volume;
        s.curved_edges += f.curved;
        s.polished += f.polished;
        s.exhausted += f.exhausted;
        s.shortened += f.shortened;
        s.outside += f.outside;
        s.lost += f.lost;
    }
    return s;
}

template <int D>
Curved<D> in_columns(const Buffer<CurvedEdge<D>>& edges, const Column<EdgeKind>& kinds,
                     const Buffer<SearchFlags>& flags) {
    Buffer<LagrangeNode<D>> nodes(edges.size());
    Buffer<EdgeChange> changes(edges.size());
    Buffer<double> straight(edges.size());
    Buffer<double> lengths(edges.size());
    for (std::size_t e = 0; e < edges.size(); ++e) {
        nodes[e] = edges[e].node;
        changes[e] = edges[e].change;
        straight[e] = edges[e].straight_length;
        lengths[e] = edges[e].length;
    }
    return {{std::move(nodes), kinds, std::move(changes)}, std::move(straight), std::move(lengths), summed<D>(flags)};
}

}  // namespace

template <int D>
Outcome<Curved<D>> curve(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                         const Column<LagrangeNode<D>>& boundary_nodes, const Incidence<ElementId>& shells,
                         const BackMesh<D>& back, const EdgeMinimiserOptions& options, const Execution& execution) {
    if (auto fits = check_columns(mesh, kinds.size(), boundary_nodes.size()); !fits) return fail(fits.error());
    const EdgeRules rules = edge_rules(options);
    Buffer<SearchFlags> flags(mesh.edges.size());
    auto edges = map_each(
        execution, mesh.edges.size(),
        [&](std::size_t e) -> CurvedEdge<D> {
            flags[e] = {};
            // An edge that no element holds (of a surface-only part) has no field to follow.
            if (kinds[e] != EdgeKind::volume || shells[e].empty()) return boundary_edge(mesh, e, boundary_nodes[e]);
            const auto& [a, b] = mesh.edges.vertices[e];
            const EdgeMinimum<D> m = minimise_back_edge(back, a, b, shells[e], rules, options);
            const bool moved = m.node.point != midpoint(mesh.linear.points[a], mesh.linear.points[b]);
            flags[e] = {
                1,         moved, m.search == EdgeSearch::polished, m.search == EdgeSearch::exhausted, m.shortened,
                m.outside, m.lost};
            return {m.node, moved ? EdgeChange::optimised : EdgeChange::straight, m.straight_length, m.length};
        },
        64);
    if (!edges) return fail(edges.error());
    return in_columns(*edges, kinds, flags);
}

template <int D>
Outcome<Curved<D>> curve_boundary(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                  const Column<LagrangeNode<D>>& boundary_nodes, const Execution& execution) {
    if (auto fits = check_columns(mesh, kinds.size(), boundary_nodes.size()); !fits) return fail(fits.error());
    auto edges = map_each(execution, mesh.edges.size(), [&](std::size_t e) {
        return boundary_edge(mesh, e, kinds[e] == EdgeKind::volume ? mesh.mid_nodes[e] : boundary_nodes[e]);
    });
    if (!edges) return fail(edges.error());
    Buffer<SearchFlags> flags(mesh.edges.size());
    for (std::size_t e = 0; e < flags.size(); ++e) flags[e] = {.volume = kinds[e] == EdgeKind::volume};
    return in_columns(*edges, kinds, flags);
}

template <int D>
Outcome<Buffer<double>> updated_lengths(const QuadraticMesh<D>& mesh, const Proposal<D>& before,
                                        const Column<double>& lengths, const Proposal<D>& after,
                                        const Incidence<ElementId>& shells, const BackMesh<D>& back,
                                        const Execution& execution) {
    const Quadrature rule = gauss_legendre(report_points);
    return map_each(execution, mesh.edges.size(), [&](std::size_t e) {
        if (after.kinds[e] != EdgeKind::volume || shells[e].empty() || after.mid_nodes[e] == before.mid_nodes[e])
            return lengths[e];
        const auto& [a, b] = mesh.edges.vertices[e];
        const QuadraticEdge<D> edge{mesh.linear.points[a], after.mid_nodes[e], mesh.linear.points[b]};
        return riemannian_length(back, edge, rule, shells[e].front()).length;
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                \
    template Outcome<Curved<D>> curve<D>(const QuadraticMesh<D>&, const Column<EdgeKind>&,                   \
                                         const Column<LagrangeNode<D>>&, const Incidence<ElementId>&,        \
                                         const BackMesh<D>&, const EdgeMinimiserOptions&, const Execution&); \
    template Outcome<Curved<D>> curve_boundary<D>(const QuadraticMesh<D>&, const Column<EdgeKind>&,          \
                                                  const Column<LagrangeNode<D>>&, const Execution&);         \
    template Outcome<Buffer<double>> updated_lengths<D>(                                                     \
        const QuadraticMesh<D>&, const Proposal<D>&, const Column<double>&, const Proposal<D>&,              \
        const Incidence<ElementId>&, const BackMesh<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
