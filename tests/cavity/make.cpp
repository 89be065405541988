// Creation of a dynamic mesh, and conversion back.
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
void check_round_trip(std::uint64_t seed) {
    LinearMesh<D> mesh = random_domain<D>(seed);
    mesh.required_vertices = Buffer<VertexId>{VertexId(1)};
    mesh.corners = Buffer<VertexId>{VertexId(0)};
    const DynamicMesh<D> dynamic = dynamic_of(mesh);
    const auto consistent = check_consistency(dynamic, one_thread);
    RC_ASSERT(consistent.has_value());
    const auto [back, edges, nodes, maps] = must(compacted(dynamic, one_thread));
    RC_ASSERT(back == mesh);
    RC_ASSERT(edges == must(unique_edges(mesh, one_thread)));
    for (std::size_t e = 0; e < edges.size(); ++e) RC_ASSERT(maps.edges[EdgeId(e)] == EdgeId(e));
    // Walks find the same elements as tables.
    const auto around = must(balls(mesh, one_thread));
    std::vector<ElementId> found;
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
        if (dynamic.states[v].marks.has(Mark::frozen)) continue;
        ball(dynamic, VertexId(v), found);
        std::sort(found.begin(), found.end());
        RC_ASSERT(std::ranges::equal(found, around[v]));
    }
    const auto shell_of = must(shells(edges, one_thread));
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

TEST_CASE("a dynamic mesh returns the mesh that it was made from") {
    property("a dynamic mesh returns its input mesh, 2D", [](std::uint64_t seed) { check_round_trip<2>(seed); });
    property("a dynamic mesh returns its input mesh, 3D", [](std::uint64_t seed) { check_round_trip<3>(seed); },
             {.count = 40});
}

TEST_CASE("the place of a vertex follows from facets and lines") {
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
    CHECK(place({{1, 1, 0}}) == VertexPlace::corner);  // the baffle meets both
    CHECK(place({{2, 1, 1}}) == VertexPlace::line);
    CHECK(dynamic.line_count() > 0);
}

TEST_CASE("make_dynamic rejects a mesh without boundary facets") {
    LatticeOptions<3> options;
    options.cells = {1, 1, 1};
    const auto bare = lattice_mesh(options);
    const auto result = make_dynamic(bare, must(unique_edges(bare, one_thread)), {}, one_thread);
    REQUIRE(!result.has_value());
    CHECK(describe(result.error()) ==
          "tetrahedron 1: a face of the boundary or between two references is not in the list of facets (prepare the "
          "mesh first)");
}

TEST_CASE("a vertex where the mesh touches itself is frozen") {
    // Two triangles that share only a vertex.
    LinearMesh<2> mesh = mesh_of<2>({Vec<2>{{0, 0}}, Vec<2>{{1, 0}}, Vec<2>{{0, 1}}, Vec<2>{{-1, 0}}, Vec<2>{{0, -1}}},
                                    {{VertexId(0), VertexId(1), VertexId(2)}, {VertexId(0), VertexId(3), VertexId(4)}});
    Buffer<SimplexVertices<1>> rim;
    for (const auto& v : mesh.elements.vertices)
        for (int i = 0; i < 3; ++i) rim.push_back({v[i], v[(i + 1) % 3]});
    mesh.facets = {std::move(rim), Buffer<Reference>(6, 1), {}};
    const auto dynamic = dynamic_of(mesh);
    CHECK(dynamic.states[0].marks.has(Mark::frozen));
    CHECK(!dynamic.states[1].marks.has(Mark::frozen));
    CHECK(check_consistency(dynamic, one_thread).has_value());
}
