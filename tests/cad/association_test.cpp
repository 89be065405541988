// Meshes and the models that they sample.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "read.hpp"

import camber.core;
import camber.bezier;
import camber.shapes;
import camber.cad;

using namespace camber;
using namespace cad_tests;

namespace {

template <class T>
T value(Outcome<T> outcome) {
    if (!outcome) FAIL(describe(outcome.error()));
    return std::move(*outcome);
}

CadAssociation associated(const LinearMesh<3>& mesh, const CadModel& model, int threads = 1) {
    const Execution execution{.threads = threads};
    return value(associate(mesh, value(unique_edges(mesh, execution)), model, execution));
}

LinearMesh<3> box_mesh() {
    BoxOptions<3> options;
    options.high = {{1, 2, 3}};
    return value(generate(options));
}

}  // namespace

TEST_CASE("a box: each side is a face, and nothing is in doubt") {
    const CadModel model = model_of(Kind::box, {1, 2, 3});
    const LinearMesh<3> mesh = box_mesh();
    const CadAssociation a = associated(mesh, model);
    CHECK(a.faces_met == 6);
    CHECK(a.edges_met == 12);
    CHECK(a.vertices_met == 8);
    CHECK(a.doubtful_facets + a.doubtful_edges + a.doubtful_vertices == 0);
    CHECK(a.largest_vertex_distance <= 1e-14);
    CHECK(a.of_references.size() == 6);
    for (const auto& [reference, faces] : a.of_references) CHECK(faces.size() == 1);
    CHECK(associated(mesh, model, 2).faces == a.faces);
}

TEST_CASE("faces are found without references") {
    const CadModel model = model_of(Kind::box, {1, 2, 3});
    LinearMesh<3> mesh = box_mesh();
    const CadAssociation with = associated(mesh, model);
    mesh.facets.references = Buffer<Reference>(mesh.facets.size(), 7);
    const CadAssociation without = associated(mesh, model);
    CHECK(without.faces == with.faces);
    CHECK(without.of_references.size() == 1);
    CHECK(without.of_references[0].second.size() == 6);
}

TEST_CASE("spheres that know each other") {
    const CadModel model = model_of(Kind::shell, {1, 5, 0}, ".step");
    REQUIRE(model.faces() == 2);
    const LinearMesh<3> mesh = value(generate(ShellOptions<3>{}));
    const CadAssociation a = associated(mesh, model);
    CHECK(a.faces_met == 2);
    CHECK(a.doubtful_facets == 0);
    CHECK(a.largest_vertex_distance <= 1e-13);
    for (const auto& [reference, faces] : a.of_references) CHECK(faces.size() == 1);
}

TEST_CASE("another size or place is refused, with the unit that would fit") {
    const CadModel model = model_of(Kind::box, {1000, 2000, 3000}, ".step");
    const LinearMesh<3> mesh = box_mesh();
    const auto edges = value(unique_edges(mesh, {}));
    const auto wrong_unit = associate(mesh, edges, model, {});
    REQUIRE(!wrong_unit);
    CHECK(wrong_unit.error().kind == ErrorKind::input);
    CHECK(wrong_unit.error().remedy.find("in m:") != std::string::npos);
    LinearMesh<3> elsewhere = mesh;
    auto points = take(std::move(elsewhere.points));
    for (Vec<3>& p : points) p[0] += 10;
    elsewhere.points = std::move(points);
    const auto moved = associate(elsewhere, edges, model_of(Kind::box, {1, 2, 3}), {});
    REQUIRE(!moved);
    CHECK(moved.error().what.find("(10, 0, 0)") != std::string::npos);
}

TEST_CASE("edges between two faces and vertices of three are told, smooth or not") {
    const CadModel model = model_of(Kind::box, {1, 2, 3});
    LinearMesh<3> mesh = box_mesh();
    mesh.facets.references = Buffer<Reference>(mesh.facets.size(), 7);
    const CadAssociation a = associated(mesh, model);
    const auto edges = value(unique_edges(mesh, {}));
    CHECK(a.corners.size() == 8);
    const auto sides_of = [&](VertexId v) {
        int count = 0;
        for (int k = 0; k < 3; ++k) count += mesh.points[v][k] == 0 || mesh.points[v][k] == 1.0 + k;
        return count;
    };
    for (const VertexId v : a.corners) CHECK(sides_of(v) == 3);
    CHECK(!a.ridges.empty());
    for (const EdgeId e : a.ridges)
        for (const VertexId v : edges.vertices[e]) CHECK(sides_of(v) >= 2);
}
