// Extends boundary displacements locally, moves nodes to extended positions, and slides nodes within planar boundary
// parts.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>
#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.repair;
import camber.core;
import camber.bezier;
import camber.extension;
import camber.validity;
import camber.curving;

namespace camber {

namespace {

template <int D>
std::vector<EdgeId> volume_edges(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                 const std::vector<ElementId>& elements) {
    std::vector<EdgeId> edges;
    for (const ElementId e : elements)
        for (const EdgeId edge : mesh.edges.of_elements[e])
            if (kinds[edge] == EdgeKind::volume) edges.push_back(edge);
    edges |= ranges::actions::sort | ranges::actions::unique;
    return edges;
}

std::vector<ElementId> elements_around(const Incidence<ElementId>& shells, const std::vector<EdgeId>& edges) {
    std::vector<ElementId> elements;
    for (const EdgeId edge : edges) elements.insert(elements.end(), shells[edge].begin(), shells[edge].end());
    elements |= ranges::actions::sort | ranges::actions::unique;
    return elements;
}

template <class Id>
struct Numbering {
    SparseMap<Id, Id> of = {};
    std::vector<Id> met = {};

    Id operator()(Id id) {
        Id& number = of.at(id);
        if (!number.valid()) {
            number = Id(met.size());
            met.push_back(id);
        }
        return number;
    }
};

template <int D>
struct Part {
    QuadraticMesh<D> mesh;
    Column<EdgeKind> kinds;     ///< `volume` for the free edges, else `fixed`
    std::vector<EdgeId> edges;  ///< number of each edge in the whole mesh
};

template <int D>
Part<D> part_of(const MovedMesh<D>& moved, const std::vector<ElementId>& elements, const std::vector<EdgeId>& free) {
    Numbering<VertexId> vertices;
    Numbering<EdgeId> edges;
    for (const EdgeId edge : free) edges(edge);
    Part<D> part;
    Buffer<SimplexVertices<D>> corners;
    Buffer<std::array<EdgeId, edges_per_simplex<D>>> of_elements;
    for (const ElementId e : elements) {
        SimplexVertices<D> v = moved.mesh.linear.elements.vertices[e];
        for (VertexId& vertex : v) vertex = vertices(vertex);
        auto own = moved.mesh.edges.of_elements[e];
        for (EdgeId& edge : own) edge = edges(edge);
        corners.push_back(v);
        of_elements.push_back(own);
    }
    Buffer<Vec<D>> points;
    for (const VertexId v : vertices.met) points.push_back(moved.points[v]);
    Buffer<std::array<VertexId, 2>> ends;
    Buffer<LagrangeNode<D>> nodes;
    Buffer<EdgeKind> kinds;
    for (const EdgeId edge : edges.met) {
        auto [a, b] = moved.mesh.edges.vertices[edge];
        ends.push_back({vertices(a), vertices(b)});
        kinds.push_back(nodes.size() < free.size() ? EdgeKind::volume : EdgeKind::fixed);
        nodes.push_back(moved.nodes[edge]);
    }
    part.mesh.linear.points = std::move(points);
    part.mesh.linear.elements.vertices = std::move(corners);
    part.mesh.edges.vertices = std::move(ends);
    part.mesh.edges.of_elements = std::move(of_elements);
    part.mesh.mid_nodes = std::move(nodes);
    part.kinds = std::move(kinds);
    part.edges = std::move(edges.met);
    return part;
}

}  // namespace

template <int D>
Outcome<LocalExtension<D>> extend_around(const MovedMesh<D>& moved, const Column<EdgeKind>& kinds,
                                         const Incidence<ElementId>& all_shells, const std::vector<ElementId>& seeds,
                                         int rings, const Execution& execution) {
    constexpr double iteration_work = 2e-3;  // work per unknown, in units of `edge_work`
    std::vector<EdgeId> free = volume_edges(moved.mesh, kinds, seeds);
    std::vector<ElementId> elements = elements_around(all_shells, free);
    for (int ring = 0; ring < rings; ++ring) {
        free = volume_edges(moved.mesh, kinds, elements);
        elements = elements_around(all_shells, free);
    }
    const Part<D> part = part_of(moved, elements, free);
    const auto part_shells = shells(part.mesh.edges, execution);
    if (!part_shells) return fail(part_shells.error());
    const auto extended = extend_boundary(part.mesh, part.kinds, part.mesh.mid_nodes, *part_shells, {}, execution);
    if (!extended) return fail(extended.error());
    LocalExtension<D> local;
    for (std::size_t i = 0; i < free.size(); ++i) local.nodes.at(free[i]) = extended->nodes[i];
    local.work = iteration_work * static_cast<double>(extended->solved) * extended->iterations;
    return local;
}

namespace {

/// A growing set of edges whose nodes move to their positions in `there`.
template <int D>
struct Growth {
    const MovedMesh<D>& moved;
    const Incidence<ElementId>& shells;
    const Column<EdgeKind>& kinds;
    const Overlay<EdgeId, LagrangeNode<D>>& there;
    SparseMap<EdgeId, std::uint8_t> chosen = {};
    std::vector<EdgeId> edges = {};

