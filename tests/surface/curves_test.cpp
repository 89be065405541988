// Smooth boundary curves, corners and lines in 2D.
#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "meshes.hpp"

using namespace surface_tests;

namespace {

// Unevenly spaced angles.
std::vector<double> uneven_angles(std::size_t n, double from, double to, unsigned seed) {
    Random random(seed);
    std::vector<double> angles;
    for (std::size_t i = 0; i <= n; ++i) {
        const bool end = i == 0 || i == n;
        const double t = (static_cast<double>(i) + (end ? 0 : random(-0.3, 0.3))) / static_cast<double>(n);
        angles.push_back(from + (to - from) * t);
    }
    return angles;
}

// Half an ellipse of half axes 1 and b, closed by its diameter, with two corners.
Soup<2> half_ellipse(std::size_t n, double b, unsigned seed = 1) {
    std::vector<Vec<2>> points;
    for (const double a : uneven_angles(n, 0, pi, seed)) points.push_back({{std::cos(a), b * std::sin(a)}});
    points.back() = {{-1, 0}};
    for (const double x : {-0.5, 0.0, 0.25}) points.push_back({{x, 0}});
    return polygon(points);
}

// |f|/|∇f| of the ellipse, which is the distance to first order.
double off_ellipse(const Vec<2>& p, double b) {
    const double f = p[0] * p[0] + p[1] * p[1] / (b * b) - 1;
    return std::fabs(f) / (2 * std::hypot(p[0], p[1] / (b * b)));
}

double node_error(const Built<2>& built, double b) {
    double worst = 0;
    for (std::size_t e = 0; e < built.nodes.size(); ++e) {
        const Vec<2> p = built.nodes[e].point;
        if (p[1] == 0) continue;
        worst = std::fmax(worst, off_ellipse(p, b));
    }
    return worst;
}

double curve_error(const Built<2>& built, double b) {
    double worst = 0;
    for (const auto& facet : built.surrogate.facets)
        for (int i = 0; i <= 10; ++i) {
            const Vec<2> p = point_at(facet, Barycentric<1>{1 - i / 10.0, i / 10.0});
            if (p[1] > 1e-12) worst = std::fmax(worst, off_ellipse(p, b));
        }
    return worst;
}

}  // namespace

TEST_CASE("nodes of a circle are exact to rounding with or without corners") {
    std::vector<Vec<2>> points;
    for (const double a : uneven_angles(20, 0, 2 * pi, 3)) points.push_back({{std::cos(a), std::sin(a)}});
    points.pop_back();
    const auto whole = build(polygon(points).mesh());
    CHECK(whole.features.corners == 0);
    CHECK(node_error(whole, 1) < 1e-14);
    CHECK(curve_error(whole, 1) < 1e-6);
    const auto half = build(half_ellipse(10, 1).mesh());
    CHECK(half.features.corners == 2);
    CHECK(node_error(half, 1) < 1e-13);
}

TEST_CASE("nodes and curves of an ellipse with corners converge with order 4") {
    const double b = 0.5;
    double nodes[2] = {0, 0}, curves[2] = {0, 0};
    for (const unsigned seed : {1U, 2U, 3U})
        for (const int level : {0, 1}) {
            const auto built = build(half_ellipse(level == 0 ? 24 : 96, b, seed).mesh());
            CHECK(built.features.corners == 2);
            nodes[level] = std::fmax(nodes[level], node_error(built, b));
            curves[level] = std::fmax(curves[level], curve_error(built, b));
        }
    MESSAGE("orders: mid nodes " << std::log2(nodes[0] / nodes[1]) / 2 << ", cubic "
                                 << std::log2(curves[0] / curves[1]) / 2);
    CHECK(std::log2(nodes[0] / nodes[1]) / 2 > 3.6);
    CHECK(std::log2(curves[0] / curves[1]) / 2 > 3.6);
}

TEST_CASE("straight sides stay straight beside curved ones") {
    const auto built = build(half_ellipse(12, 1).mesh());
    for (std::size_t e = 0; e < built.nodes.size(); ++e) {
        const auto& [low, high] = built.mesh.edges.vertices[e];
        if (built.mesh.linear.points[low][1] == 0 && built.mesh.linear.points[high][1] == 0)
            CHECK(built.nodes[e] == built.mesh.mid_nodes[e]);
    }
    const auto d = distance_of(built);
    CHECK(d.largest < 1e-4);
    CHECK(d.largest > 0);
}

TEST_CASE("projection onto a curve passes its vertices and stops at its corners") {
    const auto built = build(half_ellipse(16, 1).mesh());
    const Geometry<2> geometry = built.surrogate;
    const auto top = project<2>(geometry, {.facet = FacetId(std::size_t{2})}, Vec<2>{{0, 1.5}});
    CHECK(distance(top.point, Vec<2>{{0, 1}}) < 1e-6);
    CHECK(std::fabs(top.normal[1]) > 0.999999);
    const auto clamped = project<2>(geometry, {.facet = FacetId(std::size_t{2})}, Vec<2>{{1.2, -2}});
    CHECK(distance(clamped.point, Vec<2>{{1, 0}}) < 1e-12);
    const auto line = project<2>(geometry, {}, Vec<2>{{0.1, -2}});
    CHECK(distance(line.point, Vec<2>{{0.1, 0}}) < 1e-12);
}

TEST_CASE("boundary nodes lie on an analytic circle and line") {
    auto soup = half_ellipse(10, 1);
    soup.references.assign(soup.facets.size(), 2);
    for (std::size_t f = 0; f < 10; ++f) soup.references[f] = 1;
    const auto built = build(soup.mesh());
    const AnalyticGeometry<2> geometry{{{1, Sphere<2>{{}, 1}}, {2, Plane<2>{{}, {{0, 1}}}}}};
    const Execution execution{.threads = 1};
    const auto nodes = boundary_nodes(built.mesh, built.features, Geometry<2>(geometry), execution).value();
    for (const auto& node : nodes) CHECK((node.point[1] == 0 || std::fabs(norm(node.point) - 1) < 1e-15));
    const auto d = boundary_distance<2>(built.mesh, nodes, built.features, Geometry<2>(geometry), execution).value();
    CHECK(d.largest < 2e-4);
    CHECK(d.largest > 1e-7);
}
