// Topology compared with brute force, on randomly numbered lattices with missing cells.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "meshes.hpp"
#include "property.hpp"

import camber.core;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
LinearMesh<D> random_mesh(std::uint64_t seed) {
    Dice dice(seed);
    LatticeOptions<D> options;
    for (int& n : options.cells) n = 1 + static_cast<int>(dice.below(D == 2 ? 7 : 4));
    if (dice.below(3) != 0) options.keep = all_but_one_in<D>(4, seed);
    options.seed = seed + 1;
    return lattice_mesh(options);
}

template <std::size_t N>
std::array<VertexId, N> sorted(std::array<VertexId, N> v) {
    std::sort(v.begin(), v.end());
    return v;
}

/// Returns the mesh with its boundary faces as facets.
template <int D>
LinearMesh<D> with_facets(LinearMesh<D> mesh) {
    const auto around = must(balls(mesh, one_thread));
    Buffer<SimplexVertices<D - 1>> facets;
    for (const ElementFace& face : boundary_faces<D>(must(neighbours(mesh, around, one_thread))))
        facets.push_back(face_of(mesh, face));
    mesh.facets.vertices = std::move(facets);
    return mesh;
}

template <int D>
void check_topology() {
    property("balls list exactly the elements of the vertex in increasing order",
             [](std::uint64_t seed) {
                 const auto mesh = random_mesh<D>(seed);
                 std::vector<std::vector<ElementId>> expected(mesh.points.size());
                 for (std::size_t e = 0; e < mesh.elements.size(); ++e)
                     for (const VertexId v : mesh.elements.vertices[e]) expected[v.index()].push_back(ElementId(e));
                 for (const int threads : {1, 2, 7}) {
                     const auto found = *balls(mesh, Execution{.threads = threads});
                     RC_ASSERT(found.size() == mesh.points.size());
                     for (std::size_t v = 0; v < expected.size(); ++v)
                         RC_ASSERT(std::vector<ElementId>(found[v].begin(), found[v].end()) == expected[v]);
                 }
             },
             {.count = 30});

    property(
        "neighbours are symmetric across their common face, and the boundary is closed",
        [](std::uint64_t seed) {
            const auto mesh = random_mesh<D>(seed);
            const auto links = *neighbours(mesh, *balls(mesh, one_thread), one_thread);
            std::map<std::array<VertexId, D>, int> faces;
            for (std::size_t e = 0; e < mesh.elements.size(); ++e)
                for (int i = 0; i <= D; ++i)
                    ++faces[sorted(face_of(mesh, {ElementId(e), static_cast<std::uint32_t>(i)}))];
            for (std::size_t e = 0; e < mesh.elements.size(); ++e)
                for (int i = 0; i <= D; ++i) {
                    const auto face = sorted(face_of(mesh, {ElementId(e), static_cast<std::uint32_t>(i)}));
                    const ElementId other = links[e][i];
                    RC_ASSERT(other.valid() == (faces[face] == 2));
                    if (!other.valid()) continue;
                    int back = 0;
                    for (int j = 0; j <= D; ++j)
                        back += links[other][j] == ElementId(e) &&
                                sorted(face_of(mesh, {other, static_cast<std::uint32_t>(j)})) == face;
                    RC_ASSERT(back == 1);
                }
            const auto boundary = boundary_faces<D>(links);
            RC_ASSERT(boundary.size() == static_cast<std::size_t>(std::count_if(
                                             faces.begin(), faces.end(), [](const auto& f) { return f.second == 1; })));
            // Closed: each face of a boundary face is shared by an even number of them.
            std::map<std::vector<VertexId>, int> sides;
            for (const ElementFace& face : boundary) {
                const auto v = face_of(mesh, face);
                for (int skip = 0; skip < D; ++skip) {
                    std::vector<VertexId> side;
                    for (int i = 0; i < D; ++i)
                        if (i != skip) side.push_back(v[i]);
                    std::sort(side.begin(), side.end());
                    ++sides[side];
                }
            }
            for (const auto& [side, count] : sides) RC_ASSERT(count % 2 == 0);
        },
        {.count = 30});

    property("unique edges are sorted and equal a std::set, and each simplex refers to its own",
             [](std::uint64_t seed) {
                 auto mesh = with_facets(random_mesh<D>(seed));
                 if constexpr (D == 3)
                     mesh.edges.vertices =
                         Buffer<SimplexVertices<1>>{{mesh.facets.vertices[0][1], mesh.facets.vertices[0][0]}};
                 const auto edges = *unique_edges(mesh, one_thread);
                 std::set<std::array<VertexId, 2>> expected;
                 for (const auto& s : mesh.elements.vertices)
                     for (int i = 0; i <= D; ++i)
                         for (int j = 0; j < i; ++j) expected.insert(sorted(std::array{s[i], s[j]}));
                 RC_ASSERT(std::vector(edges.vertices.begin(), edges.vertices.end()) ==
                           std::vector(expected.begin(), expected.end()));
                 for (std::size_t e = 0; e < mesh.elements.size(); ++e)
                     for (int k = 0; k < edges_per_simplex<D>; ++k) {
                         const auto [i, j] = local_edges<D>[k];
                         const auto& s = mesh.elements.vertices[e];
                         RC_ASSERT(edges.vertices[edges.of_elements[e][k]] == sorted(std::array{s[i], s[j]}));
                         RC_ASSERT(find_edge(edges, s[j], s[i]) == edges.of_elements[e][k]);
                     }
                 for (std::size_t f = 0; f < mesh.facets.size(); ++f)
                     for (int k = 0; k < edges_per_simplex<D - 1>; ++k) {
                         const auto [i, j] = local_edges<D - 1>[k];
                         const auto& s = mesh.facets.vertices[f];
                         RC_ASSERT(edges.vertices[edges.of_facets[f][k]] == sorted(std::array{s[i], s[j]}));
                     }
                 if constexpr (D == 3)
                     RC_ASSERT(edges.vertices[edges.of_edges[0]] == sorted(std::array(mesh.edges.vertices[0])));
                 RC_ASSERT(!find_edge(edges, VertexId(std::size_t{0}), VertexId(std::size_t{0})).valid());
                 for (const int threads : {2, 7})
                     RC_ASSERT(*unique_edges(mesh, Execution{.threads = threads}) == edges);
             },
             {.count = 30});

    property("shells list the elements and the facets that contain both ends of the edge",
             [](std::uint64_t seed) {
                 const auto mesh = with_facets(random_mesh<D>(seed));
                 const auto edges = *unique_edges(mesh, one_thread);
                 const auto of_elements = *shells(edges, one_thread);
                 const auto of_facets = *facet_shells(edges, one_thread);
                 const auto names = [](const auto& s, VertexId v) {
                     return std::find(s.begin(), s.end(), v) != s.end();
                 };
                 for (std::size_t e = 0; e < edges.size(); ++e) {
                     const auto [a, b] = edges.vertices[e];
                     std::vector<ElementId> shell;
                     for (std::size_t t = 0; t < mesh.elements.size(); ++t)
                         if (names(mesh.elements.vertices[t], a) && names(mesh.elements.vertices[t], b))
                             shell.emplace_back(t);
                     RC_ASSERT(std::vector<ElementId>(of_elements[e].begin(), of_elements[e].end()) == shell);
                     std::vector<FacetId> facets;
                     for (std::size_t f = 0; f < mesh.facets.size(); ++f)
                         if (names(mesh.facets.vertices[f], a) && names(mesh.facets.vertices[f], b))
                             facets.emplace_back(f);
                     RC_ASSERT(std::vector<FacetId>(of_facets[e].begin(), of_facets[e].end()) == facets);
                 }
             },
             {.count = 10});

    property("the Euler characteristic V − E + F − T of a ball is 1",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 LatticeOptions<D> options;
                 for (int& n : options.cells) n = 1 + static_cast<int>(dice.below(4));
                 options.seed = seed + 1;
                 const auto mesh = lattice_mesh(options);
                 const auto boundary = boundary_faces<D>(*neighbours(mesh, *balls(mesh, one_thread), one_thread));
                 const auto edges = static_cast<long>(unique_edges(mesh, one_thread)->size());
                 const auto vertices = static_cast<long>(mesh.points.size());
                 const auto elements = static_cast<long>(mesh.elements.size());
                 const long faces = ((D + 1) * elements + static_cast<long>(boundary.size())) / 2;
                 if constexpr (D == 2) {
                     RC_ASSERT(faces == edges);
                     RC_ASSERT(vertices - edges + elements == 1);
                 } else {
                     RC_ASSERT(vertices - edges + faces - elements == 1);
                 }
             },
             {.count = 30});
}

}  // namespace

