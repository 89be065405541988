// Models with obliquely cut faces, whose bounding boxes are not tight, are accepted; wrong models and units are
// rejected.
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
import camber.surface;
import camber.cad;

using namespace camber;
using namespace cad_tests;

namespace {

LinearMesh<3> mesh_of(const Triangles& triangles, double scale) {
    LinearMesh<3> mesh;
    Buffer<Vec<3>> points;
    for (const auto& p : triangles.points) points.push_back(scale * Vec<3>{p});
    Buffer<SimplexVertices<2>> facets;
    Buffer<Reference> references;
    for (std::size_t t = 0; t < triangles.triangles.size(); ++t) {
        const auto& c = triangles.triangles[t];
        facets.push_back({VertexId(c[0]), VertexId(c[1]), VertexId(c[2])});
        references.push_back(triangles.faces[t]);
    }
    mesh.point_references = Buffer<Reference>(points.size(), 0);
    mesh.points = std::move(points);
    mesh.facets = {std::move(facets), std::move(references), {}};
    return mesh;
}

Outcome<CadAssociation> associated(const LinearMesh<3>& mesh, const CadModel& model) {
    const auto edges = unique_edges(mesh, {});
    if (!edges) return fail(edges.error());
    return associate(mesh, *edges, model, {});
}

struct ObliqueModel {
    Kind kind;
    std::array<double, 3> sizes;
};
constexpr std::array<ObliqueModel, 4> oblique_models{{{Kind::tilted_hole, {0.2, 0.5236, 0}},
                                                      {Kind::cap, {1, 0.6, 0}},
                                                      {Kind::groove, {1.2, 0.3, 0}},
                                                      {Kind::skew_cone, {1, 0.4, 2}}}};

}  // namespace

// Guards against correct models that are rejected because of the boxes of trimmed faces.
TEST_CASE("models with oblique faces are associated with their meshes in each format") {
    for (const auto& [kind, sizes] : oblique_models) {
        const LinearMesh<3> mesh = mesh_of(triangles_of(kind, sizes, 0.02), 1);
        REQUIRE(mesh.facets.size() > 20);
        for (const char* const ending : {".step", ".iges", ".brep"}) {
            CAPTURE(static_cast<int>(kind));
            CAPTURE(ending);
            const CadModel model = model_of(kind, sizes, ending);
            const auto found = associated(mesh, model);
            if (!found) FAIL(describe(found.error()));
            CHECK(found->faces_met == model.faces());
            CHECK(found->largest_vertex_distance <= 1e-4);
            const CadLosses losses = model.losses();
            CHECK(losses.faces + losses.entities + losses.open_shells == 0);
        }
    }
}

TEST_CASE("wrong units and wrong models are rejected with distances and the unit") {
    for (const auto& [kind, sizes] : oblique_models) {
        CAPTURE(static_cast<int>(kind));
        const CadModel model = model_of(kind, sizes);
        const Triangles triangles = triangles_of(kind, sizes, 0.02);
        for (const auto& [scale, unit] :
             {std::pair(1e-3, "in m:"), std::pair(1 / 25.4, "in in:"), std::pair(1e3, "in um:")}) {
            const auto found = associated(mesh_of(triangles, scale), model);
            REQUIRE(!found);
            CHECK(found.error().kind == ErrorKind::input);
            CHECK(found.error().what.find("reaches from") != std::string::npos);
            CHECK(found.error().remedy.find(unit) != std::string::npos);
        }
        for (const auto& other : oblique_models) {
            if (other.kind == kind) continue;
            const auto found = associated(mesh_of(triangles, 1), model_of(other.kind, other.sizes));
            REQUIRE(!found);
            CHECK(found.error().what.find("the farthest by") != std::string::npos);
        }
    }
}

TEST_CASE("the unit of a mesh is found from its boundary if exactly one fits") {
    for (const auto& [kind, sizes] : oblique_models) {
        CAPTURE(static_cast<int>(kind));
        const CadModel model = model_of(kind, sizes);  // in millimetres
        const Triangles triangles = triangles_of(kind, sizes, 0.02);
        for (const auto& [scale, unit] :
             {std::pair(1.0, "mm"), std::pair(1e-3, "m"), std::pair(1 / 25.4, "in"), std::pair(1e3, "um")}) {
            const LinearMesh<3> mesh = mesh_of(triangles, scale);
            const auto found = in_unit_of(mesh, model, {}, {});
            REQUIRE(found);
            CHECK(found->unit() == unit);
            CHECK(found->is_in_file_unit() == (scale == 1));
            const auto association = associated(mesh, *found);
            if (!association) FAIL(describe(association.error()));
            CHECK(association->largest_vertex_distance <= 1e-4 * scale);
        }
        const auto none = in_unit_of(mesh_of(triangles, 0.5), model, {}, {});
        REQUIRE(none);
        CHECK(none->unit() == "mm");
        CHECK(!associated(mesh_of(triangles, 0.5), *none));
    }
}

