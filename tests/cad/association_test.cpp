// Association of meshes with CAD models.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "read.hpp"

import camber.core;
import camber.bezier;
import camber.shapes;
import camber.surface;
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

TEST_CASE("each side of a box is associated with one face without ambiguity") {
    const CadModel model = model_of(Kind::box, {1, 2, 3});
    const LinearMesh<3> mesh = box_mesh();
    const CadAssociation a = associated(mesh, model);
    CHECK(a.faces_met == 6);
    CHECK(a.edges_met == 12);
    CHECK(a.vertices_met == 8);
    CHECK(a.ambiguous_facets + a.ambiguous_edges + a.ambiguous_vertices == 0);
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

TEST_CASE("concentric CAD spheres are associated with the right faces") {
    const CadModel model = model_of(Kind::shell, {1, 5, 0}, ".step");
    REQUIRE(model.faces() == 2);
    const LinearMesh<3> mesh = value(generate(ShellOptions<3>{}));
    const CadAssociation a = associated(mesh, model);
    CHECK(a.faces_met == 2);
    CHECK(a.ambiguous_facets == 0);
    CHECK(a.largest_vertex_distance <= 1e-13);
    for (const auto& [reference, faces] : a.of_references) CHECK(faces.size() == 1);
}

TEST_CASE("a model of another size or place is rejected with the unit that fits") {
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

TEST_CASE("ridges and corners are found without references") {
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

namespace {

/// Two unit cubes side by side along x, with the facets between them.
LinearMesh<3> two_cubes() {
    BoxOptions<3> options;
    options.high = {{2, 1, 1}};
    options.cells = {4, 2, 2};
    options.jitter = 0;
    LinearMesh<3> mesh = value(generate(options));
    std::map<std::array<VertexId, 3>, int> middle;
    for (const auto& element : mesh.elements.vertices)
        for (std::size_t out = 0; out < 4; ++out) {
            std::array<VertexId, 3> face{};
            for (std::size_t i = 0, k = 0; i < 4; ++i)
                if (i != out) face[k++] = element[i];
            std::sort(face.begin(), face.end());
            if (std::all_of(face.begin(), face.end(), [&](VertexId v) { return mesh.points[v][0] == 1; }))
                ++middle[face];
        }
    auto facets = take(std::move(mesh.facets.vertices));
    auto references = take(std::move(mesh.facets.references));
    for (const auto& [face, count] : middle) {
        facets.push_back({face[0], face[1], face[2]});
        references.push_back(9);
    }
    mesh.facets.vertices = std::move(facets);
    mesh.facets.references = std::move(references);
    return mesh;
}

/// Moves all vertices by up to this distance, in directions that depend on their numbers.
LinearMesh<3> perturbed(LinearMesh<3> mesh, double by) {
    auto points = take(std::move(mesh.points));
    for (std::size_t v = 0; v < points.size(); ++v)
        for (int k = 0; k < 3; ++k) points[v][k] += by * std::sin(static_cast<double>(3 * v) + k);
    mesh.points = std::move(points);
    return mesh;
}

}  // namespace

TEST_CASE("coincident faces of touching solids are associated with the first face") {
    const CadModel model = model_of(Kind::two_boxes, {1, 1, 1});
    REQUIRE(model.faces() == 12);
    const LinearMesh<3> mesh = two_cubes();
    const CadAssociation a = associated(mesh, model);
    CHECK(a.coincident_facets == 8);
    CHECK(a.ambiguous_facets + a.ambiguous_edges + a.ambiguous_vertices == 0);
    CHECK(a.largest_vertex_distance <= 1e-14);
    const auto& last = a.of_references.back();
    CHECK(last.first == 9);
    CHECK(last.second.size() == 1);  // all on one of the two faces
}

TEST_CASE("excluded references are on no face and make no ridges") {
    const CadModel model = model_of(Kind::box, {1, 2, 3});
    const LinearMesh<3> mesh = box_mesh();
    const auto edges = value(unique_edges(mesh, {}));
    const std::vector<Reference> elsewhere{2, 5};
    const CadAssociation whole = associated(mesh, model);
    const CadAssociation a = value(associate(mesh, edges, model, elsewhere, {}));
    std::size_t on_model = 0;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        const Reference reference = mesh.facets.references[f];
        const bool is_elsewhere = reference == 2 || reference == 5;
        CHECK(a.faces[f] == (is_elsewhere ? no_face : whole.faces[f]));
        on_model += is_elsewhere ? 0 : 1;
    }
    CHECK(a.facets == on_model);
    CHECK(a.faces_met == 4);
    CHECK(a.ridges.size() < whole.ridges.size());
    CHECK(a.ambiguous_facets + a.ambiguous_edges + a.ambiguous_vertices == 0);
}

TEST_CASE("a partial association rejects a model of another size or place") {
    const LinearMesh<3> mesh = box_mesh();
    const auto edges = value(unique_edges(mesh, {}));
    const std::vector<Reference> elsewhere{2, 5};
    for (const double unit : {1e-3, 0.1, 10.0, 1e3}) {
        const auto wrong = associate(mesh, edges, model_of(Kind::box, {unit, 2 * unit, 3 * unit}), elsewhere, {});
        REQUIRE(!wrong);
        CHECK(wrong.error().kind == ErrorKind::input);
        CHECK(wrong.error().what.find("(1, 2, 3)") != std::string::npos);
    }
    // Inside the model's box, but on none of its faces.
    LinearMesh<3> inside = mesh;
    auto points = take(std::move(inside.points));
    for (Vec<3>& p : points) p += Vec<3>{{5, 5, 5}};
    inside.points = std::move(points);
    const auto far = associate(inside, edges, model_of(Kind::box, {20, 20, 20}), elsewhere, {});
    REQUIRE(!far);
    CHECK(far.error().what.find("the farthest by") != std::string::npos);
}

TEST_CASE("vertices move onto the model unless they are required") {
    const CadModel model = model_of(Kind::box, {1, 2, 3});
    LinearMesh<3> mesh = perturbed(box_mesh(), 3e-3);
    mesh.required_vertices = Buffer<VertexId>{VertexId(0)};
    const auto edges = value(unique_edges(mesh, {}));
    const auto moved_by = [&](int threads) {
        const Execution execution{.threads = threads};
        const CadAssociation a = value(associate(mesh, edges, model, execution));
        return value(vertices_onto(model, a, mesh, Geometry<3>(CadGeometry{model, a, mesh}), execution));
    };
    const VerticesOnModel moved = moved_by(1);
    CHECK(moved.moved > 20);
    CHECK(moved.constrained == 0);
    CHECK(moved.largest <= 6e-3);
    CHECK(moved.points[VertexId(0)] == mesh.points[VertexId(0)]);
    CHECK(moved_by(2).points == moved.points);
    LinearMesh<3> on = mesh;
    on.points = moved.points;
    const CadAssociation after = associated(on, model);
    CHECK(after.farthest_vertex == VertexId(0));
    on.required_vertices = {};
    const auto again = value(vertices_onto(model, after, on, Geometry<3>(CadGeometry{model, after, on}), {}));
    CHECK(again.moved == 1);  // the vertex that was required
    on.points = again.points;
    CHECK(associated(on, model).largest_vertex_distance <= 1e-12);
}

TEST_CASE("a vertex moves only as far as no element becomes flat") {
    const CadModel model = model_of(Kind::box, {1, 1, 1});
    // A vertex is 0.04 above the side; the vertex under it is 0.002 below the side.
    BoxOptions<3> options;
    options.cells = {2, 2, 2};
    options.jitter = 0;
    LinearMesh<3> mesh = value(generate(options));
    auto points = take(std::move(mesh.points));
    for (Vec<3>& p : points) {
        if (p == Vec<3>{{0.5, 0.5, 0.5}}) p[2] = 0.998;
        if (p == Vec<3>{{0.5, 0.5, 1}}) p[2] = 1.04;
    }
    mesh.points = std::move(points);
    const CadAssociation a = associated(mesh, model);
    const auto moved = value(vertices_onto(model, a, mesh, Geometry<3>(CadGeometry{model, a, mesh}), {}));
    CHECK(moved.moved == 1);
    CHECK(moved.constrained == 1);
    CHECK(moved.largest < 0.04);
}

TEST_CASE("a facet that spans a ridge of the model is reported with its position") {
    const CadModel model = model_of(Kind::box, {1, 2, 3});
    BoxOptions<3> options;
    options.high = {{1, 2, 3}};
    options.jitter = 0;
    LinearMesh<3> mesh = value(generate(options));
    CHECK(associated(mesh, model).across.count == 0);
    // Moves a vertex of the ridge x = y = 0 within the side x = 0.
    auto points = take(std::move(mesh.points));
    const auto moved = std::find_if(points.begin(), points.end(),
                                    [](const Vec<3>& p) { return p[0] == 0 && p[1] == 0 && p[2] > 0.5 && p[2] < 2.5; });
    REQUIRE(moved != points.end());
    const double height = (*moved)[2];
    (*moved)[1] += 0.15;
    mesh.points = std::move(points);
    const CadAssociation a = associated(mesh, model);
    CHECK(!a.fit_error);
    REQUIRE(a.across.count >= 1);
    CHECK(distance(a.across.place, Vec<3>{{0, 0, height}}) <= 1e-12);
    CHECK(a.joined.empty());
}
