// CAD models as the geometry of meshes.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
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

template <class T>
T value(Outcome<T> outcome) {
    if (!outcome) FAIL(describe(outcome.error()));
    return std::move(*outcome);
}

Geometry<3> geometry_of(const QuadraticMesh<3>& mesh, const CadModel& model) {
    return Geometry<3>(CadGeometry{model, value(associate(mesh.linear, mesh.edges, model, {})), mesh.linear});
}

double largest_distance(const QuadraticMesh<3>& mesh, const Geometry<3>& geometry) {
    const auto features = value(find_features(mesh.linear, mesh.edges, FeatureOptions<3>{}, {}));
    const auto nodes = value(boundary_nodes(mesh, features, geometry, {}));
    const auto around = value(boundary_distance<3>(mesh, nodes, features, geometry, {}));
    return around.largest;
}

/// A cylinder of prisms cut to tetrahedra, with n corners around.
LinearMesh<3> cylinder_mesh(std::size_t n, double radius, double height) {
    Buffer<Vec<3>> points{{{0, 0, 0}}, {{0, 0, height}}};
    for (std::size_t i = 0; i < n; ++i) {
        const double angle = 2 * 3.141592653589793 * static_cast<double>(i) / static_cast<double>(n);
        for (const double z : {0.0, height})
            points.push_back({{radius * std::cos(angle), radius * std::sin(angle), z}});
    }
    const auto v = [](std::size_t i) { return VertexId(i); };
    const auto low = [&](std::size_t i) { return v(2 + 2 * (i % n)); };
    const auto high = [&](std::size_t i) { return v(3 + 2 * (i % n)); };
    Buffer<SimplexVertices<3>> elements;
    Buffer<SimplexVertices<2>> facets;
    for (std::size_t i = 0; i < n; ++i) {
        elements.push_back({v(0), low(i), low(i + 1), v(1)});
        elements.push_back({low(i), low(i + 1), v(1), high(i + 1)});
        elements.push_back({low(i), high(i + 1), v(1), high(i)});
        facets.push_back({v(0), low(i + 1), low(i)});
        facets.push_back({v(1), high(i), high(i + 1)});
        facets.push_back({low(i), low(i + 1), high(i + 1)});
        facets.push_back({low(i), high(i + 1), high(i)});
    }
    LinearMesh<3> mesh;
    mesh.point_references = Buffer<Reference>(points.size(), 0);
    mesh.points = std::move(points);
    mesh.elements = {elements, Buffer<Reference>(elements.size(), 1), {}};
    mesh.facets = {facets, Buffer<Reference>(facets.size(), 1), {}};
    return mesh;
}

}  // namespace

TEST_CASE("nodes of a shell lie on its spheres") {
    for (const char* const ending : {".brep", ".step"}) {
        const CadModel model = model_of(Kind::shell, {1, 5, 0}, ending);
        const auto mesh = value(elevate(value(generate(ShellOptions<3>{})), {}));
        const Geometry<3> geometry = geometry_of(mesh, model);
        const auto features = value(find_features(mesh.linear, mesh.edges, FeatureOptions<3>{}, {}));
        const auto nodes = value(boundary_nodes(mesh, features, geometry, {}));
        for (std::size_t e = 0; e < nodes.size(); ++e) {
            if (features.edge_kinds[e] == EdgeKind::volume) continue;
            const double r = norm(nodes[e].point);
            CHECK(std::fmin(std::abs(r - 1), std::abs(r - 5)) <= 1e-14);
        }
    }
}

TEST_CASE("nodes of a cylinder lie on its circles and on its mantle") {
    const CadModel model = model_of(Kind::cylinder, {0.5, 2, 0});
    for (const std::size_t n : {7, 12}) {
        const auto mesh = value(elevate(cylinder_mesh(n, 0.5, 2), {}));
        const CadAssociation a = value(associate(mesh.linear, mesh.edges, model, {}));
        CHECK(a.faces_met == 3);
        CHECK(a.edges_met == 2);
        CHECK(a.ambiguous_facets + a.ambiguous_edges + a.ambiguous_vertices == 0);
        const Geometry<3> geometry = geometry_of(mesh, model);
        const auto features = value(find_features(mesh.linear, mesh.edges, FeatureOptions<3>{}, {}));
        const auto nodes = value(boundary_nodes(mesh, features, geometry, {}));
        std::size_t rims = 0;
        for (std::size_t f = 0; f < mesh.linear.facets.size(); ++f)
            for (const EdgeId e : mesh.edges.of_facets[f]) {
                const auto& [low, high] = mesh.edges.vertices[e];
                if (low.index() < 2 || high.index() < 2) continue;
                const Vec<3>& p = nodes[e.index()].point;
                CHECK(std::abs(std::hypot(p[0], p[1]) - 0.5) <= 1e-15);
                rims += p[2] == 0 ? 1 : 0;
            }
        CHECK(rims == 2 * n);
        // The bound is for the distance between a circle and the parabola through three of its points.
        CHECK(largest_distance(mesh, geometry) <= 0.5 * std::pow(6.3 / static_cast<double>(n), 4) / 64);
    }
}

