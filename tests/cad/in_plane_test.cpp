// Plane models as the geometry of 2D meshes.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
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

constexpr double pi = 3.141592653589793;

template <class T>
T value(Outcome<T> outcome) {
    if (!outcome) FAIL(describe(outcome.error()));
    return std::move(*outcome);
}

/// A fan of triangles around a point near the origin, with its rim through these points.
LinearMesh<2> fan(const std::vector<Vec<2>>& rim) {
    const auto v = [&](std::size_t i) { return VertexId(1 + i % rim.size()); };
    Buffer<Vec<2>> points{Vec<2>{{0, 0.1}}};
    Buffer<SimplexVertices<2>> elements;
    Buffer<SimplexVertices<1>> facets;
    for (std::size_t i = 0; i < rim.size(); ++i) {
        points.push_back(rim[i]);
        elements.push_back({VertexId(0), v(i), v(i + 1)});
        facets.push_back({v(i), v(i + 1)});
    }
    LinearMesh<2> mesh;
    mesh.point_references = Buffer<Reference>(points.size(), 0);
    mesh.points = std::move(points);
    mesh.elements = {elements, Buffer<Reference>(elements.size(), 1), {}};
    mesh.facets = {facets, Buffer<Reference>(facets.size(), 1), {}};
    return mesh;
}

/// n points along the only edge of a model.
std::vector<Vec<2>> along_edge(const CadModel& model, std::size_t n) {
    const auto samples = value(samples_of<2>(model, n, {}));
    std::vector<Vec<2>> rim;
    rim.reserve(n);
    const std::size_t all = samples.points.size();
    for (std::size_t i = 0; i < n; ++i) rim.push_back(samples.points[i * all / n]);
    return rim;
}

CadAssociation associated(const LinearMesh<2>& mesh, const CadModel& model, int threads = 1) {
    const Execution execution{.threads = threads};
    return value(associate(mesh, value(unique_edges(mesh, execution)), model, execution));
}

double largest_distance(const LinearMesh<2>& straight, const CadModel& model) {
    const auto mesh = value(elevate(straight, {}));
    const Geometry<2> geometry(
        CadGeometry<2>{model, value(associate(mesh.linear, mesh.edges, model, {})), mesh.linear});
    const auto features = value(find_features(mesh.linear, mesh.edges, FeatureOptions<2>{}, {}));
    const auto nodes = value(boundary_nodes(mesh, features, geometry, {}));
    for (std::size_t f = 0; f < straight.facets.size(); ++f) {
        const EdgeId e = mesh.edges.of_facets[f][0];
        const GeometryEntity on = geometry->surface_at(facet_site(mesh.linear, FacetId(f)));
        CHECK(project(geometry, {.facet = {}, .reference = {}, .entity = on}, nodes[e.index()].point).distance <=
              1e-13);
    }
    return value(boundary_distance<2>(mesh, nodes, features, geometry, {})).largest;
}

}  // namespace

TEST_CASE("closest points on plane curves are perpendicular and idempotent") {
    for (const Kind kind : {Kind::annulus, Kind::ellipse, Kind::spline, Kind::half_disc})
        for (const char* const ending : {".brep", ".step"}) {
            const bool is_ellipse = kind == Kind::ellipse;
            const CadModel model = model_of(kind, {is_ellipse ? 2.0 : 1.0, is_ellipse ? 1.0 : 2.0, 0}, ending);
            for (std::size_t e = 0; e < model.edges(); ++e)
                for (int i = 0; i < 40; ++i) {
                    const Vec<2> p{{1.7 * std::cos(0.7 * i), 1.4 * std::sin(1.1 * i)}};
                    const CadCurveFoot foot = closest_on_curve(model, e, p);
                    const CadCurveFoot again = closest_on_curve(model, e, foot.point);
                    CHECK(again.point == foot.point);
                    CHECK(again.distance == 0);
                    CHECK(distance(point_on_curve(model, e, foot.t).point, foot.point) <= 1e-14);
                    CHECK(std::abs(norm(foot.normal) - 1) <= 1e-15);
                    if (kind != Kind::half_disc) CHECK(std::abs(cross(p - foot.point, foot.normal)) <= 1e-12);
                }
        }
    const CadModel model = model_of(Kind::annulus, {1, 5, 3});
    for (std::size_t e = 0; e < 2; ++e) {
        const CadCurveFoot foot = closest_on_curve(model, e, {{2, 2}});
        const double radius = norm(foot.point);
        CHECK(std::fmin(std::abs(radius - 1), std::abs(radius - 5)) <= 1e-15 * 5);
    }
}

TEST_CASE("curves are associated from faces and from curves alone") {
    const LinearMesh<2> mesh = value(generate(ShellOptions<2>{}));
    for (const Kind kind : {Kind::annulus, Kind::circles})
        for (const char* const ending : {".brep", ".step", ".iges"}) {
            CAPTURE(ending);
            const CadModel model = model_of(kind, {1, 5, 0.25}, ending);
            CHECK(model.faces() == (kind == Kind::annulus ? 1 : 0));
            const CadAssociation a = associated(mesh, model);
            CHECK(a.faces_met == model.faces());
            CHECK(a.edges_met == 2);
            CHECK(a.vertices_met == 0);
            CHECK(a.ambiguous_facets + a.ambiguous_edges + a.ambiguous_vertices == 0);
            CHECK(a.largest_vertex_distance <= 1e-13);
            CHECK(a.corners.empty());
            CHECK(associated(mesh, model, 2).faces == a.faces);
        }
}