TEST_CASE("balls, neighbours, edges and shells equal brute force in 2D") { check_topology<2>(); }
TEST_CASE("balls, neighbours, edges and shells equal brute force in 3D") { check_topology<3>(); }

TEST_CASE("the faces of a positive simplex are oriented outwards") {
    const std::array<Vec<3>, 4> p{Vec<3>{{0, 0, 0}}, Vec<3>{{1, 0, 0}}, Vec<3>{{0, 1, 0}}, Vec<3>{{0, 0, 1}}};
    for (int i = 0; i < 4; ++i) {
        const auto [a, b, c] = face_opposite<3>(i);
        CHECK(dot(cross(p[b] - p[a], p[c] - p[a]), p[i] - p[a]) < 0);
    }
    const std::array<Vec<2>, 3> q{Vec<2>{{0, 0}}, Vec<2>{{1, 0}}, Vec<2>{{0, 1}}};
    for (int i = 0; i < 3; ++i) {
        const auto [a, b] = face_opposite<2>(i);
        CHECK(cross(q[b] - q[a], q[i] - q[a]) > 0);
    }
}

TEST_CASE("an empty mesh has empty topology") {
    const LinearMesh<3> mesh;
    const auto around = must(balls(mesh, one_thread));
    CHECK(around.size() == 0);
    CHECK(must(neighbours(mesh, around, one_thread)).empty());
    const auto edges = must(unique_edges(mesh, one_thread));
    CHECK(edges.size() == 0);
    CHECK(must(shells(edges, one_thread)).size() == 0);
    CHECK(!find_edge(edges, VertexId(std::size_t{0}), VertexId(std::size_t{1})).valid());
}