TEST_CASE("edges and facets are assigned to their curves and surfaces") {
    const CadModel model = model_of(Kind::cylinder, {0.5, 2, 0});
    const auto mesh = value(elevate(cylinder_mesh(8, 0.5, 2), {}));
    const Geometry<3> geometry = geometry_of(mesh, model);
    const auto shells = value(facet_shells(mesh.edges, {}));
    for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
        if (shells[e].empty()) continue;
        const auto& [low, high] = mesh.edges.vertices[e];
        const EdgeSite<3> site{EdgeId(e),
                               EdgeKind::surface,
                               {mesh.linear.points[low], mesh.linear.points[high]},
                               facet_sites<3>(mesh.linear, shells[e])};
        const GeometryEntity entity = geometry->entity_at_edge(site);
        const bool is_rim = site.ends[0][2] == site.ends[1][2] && low.index() >= 2;
        CHECK(entity.kind == (is_rim ? GeometryKind::curve : GeometryKind::surface));
        const auto at = geometry->on_edge(site, site.middle());
        CHECK(at.entity == entity);
        REQUIRE(at.parameters);
        const auto again = geometry->evaluate(entity, *at.parameters);
        REQUIRE(again);
        CHECK(distance(again->point, at.point) <= 1e-14);
    }
    // Facets without an id are found by their reference and position.
    FacetSite<3> bottom = facet_site(mesh.linear, FacetId(0)), mantle = facet_site(mesh.linear, FacetId(2));
    const GeometryEntity of_bottom = geometry->surface_at(bottom), of_mantle = geometry->surface_at(mantle);
    CHECK(of_bottom != of_mantle);
    bottom.id = mantle.id = {};
    CHECK(geometry->surface_at(bottom) == of_bottom);
    CHECK(geometry->surface_at(mantle) == of_mantle);
    CHECK(geometry->plane_at(bottom).has_value());
    CHECK(!geometry->plane_at(mantle).has_value());
}

namespace {

/// The triangles of a model as a quadratic surface mesh; references are faces.
QuadraticMesh<3> surface_of(Kind kind, const std::array<double, 3>& sizes, double deflection) {
    const Triangles triangles = triangles_of(kind, sizes, deflection);
    LinearMesh<3> mesh;
    Buffer<Vec<3>> points;
    for (const auto& p : triangles.points) points.push_back(Vec<3>{p});
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
    return value(elevate(std::move(mesh), {}));
}

}  // namespace

TEST_CASE("the largest distance from a model needs few projections") {
    struct Model {
        Kind kind;
        std::array<double, 3> sizes;
        double deflection;
    };
    for (const auto& [kind, sizes, deflection] :
         {Model{Kind::nurbs_ball, {1, 0, 0}, 0.005}, Model{Kind::nurbs_torus, {2, 0.5, 0}, 0.01},
          Model{Kind::tilted_hole, {0.2, 0.5236, 0}, 0.005}, Model{Kind::groove, {1.2, 0.3, 0}, 0.01},
          Model{Kind::skew_cone, {1, 0.4, 2}, 0.01}}) {
        CAPTURE(static_cast<int>(kind));
        const CadModel model = model_of(kind, sizes);
        const QuadraticMesh<3> mesh = surface_of(kind, sizes, deflection);
        const Geometry<3> geometry = geometry_of(mesh, model);
        const auto features = value(find_features(mesh.linear, mesh.edges, FeatureOptions<3>{}, {}));
        const auto nodes = value(boundary_nodes(mesh, features, geometry, {}));
        std::size_t projected = mesh.edges.size();  // one projection for each node
        for (const std::span<const LagrangeNode<3>> places :
             {mesh.mid_nodes.view(), std::span(nodes).first(nodes.size())}) {
            const auto all = value(boundary_distance<3>(mesh, places, features, geometry, {}));
            const auto largest = value(largest_boundary_distance<3>(mesh, places, features, geometry, {}));
            CHECK(largest.largest == doctest::Approx(all.largest).epsilon(1e-9));
            const auto threads = value(largest_boundary_distance<3>(mesh, places, features, geometry, {.threads = 3}));
            CHECK(threads.largest == largest.largest);
            CHECK(threads.projected == largest.projected);
            projected += largest.projected;
        }
        CHECK(4 * projected <= 9 * mesh.edges.size());
        const auto curved = value(largest_boundary_distance<3>(mesh, nodes, features, geometry, {}));
        const auto straight = value(largest_boundary_distance<3>(mesh, mesh.mid_nodes.view(), features, geometry, {}));
        const NearBoundary<3> near{mesh, nodes, curved.largest};
        const auto by_curved =
            value(largest_boundary_distance<3>(mesh, mesh.mid_nodes.view(), features, geometry, near, {}));
        CHECK(by_curved.largest == doctest::Approx(straight.largest).epsilon(1e-9));
        CHECK(by_curved.projected <= straight.projected);
    }
}