// Guards against accepted models that lack a face of the mesh.
TEST_CASE("a model that lacks a face is rejected with the reference of that face") {
    // The mesh is that of a longer box, so all its faces but one lie on the model.
    BoxOptions<3> options;
    options.high = {{44, 1, 1}};
    options.cells = {88, 2, 2};
    options.jitter = 0;
    const auto mesh = generate(options);
    REQUIRE(mesh);
    const auto found = associated(*mesh, model_of(Kind::box, {40, 1, 1}));
    REQUIRE(!found);
    CHECK(found.error().what.find("of reference") != std::string::npos);
}

TEST_CASE("a mesh of another radius is rejected with face, vertex and distance") {
    // Edges of the mesh are about 0.3 long; the radius of the model differs by this share of it.
    for (const double share : {0.0, 0.03, -0.03, 0.15, -0.15, 0.4}) {
        CAPTURE(share);
        const Triangles triangles = triangles_of(Kind::cylinder, {1, 2, 0}, 0.01);
        const CadModel model = model_of(Kind::cylinder, {1 - 0.3 * share, 2, 0});
        const auto found = associated(mesh_of(triangles, 1), model);
        if (!found) FAIL(describe(found.error()));
        const auto fits = check_vertices<3>(*found, CadVertices::keep);
        REQUIRE(fits.has_value() == (std::abs(share) < 0.05));
        if (fits) continue;
        CHECK(fits.error().kind == ErrorKind::input);
        CHECK(fits.error().entity->kind == "vertex");
        CHECK(fits.error().what.find(" away from CAD face 1, ") != std::string::npos);
        CHECK(fits.error().what.find(" % of the shortest boundary edge there; ") != std::string::npos);
        CHECK(fits.error().remedy.find("--cad-vertices move") != std::string::npos);
        CHECK(std::abs(found->fit_error->fit.largest - 0.3 * std::abs(share)) <= 1e-9);
        CHECK(found->fit_error->fit.off == found->fit_error->fit.vertices);
    }
}

TEST_CASE("a mesh with few vertices off a face is accepted") {
    const CadModel model = model_of(Kind::box, {1, 1, 1});
    BoxOptions<3> options;
    options.jitter = 0;
    options.cells = {10, 10, 10};
    const auto fits = [&](std::size_t count) {
        auto mesh = generate(options);
        REQUIRE(mesh);
        auto points = take(std::move(mesh->points));
        std::size_t moved = 0;
        for (Vec<3>& p : points)
            if (p[2] == 1 && p[0] > 0 && p[0] < 1 && p[1] > 0 && p[1] < 1 && moved < count) {
                p[2] = 1.03;
                ++moved;
            }
        mesh->points = std::move(points);
        const auto found = associated(*mesh, model);
        if (!found) FAIL(describe(found.error()));
        return check_vertices<3>(*found, CadVertices::keep).has_value();
    };
    CHECK(fits(2));  // of 121 vertices of that side
    CHECK_FALSE(fits(20));
    options.cells = {2, 2, 2};
    CHECK(fits(1));  // of 9
}

TEST_CASE("a CAD model is identical to the last bit in another process") {
    const File file(".step");
    write_model(Kind::filleted_box, {2, 0.3, 0}, file, "INCH");
    for (const CadUnit unit : {CadUnit::file, CadUnit::m}) {
        const auto original = read_cad(file.path(), {unit}), plain = read_cad(file.path(), {});
        REQUIRE(original);
        REQUIRE(plain);
        const auto bytes = packed_cad(*plain);
        REQUIRE(bytes);
        const auto unpacked = unpacked_cad(*bytes, {unit});
        REQUIRE(unpacked);
        CHECK(unpacked->file_unit() == original->file_unit());
        REQUIRE(unpacked->faces() == original->faces());
        REQUIRE(unpacked->vertices() == original->vertices());
        for (std::size_t v = 0; v < original->vertices(); ++v) CHECK(unpacked->vertex(v) == original->vertex(v));
        for (std::size_t f = 0; f < original->faces(); ++f) {
            const Vec<3> p{{0.31, 0.17, 0.05}};
            CHECK(closest_on_face(*unpacked, f, p).point == closest_on_face(*original, f, p).point);
        }
    }
    const auto cut = unpacked_cad("camber-cad-1 1 0", {});
    REQUIRE(!cut);
    CHECK(cut.error().kind == ErrorKind::input);
}