TEST_CASE("one tetrahedron has four boundary faces and six edges") {
    LatticeOptions<3> options{.cells = {1, 1, 1}};
    auto mesh = lattice_mesh(options);
    mesh.elements.vertices = Buffer<SimplexVertices<3>>{mesh.elements.vertices[0]};
    CHECK(boundary_faces<3>(must(neighbours(mesh, must(balls(mesh, one_thread)), one_thread))).size() == 4);
    CHECK(must(unique_edges(mesh, one_thread)).size() == 6);
}

TEST_CASE("a surface mesh without elements has edges and facet shells") {
    LinearMesh<3> mesh;
    mesh.points = Buffer<Vec<3>>(4);
    mesh.facets.vertices =
        Buffer<SimplexVertices<2>>{{VertexId(std::size_t{0}), VertexId(std::size_t{1}), VertexId(std::size_t{2})},
                                   {VertexId(std::size_t{2}), VertexId(std::size_t{1}), VertexId(std::size_t{3})}};
    const auto edges = must(unique_edges(mesh, one_thread));
    CHECK(edges.size() == 5);
    CHECK(edges.of_elements.empty());
    CHECK(edges.of_facets.size() == 2);
    CHECK(must(shells(edges, one_thread)).size() == 5);
    CHECK(must(facet_shells(edges, one_thread))[edges.of_facets[0][1]].size() == 2);
}

TEST_CASE("three elements on a face are an error that names one of them") {
    auto mesh = lattice_mesh(LatticeOptions<2>{.cells = {3, 1}});
    auto elements = take(mesh.elements.vertices);
    elements.push_back({elements[2][0], elements[2][1], elements[0][0]});
    elements.push_back(elements[2]);
    mesh.elements.vertices = elements;
    const auto links = neighbours(mesh, must(balls(mesh, one_thread)), one_thread);
    REQUIRE(!links.has_value());
    CHECK(links.error().kind == ErrorKind::input);
    REQUIRE(links.error().entity.has_value());
    CHECK(links.error().entity->kind == "triangle");
    CHECK(links.error().entity->number >= 1);
    CHECK(links.error().entity->number <= elements.size());
}

TEST_CASE("a simplex with a repeated vertex is an error that names it") {
    auto mesh = lattice_mesh(LatticeOptions<3>{.cells = {1, 1, 1}});
    auto elements = take(mesh.elements.vertices);
    elements[3][1] = elements[3][0];
    mesh.elements.vertices = elements;
    const auto edges = unique_edges(mesh, one_thread);
    REQUIRE(!edges.has_value());
    CHECK(edges.error().kind == ErrorKind::input);
    REQUIRE(edges.error().entity.has_value());
    CHECK(edges.error().entity->number == 4);
}