TEST_CASE("nodes of facets across sliver and split faces lie on the virtual face") {
    for (const double sliver : {0.5, 0.03, 0.002}) {
        const CadModel model = model_of(Kind::split_cylinder, {0.5, 2, sliver}, ".step");
        REQUIRE(model.faces() == 9);
        for (const std::size_t n : {8, 12, 24}) {
            CAPTURE(sliver);
            CAPTURE(n);
            const auto mesh = value(elevate(cylinder_mesh(n, 0.5, 2), {}));
            const CadAssociation a = value(associate(mesh.linear, mesh.edges, model, {}));
            CHECK(a.ambiguous_facets + a.ambiguous_edges + a.ambiguous_vertices == 0);
            CHECK(a.largest_vertex_distance <= 1e-12);
            CHECK(!a.fit_error);
            CHECK(a.across.count == 0);
            REQUIRE(a.joined.size() == 3);  // the mantle and both ends
            for (const auto& faces : a.joined) CHECK(faces.size() == 3);
            const Geometry<3> geometry = geometry_of(mesh, model);
            const auto features = value(find_features(mesh.linear, mesh.edges, FeatureOptions<3>{}, {}));
            const auto nodes = value(boundary_nodes(mesh, features, geometry, {}));
            for (std::size_t f = 0; f < mesh.linear.facets.size(); ++f)
                for (const EdgeId e : mesh.edges.of_facets[f]) {
                    const auto& [low, high] = mesh.edges.vertices[e];
                    const Vec<3>& p = nodes[e.index()].point;
                    if (low.index() < 2 || high.index() < 2) {
                        CHECK(distance(p, midpoint(mesh.linear.points[low], mesh.linear.points[high])) <= 1e-12);
                    } else {
                        CHECK(std::abs(std::hypot(p[0], p[1]) - 0.5) <= 1e-12);
                        const double z = mesh.linear.points[low][2];
                        if (z == mesh.linear.points[high][2]) CHECK(std::abs(p[2] - z) <= 1e-12);
                    }
                }
            CHECK(largest_distance(mesh, geometry) <= 0.5 * std::pow(6.3 / static_cast<double>(n), 4) / 64 + 1e-13);
        }
    }
}

TEST_CASE("a mesh that respects the model's edges joins no faces") {
    for (const auto& [kind, sizes] : {std::pair(Kind::cylinder, std::array{0.5, 2.0, 0.0}),
                                      std::pair(Kind::split_cylinder, std::array{0.5, 2.0, 0.5})}) {
        LinearMesh<3> straight = cylinder_mesh(12, 0.5, 2);
        if (kind == Kind::split_cylinder) {  // vertices at the ends of its three parts, as a mesher places them
            auto points = take(std::move(straight.points));
            const std::array<double, 4> parts{0.2, 0.7, 0.2 + 0.5 * (2 * 3.141592653589793 + 0.5),
                                              0.2 + 2 * 3.141592653589793};
            for (std::size_t i = 0; i < 12; ++i) {
                const double angle = parts[i / 4] + (parts[i / 4 + 1] - parts[i / 4]) * static_cast<double>(i % 4) / 4;
                for (const std::size_t k : {0, 1}) {
                    points[2 + 2 * i + k][0] = 0.5 * std::cos(angle);
                    points[2 + 2 * i + k][1] = 0.5 * std::sin(angle);
                }
            }
            straight.points = std::move(points);
        }
        const auto mesh = value(elevate(straight, {}));
        const CadAssociation a = value(associate(mesh.linear, mesh.edges, model_of(kind, sizes), {}));
        CHECK(a.joined.empty());
        CHECK(a.ambiguous_facets + a.ambiguous_edges + a.ambiguous_vertices == 0);
    }
}
