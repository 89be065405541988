// Creates dynamic meshes of volumes and of standalone surfaces.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <numeric>
#include <span>
#include <utility>
#include <vector>
module camber.cavity;
import camber.core;

namespace camber {

namespace {

template <int D>
Outcome<Done> check_sizes(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const BreaksOfMesh& breaks) {
    if (edges.of_elements.size() != mesh.elements.size() ||
        (!breaks.edge_kinds.empty() && breaks.edge_kinds.size() != edges.size()))
        return fail(ErrorKind::internal, "make_dynamic: the edges belong to another mesh");
    if (mesh.elements.size() >= 0x7fffffffU)
        return fail(ErrorKind::unsupported, "a mesh whose elements change can have at most 2147483646 elements");
    return Done{};
}

/// Errors: input, for the first element that lacks a facet on a face of the boundary or between two references.
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
    return fail(ErrorKind::input, "a face of the boundary or between two references is not in the list of facets", {},
                Entity{simplex_name<D>, *first + 1}, prepare_it);
}

template <class Columns>
Reference entity_of(const Columns& entities, std::size_t i) {
    return entities.empty() ? 0 : entities[i];
}
Marks kind_of(Marks marks) {
    Marks kind;
    for (const Mark mark : {Mark::ridge, Mark::implied, Mark::embedded})
        if (marks.has(mark)) kind |= mark;
    return kind;
}

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
    const auto is_break = [&](std::size_t e) {
        const auto facets = facet_shells[e];
        if (facets.empty()) return false;
        if (!breaks.edge_kinds.empty() && breaks.edge_kinds[e] == EdgeKind::ridge) return true;
        // An edge of a facet without elements becomes a line, because walks from element to element do not find that
        // facet.
        if (std::ranges::any_of(facets, [&](FacetId f) { return !sides[f][0].valid(); })) return true;
        return facets.size() != 2 || mesh.facets.references[facets[0]] != mesh.facets.references[facets[1]] ||
               entity_of(mesh.facets.entities, facets[0].index()) != entity_of(mesh.facets.entities, facets[1].index());
    };
    for (std::size_t e = 0; e < edges.size(); ++e)
        if (!lines.of_edges[e].valid() && is_break(e)) lines.add(EdgeId(e), 0, 0, Mark::implied);
    for (std::size_t l = 0; !breaks.edge_kinds.empty() && l < lines.edges.size(); ++l)
        if (breaks.edge_kinds[lines.edges[l].index()] != EdgeKind::ridge) lines.marks[l] |= Mark::embedded;
    return lines;
}

/// Lines (2D: facets) that meet at a vertex. `mixed`: they differ in reference, entity or kind.
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

