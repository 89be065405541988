module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>
#include <utility>
#include <vector>
module camber.cavity;
import camber.core;

namespace camber {

namespace {

constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

/// The pieces of a surface, numbered by their first triangles: triangles that hang together by edges which two of them
/// share. None for a triangle that shares an edge of more than two with another one of its piece: it stays as it is.
struct Pieces {
    Buffer<std::uint32_t> of;  ///< each triangle's
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
    Buffer<std::uint32_t> numbers(triangles, none);
    for (std::uint32_t& piece : pieces.of) {
        if (numbers[piece] == none) numbers[piece] = static_cast<std::uint32_t>(pieces.count++);
        piece = numbers[piece];
    }
    for (const FacetId f : stay) pieces.of[f.index()] = none;
    return pieces;
}

/// One that no facet has.
Reference reference_of_none(const Column<Reference>& references) {
    std::vector<Reference> used(references.begin(), references.end());
    std::ranges::sort(used);
    Reference free = 1;
    for (const Reference r : used)
        if (r == free) ++free;
    return free;
}

/// The facets and those between the edges where a piece ends and its vertex at infinity.
Simplices<2> with_faces_to_infinity(const LinearMesh<3>& mesh, const EdgeSet<3>& edges,
                                    const Incidence<FacetId>& around, const Pieces& pieces) {
    Simplices<2> facets = mesh.facets;
    Buffer<SimplexVertices<2>> made;
    const auto piece = [&](FacetId f) { return pieces.of[f.index()]; };
    for (std::size_t e = 0; e < around.size(); ++e) {
        const auto at = around[e];
        if (at.size() == 2 && piece(at[0]) != none && piece(at[1]) != none) continue;
        const auto& [a, b] = edges.vertices[e];
        for (const FacetId f : at)
            if (piece(f) != none) made.push_back({a, b, VertexId(mesh.points.size() + piece(f))});
    }
    auto vertices = take(std::move(facets.vertices));
    auto references = facets.references.size() == mesh.facets.size() ? take(std::move(facets.references))
                                                                     : Buffer<Reference>(mesh.facets.size(), 0);
    references.insert(references.end(), made.size(), reference_of_none(mesh.facets.references));
    vertices.insert(vertices.end(), made.begin(), made.end());
    facets.vertices = std::move(vertices);
    facets.references = std::move(references);
    if (!facets.entities.empty()) {
        auto entities = take(std::move(facets.entities));
        entities.insert(entities.end(), made.size(), 0);
        facets.entities = std::move(entities);
    }
    return facets;
}

/// The surface with its pieces joined to infinity.
LinearMesh<3> joined_to_infinity(const LinearMesh<3>& mesh, const EdgeSet<3>& edges, const Incidence<FacetId>& around,
                                 const Pieces& pieces) {
    LinearMesh<3> joined = mesh;
    const std::size_t n = mesh.points.size();
    auto points = take(std::move(joined.points));
    points.resize(n + pieces.count, points.front());  // nobody asks where infinity is
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
        if (pieces.of[f] != none) elements.push_back({a, b, c, VertexId(n + pieces.of[f])});
    }
    joined.elements = {std::move(elements), {}, {}, {}};
    joined.facets = with_faces_to_infinity(mesh, edges, around, pieces);
    return joined;
}

/// The kinds of the joined mesh's edges: those of the surface as they were, nothing breaks along those to infinity.
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
        return fail(ErrorKind::internal, "make_dynamic_surface was given a mesh that is no surface alone");
    if (!breaks.edge_kinds.empty() && breaks.edge_kinds.size() != edges.size())
        return fail(ErrorKind::internal, "make_dynamic_surface was given edges of another mesh");
    return guarded([&]() -> Outcome<DynamicMesh<3>> {
        const auto around = facet_shells(edges, without_progress(execution));
        if (!around) return fail(around.error());
        const Pieces pieces = pieces_of(*around, mesh.facets.size());
        if (pieces.count + mesh.points.size() >= max_entities)
            return fail(ErrorKind::unsupported, "the mesh has more vertices than 32 bits count");
        const LinearMesh<3> joined = joined_to_infinity(mesh, edges, *around, pieces);
        const auto joined_edges = unique_edges(joined, without_progress(execution));
        if (!joined_edges) return fail(joined_edges.error());
        const Buffer<EdgeKind> kinds = kinds_of(*joined_edges, edges, breaks);
        Buffer<VertexId> at_infinity;
        for (std::size_t i = 0; i < pieces.count; ++i) at_infinity.push_back(VertexId(mesh.points.size() + i));
        return make_dynamic_with<3>(joined, *joined_edges, {kinds, breaks.corners}, at_infinity, execution);
    });
}

}  // namespace camber