TEST_CASE("vertices of the model where two curves meet are corners") {
    const CadModel model = model_of(Kind::half_disc, {1, 0, 0}, ".step");
    std::vector<Vec<2>> rim;
    for (int i = 0; i <= 12; ++i) rim.push_back({{std::cos(pi * i / 12), i % 12 == 0 ? 0 : std::sin(pi * i / 12)}});
    for (int i = 1; i < 6; ++i) rim.push_back({{-1 + i / 3.0, 0}});
    const LinearMesh<2> mesh = fan(rim);
    const CadAssociation a = associated(mesh, model);
    CHECK(a.edges_met == 2);
    CHECK(a.vertices_met == 2);
    CHECK(a.corners.size() == 2);
    CHECK(a.ambiguous_facets + a.ambiguous_vertices == 0);
    CHECK(largest_distance(mesh, model) <= std::pow(pi / 12, 3) / 8);
}

TEST_CASE("curved edges converge to the model curve with order 3") {
    for (const Kind kind : {Kind::ellipse, Kind::spline}) {
        const CadModel model = model_of(kind, {1, 0.7, 0});
        const double coarse = largest_distance(fan(along_edge(model, 32)), model);
        const double fine = largest_distance(fan(along_edge(model, 64)), model);
        CHECK(coarse > 0);
        // At the knots of a spline the third derivative jumps, so errors of edges across knots vary.
        CHECK(fine < coarse / (kind == Kind::ellipse ? 6.5 : 4));
    }
}

TEST_CASE("models in space, of another size or place are rejected") {
    const LinearMesh<2> mesh = value(generate(ShellOptions<2>{}));
    const auto edges = value(unique_edges(mesh, {}));
    const auto error = [&](Kind kind, const std::array<double, 3>& sizes) {
        const auto refused = associate(mesh, edges, model_of(kind, sizes, ".step"), {});
        REQUIRE(!refused);
        CHECK(refused.error().kind == ErrorKind::input);
        return describe(refused.error());
    };
    CHECK(error(Kind::cylinder, {1, 3, 0}).find("from z = 0 to 3") != std::string::npos);
    CHECK(error(Kind::annulus, {1000, 5000, 7}).find("in m:") != std::string::npos);
    CHECK(error(Kind::annulus, {1, 3, 0}).find("(-3, -3)") != std::string::npos);
    // Curves without faces cannot bound a volume.
    const auto solid = value(generate(ShellOptions<3>{}));
    const auto no_faces = associate(solid, value(unique_edges(solid, {})), model_of(Kind::circles, {1, 5, 0}), {});
    REQUIRE(!no_faces);
    CHECK(no_faces.error().what == "the model has no faces");
}

TEST_CASE("a 2D mesh of another radius is rejected and can be moved onto the model") {
    for (const std::size_t n : {6, 16, 40})
        for (const double share : {0.0, 0.03, -0.03, 0.12, -0.12, 0.3}) {  // of the edge length
            CAPTURE(n);
            CAPTURE(share);
            const double length = 2 * std::sin(pi / static_cast<double>(n)), radius = 1 - share * length;
            std::vector<Vec<2>> rim;
            for (std::size_t i = 0; i < n; ++i) {
                const double angle = 2 * pi * static_cast<double>(i) / static_cast<double>(n);
                rim.push_back({{std::cos(angle), std::sin(angle)}});
            }
            const CadModel model = model_of(Kind::ellipse, {radius, radius * (1 - 1e-9), 0});
            const LinearMesh<2> mesh = fan(rim);
            const CadAssociation a = associated(mesh, model);
            const auto fits = check_vertices<2>(a, CadVertices::keep);
            REQUIRE(fits.has_value() == (std::abs(share) < 0.05));
            if (!fits) CHECK(fits.error().what.find("away from CAD edge 1, ") != std::string::npos);
            // The mesh fits after its vertices are moved onto the model.
            const Geometry<2> geometry(CadGeometry<2>{model, a, mesh});
            const auto moved = value(vertices_onto(model, a, mesh, geometry, {}));
            LinearMesh<2> on = mesh;
            on.points = moved.points;
            CHECK(moved.constrained == 0);
            CHECK(associated(on, model).largest_vertex_distance <= 1e-12);
        }
}

TEST_CASE("nodes of 2D facets across smooth model vertices lie on the joined curves") {
    for (const double sliver : {0.5, 0.03, 0.002}) {
        const CadModel model = model_of(Kind::split_disc, {1, sliver, 0});
        REQUIRE(model.edges() == 3);
        for (const std::size_t n : {5, 12, 24}) {
            CAPTURE(sliver);
            CAPTURE(n);
            std::vector<Vec<2>> rim;
            for (std::size_t i = 0; i < n; ++i) {
                const double angle = 2 * pi * static_cast<double>(i) / static_cast<double>(n);
                rim.push_back({{std::cos(angle), std::sin(angle)}});
            }
            const auto mesh = value(elevate(fan(rim), {}));
            const CadAssociation a = value(associate(mesh.linear, mesh.edges, model, {}));
            CHECK(a.ambiguous_facets + a.ambiguous_vertices == 0);
            CHECK(a.largest_vertex_distance <= 1e-12);
            CHECK(!a.fit_error);
            CHECK(a.joined == std::vector<std::vector<std::size_t>>{{0, 1, 2}});
            const Geometry<2> geometry(CadGeometry<2>{model, a, mesh.linear});
            const auto features = value(find_features(mesh.linear, mesh.edges, FeatureOptions<2>{}, {}));
            const auto nodes = value(boundary_nodes(mesh, features, geometry, {}));
            for (const auto& edges : mesh.edges.of_facets)
                CHECK(std::abs(norm(nodes[edges[0].index()].point) - 1) <= 1e-14);
        }
    }
}
