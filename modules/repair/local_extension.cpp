module;
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.repair;
import :local_extension;
import :moved_mesh;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.curving;

namespace camber {

namespace {

/// The volume edges of the elements, rising.
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

std::vector<ElementId> around(const Incidence<ElementId>& shells, const std::vector<EdgeId>& edges) {
    std::vector<ElementId> elements;
    for (const EdgeId edge : edges) elements.insert(elements.end(), shells[edge].begin(), shells[edge].end());
    elements |= ranges::actions::sort | ranges::actions::unique;
    return elements;
}

/// The numbers that things of the mesh have in a part of it, in the order in which they are met.
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

/// A part of a mesh as a mesh, with the places that it has now.
template <int D>
struct Part {
    QuadraticMesh<D> mesh;
    Column<EdgeKind> kinds;     ///< those of `free` of the volume, all others given
    std::vector<EdgeId> edges;  ///< of the whole mesh
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
    constexpr double iteration_work = 2e-3;  // of an edge
    std::vector<EdgeId> free = volume_edges(moved.mesh, kinds, seeds);
    std::vector<ElementId> elements = around(all_shells, free);
    for (int ring = 0; ring < rings; ++ring) {
        free = volume_edges(moved.mesh, kinds, elements);
        elements = around(all_shells, free);
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

#define CAMBER_INSTANTIATE(D)                                                                                        \
    template Outcome<LocalExtension<D>> extend_around<D>(const MovedMesh<D>&, const Column<EdgeKind>&,               \
                                                         const Incidence<ElementId>&, const std::vector<ElementId>&, \
                                                         int, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
