module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.cavity;
import camber.core;
import camber.metric;
import camber.validity;
import camber.programmes;
import camber.curving;
import camber.repair;

namespace camber {

namespace {

/// A node nearer to its target than this share of its offset is there.
constexpr double close_enough = 1e-2;

/// The walk over a mesh's vertices.
template <int D>
struct Walk {
    Curving<D> curving;
    const CavityTopology<D>& topology;
    const BackMesh<D>& back;
    const ReinsertAllOptions& options;
    EdgeRules rules;
    ReinsertStatistics statistics;
    std::vector<std::uint8_t> changed;  ///< vertices in a ball that was patched since their last turn
    std::size_t done = 0;               ///< vertices reinserted in this turn
    Schedule schedule{curving.mesh.linear.elements.size()};
};

template <int D>
Curving<D> nothing_known(QuadraticMesh<D> mesh, const Column<EdgeKind>& kinds, const Column<LagrangeNode<D>>& base) {
    const std::size_t n = mesh.edges.size();
    return {
        std::move(mesh),           kinds, base, Buffer<EdgeChange>(n, EdgeChange::straight), Buffer<EdgeTarget<D>>(n),
        Buffer<std::uint8_t>(n, 0)};
}

/// Known of all edges before the first cavity: nodes for accuracy are judged by element, and searches go in packs.
template <int D>
Outcome<Curving<D>> with_targets_of_edges(Curving<D> c, const Incidence<ElementId>& shells, const BackMesh<D>& back,
                                          const CurveOptions& options, const Execution& execution) {
    auto targets = edge_targets(c.mesh, c.kinds, c.base, shells, back, options, execution);
    if (!targets) return fail(targets.error());
    c.known = Buffer<std::uint8_t>(targets->size(), 1);
    c.targets = std::move(*targets);
    return c;
}

template <int D>
Curving<D> with_targets(Curving<D> curving, const std::vector<Reinsertion<D>>& round) {
    auto targets = take(std::move(curving.targets));
    auto known = take(std::move(curving.known));
    for (const auto& reinsertion : round)
        for (const auto& [edge, target] : reinsertion.found) {
            targets[edge.index()] = target;
            known[edge.index()] = 1;
        }
    curving.targets = std::move(targets);
    curving.known = std::move(known);
    return curving;
}

void count(ReinsertStatistics& statistics, const Rejection& rejection) {
    if (rejection.reason == ReinsertionFailure::not_valid) ++statistics.not_valid;
    if (rejection.reason == ReinsertionFailure::no_gain) ++statistics.no_gain;
}

/// Plans the cavities of these vertices, which do not overlap, against the mesh as it is, and commits what comes of it.
template <int D>
Outcome<Done> round(Walk<D>& walk, std::span<const VertexId> vertices, const Execution& execution) {
    auto planned = map_each(
        execution, vertices.size(),
        [&](std::size_t i) {
            return reinsert(walk.curving, walk.topology, walk.back, vertices[i], walk.rules, walk.options.cavity);
        },
        1);  // milliseconds each
    if (!planned) return fail(planned.error());
    std::vector<Reinsertion<D>> results;
    std::vector<Patch<D>> patches;
    results.reserve(planned->size());
    patches.reserve(planned->size());
    for (auto& outcome : *planned) {
        if (!outcome) return fail(outcome.error());
        results.push_back(std::move(*outcome));
    }
    walk.curving = with_targets(std::move(walk.curving), results);
    for (auto& [vertex, result, found] : results) {
        walk.changed[vertex.index()] = 0;
        if (const auto* rejection = std::get_if<Rejection>(&result)) {
            count(walk.statistics, *rejection);
            continue;
        }
        patches.push_back(std::move(std::get<Patch<D>>(result)));
        for (const auto& v : patches.back().elements)
            for (const VertexId w : v)
                if (w != vertex) walk.changed[w.index()] = 1;
    }
    walk.statistics.patches += patches.size();
    ++walk.statistics.rounds;
    auto committed = commit<D>(std::move(walk.curving), patches);
    if (!committed) return fail(committed.error());
    walk.curving = std::move(*committed);
    return Done{};
}

/// Reinserts all of these vertices, round by round, as if one after the other in the order of `spread_rank`.
template <int D>
Outcome<Done> reinsert_each(Walk<D>& walk, std::vector<VertexId> pending, std::size_t total,
                            const Execution& execution) {
    std::ranges::sort(pending, {}, [](VertexId v) { return spread_rank(v); });
    const auto do_round = [&](std::span<const VertexId> chosen) -> Outcome<bool> {
        std::vector<VertexId> vertices(chosen.begin(), chosen.end());
        std::ranges::sort(vertices);
        const auto share = [all = static_cast<double>(total)](std::size_t n) { return static_cast<double>(n) / all; };
        auto done = round<D>(walk, vertices, part_of(execution, share(walk.done), share(walk.done + vertices.size())));
        if (!done) return fail(done.error());
        walk.done += vertices.size();
        return true;
    };
    return in_rounds(
        walk.schedule, std::move(pending), Execution{execution.threads, execution.stop, {}},
        [](VertexId) { return false; }, [&](VertexId v) { return Claim(walk.topology.balls[v]); }, do_round);
}

/// 1 for vertices with an edge whose node is short of its target.
template <int D>
std::vector<std::uint8_t> short_of_target(const Curving<D>& c) {
    std::vector<std::uint8_t> marks(c.mesh.linear.points.size(), 0);
    for (std::size_t e = 0; e < c.mesh.edges.size(); ++e)
        if (c.known[e] != 0 && misfit(c.mesh, EdgeId(e), c.mesh.mid_nodes[e], c.targets[e].node) > close_enough)
            for (const VertexId v : c.mesh.edges.vertices[e]) marks[v.index()] = 1;
    return marks;
}

/// One turn over the vertices that `wanted` marks: volume, then boundary. 0 when there were none.
template <int D>
Outcome<std::size_t> turn(Walk<D>& walk, const Buffer<std::uint8_t>& boundary, const std::vector<std::uint8_t>& wanted,
                          const Execution& execution) {
    const auto total = static_cast<std::size_t>(std::count(wanted.begin(), wanted.end(), 1));
    walk.done = 0;
    for (const int side : {0, 1}) {
        std::vector<VertexId> vertices;
        vertices.reserve(total);
        for (std::size_t v = 0; v < wanted.size(); ++v)
            if (wanted[v] != 0 && boundary[v] == side) vertices.emplace_back(v);
        if (auto ok = reinsert_each(walk, std::move(vertices), total, execution); !ok) return fail(ok.error());
    }
    return total;
}

/// Edges that no cavity holds (of facets without elements) go straight to the geometry: no element is in the way.
template <int D>
Outcome<Curving<D>> with_bare_edges(Curving<D> c, const Incidence<ElementId>& shells) {
    std::vector<Reinsertion<D>> bare(1);
    Patch<D> patch;
    for (std::size_t e = 0; e < c.mesh.edges.size(); ++e) {
        if (!shells[e].empty()) continue;
        const EdgeId edge(e);
        const auto target =
            boundary_target(c.mesh, edge, c.kinds[e] == EdgeKind::volume ? c.mesh.mid_nodes[edge] : c.base[edge]);
        bare[0].found.push_back({edge, target});
        patch.nodes.push_back({c.mesh.edges.vertices[edge], edge, target.node, target.change});
    }
    c = with_targets(std::move(c), bare);
    return commit<D>(std::move(c), std::span(&patch, 1));
}

}  // namespace

template <int D>
Outcome<Reinserted<D>> reinsert_all(QuadraticMesh<D> mesh, const Column<EdgeKind>& kinds,
                                    const Column<LagrangeNode<D>>& base, const BackMesh<D>& back,
                                    const ReinsertAllOptions& options, const Execution& execution) {
    const std::size_t n = mesh.edges.size();
    if (kinds.size() != n || base.size() != n)
        return fail(ErrorKind::internal, "reinsert_all needs a kind and a boundary node for each of the " +
                                             std::to_string(n) + " edges, not " + std::to_string(kinds.size()) +
                                             " and " + std::to_string(base.size()));
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    if (auto checked = check_limits(options.cavity.edge); !checked) return fail(checked.error());
    const auto topology = cavity_topology(mesh, without_progress(execution));
    if (!topology) return fail(topology.error());
    const std::size_t vertices = mesh.linear.points.size();
    const auto boundary = boundary_vertices(mesh, kinds);
    auto aimed = with_targets_of_edges(nothing_known(std::move(mesh), kinds, base), topology->shells, back,
                                       options.cavity.edge, without_progress(execution));
    if (!aimed) return fail(aimed.error());
    auto begun = with_bare_edges(std::move(*aimed), topology->shells);
    if (!begun) return fail(begun.error());
    Walk<D> walk{std::move(*begun),
                 *topology,
                 back,
                 options,
                 edge_rules(options.cavity.edge),
                 {},
                 std::vector<std::uint8_t>(vertices, 1),
                 0};
    std::vector<std::uint8_t> wanted(vertices, 1);
    for (int t = 0; t < options.max_turns; ++t) {
        // Nobody knows how many turns there will be: each is taken for as long as all after it.
        const Execution of_turn = part_of(execution, 1 - std::ldexp(1.0, -t), 1 - std::ldexp(1.0, -t - 1));
        const auto reinserted = turn(walk, boundary, wanted, of_turn);
        if (!reinserted) return fail(reinserted.error());
        if (*reinserted == 0) break;
        ++walk.statistics.turns;
        wanted = short_of_target(walk.curving);
        for (std::size_t v = 0; v < vertices; ++v) wanted[v] = wanted[v] != 0 && walk.changed[v] != 0;
        walk.statistics.left = static_cast<std::size_t>(std::count(wanted.begin(), wanted.end(), 1));
    }
    Curving<D>& c = walk.curving;
    return Reinserted<D>{in_columns<D>(c.mesh.linear, c.targets.view(), kinds),
                         {c.mesh.linear.points, c.mesh.mid_nodes, kinds, c.changes},
                         std::move(c.mesh),
                         walk.statistics};
}

#define CAMBER_INSTANTIATE(D)                                                                           \
    template Outcome<Reinserted<D>> reinsert_all<D>(QuadraticMesh<D>, const Column<EdgeKind>&,          \
                                                    const Column<LagrangeNode<D>>&, const BackMesh<D>&, \
                                                    const ReinsertAllOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
