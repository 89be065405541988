module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.cavity;
import camber.core;
import camber.validity;

namespace camber {

namespace {

/// The faces of these K-simplices that occur once, simplices of different `group` looked at apart.
template <int K, class Id, class Group>
std::vector<OpenFace> open_faces(const Simplices<K>& simplices, const std::vector<Id>& removed, Group&& group) {
    using Key = std::tuple<Reference, SimplexVertices<K - 1>>;
    std::vector<std::pair<Key, OpenFace>> faces;
    faces.reserve(removed.size() * (K + 1));
    for (const Id id : removed) {
        const SimplexVertices<K>& v = simplices.vertices[id];
        for (int opposite = 0; opposite <= K; ++opposite) {
            SimplexVertices<K - 1> face;
            std::copy_n(v.begin(), opposite, face.begin());
            std::copy(v.begin() + opposite + 1, v.end(), face.begin() + opposite);
            std::sort(face.begin(), face.end());
            faces.push_back({{group(id), face}, {id.value, static_cast<std::uint32_t>(opposite)}});
        }
    }
    std::sort(faces.begin(), faces.end(), [](const auto& a, const auto& b) {
        return std::tie(a.first, a.second.simplex) < std::tie(b.first, b.second.simplex);
    });
    std::vector<OpenFace> open;
    for (std::size_t i = 0; i < faces.size();) {
        std::size_t j = i + 1;
        while (j < faces.size() && faces[j].first == faces[i].first) ++j;
        if (j == i + 1) open.push_back(faces[i].second);
        i = j;
    }
    std::sort(open.begin(), open.end(),
              [](OpenFace a, OpenFace b) { return std::tie(a.simplex, a.opposite) < std::tie(b.simplex, b.opposite); });
    return open;
}

/// A mesh may go without a column of references: all are 0.
Reference reference_of(const Column<Reference>& references, std::size_t i) {
    return references.empty() ? Reference{0} : references[i];
}

/// Open faces joined to the point, in the vertices of the mesh.
template <int K>
struct Joined {
    std::vector<SimplexVertices<K>> vertices;
    std::vector<Reference> references;
    std::vector<std::uint32_t> replaced;
};

template <int K>
Joined<K> joined(const Simplices<K>& simplices, const std::vector<OpenFace>& open, VertexId point) {
    Joined<K> out;
    for (const auto& [simplex, opposite] : open) {
        SimplexVertices<K> v = simplices.vertices[simplex];
        v[opposite] = point;
        if (std::count(v.begin(), v.end(), point) > 1) continue;
        out.vertices.push_back(v);
        out.references.push_back(reference_of(simplices.references, simplex));
        out.replaced.push_back(simplex);
    }
    return out;
}

template <int K>
void collect(const Joined<K>& joined, std::vector<VertexId>& vertices) {
    for (const auto& v : joined.vertices) vertices.insert(vertices.end(), v.begin(), v.end());
}

/// The joined simplices by the places of their vertices in `vertices`.
template <int K>
Simplices<K> numbered(const Joined<K>& joined, const std::vector<VertexId>& vertices) {
    Buffer<SimplexVertices<K>> local(joined.vertices.size());
    for (std::size_t i = 0; i < local.size(); ++i)
        for (int k = 0; k <= K; ++k)
            local[i][k] = VertexId(static_cast<std::size_t>(
                std::lower_bound(vertices.begin(), vertices.end(), joined.vertices[i][k]) - vertices.begin()));
    return {std::move(local), Buffer<Reference>(joined.references.begin(), joined.references.end()), {}};
}

}  // namespace

template <int D>
Outcome<CavityTopology<D>> cavity_topology(const QuadraticMesh<D>& mesh, const Execution& execution) {
    CavityTopology<D> topology;
    auto elements = balls(mesh.linear, execution);
    if (!elements) return fail(elements.error());
    topology.balls = std::move(*elements);
    auto facets = facet_balls(mesh.linear, execution);
    if (!facets) return fail(facets.error());
    topology.facet_balls = std::move(*facets);
    auto ridges = feature_edge_balls(mesh.linear, execution);
    if (!ridges) return fail(ridges.error());
    topology.ridge_balls = std::move(*ridges);
    auto around = shells(mesh.edges, execution);
    if (!around) return fail(around.error());
    topology.shells = std::move(*around);
    return topology;
}

template <int D>
Cavity<D> vertex_ball(const CavityTopology<D>& topology, VertexId vertex) {
    const auto listed = [&](const auto& balls) { return std::vector(balls[vertex].begin(), balls[vertex].end()); };
    return {vertex, listed(topology.balls), listed(topology.facet_balls), listed(topology.ridge_balls)};
}

template <int D>
CavityBoundary<D> empty(const LinearMesh<D>& mesh, const Cavity<D>& cavity) {
    CavityBoundary<D> boundary;
    // An interface does not bound a cavity: elements of all materials are one body.
    boundary.of_elements = open_faces(mesh.elements, cavity.elements, [](ElementId) { return Reference{0}; });
    boundary.of_facets = open_faces(mesh.facets, cavity.facets,
                                    [&](FacetId f) { return reference_of(mesh.facets.references, f.index()); });
    boundary.of_ridges =
        open_faces(mesh.edges, cavity.ridges, [&](EdgeId e) { return reference_of(mesh.edges.references, e.index()); });
    return boundary;
}

template <int D>
StarMesh<D> star(const LinearMesh<D>& mesh, const Cavity<D>& cavity, const CavityBoundary<D>& boundary) {
    const auto ridges = joined(mesh.edges, boundary.of_ridges, cavity.point);
    const auto facets = joined(mesh.facets, boundary.of_facets, cavity.point);
    const auto elements = joined(mesh.elements, boundary.of_elements, cavity.point);

    StarMesh<D> out;
    out.vertices.push_back(cavity.point);
    collect(ridges, out.vertices);
    collect(facets, out.vertices);
    collect(elements, out.vertices);
    out.vertices |= ranges::actions::sort | ranges::actions::unique;
    const std::size_t n = out.vertices.size();
    Buffer<Vec<D>> points(n);
    Buffer<Reference> references(n);
    for (std::size_t v = 0; v < n; ++v) {
        points[v] = mesh.points[out.vertices[v]];
        references[v] = reference_of(mesh.point_references, out.vertices[v].index());
        if (out.vertices[v] == cavity.point) out.point = VertexId(v);
    }
    out.mesh.points = std::move(points);
    out.mesh.point_references = std::move(references);
    out.mesh.edges = numbered(ridges, out.vertices);
    out.mesh.facets = numbered(facets, out.vertices);
    out.mesh.elements = numbered(elements, out.vertices);
    out.replaces.reserve(elements.replaced.size());
    for (const std::uint32_t e : elements.replaced) out.replaces.emplace_back(std::size_t{e});
    return out;
}

#define CAMBER_INSTANTIATE(D)                                                                          \
    template Outcome<CavityTopology<D>> cavity_topology<D>(const QuadraticMesh<D>&, const Execution&); \
    template Cavity<D> vertex_ball<D>(const CavityTopology<D>&, VertexId);                             \
    template CavityBoundary<D> empty<D>(const LinearMesh<D>&, const Cavity<D>&);                       \
    template StarMesh<D> star<D>(const LinearMesh<D>&, const Cavity<D>&, const CavityBoundary<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
