module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.cavity;
import :attempt;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;
import camber.programmes;
import camber.curving;
import camber.repair;

namespace camber {

namespace {

/// The edges of the removed elements by their vertices: the small table that the paper's step 1 makes.
template <int D>
std::vector<std::pair<std::array<VertexId, 2>, EdgeId>> edge_table(const EdgeSet<D>& edges,
                                                                   const std::vector<ElementId>& elements) {
    std::vector<EdgeId> all;
    all.reserve(elements.size() * edges_per_simplex<D>);
    for (const ElementId e : elements) all.insert(all.end(), edges.of_elements[e].begin(), edges.of_elements[e].end());
    all |= ranges::actions::sort | ranges::actions::unique;
    std::vector<std::pair<std::array<VertexId, 2>, EdgeId>> table;
    table.reserve(all.size());
    for (const EdgeId e : all) table.emplace_back(edges.vertices[e], e);
    return table;  // EdgeSet is sorted by vertices, so the table is
}

template <int D>
CavityEdges cavity_edges(const QuadraticMesh<D>& mesh, const StarMesh<D>& star, const QuadraticMesh<D>& small,
                         const std::vector<ElementId>& removed) {
    const auto table = edge_table<D>(mesh.edges, removed);
    CavityEdges out;
    out.of_mesh.resize(small.edges.size());
    for (std::size_t e = 0; e < small.edges.size(); ++e) {
        const auto& [a, b] = small.edges.vertices[e];
        const std::array key{star.vertices[a.index()], star.vertices[b.index()]};
        const auto it = std::lower_bound(table.begin(), table.end(), key,
                                         [](const auto& entry, const auto& k) { return entry.first < k; });
        // An edge of a facet or a ridge alone is in no element.
        out.of_mesh[e] = it != table.end() && it->first == key ? it->second : find_edge(mesh.edges, key[0], key[1]);
        if (a == star.point || b == star.point) out.inner.emplace_back(e);
    }
    return out;
}

template <int D>
Patch<D> patch_of(const Operation<D>& op, const std::vector<ElementId>& removed, VertexId point,
                  const Proposal<D>& planned, const Proposal<D>& wanted) {
    Patch<D> patch{point, removed, {}, {}, 0};
    patch.elements.reserve(op.small.linear.elements.size());
    for (const auto& local : op.small.linear.elements.vertices) {
        SimplexVertices<D> v;
        for (int i = 0; i <= D; ++i) v[i] = op.star.vertices[local[i].index()];
        patch.elements.push_back(v);
    }
    patch.nodes.reserve(op.edges.inner.size());
    for (const EdgeId e : op.edges.inner) {
        const auto& [a, b] = op.small.edges.vertices[e];
        patch.nodes.push_back({{op.star.vertices[a.index()], op.star.vertices[b.index()]},
                               op.edges.of_mesh[e.index()],
                               planned.mid_nodes[e],
                               planned.changes[e]});
        patch.relaxed_edges += planned.mid_nodes[e] != wanted.mid_nodes[e];
    }
    return patch;
}

}  // namespace

template <int D>
double misfit(const QuadraticMesh<D>& mesh, EdgeId edge, const LagrangeNode<D>& node, const LagrangeNode<D>& target) {
    if (node == target) return 0;
    const auto& [a, b] = mesh.edges.vertices[edge];
    const Vec<D> middle = midpoint(mesh.linear.points[a], mesh.linear.points[b]);
    const double offset = distance(target.point, middle);
    return offset > 0 ? std::min(1.0, distance(node.point, target.point) / offset) : 1.0;
}

template <int D>
Outcome<Reinsertion<D>> reinsert(const Curving<D>& curving, const CavityTopology<D>& topology, const BackMesh<D>& back,
                                 VertexId vertex, const EdgeRules& rules, const ReinsertOptions& options) {
    const Execution alone{.threads = 1};
    const Cavity<D> cavity = vertex_ball(topology, vertex);
    Reinsertion<D> out{vertex, Rejection{}, {}};
    if (cavity.elements.empty()) return out;

    const LinearMesh<D>& linear = curving.mesh.linear;
    const StarMesh<D> new_elements = star(linear, cavity, empty(linear, cavity));
    const auto small = elevate(new_elements.mesh, alone);
    if (!small) return fail(small.error());
    const auto edges = cavity_edges(curving.mesh, new_elements, *small, cavity.elements);
    const Operation<D> op{curving, new_elements, *small, edges};

    const auto target = [&](EdgeId e) {
        if (curving.known[e] != 0) return curving.targets[e];
        // Not from the node as it is: a target must not depend on when it is asked for.
        const LagrangeNode<D>& base = curving.base[e];
        auto t = curving.kinds[e] == EdgeKind::volume
                     ? volume_target(curving.mesh, e, base, topology.shells[e], back, rules, options.edge)
                     : boundary_target(curving.mesh, e, base);
        out.found.push_back({e, t});
        return t;
    };
    const Proposal<D> wanted = op.proposal([&](EdgeId e) {
        const EdgeTarget<D> t = target(e);
        return std::pair(t.node, t.change);
    });
    const Proposal<D> present =
        op.proposal([&](EdgeId e) { return std::pair(curving.mesh.mid_nodes[e], curving.changes[e]); });

    const ModelFit fit = options.edge.aim == CurvingAim::accuracy ? ModelFit::accuracy : ModelFit::length;
    const EdgeModels<D> models = [&](EdgeId e) {
        const EdgeId of_mesh = op.edges.of_mesh[e.index()];
        return edge_model(curving.mesh, of_mesh, wanted.mid_nodes[e], topology.shells[of_mesh], back, fit);
    };
    Attempt<D> best;
    const JacobianBound& wished = options.relax.min_scaled_jacobian;
    const double bound = wished.is_asked ? wished.value : least_bound;
    RepairOptions relax = options.relax;
    relax.min_scaled_jacobian = bound;
    for (const double asked : {options.relax.aim(), bound}) {
        auto attempt = repaired_from_targets(op, wanted, present, models, asked, relax);
        if (!attempt) return fail(attempt.error());
        if (!best.planned || attempt->serves_surface_better_than(best)) best = std::move(*attempt);
        if (best.planned && best.misfits.surface == 0) break;
    }
    Rejection rejection{ReinsertionFailure::no_gain, {}};
    if (!best.planned) {
        rejection = {ReinsertionFailure::not_valid, best.broken};
        best = stepped_from_present(op, wanted, present, bound);
    }
    if (is_worth_a_commit(op, best, wanted, present, bound))
        out.result = patch_of(op, cavity.elements, vertex, *best.planned, wanted);
    else
        out.result = rejection;
    return out;
}

#define CAMBER_INSTANTIATE(D)                                                                                     \
    template double misfit<D>(const QuadraticMesh<D>&, EdgeId, const LagrangeNode<D>&, const LagrangeNode<D>&);   \
    template Outcome<Reinsertion<D>> reinsert<D>(const Curving<D>&, const CavityTopology<D>&, const BackMesh<D>&, \
                                                 VertexId, const EdgeRules&, const ReinsertOptions&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
