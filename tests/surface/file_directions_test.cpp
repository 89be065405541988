// Normals and tangents that the file gives.
#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "meshes.hpp"

using namespace surface_tests;

namespace {

template <class Direction>
DirectionsAtVertices<3> directions_at(const LinearMesh<3>& mesh, Direction&& direction) {
    Buffer<Vec<3>> directions;
    Buffer<DirectionRow> at;
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
        directions.push_back(direction(mesh.points[v]));
        at.push_back({VertexId(v), static_cast<std::uint32_t>(v)});
    }
    return {std::move(directions), std::move(at)};
}

}  // namespace

TEST_CASE("exact normals put the nodes of a sphere on it, whichever side they point to") {
    auto mesh = sphere(5, 1).mesh();
    const auto off = off_surface(Sphere<3>{{}, 1});
    const auto alone = errors(build(mesh), off);
    for (const double sign : {1.0, -3.0}) {
        mesh.geometry.normals = directions_at(mesh, [&](const Vec<3>& p) { return sign * p; });
        const auto given = errors(build(mesh), off);
        CHECK(given.edges < 1e-14);
        CHECK(given.edges < alone.edges);
    }
}

TEST_CASE("normals that have nothing to do with the surface are not taken, nor any when told so") {
    auto mesh = sphere(5, 1).mesh();
    const auto alone = build(mesh);
    mesh.geometry.normals = directions_at(mesh, [](const Vec<3>& p) { return cross(p, Vec<3>{{0.3, 0.5, 0.8}}); });
    CHECK(build(mesh).nodes == alone.nodes);
    mesh.geometry.normals = directions_at(mesh, [](const Vec<3>& p) { return p; });
    CHECK(build(mesh, {.file_directions_degrees = 0}).nodes == alone.nodes);
    CHECK(build(mesh).nodes != alone.nodes);
}

TEST_CASE("rows that the table does not have are ignored") {
    auto mesh = sphere(4, 1).mesh();
    const auto alone = build(mesh);
    mesh.geometry.normals.at = Buffer<DirectionRow>{{VertexId(std::size_t{0}), 99}};
    mesh.geometry.tangents.at = Buffer<DirectionRow>{{VertexId(std::size_t{0}), 99}};
    CHECK(build(mesh).nodes == alone.nodes);
}

TEST_CASE("tangents of ridges") {
    auto mesh = tube(24, 6, 1).mesh();
    mesh.geometry.tangents = directions_at(mesh, [](const Vec<3>& p) { return Vec<3>{{-p[1], p[0], 0.05}}; });
    const auto given = build(mesh), alone = build(mesh, {.file_directions_degrees = 0});
    double moved = 0;
    for (std::size_t e = 0; e < given.nodes.size(); ++e)
        if (given.features.edge_kinds[e] == EdgeKind::ridge)
            moved = std::fmax(moved, distance(given.nodes[e].point, alone.nodes[e].point));
    CHECK(given.nodes != alone.nodes);  // they bend the rim out of its plane, symmetrically: the middle hardly moves
    CHECK(moved < 1e-2);
}
