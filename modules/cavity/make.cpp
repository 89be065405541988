module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.cavity;
import camber.core;
import :with_faces;

namespace camber {

namespace {

template <int D>
Outcome<Done> check_sizes(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const BreaksOfMesh& breaks) {
    if (edges.of_elements.size() != mesh.elements.size() ||
        (!breaks.edge_kinds.empty() && breaks.edge_kinds.size() != edges.size()))
        return fail(ErrorKind::internal, "make_dynamic was given edges of another mesh");
    if (mesh.elements.size() >= 0x7fffffffU)
        return fail(ErrorKind::unsupported, "a mesh that changes has at most 2147483646 elements");
    return Done{};
}

/// Faces of the boundary and between references must be facets: of the first element with one that is not.
template <int D>
Outcome<Done> check_facets(const DynamicMesh<D>& mesh, const Execution& execution) {
    const std::size_t none = mesh.elements.size();
    const auto first = reduce_each(
        execution, none, none,
        [&](std::size_t& least, std::size_t e) {
            for (const FaceNeighbour a : mesh.face_neighbours[e])
                if (!a.valid() ||
                    (a.is_element() && mesh.elements.references[a.element()] != mesh.elements.references[e]))
                    least = std::min(least, e);
        },
        [](std::size_t a, std::size_t b) { return std::min(a, b); });
    if (!first) return fail(first.error());
    if (*first == none) return Done{};
    return fail(ErrorKind::input, "a face of the boundary, or between two references, is no facet", {},
                Entity{simplex_name<D>, *first + 1}, prepare_it);
}

template <class Columns>
Reference entity_of(const Columns& entities, std::size_t i) {
    return entities.empty() ? 0 : entities[i];
}
/// What tells lines apart that a vertex may not lie between.
Marks kind_of(Marks marks) {
    Marks kind;
    for (const Mark mark : {Mark::ridge, Mark::implied, Mark::embedded})
        if (marks.has(mark)) kind |= mark;
    return kind;
}

/// Lines as columns, in the making.
struct Lines {
    Buffer<LineId> of_edges;
    Buffer<EdgeId> edges;
    Buffer<Reference> references, entities;
    Buffer<Marks> marks;