/// Returns the states of all vertices. `inside`: ends of lines that have no facets.
template <int D>
Buffer<VertexState> places(const LinearMesh<D>& mesh, const DynamicMesh<D>& result, const BreaksOfMesh& breaks,
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
                meetings[v.index()].add(result.facets.references[f], entity_of(result.facets.entities, f), {});
        for (const std::uint32_t f : mesh.ridges)
            for (const VertexId v : mesh.facets.vertices[f]) states[v.index()].place = VertexPlace::corner;
    } else {
        for (std::size_t l = 0; l < result.lines.size(); ++l)
            for (const VertexId v : result.edges[result.lines[l]]) {
                meetings[v.index()].add(result.line_references[l], result.line_entities[l],
                                        kind_of(result.line_marks[l]));
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
            if (result.point_references[v] == group.reference) states[v].place = VertexPlace::corner;
    for (const VertexId v : breaks.corners) states[v.index()].place = VertexPlace::corner;
    return states;
}

template <int D>
void mark_input_data(const InputGeometry<D>& geometry, Buffer<VertexState>& states) {
    const auto mark = [&](VertexId v) { states[v.index()].marks |= Mark::has_input_data; };
    for (const auto& at : geometry.normals.at) mark(at.vertex);
    for (const auto& at : geometry.tangents.at) mark(at.vertex);
    for (const auto& on : geometry.on_points) mark(on.item);
    for (const auto& on : geometry.on_curves) mark(on.item);
    for (const auto& on : geometry.on_surfaces) mark(on.item);
}

template <int D>
Outcome<Done> freeze_vertices(const LinearMesh<D>& mesh, const DynamicMesh<D>& result,
                              const Incidence<ElementId>& balls, const EdgeSet<D>& edges, Buffer<VertexState>& states,
                              const Execution& execution) {
    for (std::size_t f = 0; f < result.sides.size(); ++f)
        if (!result.sides[f][0].valid())
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
            if (n == 0 ||
                (states[v].place != VertexPlace::inside && is_pinched(result, n, VertexId(v), *around, found)))
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
        auto result = with_faces(mesh, edges, *around, execution);
        if (!result) return result;
        if (auto checked = check_facets(*result, execution); !checked) return fail(checked.error());
        std::vector<VertexId> inside;
        if constexpr (D == 3) {
            const auto facets = facet_shells(edges, execution);
            if (!facets) return fail(facets.error());
            Lines lines = lines_of(mesh, edges, breaks, *facets, result->sides);
            result->line_of = std::move(lines.of_edges);
            result->lines = std::move(lines.edges);
            result->line_references = std::move(lines.references);
            result->line_entities = std::move(lines.entities);
            result->line_marks = std::move(lines.marks);
            for (const EdgeId line : result->lines)
                if ((*facets)[line].empty())
                    inside.insert(inside.end(), edges.vertices[line].begin(), edges.vertices[line].end());
        }
        auto states = places(mesh, *result, breaks, inside);
        for (const VertexId v : mesh.required_vertices) states[v.index()].marks |= Mark::required;
        mark_input_data(mesh.geometry, states);
        for (const VertexId v : at_infinity) states[v.index()] = {VertexPlace::infinity, Mark::frozen};
        result->at_infinity = Buffer<VertexId>(at_infinity.begin(), at_infinity.end());
        result->states = states;
        if (auto done = freeze_vertices(mesh, *result, *around, edges, states, execution); !done)
            return fail(done.error());
        result->states = std::move(states);
        result->stamp = new_stamp();
        return result;
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
        return fail(ErrorKind::internal, "a mesh of degree 2 must have one node for each edge");
    auto result = make_dynamic(mesh.linear, mesh.edges, breaks, execution);
    if (result) result->nodes = mesh.mid_nodes;
    return result;
}

namespace {

template <int K>
DynamicSimplices<K> with_marks(const Simplices<K>& simplices, Reference none) {
    Buffer<Marks> marks(simplices.size(), Marks{});
    for (const std::uint32_t i : simplices.required) marks[i] |= Mark::required;
    Column<Reference> references = simplices.references;
    if (references.size() != simplices.size()) references = Buffer<Reference>(simplices.size(), none);
    return {simplices.vertices, std::move(references), simplices.entities, std::move(marks)};
}

template <int D>
struct FacetPlace {
    FacetSides sides;
    std::array<int, 2> opposite{};
};
template <int D>
FacetPlace<D> place_of(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls, const SimplexVertices<D - 1>& f) {
    FacetPlace<D> place;
    int n = 0;
    for (const ElementId e : balls[f[0]]) {
        const auto& v = mesh.elements.vertices[e];
        int opposite = 0;
        int shared = 0;
        for (int i = 0; i <= D; ++i)
            if (std::find(f.begin(), f.end(), v[i]) == f.end())
                opposite = i;
            else
                ++shared;
        if (shared != D || n == 2) continue;
        place.sides[n] = e;
        place.opposite[n++] = opposite;
    }
    return place;
}

template <int D>
Outcome<Done> put_facets(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                         Buffer<std::array<FaceNeighbour, D + 1>>& across, Buffer<FacetSides>& sides,
                         const Execution& execution) {
    return each(execution, mesh.facets.size(), [&](std::size_t f) {
        const FacetPlace<D> place = place_of<D>(mesh, balls, mesh.facets.vertices[f]);
        sides[f] = place.sides;
        for (int side = 0; side < 2; ++side)
            if (place.sides[side].valid())
                across[place.sides[side].index()][place.opposite[side]] = FaceNeighbour(FacetId(f));
    });
}

template <int D>
Buffer<std::array<FaceNeighbour, D + 1>> faces_across(const Neighbours<D>& neighbours) {
    Buffer<std::array<FaceNeighbour, D + 1>> across(neighbours.size());
    for (std::size_t e = 0; e < across.size(); ++e)
        for (int i = 0; i <= D; ++i)
            across[e][i] = neighbours[e][i].valid() ? FaceNeighbour(neighbours[e][i]) : FaceNeighbour{};
    return across;
}

Buffer<Marks> with_ridges(Buffer<Marks> marks, const Column<std::uint32_t>& ridges) {
    for (const std::uint32_t f : ridges) marks[f] |= Mark::ridge;
    return marks;
}

}  // namespace

template <int D>
Outcome<DynamicMesh<D>> with_faces(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                   const Incidence<ElementId>& balls, const Execution& execution) {
    DynamicMesh<D> result;
    auto beside = neighbours(mesh, balls, execution);
    if (!beside) return fail(beside.error());
    auto across = faces_across<D>(*beside);
    Buffer<FacetSides> sides(mesh.facets.size());
    if (auto done = put_facets<D>(mesh, balls, across, sides, execution); !done) return fail(done.error());
    for (std::size_t f = 0; f < sides.size(); ++f)
        for (const ElementId side : sides[f])
            if (side.valid() &&
                std::ranges::find(across[side.index()], FaceNeighbour(FacetId(f))) == across[side.index()].end())
                return fail(ErrorKind::input, "two facets have the same vertices", {}, Entity{"facet", f + 1},
                            prepare_it);
    result.face_neighbours = std::move(across);
    result.sides = std::move(sides);
    result.elements = with_marks(mesh.elements, 0);
    result.facets = with_marks(mesh.facets, 0);
    if (D == 2) result.facets.marks = with_ridges(take(std::move(result.facets.marks)), mesh.ridges);
    auto element_of = map_each(execution, mesh.points.size(),
                               [&](std::size_t v) { return balls[v].empty() ? ElementId{} : balls[v].front(); });
    if (!element_of) return fail(element_of.error());
    result.element_of = std::move(*element_of);
    result.points = mesh.points;
    result.point_references = mesh.point_references.size() == mesh.points.size()
                                  ? mesh.point_references
                                  : Column<Reference>(Buffer<Reference>(mesh.points.size(), 0));
    result.edges_of = edges.of_elements;
    result.edges = edges.vertices;
    result.geometry = mesh.geometry;
    result.groups = mesh.groups;
    return result;
}

template <int D>
bool is_pinched(const DynamicMesh<D>& mesh, std::size_t around, VertexId v, const Incidence<ElementId>& shells,
                std::vector<ElementId>& found) {
    ball(mesh, v, found);
    if (found.size() != around) return true;
    if constexpr (D == 3) {
        const std::vector<ElementId> of_vertex = found;
        for (const ElementId e : of_vertex)
            for (int k = 0; k < edges_per_simplex<D>; ++k) {
                const EdgeId edge = mesh.edges_of[e][k];
                if (!mesh.line_at(edge).valid() || (mesh.edges[edge][0] != v && mesh.edges[edge][1] != v)) continue;
                shell(mesh, e, k, found);
                if (found.size() != shells[edge].size()) return true;
            }
    }
    return false;
}

namespace {

constexpr std::uint32_t no_piece = std::numeric_limits<std::uint32_t>::max();

/// Pieces of a surface, connected by edges of exactly two triangles. Triangles that share an edge of more than two
/// triangles with another triangle of their piece are in no piece, and do not change.
struct Pieces {
    Buffer<std::uint32_t> of;
    std::size_t count = 0;
};

std::uint32_t root(Buffer<std::uint32_t>& of, std::uint32_t i) {
    while (of[i] != i) i = of[i] = of[of[i]];
    return i;
}

Pieces pieces_of(const Incidence<FacetId>& around, std::size_t triangles) {
    Pieces pieces{Buffer<std::uint32_t>(triangles)};
    std::iota(pieces.of.begin(), pieces.of.end(), 0U);
    for (std::size_t e = 0; e < around.size(); ++e) {
        if (around[e].size() != 2) continue;
        const std::uint32_t a = root(pieces.of, around[e][0].value);
        const std::uint32_t b = root(pieces.of, around[e][1].value);
        pieces.of[std::max(a, b)] = std::min(a, b);
    }
    for (std::uint32_t f = 0; f < triangles; ++f) pieces.of[f] = root(pieces.of, f);
    std::vector<FacetId> stay;
    for (std::size_t e = 0; e < around.size(); ++e) {
        if (around[e].size() <= 2) continue;
        for (const FacetId f : around[e])
            if (std::ranges::any_of(around[e],
                                    [&](FacetId g) { return g != f && pieces.of[g.index()] == pieces.of[f.index()]; }))
                stay.push_back(f);
    }
    Buffer<std::uint32_t> numbers(triangles, no_piece);
    for (std::uint32_t& piece : pieces.of) {
        if (numbers[piece] == no_piece) numbers[piece] = static_cast<std::uint32_t>(pieces.count++);
        piece = numbers[piece];
    }
    for (const FacetId f : stay) pieces.of[f.index()] = no_piece;
    return pieces;
}

Reference reference_of_none(const Column<Reference>& references) {
    std::vector<Reference> used(references.begin(), references.end());
    std::ranges::sort(used);
    Reference free = 1;
    for (const Reference r : used)
        if (r == free) ++free;
    return free;
}

Simplices<2> with_faces_to_infinity(const LinearMesh<3>& mesh, const EdgeSet<3>& edges,
                                    const Incidence<FacetId>& around, const Pieces& pieces) {
    Simplices<2> facets = mesh.facets;
    Buffer<SimplexVertices<2>> result;
    const auto piece = [&](FacetId f) { return pieces.of[f.index()]; };
    for (std::size_t e = 0; e < around.size(); ++e) {
        const auto at = around[e];
        if (at.size() == 2 && piece(at[0]) != no_piece && piece(at[1]) != no_piece) continue;
        const auto& [a, b] = edges.vertices[e];
        for (const FacetId f : at)
            if (piece(f) != no_piece) result.push_back({a, b, VertexId(mesh.points.size() + piece(f))});
    }
    auto vertices = take(std::move(facets.vertices));
    auto references = facets.references.size() == mesh.facets.size() ? take(std::move(facets.references))
                                                                     : Buffer<Reference>(mesh.facets.size(), 0);
    references.insert(references.end(), result.size(), reference_of_none(mesh.facets.references));
    vertices.insert(vertices.end(), result.begin(), result.end());
    facets.vertices = std::move(vertices);
    facets.references = std::move(references);
    if (!facets.entities.empty()) {
        auto entities = take(std::move(facets.entities));
        entities.insert(entities.end(), result.size(), 0);
        facets.entities = std::move(entities);
    }
    return facets;
}

LinearMesh<3> joined_to_infinity(const LinearMesh<3>& mesh, const EdgeSet<3>& edges, const Incidence<FacetId>& around,
                                 const Pieces& pieces) {
    LinearMesh<3> joined = mesh;
    const std::size_t n = mesh.points.size();
    auto points = take(std::move(joined.points));
    points.resize(n + pieces.count, points.front());  // placeholder: the positions of vertices at infinity are never
                                                      // read
    joined.points = std::move(points);
    if (!joined.point_references.empty()) {
        auto references = take(std::move(joined.point_references));
        references.resize(n + pieces.count, 0);
        joined.point_references = std::move(references);
    }
    Buffer<SimplexVertices<3>> elements;
    elements.reserve(mesh.facets.size());
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        const auto& [a, b, c] = mesh.facets.vertices[f];
        if (pieces.of[f] != no_piece) elements.push_back({a, b, c, VertexId(n + pieces.of[f])});
    }
    joined.elements = {std::move(elements), {}, {}, {}};
    joined.facets = with_faces_to_infinity(mesh, edges, around, pieces);
    return joined;
}

/// Kinds of all edges. Edges to infinity have kind `surface`, because they are no ridges.
Buffer<EdgeKind> kinds_of(const EdgeSet<3>& joined, const EdgeSet<3>& edges, const BreaksOfMesh& breaks) {
    Buffer<EdgeKind> kinds(breaks.edge_kinds.empty() ? 0 : joined.size(), EdgeKind::surface);
    for (std::size_t e = 0; e < kinds.size(); ++e) {
        const auto& [a, b] = joined.vertices[e];
        if (const EdgeId of_surface = find_edge(edges, a, b); of_surface.valid())
            kinds[e] = breaks.edge_kinds[of_surface.index()];
    }
    return kinds;
}

}  // namespace

