// A mesh that changes, as it is made and given back.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "domains.hpp"
#include "property.hpp"

import camber.core;
import camber.cavity;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
void made_and_given_back(std::uint64_t seed) {
    LinearMesh<D> mesh = random_domain<D>(seed);
    mesh.required_vertices = Buffer<VertexId>{VertexId(1)};
    mesh.corners = Buffer<VertexId>{VertexId(0)};
    const DynamicMesh<D> dynamic = dynamic_of(mesh);
    const auto consistent = check_consistency(dynamic, alone);
    RC_ASSERT(consistent.has_value());
    const auto [back, edges, nodes, maps] = must(compacted(dynamic, alone));
    RC_ASSERT(back == mesh);
    RC_ASSERT(edges == must(unique_edges(mesh, alone)));
    for (std::size_t e = 0; e < edges.size(); ++e) RC_ASSERT(maps.edges[EdgeId(e)] == EdgeId(e));
    // What walks find is what tables have.
    const auto around = must(balls(mesh, alone));
    std::vector<ElementId> found;
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
        if (dynamic.states[v].marks.has(Mark::frozen)) continue;
        ball(dynamic, VertexId(v), found);
        std::sort(found.begin(), found.end());
        RC_ASSERT(std::ranges::equal(found, around[v]));
    }
    const auto shell_of = must(shells(edges, alone));
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        for (int k = 0; k < edges_per_simplex<D>; ++k) {
            const EdgeId edge = dynamic.edges_of[e][k];
            if (dynamic.states[dynamic.edges[edge][0]].marks.has(Mark::frozen)) continue;
            shell(dynamic, ElementId(e), k, found);
            std::sort(found.begin(), found.end());
            RC_ASSERT(std::ranges::equal(found, shell_of[edge]));
        }
}

}  // namespace

TEST_CASE("a mesh that changes") {
    property("gives back what it was made of, 2D", [](std::uint64_t seed) { made_and_given_back<2>(seed); });
    property("gives back what it was made of, 3D", [](std::uint64_t seed) { made_and_given_back<3>(seed); },
             {.count = 40});
}

TEST_CASE("where vertices lie follows from facets and lines") {
    LatticeOptions<3> options;
    options.cells = {2, 2, 2};
    const auto mesh = with_references<3>(lattice_mesh(options), options.cells, true);
    const auto dynamic = dynamic_of(mesh);
    const auto place = [&](Vec<3> p) {
        for (std::size_t v = 0; v < mesh.points.size(); ++v)
            if (mesh.points[v] == p) return dynamic.states[v].place;
        return VertexPlace::inside;
    };
    CHECK(place({{0, 0, 0}}) == VertexPlace::corner);
    CHECK(place({{0, 0, 1}}) == VertexPlace::line);
    CHECK(place({{0, 1, 1}}) == VertexPlace::surface);
    CHECK(place({{1, 1, 1}}) == VertexPlace::line);    // the baffle meets the interface
    CHECK(place({{1, 0, 1}}) == VertexPlace::line);    // the interface meets the boundary
    CHECK(place({{1, 1, 0}}) == VertexPlace::corner);  // and the baffle both
    CHECK(place({{2, 1, 1}}) == VertexPlace::line);
    CHECK(dynamic.line_count() > 0);
}

TEST_CASE("a mesh that is not prepared is refused") {
    LatticeOptions<3> options;
    options.cells = {1, 1, 1};
    const auto bare = lattice_mesh(options);
    const auto made = make_dynamic(bare, must(unique_edges(bare, alone)), {}, alone);
    REQUIRE(!made.has_value());
    CHECK(describe(made.error()) ==
          "tetrahedron 1: a face of the boundary, or between two references, is no facet (prepare the mesh first)");
}

TEST_CASE("a place where the mesh touches itself is held") {
    // Two triangles that share a vertex only.
    LinearMesh<2> mesh = mesh_of<2>({Vec<2>{{0, 0}}, Vec<2>{{1, 0}}, Vec<2>{{0, 1}}, Vec<2>{{-1, 0}}, Vec<2>{{0, -1}}},
                                    {{VertexId(0), VertexId(1), VertexId(2)}, {VertexId(0), VertexId(3), VertexId(4)}});
    Buffer<SimplexVertices<1>> rim;
    for (const auto& v : mesh.elements.vertices)
        for (int i = 0; i < 3; ++i) rim.push_back({v[i], v[(i + 1) % 3]});
    mesh.facets = {std::move(rim), Buffer<Reference>(6, 1), {}};
    const auto dynamic = dynamic_of(mesh);
    CHECK(dynamic.states[0].marks.has(Mark::frozen));
    CHECK(!dynamic.states[1].marks.has(Mark::frozen));
    CHECK(check_consistency(dynamic, alone).has_value());
}
