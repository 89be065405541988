// Normals and tangents of the file.
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

TEST_CASE("exact normals of the file put the nodes of a sphere on it with either sign") {
    auto mesh = sphere(5, 1).mesh();
    const auto off = off_surface(Sphere<3>{{}, 1});
    const auto without_file = errors(build(mesh), off);
    for (const double sign : {1.0, -3.0}) {
        mesh.geometry.normals = directions_at(mesh, [&](const Vec<3>& p) { return sign * p; });
        const auto with_file = errors(build(mesh), off);
        CHECK(with_file.edges < 1e-14);
        CHECK(with_file.edges < without_file.edges);
    }
}

TEST_CASE("normals of the file are ignored if they are wrong or disabled") {
    auto mesh = sphere(5, 1).mesh();
    const auto without_file = build(mesh);
    mesh.geometry.normals = directions_at(mesh, [](const Vec<3>& p) { return cross(p, Vec<3>{{0.3, 0.5, 0.8}}); });
    CHECK(build(mesh).nodes == without_file.nodes);
    mesh.geometry.normals = directions_at(mesh, [](const Vec<3>& p) { return p; });
    CHECK(build(mesh, {.file_directions_degrees = 0}).nodes == without_file.nodes);
    CHECK(build(mesh).nodes != without_file.nodes);
}

TEST_CASE("rows of file directions that the table lacks are ignored") {
    auto mesh = sphere(4, 1).mesh();
    const auto without_file = build(mesh);
    mesh.geometry.normals.at = Buffer<DirectionRow>{{VertexId(std::size_t{0}), 99}};
    mesh.geometry.tangents.at = Buffer<DirectionRow>{{VertexId(std::size_t{0}), 99}};
    CHECK(build(mesh).nodes == without_file.nodes);
}

TEST_CASE("tangents of the file bend the ridge curves") {
    auto mesh = tube(24, 6, 1).mesh();
    mesh.geometry.tangents = directions_at(mesh, [](const Vec<3>& p) { return Vec<3>{{-p[1], p[0], 0.05}}; });
    const auto with_file = build(mesh), without_file = build(mesh, {.file_directions_degrees = 0});
    double moved = 0;
    for (std::size_t e = 0; e < with_file.nodes.size(); ++e)
        if (with_file.features.edge_kinds[e] == EdgeKind::ridge)
            moved = std::fmax(moved, distance(with_file.nodes[e].point, without_file.nodes[e].point));
    CHECK(with_file.nodes !=
          without_file.nodes);  // the rim bends out of its plane symmetrically, so midpoints hardly move
    CHECK(moved < 1e-2);
}