Outcome<DynamicMesh<3>> make_dynamic_surface(const LinearMesh<3>& mesh, const EdgeSet<3>& edges,
                                             const BreaksOfMesh& breaks, const Execution& execution) {
    if (mesh.elements.size() != 0 || mesh.facets.size() == 0)
        return fail(ErrorKind::internal, "make_dynamic_surface: the mesh is not a standalone surface mesh");
    if (!breaks.edge_kinds.empty() && breaks.edge_kinds.size() != edges.size())
        return fail(ErrorKind::internal, "make_dynamic_surface: the edges belong to another mesh");
    return guarded([&]() -> Outcome<DynamicMesh<3>> {
        const auto around = facet_shells(edges, without_progress(execution));
        if (!around) return fail(around.error());
        const Pieces pieces = pieces_of(*around, mesh.facets.size());
        if (pieces.count + mesh.points.size() >= max_entities)
            return fail(ErrorKind::unsupported, "the mesh has more vertices than 32 bits can number");
        const LinearMesh<3> joined = joined_to_infinity(mesh, edges, *around, pieces);
        const auto joined_edges = unique_edges(joined, without_progress(execution));
        if (!joined_edges) return fail(joined_edges.error());
        const Buffer<EdgeKind> kinds = kinds_of(*joined_edges, edges, breaks);
        Buffer<VertexId> at_infinity;
        for (std::size_t i = 0; i < pieces.count; ++i) at_infinity.push_back(VertexId(mesh.points.size() + i));
        return make_dynamic_with<3>(joined, *joined_edges, {kinds, breaks.corners}, at_infinity, execution);
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template Outcome<DynamicMesh<D>> make_dynamic_with<D>(                                                            \
        const LinearMesh<D>&, const EdgeSet<D>&, const BreaksOfMesh&, std::span<const VertexId>, const Execution&);   \
    template Outcome<DynamicMesh<D>> make_dynamic<D>(const QuadraticMesh<D>&, const BreaksOfMesh&, const Execution&); \
    template Outcome<DynamicMesh<D>> make_dynamic<D>(const LinearMesh<D>&, const EdgeSet<D>&, const BreaksOfMesh&,    \
                                                     const Execution&);                                               \
    template Outcome<DynamicMesh<D>> with_faces<D>(const LinearMesh<D>&, const EdgeSet<D>&,                           \
                                                   const Incidence<ElementId>&, const Execution&);                    \
    template bool is_pinched<D>(const DynamicMesh<D>&, std::size_t, VertexId, const Incidence<ElementId>&,            \
                                std::vector<ElementId>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
