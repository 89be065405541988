module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <utility>
#include <vector>
module camber.shapes;
import camber.core;

namespace camber {

namespace {

template <int D>
Outcome<Done> check_volumes(const LinearMesh<D>& mesh) {
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        if (!(determinant(mesh.points, mesh.elements.vertices[e]) > 0))
            return fail(ErrorKind::usage, "the generator made an element without positive volume", {},
                        Entity{simplex_name<D>, e + 1}, "the sizes do not fit together");
    return Done{};
}

template <int D>
Outcome<Simplices<D - 1>> boundary_facets(const LinearMesh<D>& mesh, const FacetReference<D>& facet_reference) {
    const Execution execution;
    const auto around = balls(mesh, execution);
    if (!around) return fail(around.error());
    const auto adjacent = neighbours(mesh, *around, execution);
    if (!adjacent) return fail(adjacent.error());
    Buffer<SimplexVertices<D - 1>> vertices;
    Buffer<Reference> references;
    const auto& material = mesh.elements.references;
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        for (int opposite = 0; opposite <= D; ++opposite) {
            const ElementId other = (*adjacent)[e][opposite];
            if (other.valid() && material[other] <= material[e]) continue;  // inside, or seen from the other side
            SimplexVertices<D - 1> facet;
            const auto local = face_opposite<D>(opposite);
            for (int i = 0; i < D; ++i) facet[i] = mesh.elements.vertices[e][local[i]];
            vertices.push_back(facet);
            references.push_back(facet_reference(facet));
        }
    return Simplices<D - 1>{std::move(vertices), std::move(references), {}};
}

/// The references of the facets at each vertex: bounded by few, so a small sorted list.
template <int D>
std::map<VertexId, std::set<Reference>> references_at_vertices(const LinearMesh<D>& mesh) {
    std::map<VertexId, std::set<Reference>> at;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        for (const VertexId v : mesh.facets.vertices[f]) at[v].insert(mesh.facets.references[f]);
    return at;
}

template <int D>
Column<Reference> vertex_references(std::size_t count, const std::map<VertexId, std::set<Reference>>& at) {
    Buffer<Reference> references(count, Reference{0});
    for (const auto& [v, found] : at) references[v.index()] = *found.begin();
    return references;
}

/// Edges between facets of two references; numbered in the order of the pairs.
void add_ridges(LinearMesh<3>& mesh) {
    std::map<std::array<VertexId, 2>, std::set<Reference>> at;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        for (int i = 0; i < 3; ++i) {
            const auto& facet = mesh.facets.vertices[f];
            const VertexId a = facet[i], b = facet[(i + 1) % 3];
            at[{std::min(a, b), std::max(a, b)}].insert(mesh.facets.references[f]);
        }
    std::map<std::set<Reference>, Reference> numbers;
    for (const auto& [edge, found] : at)
        if (found.size() > 1) numbers.try_emplace(found, 0);
    Reference next = 0;
    for (auto& [pair, number] : numbers) number = ++next;
    Buffer<std::array<VertexId, 2>> edges;
    Buffer<Reference> references;
    Buffer<std::uint32_t> ridges;
    for (const auto& [edge, found] : at) {
        if (found.size() < 2) continue;
        ridges.push_back(static_cast<std::uint32_t>(edges.size()));
        edges.push_back(edge);
        references.push_back(numbers.at(found));
    }
    mesh.edges = {std::move(edges), std::move(references), {}};
    mesh.ridges = std::move(ridges);
}

}  // namespace

template <int D>
Outcome<LinearMesh<D>> bounded_mesh(Buffer<Vec<D>> points, Buffer<SimplexVertices<D>> elements,
                                    Buffer<Reference> materials, const FacetReference<D>& facet_reference) {
    LinearMesh<D> mesh;
    const std::size_t count = points.size();
    mesh.points = std::move(points);
    mesh.point_references = Buffer<Reference>(count, Reference{0});
    mesh.elements = {std::move(elements), std::move(materials), {}};
    if (auto checked = check_volumes(mesh); !checked) return fail(checked.error());
    auto facets = boundary_facets<D>(mesh, facet_reference);
    if (!facets) return fail(facets.error());
    mesh.facets = std::move(*facets);
    const auto at = references_at_vertices(mesh);
    mesh.point_references = vertex_references<D>(count, at);
    Buffer<VertexId> corners;
    for (const auto& [v, found] : at)
        if (found.size() >= std::size_t{D}) corners.push_back(v);
    mesh.corners = std::move(corners);
    if constexpr (D == 3) add_ridges(mesh);
    return mesh;
}

template Outcome<LinearMesh<2>> bounded_mesh<2>(Buffer<Vec<2>>, Buffer<SimplexVertices<2>>, Buffer<Reference>,
                                                const FacetReference<2>&);
template Outcome<LinearMesh<3>> bounded_mesh<3>(Buffer<Vec<3>>, Buffer<SimplexVertices<3>>, Buffer<Reference>,
                                                const FacetReference<3>&);

}  // namespace camber
