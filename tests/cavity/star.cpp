// Emptying and starring: what a cavity gives back.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "meshes.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.cavity;

using namespace camber;
using namespace camber::testing;

namespace {

/// A lattice of two materials with its boundary and interface facets, and with feature edges in 3D.
template <int D>
QuadraticMesh<D> two_materials(std::uint64_t seed) {
    LatticeOptions<D> options;
    options.cells.fill(D == 2 ? 4 : 3);
    options.jitter = 0.2;
    options.seed = seed + 1;
    LinearMesh<D> mesh = lattice_mesh(options);
    Buffer<Reference> references(mesh.elements.size());
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
        double x = 0;
        for (const Vec<D>& p : corners(mesh, e)) x += p[0] / (D + 1);
        references[e] = x < 1.5 ? 7 : 8;
    }
    mesh.elements.references = references;
    const auto around = must(balls(mesh, alone));
    const auto across = must(neighbours(mesh, around, alone));
    Buffer<SimplexVertices<D - 1>> facets;
    Buffer<Reference> colours;
    Buffer<SimplexVertices<1>> edges;
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        for (int i = 0; i <= D; ++i) {
            const ElementId other = across[e][i];
            if (other.valid() && (references[other.index()] == references[e] || other.index() < e)) continue;
            SimplexVertices<D - 1> facet;
            for (int k = 0; k < D; ++k) facet[k] = mesh.elements.vertices[e][face_opposite<D>(i)[k]];
            facets.push_back(facet);
            colours.push_back(other.valid() ? 3 : 1 + static_cast<Reference>(mesh.points[facet[0]][1] > 1.5));
            if (D == 3 && i == 1) edges.push_back({std::min(facet[0], facet[1]), std::max(facet[0], facet[1])});
        }
    mesh.facets = {std::move(facets), std::move(colours), {}};
    if constexpr (D == 3) {
        std::sort(edges.begin(), edges.end());
        edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
        mesh.edges.references = Buffer<Reference>(edges.size(), 5);
        mesh.edges.vertices = std::move(edges);
    }
    return must(elevate(std::move(mesh), alone));
}

/// Simplices of a star in the vertices of its mesh, with references, sorted.
template <int K>
std::vector<std::pair<SimplexVertices<K>, Reference>> listed(const Simplices<K>& simplices,
                                                             const std::vector<VertexId>& vertices) {
    std::vector<std::pair<SimplexVertices<K>, Reference>> out;
    for (std::size_t i = 0; i < simplices.size(); ++i) {
        auto v = simplices.vertices[i];
        for (VertexId& x : v) x = vertices[x.index()];
        out.emplace_back(v, simplices.references[i]);
    }
    std::sort(out.begin(), out.end());
    return out;
}
template <int K, class Id>
std::vector<std::pair<SimplexVertices<K>, Reference>> picked(const Simplices<K>& simplices,
                                                             const std::vector<Id>& ids) {
    std::vector<std::pair<SimplexVertices<K>, Reference>> out;
    for (const Id id : ids) out.emplace_back(simplices.vertices[id], simplices.references[id]);
    std::sort(out.begin(), out.end());
    return out;
}

template <int D>
double volume(const LinearMesh<D>& mesh) {
    double sum = 0;
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) sum += orientation(corners(mesh, e));
    return sum;
}

/// How often each face occurs: once on the cavity's boundary, twice inside.
template <int D>
std::size_t faces_that_occur_once(const LinearMesh<D>& mesh) {
    std::map<SimplexVertices<D - 1>, int> faces;
    for (const auto& v : mesh.elements.vertices)
        for (int i = 0; i <= D; ++i) {
            SimplexVertices<D - 1> face;
            for (int k = 0; k < D; ++k) face[k] = v[face_opposite<D>(i)[k]];
            std::sort(face.begin(), face.end());
            ++faces[face];
        }
    std::size_t once = 0;
    for (const auto& [face, count] : faces) {
        RC_ASSERT(count <= 2);
        once += count == 1;
    }
    return once;
}

template <int D>
void star_laws() {
    property("a vertex's ball, starred, is the ball",
             [](std::uint64_t seed) {
                 const auto mesh = two_materials<D>(seed);
                 const auto topology = *cavity_topology(mesh, alone);
                 for (std::size_t v = 0; v < mesh.linear.points.size(); ++v) {
                     const Cavity<D> cavity = vertex_ball(topology, VertexId(v));
                     const auto s = star(mesh.linear, cavity, empty(mesh.linear, cavity));
                     RC_ASSERT(s.vertices[s.point.index()] == VertexId(v));
                     RC_ASSERT(std::is_sorted(s.vertices.begin(), s.vertices.end()));
                     RC_ASSERT(s.replaces == cavity.elements);
                     RC_ASSERT(listed(s.mesh.elements, s.vertices) == picked(mesh.linear.elements, cavity.elements));
                     RC_ASSERT(listed(s.mesh.facets, s.vertices) == picked(mesh.linear.facets, cavity.facets));
                     RC_ASSERT(listed(s.mesh.edges, s.vertices) == picked(mesh.linear.edges, cavity.ridges));
                 }
             },
             {.count = 3});
    property("a collapse (the ball of one vertex from a neighbour) keeps the volume and the outer faces",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto mesh = two_materials<D>(seed);
                 const auto topology = *cavity_topology(mesh, alone);
                 for (int trial = 0; trial < 20; ++trial) {
                     const auto [a, b] = mesh.edges.vertices[dice.below(mesh.edges.size())];
                     Cavity<D> cavity = vertex_ball(topology, a);
                     const auto ball = star(mesh.linear, cavity, empty(mesh.linear, cavity));
                     cavity.point = b;
                     const auto s = star(mesh.linear, cavity, empty(mesh.linear, cavity));
                     RC_ASSERT(std::find(s.vertices.begin(), s.vertices.end(), b) != s.vertices.end());
                     RC_ASSERT(std::abs(volume(s.mesh) - volume(ball.mesh)) < 1e-9);
                     RC_ASSERT(faces_that_occur_once(s.mesh) <= faces_that_occur_once(ball.mesh));
                 }
             },
             {.count = 5});
    property("a swap (the shell of an edge from a vertex of its link) keeps the volume, and the boundary face by face",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto mesh = two_materials<D>(seed);
                 const auto topology = *cavity_topology(mesh, alone);
                 for (int trial = 0; trial < 20; ++trial) {
                     const std::size_t e = dice.below(mesh.edges.size());
                     const auto shell = topology.shells[e];
                     Cavity<D> cavity{{}, {shell.begin(), shell.end()}, {}, {}};
                     double before = 0;
                     for (const ElementId k : shell) before += orientation(corners(mesh.linear, k.index()));
                     const auto boundary = empty(mesh.linear, cavity);
                     for (const VertexId v : mesh.linear.elements.vertices[shell.front()]) {
                         cavity.point = v;
                         const auto s = star(mesh.linear, cavity, boundary);
                         RC_ASSERT(std::abs(volume(s.mesh) - before) < 1e-9);
                         RC_ASSERT(faces_that_occur_once(s.mesh) == boundary.of_elements.size());
                     }
                 }
             },
             {.count = 5});
}

}  // namespace

TEST_CASE("stars of triangles") { star_laws<2>(); }
TEST_CASE("stars of tetrahedra") { star_laws<3>(); }