    [[nodiscard]] bool is_chosen(EdgeId edge) const {
        const std::uint8_t* mark = chosen.find(edge);
        return mark && *mark == 1;
    }
    [[nodiscard]] NodalSimplex<D> element(ElementId e) const {
        NodalSimplex<D> element = moved.element(e);
        const auto& edges_of = moved.mesh.edges.of_elements[e];
        for (int i = 0; i < edges_per_simplex<D>; ++i)
            if (is_chosen(edges_of[i])) element.nodes[D + 1 + i] = there[edges_of[i]].point;
        return element;
    }
    [[nodiscard]] std::vector<ElementId> around(const std::vector<EdgeId>& some) const {
        return elements_around(shells, some);
    }
    void choose(EdgeId edge) {
        chosen.at(edge) = 1;
        edges.push_back(edge);
    }
    std::vector<EdgeId> choose_all_of(ElementId e) {
        std::vector<EdgeId> added;
        for (const EdgeId edge : moved.mesh.edges.of_elements[e]) {
            if (kinds[edge] != EdgeKind::volume || is_chosen(edge)) continue;
            choose(edge);
            added.push_back(edge);
        }
        return added;
    }
};

template <int D>
void grow(Growth<D>& growth, const std::vector<ElementId>& seeds, double bound) {
    std::vector<ElementId> queue = seeds;
    while (!queue.empty()) {
        std::vector<EdgeId> added;
        for (const ElementId e : queue) {
            const auto own = growth.choose_all_of(e);
            added.insert(added.end(), own.begin(), own.end());
        }
        queue.clear();
        for (const ElementId e : growth.around(added))
            if (decide(growth.element(e), bound) != Verdict::valid) queue.push_back(e);
    }
}

template <int D>
void shrink(const RepairState<D>& state, Growth<D>& growth) {
    std::vector<ElementId> candidates = growth.around(growth.edges);
    while (!candidates.empty()) {
        std::vector<EdgeId> removed;
        for (const ElementId e : candidates) {
            if (!is_degraded(state, e, growth.element(e), verdict_of(state, e, growth.element(e)))) continue;
            for (const EdgeId edge : state.mesh().edges.of_elements[e]) {
                if (!growth.is_chosen(edge)) continue;
                growth.chosen.at(edge) = 0;
                removed.push_back(edge);
            }
        }
        candidates = growth.around(removed);
    }
    std::erase_if(growth.edges, [&](EdgeId e) { return !growth.is_chosen(e); });
}

/// Maximum number of steps of a node; all but the last cover half of the remaining distance.
constexpr int max_steps = 4;

template <int D>
Moves<D> restoring_moves(const RepairState<D>& state, const std::vector<ElementId>& elements,
                         const RestoredPosition<D>& restored, SparseMap<EdgeId, int>& steps) {
    const std::vector<EdgeId> edges = volume_edges(state.mesh(), state.kinds, elements);
    Moves<D> moves;
    for (const EdgeId edge : edges) {
        const auto there = restored(edge);
        const LagrangeNode<D>& now = state.moved.nodes[edge];
        if (!there || *there == now) continue;
        const bool last = ++steps.at(edge) >= max_steps;
        moves.nodes.emplace_back(edge, last ? *there : LagrangeNode<D>{midpoint(now.point, there->point)});
    }
    return moves;
}

template <int D>
std::vector<ElementId> elements_around_nodes(const RepairState<D>& state,
                                             const std::vector<std::pair<EdgeId, LagrangeNode<D>>>& nodes) {
    std::vector<ElementId> elements;
    for (const auto& [edge, node] : nodes)
        elements.insert(elements.end(), state.shells[edge].begin(), state.shells[edge].end());
    elements |= ranges::actions::sort | ranges::actions::unique;
    return elements;
}

template <int D>
Moves<D> plan_of(const RepairState<D>& state, Growth<D>& growth) {
    Moves<D> plan;
    for (const ElementId e : growth.around(growth.edges))
        plan.verdicts.emplace_back(e, verdict_of(state, e, growth.element(e)));
    growth.edges |= ranges::actions::sort;
    plan.nodes.reserve(growth.edges.size());
    for (const EdgeId edge : growth.edges) plan.nodes.emplace_back(edge, growth.there[edge]);
    return plan;
}

}  // namespace

template <int D>
Outcome<Done> restore_nodes(RepairState<D>& state, std::vector<ElementId> queue, const RestoredPosition<D>& restored,
                            const Execution& execution) {
    const double requested = state.options.effective_target();
    SparseMap<EdgeId, int> steps;
    while (!queue.empty()) {
        const auto moves = restoring_moves(state, queue, restored, steps);
        if (moves.nodes.empty()) break;
        state.moved.apply(moves);
        const std::vector<ElementId> touched = elements_around_nodes(state, moves.nodes);
        const auto judged = map_each(execution, touched.size(), [&](std::size_t i) {
            const NodalSimplex<D> element = state.element(touched[i]);
            const Verdict verdict = verdict_of(state, touched[i], element);
            return std::pair(verdict, verdict == Verdict::valid && decide(element, requested) == Verdict::valid);
        });
        if (!judged) return fail(judged.error());
        std::vector<ElementId> next;
        for (std::size_t i = 0; i < touched.size(); ++i) {
            const auto& [verdict, reached] = (*judged)[i];
            state.moved.verdicts.set(touched[i], verdict);
            const bool waits = !reached && std::ranges::binary_search(queue, touched[i]);
            if (verdict != Verdict::valid || waits) next.push_back(touched[i]);
        }
        queue = std::move(next);
    }
    return Done{};
}

template <int D>
Moves<D> plan_towards(const RepairState<D>& state, const Overlay<EdgeId, LagrangeNode<D>>& there) {
    Growth<D> growth{state.moved, state.shells, state.kinds, there};
    for (const EdgeId edge : there.set_rows())
        if (there[edge] != state.moved.nodes[edge]) growth.choose(edge);
    shrink(state, growth);
    return plan_of(state, growth);
}

namespace {

/// Tolerance for coplanar points, as a share of the chord.
constexpr double flat = 1e-9;

std::optional<Vec<3>> plane_of(const QuadraticMesh<3>& mesh, const Column<LagrangeNode<3>>& nodes,
                               const Incidence<FacetId>& around, std::size_t e) {
    const auto& [a, b] = mesh.edges.vertices[e];
    const Vec<3>& origin = mesh.linear.points[a];
    const double chord = norm(mesh.linear.points[b] - origin);
    std::optional<Vec<3>> normal;
    for (const FacetId f : around[e]) {
        const auto& v = mesh.linear.facets.vertices[f];
        const auto point = [&](int i) { return mesh.linear.points[v[i]]; };
        if (!normal) normal = normalised(cross(point(1) - point(0), point(2) - point(0)));
        for (int i = 0; i < 3; ++i) {
            const Vec<3>& node = nodes[mesh.edges.of_facets[f][i]].point;
            if (!(std::abs(dot(point(i) - origin, *normal)) <= flat * chord)) return {};
            if (!(std::abs(dot(node - origin, *normal)) <= flat * chord)) return {};
        }
    }
    return normal;
}

}  // namespace

Outcome<Proposal<3>> slid_in_planes(const JudgedProposal<3>& judged, double tolerance, const Execution& execution) {
    const Proposal<3>& proposal = judged.proposal();
    const QuadraticMesh<3> mesh = apply_proposal(judged.mesh(), proposal);
    const auto around = facet_shells(mesh.edges, execution);
    if (!around) return fail(around.error());
    const auto elements = shells(mesh.edges, execution);
    if (!elements) return fail(elements.error());
    std::vector<std::optional<Vec<3>>> normals(mesh.edges.size());
    Buffer<EdgeKind> kinds(proposal.kinds.begin(), proposal.kinds.end());
    for (std::size_t e = 0; e < kinds.size(); ++e) {
        if (kinds[e] != EdgeKind::surface) continue;
        normals[e] = plane_of(mesh, proposal.mid_nodes, *around, e);
        if (normals[e]) kinds[e] = EdgeKind::volume;
    }
    const Column<EdgeKind> free(std::move(kinds));
    auto extension = extend_boundary(mesh, free, proposal.mid_nodes, *elements, {}, execution);
    if (!extension) return fail(extension.error());
    Overlay<EdgeId, LagrangeNode<3>> there(Column<LagrangeNode<3>>(std::move(extension->nodes)));
    for (std::size_t e = 0; e < normals.size(); ++e) {
        if (!normals[e]) continue;
        const EdgeId edge(e);
        Vec<3> slide = there[edge].point - proposal.mid_nodes[edge].point;
        slide -= dot(slide, *normals[e]) * *normals[e];
        const double length = norm(slide);
        if (length > tolerance) slide *= (1 - 1e-9) * tolerance / length;
        there.set(edge, {proposal.mid_nodes[edge].point + slide});
    }
    const MovedMesh<3> moved(judged);
    Growth<3> growth{moved, *elements, free, there};
    grow(growth, elements_not_valid(judged.validation()), judged.validation().bound);
    Overlay<EdgeId, LagrangeNode<3>> nodes(proposal.mid_nodes);
    for (const EdgeId edge : growth.edges) nodes.set(edge, there[edge]);
    Proposal<3> slid = proposal;
    slid.mid_nodes = nodes.column();
    return slid;
}

#define CAMBER_INSTANTIATE(D)                                                                                        \
    template Outcome<LocalExtension<D>> extend_around<D>(const MovedMesh<D>&, const Column<EdgeKind>&,               \
                                                         const Incidence<ElementId>&, const std::vector<ElementId>&, \
                                                         int, const Execution&);                                     \
    template Outcome<Done> restore_nodes<D>(RepairState<D>&, std::vector<ElementId>, const RestoredPosition<D>&,     \
                                            const Execution&);                                                       \
    template Moves<D> plan_towards<D>(const RepairState<D>&, const Overlay<EdgeId, LagrangeNode<D>>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