    void add(EdgeId edge, Reference reference, Reference entity, Marks mark) {
        of_edges[edge.index()] = LineId(edges.size());
        edges.push_back(edge);
        references.push_back(reference);
        entities.push_back(entity);
        marks.push_back(mark);
    }
};

Lines lines_of(const LinearMesh<3>& mesh, const EdgeSet<3>& edges, const BreaksOfMesh& breaks,
               const Incidence<FacetId>& facet_shells, const Column<FacetSides>& sides) {
    Lines lines;
    lines.of_edges.assign(edges.size(), LineId{});
    const auto& listed = mesh.edges;
    for (std::size_t i = 0; i < listed.size(); ++i)
        if (!lines.of_edges[edges.of_edges[i].index()].valid())
            lines.add(edges.of_edges[i], listed.references.empty() ? 0 : listed.references[i],
                      listed.entities.empty() ? 0 : listed.entities[i], {});
    const auto mark = [&](std::uint32_t row, Mark m) {
        lines.marks[lines.of_edges[edges.of_edges[row].index()].index()] |= m;
    };
    for (const std::uint32_t row : listed.required) mark(row, Mark::required);
    for (const std::uint32_t row : mesh.ridges) mark(row, Mark::ridge);
    const auto breaks_here = [&](std::size_t e) {
        const auto facets = facet_shells[e];
        if (facets.empty()) return false;
        if (!breaks.edge_kinds.empty() && breaks.edge_kinds[e] == EdgeKind::ridge) return true;
        // A facet on no element has neighbours that no walk finds.
        if (std::ranges::any_of(facets, [&](FacetId f) { return !sides[f][0].valid(); })) return true;
        return facets.size() != 2 || mesh.facets.references[facets[0]] != mesh.facets.references[facets[1]] ||
               entity_of(mesh.facets.entities, facets[0].index()) != entity_of(mesh.facets.entities, facets[1].index());
    };
    for (std::size_t e = 0; e < edges.size(); ++e)
        if (!lines.of_edges[e].valid() && breaks_here(e)) lines.add(EdgeId(e), 0, 0, Mark::implied);
    for (std::size_t l = 0; !breaks.edge_kinds.empty() && l < lines.edges.size(); ++l)
        if (breaks.edge_kinds[lines.edges[l].index()] != EdgeKind::ridge) lines.marks[l] |= Mark::embedded;
    return lines;
}

/// How many lines (2D: facets) a vertex has, and whether they are of one reference, entity and kind.
struct Meeting {
    std::uint32_t count = 0;
    Reference reference = 0, entity = 0;
    Marks marks;
    bool mixed = false;
    void add(Reference other, Reference other_entity, Marks other_marks) {
        mixed = mixed || (count > 0 && (other != reference || other_entity != entity || other_marks != marks));
        reference = other;
        entity = other_entity;
        marks = other_marks;
        ++count;
    }
};

/// Places of vertices, from what meets in them. `inside`: ends of lines in the volume, which are on no facet.
template <int D>
Buffer<VertexState> places(const LinearMesh<D>& mesh, const DynamicMesh<D>& made, const BreaksOfMesh& breaks,
                           std::span<const VertexId> inside) {
    Buffer<VertexState> states(mesh.points.size(), VertexState{});
    for (const auto& f : mesh.facets.vertices)
        for (const VertexId v : f) states[v.index()].place = VertexPlace::surface;
    std::vector<VertexId> on_walls;
    std::copy_if(inside.begin(), inside.end(), std::back_inserter(on_walls),
                 [&](VertexId v) { return states[v.index()].place == VertexPlace::surface; });
    std::vector<Meeting> meetings(mesh.points.size());
    if constexpr (D == 2) {
        for (std::size_t f = 0; f < mesh.facets.size(); ++f)
            for (const VertexId v : mesh.facets.vertices[f])
                meetings[v.index()].add(made.facets.references[f], entity_of(made.facets.entities, f), {});
        for (const std::uint32_t f : mesh.ridges)
            for (const VertexId v : mesh.facets.vertices[f]) states[v.index()].place = VertexPlace::corner;
    } else {
        for (std::size_t l = 0; l < made.lines.size(); ++l)
            for (const VertexId v : made.edges[made.lines[l]]) {
                meetings[v.index()].add(made.line_references[l], made.line_entities[l], kind_of(made.line_marks[l]));
                states[v.index()].place = VertexPlace::line;
            }
    }
    for (std::size_t v = 0; v < states.size(); ++v)
        if (meetings[v].count > 0 && (meetings[v].count != 2 || meetings[v].mixed))
            states[v].place = VertexPlace::corner;
    for (const VertexId v : on_walls) states[v.index()].place = VertexPlace::corner;
    for (const VertexId v : mesh.corners) states[v.index()] = {VertexPlace::corner, Mark::corner};
    for (const auto& on : mesh.geometry.on_points) states[on.item.index()].place = VertexPlace::corner;
    for (const Group& group : mesh.groups)
        for (std::size_t v = 0; group.dimension == 0 && v < states.size(); ++v)
            if (made.point_references[v] == group.reference) states[v].place = VertexPlace::corner;
    for (const VertexId v : breaks.corners) states[v.index()].place = VertexPlace::corner;
    return states;
}

template <int D>
void mark_given(const GivenGeometry<D>& geometry, Buffer<VertexState>& states) {
    const auto mark = [&](VertexId v) { states[v.index()].marks |= Mark::given; };
    for (const auto& at : geometry.normals.at) mark(at.vertex);
    for (const auto& at : geometry.tangents.at) mark(at.vertex);
    for (const auto& on : geometry.on_points) mark(on.item);
    for (const auto& on : geometry.on_curves) mark(on.item);
    for (const auto& on : geometry.on_surfaces) mark(on.item);
}

/// The vertices at infinity are as they are.
template <int D>
Outcome<Done> hold(const LinearMesh<D>& mesh, const DynamicMesh<D>& made, const Incidence<ElementId>& balls,
                   const EdgeSet<D>& edges, Buffer<VertexState>& states, const Execution& execution) {
    for (std::size_t f = 0; f < made.sides.size(); ++f)
        if (!made.sides[f][0].valid())
            for (const VertexId v : mesh.facets.vertices[f]) states[v.index()].marks |= Mark::frozen;
    const auto around = shells(edges, execution);
    if (!around) return fail(around.error());
    for (std::size_t e = 0; e < edges.size(); ++e)
        if ((*around)[e].empty())
            for (const VertexId v : edges.vertices[e]) states[v.index()].marks |= Mark::frozen;
    return each_chunk(execution, states.size(), [&](std::size_t begin, std::size_t end) {
        std::vector<ElementId> found;
        for (std::size_t v = begin; v < end; ++v) {
            const auto n = balls[v].size();
            if (states[v].place == VertexPlace::infinity) continue;
            if (n == 0 || (states[v].place != VertexPlace::inside && is_pinched(made, n, VertexId(v), *around, found)))
                states[v].marks |= Mark::frozen;
        }
    });
}

}  // namespace

template <int D>
Outcome<DynamicMesh<D>> make_dynamic_with(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                          const BreaksOfMesh& breaks, std::span<const VertexId> at_infinity,
                                          const Execution& execution) {
    return guarded([&]() -> Outcome<DynamicMesh<D>> {
        if (auto checked = check_sizes(mesh, edges, breaks); !checked) return fail(checked.error());
        const auto around = balls(mesh, execution);
        if (!around) return fail(around.error());
        auto made = with_faces(mesh, edges, *around, execution);
        if (!made) return made;
        if (auto checked = check_facets(*made, execution); !checked) return fail(checked.error());
        std::vector<VertexId> inside;
        if constexpr (D == 3) {
            const auto facets = facet_shells(edges, execution);
            if (!facets) return fail(facets.error());
            Lines lines = lines_of(mesh, edges, breaks, *facets, made->sides);
            made->line_of = std::move(lines.of_edges);
            made->lines = std::move(lines.edges);
            made->line_references = std::move(lines.references);
            made->line_entities = std::move(lines.entities);
            made->line_marks = std::move(lines.marks);
            for (const EdgeId line : made->lines)
                if ((*facets)[line].empty())
                    inside.insert(inside.end(), edges.vertices[line].begin(), edges.vertices[line].end());
        }
        auto states = places(mesh, *made, breaks, inside);
        for (const VertexId v : mesh.required_vertices) states[v.index()].marks |= Mark::required;
        mark_given(mesh.geometry, states);
        for (const VertexId v : at_infinity) states[v.index()] = {VertexPlace::infinity, Mark::frozen};
        made->at_infinity = Buffer<VertexId>(at_infinity.begin(), at_infinity.end());
        made->states = states;
        if (auto done = hold(mesh, *made, *around, edges, states, execution); !done) return fail(done.error());
        made->states = std::move(states);
        made->stamp = new_stamp();
        return made;
    });
}

template <int D>
Outcome<DynamicMesh<D>> make_dynamic(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const BreaksOfMesh& breaks,
                                     const Execution& execution) {
    return make_dynamic_with<D>(mesh, edges, breaks, {}, execution);
}

template <int D>
Outcome<DynamicMesh<D>> make_dynamic(const QuadraticMesh<D>& mesh, const BreaksOfMesh& breaks,
                                     const Execution& execution) {
    if (mesh.mid_nodes.size() != mesh.edges.size())
        return fail(ErrorKind::internal, "a mesh of degree 2 has not one node for each edge");
    auto made = make_dynamic(mesh.linear, mesh.edges, breaks, execution);
    if (made) made->nodes = mesh.mid_nodes;
    return made;
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template Outcome<DynamicMesh<D>> make_dynamic_with<D>(                                                            \
        const LinearMesh<D>&, const EdgeSet<D>&, const BreaksOfMesh&, std::span<const VertexId>, const Execution&);   \
    template Outcome<DynamicMesh<D>> make_dynamic<D>(const QuadraticMesh<D>&, const BreaksOfMesh&, const Execution&); \
    template Outcome<DynamicMesh<D>> make_dynamic<D>(const LinearMesh<D>&, const EdgeSet<D>&, const BreaksOfMesh&,    \
                                                     const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
