// Degree elevation is exact.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stop_token>

#include "dice.hpp"
#include "meshes.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
void check_elevation() {
    property("elevation places nodes at midpoints to the last bit and shares the linear mesh",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 LatticeOptions<D> options;
                 options.cells.fill(3);
                 options.seed = seed + 1;
                 options.jitter = 0.2;
                 const double plane = dice.uniform(-10, 10);
                 options.place = [plane](Vec<D> p) {
                     p *= 1 / 3.0;
                     if (p[0] < 0.1) p[0] = plane;  // one side lies in a coordinate plane
                     return p;
                 };
                 const auto mesh = lattice_mesh(options);
                 const auto p2 = *elevate(mesh, one_thread);
                 RC_ASSERT(p2.linear == mesh);
                 RC_ASSERT(p2.linear.points.data() == mesh.points.data());
                 RC_ASSERT(p2.edges == *unique_edges(mesh, one_thread));
                 for (std::size_t e = 0; e < p2.edges.size(); ++e) {
                     const auto [a, b] = p2.edges.vertices[e];
                     RC_ASSERT(p2.mid_nodes[e].point == midpoint(mesh.points[a], mesh.points[b]));
                     if (mesh.points[a][0] == plane && mesh.points[b][0] == plane)
                         RC_ASSERT(p2.mid_nodes[e].point[0] == plane);
                     RC_ASSERT(edge_of(p2, EdgeId(e)).offset() == Vec<D>{});
                 }
                 const auto xi = dice.barycentric<D>();
                 for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
                     const auto p = corners(mesh, e);
                     Vec<D> linear;
                     for (int i = 0; i <= D; ++i) linear += xi[i] * p[i];
                     RC_ASSERT(norm(element_of(p2, ElementId(e)).point(xi) - linear) < 1e-14 * (1 + std::abs(plane)));
                 }
                 for (const int threads : {2, 7}) RC_ASSERT(*elevate(mesh, Execution{.threads = threads}) == p2);
             },
             {.count = 20});
}

}  // namespace

TEST_CASE("elevated triangles have midpoint nodes to the last bit") { check_elevation<2>(); }
TEST_CASE("elevated tetrahedra have midpoint nodes to the last bit") { check_elevation<3>(); }

TEST_CASE("facets are converted to Bézier form") {
    auto mesh = lattice_mesh(LatticeOptions<3>{.cells = {1, 1, 1}});
    const auto& s = mesh.elements.vertices[0];
    mesh.facets.vertices = Buffer<SimplexVertices<2>>{{s[0], s[1], s[2]}};
    const auto p2 = must(elevate(mesh, one_thread));
    const auto facet = facet_of(p2, FacetId(std::size_t{0}));
    for (int i = 0; i < 3; ++i) CHECK(facet.control[i] == mesh.points[s[i]]);
    for (int e = 0; e < 3; ++e) {
        const auto [i, j] = local_edges<2>[e];
        CHECK(facet.control[3 + e] == midpoint(mesh.points[s[i]], mesh.points[s[j]]));
    }
}

TEST_CASE("an elevated empty mesh has no mid nodes") {
    CHECK(must(elevate(LinearMesh<2>{}, one_thread)).mid_nodes.empty());
}

TEST_CASE("elevation stops on request") {
    std::stop_source source;
    source.request_stop();
    const auto mesh = lattice_mesh(LatticeOptions<2>{.cells = {2, 2}});
    const auto stopped_early = elevate(mesh, Execution{.threads = 1, .stop = source.get_token()});
    REQUIRE(!stopped_early.has_value());
    CHECK(stopped_early.error().kind == ErrorKind::stopped);
}
