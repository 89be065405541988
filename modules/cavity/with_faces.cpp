module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.cavity;
import camber.core;
import :with_faces;

namespace camber {

namespace {

template <int K>
DynamicSimplices<K> with_marks(const Simplices<K>& simplices, Reference none) {
    Buffer<Marks> marks(simplices.size(), Marks{});
    for (const std::uint32_t i : simplices.required) marks[i] |= Mark::required;
    Column<Reference> references = simplices.references;
    if (references.size() != simplices.size()) references = Buffer<Reference>(simplices.size(), none);
    return {simplices.vertices, std::move(references), simplices.entities, std::move(marks)};
}

/// The elements that have a facet as a face, by rising number, and which local vertex is opposite.
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

/// In 2D ridges are facets.
Buffer<Marks> with_ridges(Buffer<Marks> marks, const Column<std::uint32_t>& ridges) {
    for (const std::uint32_t f : ridges) marks[f] |= Mark::ridge;
    return marks;
}

}  // namespace

template <int D>
Outcome<DynamicMesh<D>> with_faces(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                   const Incidence<ElementId>& balls, const Execution& execution) {
    DynamicMesh<D> made;
    auto beside = neighbours(mesh, balls, execution);
    if (!beside) return fail(beside.error());
    auto across = faces_across<D>(*beside);
    Buffer<FacetSides> sides(mesh.facets.size());
    if (auto done = put_facets<D>(mesh, balls, across, sides, execution); !done) return fail(done.error());
    for (std::size_t f = 0; f < sides.size(); ++f)
        for (const ElementId side : sides[f])
            if (side.valid() &&
                std::ranges::find(across[side.index()], FaceNeighbour(FacetId(f))) == across[side.index()].end())
                return fail(ErrorKind::input, "two facets are on one face", {}, Entity{"facet", f + 1}, prepare_it);
    made.face_neighbours = std::move(across);
    made.sides = std::move(sides);
    made.elements = with_marks(mesh.elements, 0);
    made.facets = with_marks(mesh.facets, 0);
    if (D == 2) made.facets.marks = with_ridges(take(std::move(made.facets.marks)), mesh.ridges);
    auto element_of = map_each(execution, mesh.points.size(),
                               [&](std::size_t v) { return balls[v].empty() ? ElementId{} : balls[v].front(); });
    if (!element_of) return fail(element_of.error());
    made.element_of = std::move(*element_of);
    made.points = mesh.points;
    made.point_references = mesh.point_references.size() == mesh.points.size()
                                ? mesh.point_references
                                : Column<Reference>(Buffer<Reference>(mesh.points.size(), 0));
    made.edges_of = edges.of_elements;
    made.edges = edges.vertices;
    made.geometry = mesh.geometry;
    made.groups = mesh.groups;
    return made;
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

#define CAMBER_INSTANTIATE(D)                                                                              \
    template Outcome<DynamicMesh<D>> with_faces<D>(const LinearMesh<D>&, const EdgeSet<D>&,                \
                                                   const Incidence<ElementId>&, const Execution&);         \
    template bool is_pinched<D>(const DynamicMesh<D>&, std::size_t, VertexId, const Incidence<ElementId>&, \
                                std::vector<ElementId>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
