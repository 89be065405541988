module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.cavity;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;

namespace camber {

namespace {

/// A patch that wins less than this over all its nodes is not worth a commit.
constexpr double least_gain = 1e-3;

/// The edges of a cavity in its small mesh, and which edges of the large one they are.
template <int D>
struct CavityEdges {
    std::vector<EdgeId> of_mesh;  ///< for each edge of the star
    std::vector<EdgeId> inner;    ///< edges of the star at its point: theirs is the freedom
};

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
CavityEdges<D> cavity_edges(const QuadraticMesh<D>& mesh, const Star<D>& star, const QuadraticMesh<D>& small,
                            const std::vector<ElementId>& removed) {
    const auto table = edge_table<D>(mesh.edges, removed);
    CavityEdges<D> out;
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

/// Surface before volume: sums of misfits.
struct Misfits {
    double surface = 0, volume = 0;
    void add(EdgeKind kind, double misfit) { (kind == EdgeKind::volume ? volume : surface) += misfit; }
    [[nodiscard]] bool better_than(const Misfits& other) const {
        if (surface < other.surface - least_gain) return true;
        return surface < other.surface + least_gain && volume < other.volume - least_gain;
    }
};

/// One reinsertion under way.
template <int D>
struct Operation {
    const Curving<D>& curving;
    const Star<D>& star;
    const QuadraticMesh<D>& small;
    const CavityEdges<D>& edges;

    /// The star with the nodes that the mesh has now, those at the point excepted: they are where `choose` says.
    template <class Choose>
    [[nodiscard]] Proposal<D> proposal(Choose&& choose) const {
        const std::size_t n = small.edges.size();
        Buffer<LagrangeNode<D>> nodes(n);
        Buffer<EdgeKind> kinds(n, EdgeKind::fixed);
        Buffer<EdgeChange> changes(n, EdgeChange::straight);
        for (std::size_t e = 0; e < n; ++e) nodes[e] = curving.mesh.mid_nodes[edges.of_mesh[e]];
        for (const EdgeId e : edges.inner) {
            const EdgeId of_mesh = edges.of_mesh[e.index()];
            kinds[e.index()] = curving.kinds[of_mesh];
            std::tie(nodes[e.index()], changes[e.index()]) = choose(of_mesh);
        }
        return {std::move(nodes), std::move(kinds), std::move(changes)};
    }

    [[nodiscard]] Misfits misfits(const Proposal<D>& nodes, const Proposal<D>& targets) const {
        Misfits sum;
        for (const EdgeId e : edges.inner)
            sum.add(targets.kinds[e], misfit(small, e, nodes.mid_nodes[e], targets.mid_nodes[e]));
        return sum;
    }
};

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

/// The first element that is valid now and would not be so any more; an invalid id when there is none.
template <int D>
ElementId first_broken(const Validation<D>& now, const Validation<D>& then, const Star<D>& star) {
    for (std::size_t e = 0; e < then.verdicts.size(); ++e)
        if (then.verdicts[e] != Verdict::valid && now.verdicts[e] == Verdict::valid) return star.replaces[e];
    return {};
}

/// Nodes for the star that break no element, if there are some.
template <int D>
struct Attempt {
    std::optional<Proposal<D>> planned;  ///< none when an element would break
    ElementId broken;                    ///< the first that would
    Misfits misfits;

    [[nodiscard]] bool serves_surface_better_than(const Attempt& other) const {
        return planned && misfits.surface < other.misfits.surface - least_gain;
    }
};

/// The first element that holds a bound with the nodes `present` and does not with those `planned`.
template <int D>
Outcome<ElementId> first_broken(const Operation<D>& op, const Proposal<D>& present, const Proposal<D>& planned,
                                double bound) {
    const Execution alone{.threads = 1};
    const auto then = validate(op.small, planned, bound, alone);
    if (!then) return fail(then.error());
    if (then->all_valid()) return ElementId{};
    const auto now = validate(op.small, present, bound, alone);
    if (!now) return fail(now.error());
    return first_broken(*now, *then, op.star);
}

/// Relaxed to `asked`, which may be more than the bound that options have.
template <int D>
Outcome<Attempt<D>> attempted(const Operation<D>& op, const Proposal<D>& wanted, const Proposal<D>& present,
                              double asked, RelaxOptions options) {
    const Execution alone{.threads = 1};
    const double bound = std::exchange(options.min_scaled_jacobian, asked);
    const auto validation = validate(op.small, wanted, asked, alone);
    if (!validation) return fail(validation.error());
    auto relaxed = relax(op.small, wanted, *validation, options, alone);
    if (!relaxed) return fail(relaxed.error());
    Attempt<D> attempt{{}, {}, op.misfits(relaxed->proposal, wanted)};
    if (!relaxed->validation.all_valid()) {
        // Elements that were short of what is asked before may stay so, but not fall below the bound.
        for (const double limit : {asked, bound}) {
            const auto broken = first_broken(op, present, relaxed->proposal, limit);
            if (!broken) return fail(broken.error());
            attempt.broken = *broken;
            if (broken->valid()) return attempt;
        }
    }
    attempt.planned = std::move(relaxed->proposal);
    return attempt;
}

template <int D>
Proposal<D> with_node(Proposal<D> proposal, EdgeId edge, const LagrangeNode<D>& node, EdgeChange change) {
    auto nodes = take(std::move(proposal.mid_nodes));
    auto changes = take(std::move(proposal.changes));
    nodes[edge.index()] = node;
    changes[edge.index()] = change;
    proposal.mid_nodes = std::move(nodes);
    proposal.changes = std::move(changes);
    return proposal;
}

/// Where relaxing from the targets fails, since the straight star does not fit its curved surroundings: from the nodes
/// as they are, one edge after the other a part of its way, as far as nothing breaks. Volume edges first: they make
/// room for those of the surface.
template <int D>
Outcome<Attempt<D>> stepped(const Operation<D>& op, const Proposal<D>& wanted, const Proposal<D>& present,
                            double bound) {
    std::vector<EdgeId> order = op.edges.inner;
    std::ranges::stable_partition(order, [&](EdgeId e) { return present.kinds[e] == EdgeKind::volume; });
    Proposal<D> planned = present;
    for (const EdgeId e : order)
        for (const double share : {1.0, 0.5, 0.25}) {
            const Vec<D> from = planned.mid_nodes[e].point;
            const LagrangeNode<D> goal = wanted.mid_nodes[e];
            if (goal.point == from) break;
            const bool whole = share == 1;
            const Proposal<D> next =
                with_node(planned, e, whole ? goal : LagrangeNode<D>{from + share * (goal.point - from)},
                          whole ? wanted.changes[e] : EdgeChange::relaxed);
            const auto broken = first_broken(op, present, next, bound);
            if (!broken) return fail(broken.error());
            if (broken->valid()) continue;
            planned = next;
            break;
        }
    const Misfits misfits = op.misfits(planned, wanted);
    return Attempt<D>{std::move(planned), {}, misfits};
}

/// Elements that do not hold the bound with these nodes.
template <int D>
Outcome<std::size_t> count_not_valid(const Operation<D>& op, const Proposal<D>& nodes, double bound) {
    return validate(op.small, nodes, bound, Execution{.threads = 1}).map([](const Validation<D>& v) {
        return v.invalid + v.undecided;
    });
}

/// Whether these nodes are worth a commit: nearer to their targets, or of fewer elements that are not valid.
template <int D>
Outcome<bool> gains(const Operation<D>& op, const Attempt<D>& attempt, const Proposal<D>& wanted,
                    const Proposal<D>& present, double bound) {
    if (attempt.misfits.better_than(op.misfits(present, wanted))) return true;
    const auto now = count_not_valid(op, present, bound);
    if (!now) return fail(now.error());
    if (*now == 0) return false;
    return count_not_valid(op, *attempt.planned, bound).map([&](std::size_t then) { return then < *now; });
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
    const Star<D> new_elements = star(linear, cavity, empty(linear, cavity));
    const auto small = elevate(new_elements.mesh, alone);
    if (!small) return fail(small.error());
    const auto edges = cavity_edges(curving.mesh, new_elements, *small, cavity.elements);
    const Operation<D> op{curving, new_elements, *small, edges};

    const auto target = [&](EdgeId e) {
        if (curving.known[e] != 0) return curving.targets[e];
        auto t = curving.kinds[e] == EdgeKind::volume
                     ? volume_target(curving.mesh, e, topology.shells[e], back, rules, options.edge)
                     : boundary_target(curving.mesh, e, curving.boundary_nodes[e]);
        out.found.push_back({e, t});
        return t;
    };
    const Proposal<D> wanted = op.proposal([&](EdgeId e) {
        const EdgeTarget<D> t = target(e);
        return std::pair(t.node, t.change);
    });
    const Proposal<D> present =
        op.proposal([&](EdgeId e) { return std::pair(curving.mesh.mid_nodes[e], curving.changes[e]); });

    Attempt<D> best;
    const double bound = options.relax.min_scaled_jacobian;
    for (const double asked : {std::max(bound, options.relax.target), bound}) {
        auto attempt = attempted(op, wanted, present, asked, options.relax);
        if (!attempt) return fail(attempt.error());
        if (!best.planned || attempt->serves_surface_better_than(best)) best = std::move(*attempt);
        if (best.planned && best.misfits.surface == 0) break;
    }
    Rejection rejection{RejectionReason::no_gain, {}};
    if (!best.planned) {
        rejection = {RejectionReason::not_valid, best.broken};
        auto attempt = stepped(op, wanted, present, bound);
        if (!attempt) return fail(attempt.error());
        best = std::move(*attempt);
    }
    const auto worth = gains(op, best, wanted, present, bound);
    if (!worth) return fail(worth.error());
    if (*worth)
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
