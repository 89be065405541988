// Where a boundary is not smooth: tips of cones, knife edges, open rims, edges of three facets, on surfaces that are
// known.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "meshes.hpp"

using namespace surface_tests;

namespace {

/// A cone about z, or a share of it: the tip at (0, 0, slope), 10 k edges on the k-th of `rings` circles, the last of
/// radius 1.
Soup<3> pointed(std::size_t rings, double slope, double share = 1, unsigned seed = 1) {
    Random random(seed);
    const std::size_t around = 10;
    Soup<3> soup{{{{0, 0, slope}}}, {}, {}};
    std::vector<std::size_t> first{0};
    const bool whole = share == 1;
    for (std::size_t k = 1; k <= rings; ++k) {
        first.push_back(soup.points.size());
        const double r = static_cast<double>(k) / static_cast<double>(rings);
        const auto n = static_cast<std::size_t>(share * static_cast<double>(around * k));
        for (std::size_t i = 0; i < n + (whole ? 0 : 1); ++i) {
            const bool moves = whole || (i > 0 && i < n);
            const double place = static_cast<double>(i) + (moves ? random(-0.2, 0.2) : 0);
            const double a = 2 * pi * share * place / static_cast<double>(n);
            soup.points.push_back({{r * std::cos(a), moves ? r * std::sin(a) : 0, slope * (1 - r)}});
        }
    }
    const auto sectors = static_cast<std::size_t>(share * static_cast<double>(around));
    const auto at = [&](std::size_t k, std::size_t i) {
        return k == 0 ? 0 : first[k] + (whole ? i % (around * k) : i);
    };
    for (std::size_t k = 0; k < rings; ++k)
        for (std::size_t s = 0; s < sectors; ++s)
            for (std::size_t j = 0; j <= k; ++j) {
                const std::size_t inner = s * k + j, outer = s * (k + 1) + j;
                soup.facets.push_back({at(k, inner), at(k + 1, outer), at(k + 1, outer + 1)});
                if (j < k) soup.facets.push_back({at(k, inner), at(k + 1, outer + 1), at(k, inner + 1)});
            }
    return soup;
}

/// A distance across straight lines turned about z, each from (radius, height) at an angle.
struct Line {
    double radius, height, degrees;
};
Off off_turned(std::vector<Line> lines) {
    return [lines = std::move(lines)](const Vec<3>& p) {
        double least = 1e300;
        for (const Line& line : lines) {
            const double a = line.degrees * pi / 180, x = std::hypot(p[0], p[1]) - line.radius, y = p[2] - line.height;
            const double along = x * std::cos(a) + y * std::sin(a), across = y * std::cos(a) - x * std::sin(a);
            least = std::fmin(least, along > 0 ? std::fabs(across) : std::hypot(x, y));
        }
        return least;
    };
}

/// The sheets of lines of length 0.5, which meet in a circle of radius 1.
Soup<3> sheets(std::size_t n, const std::vector<double>& degrees, unsigned seed = 1) {
    std::vector<Soup<3>> parts;
    for (const double d : degrees)
        parts.push_back(grid_mesh(
            {.n = n, .m = std::max<std::size_t>(2, n / 12), .u = Closing::closed, .grading = 0, .seed = seed},
            [=](double u, double v) {
                const double r = 1 + 0.5 * v * std::cos(d * pi / 180);
                return Vec<3>{{r * std::cos(2 * pi * u), r * std::sin(2 * pi * u), 0.5 * v * std::sin(d * pi / 180)}};
            }));
    return welded(parts);
}
std::vector<Line> lines_at(const std::vector<double>& degrees) {
    std::vector<Line> lines;
    for (const double d : degrees) lines.push_back({1, 0, d});
    return lines;
}

/// The largest distances of nodes: of edges at a vertex, and of all.
struct NodesOff {
    double at_vertex = 0, all = 0;
};
NodesOff nodes_off(const Built<3>& b, const Off& off, VertexId v) {
    NodesOff found;
    for (std::size_t e = 0; e < b.nodes.size(); ++e) {
        const auto& ends = b.mesh.edges.vertices[e];
        const double d = off(b.nodes[e].point);
        found.all = std::fmax(found.all, d);
        if (ends[0] == v || ends[1] == v) found.at_vertex = std::fmax(found.at_vertex, d);
    }
    return found;
}

constexpr double slope_50 = 1.19175;  // the tangent of 50 degrees

}  // namespace

TEST_CASE("the tip of a cone is a corner without a normal, and its edges are straight") {
    const VertexId tip(std::size_t{0});
    for (const unsigned seed : {1U, 2U, 3U}) {
        const auto b = build(pointed(6, slope_50, 1, seed).mesh());
        CHECK(b.features.vertex_kinds[tip] == VertexKind::corner);
        CHECK(b.features.corners == 1);
        CHECK(b.features.patch_count == 1);
        const auto off = off_turned({{0, slope_50, -50}});
        const auto e = errors(b, off);
        const auto nodes = nodes_off(b, off, tip);
        MESSAGE("nodes at the tip " << nodes.at_vertex << ", all " << nodes.all << "; P3 " << e.surrogate << ", P2 "
                                    << e.quadratic << ", straight " << e.straight);
        CHECK(nodes.at_vertex < 0.015 / 6);
        CHECK(e.surrogate < e.straight / 4);
        CHECK(e.quadratic < e.straight / 2);  // a quadratic triangle is no cone
    }
}

TEST_CASE("a tip is found whichever way facets are turned, and however large it is") {
    auto soup = transformed_soup(pointed(3, slope_50), [](const Vec<3>& p) { return 0x1p-40 * rotated(p); });
    for (std::size_t f = 0; f < soup.facets.size(); f += 3) std::swap(soup.facets[f][0], soup.facets[f][1]);
    CHECK(build(soup.mesh()).features.vertex_kinds[VertexId(std::size_t{0})] == VertexKind::corner);
}

TEST_CASE("no tip: a blunt cone, a coarse sphere, a saddle") {
    for (const double slope : {0.0, 0.3, 0.8})
        CHECK(build(pointed(4, slope).mesh()).features.vertex_kinds[VertexId(std::size_t{0})] == VertexKind::surface);
    for (const std::size_t n : {6, 8}) CHECK(build(sphere(n, 1).mesh()).features.corners == 0);
    const auto saddle = transformed_soup(pointed(4, 0), [](Vec<3> p) {
        p[2] = 0.5 * (p[0] * p[0] - p[1] * p[1]);
        return p;
    });
    CHECK(build(saddle.mesh()).features.vertex_kinds[VertexId(std::size_t{0})] == VertexKind::surface);
}

TEST_CASE("a blunt tip that the file lists as a corner has no normal either") {
    const VertexId tip(std::size_t{0});
    const double slope = std::tan(30 * pi / 180);
    const auto off = off_turned({{0, slope, -30}});
    auto mesh = pointed(6, slope).mesh();
    const auto smooth = nodes_off(build(mesh), off, tip);
    mesh.corners = Buffer<VertexId>{tip};
    const auto listed = nodes_off(build(mesh), off, tip);
    MESSAGE("nodes at the tip: smooth " << smooth.at_vertex << ", listed " << listed.at_vertex);
    CHECK(listed.at_vertex < smooth.at_vertex / 5);
}

TEST_CASE("a corner that the file lists on a smooth surface costs no order") {
    auto mesh = sphere(8, 1).mesh();
    const auto off = off_surface(Sphere<3>{{}, 1});
    const double alone = errors(build(mesh), off).edges;
    mesh.corners = Buffer<VertexId>{VertexId(std::size_t{0}), VertexId(std::size_t{40})};
    CHECK(errors(build(mesh), off).edges <= 1.01 * alone);
}

TEST_CASE("half a cone, as beside a plane of symmetry") {
    const VertexId tip(std::size_t{0});
    const auto b = build(pointed(6, slope_50, 0.5).mesh());
    const auto off = off_turned({{0, slope_50, -50}});
    const auto nodes = nodes_off(b, off, tip);
    MESSAGE("nodes at the tip " << nodes.at_vertex << ", all " << nodes.all);
    CHECK(nodes.at_vertex < 0.015 / 6);
    CHECK(errors(b, off).quadratic < 0.6 * errors(b, off).straight);
}

TEST_CASE("a knife edge is a ridge, and both sides are smooth up to it") {
    // 10 degrees between the sides, which are cones: the edge is a circle.
    const std::vector<double> degrees{175, 185};
    const auto measured = [&](std::size_t n) {
        const auto b = build(sheets(n, degrees).mesh());
        CHECK(b.features.patch_count == 2);
        CHECK(b.features.corners == 0);
        return errors(b, off_turned(lines_at(degrees)));
    };
    const auto coarse = measured(24), fine = measured(48);
    MESSAGE("nodes " << coarse.edges << " to " << fine.edges << ", P2 " << coarse.quadratic << " to "
                     << fine.quadratic);
    CHECK(fine.edges < coarse.edges / 10);
    CHECK(fine.quadratic < coarse.quadratic / 8);
}

TEST_CASE("an edge of three facets is a ridge: a curve of its own, and three smooth sides") {
    const std::vector<double> degrees{0, 120, 240};
    const auto measured = [&](std::size_t n) {
        const auto b = build(sheets(n, degrees).mesh());
        CHECK(b.features.patch_count == 3);
        double on_circle = 0;
        std::size_t ridges = 0;
        for (std::size_t e = 0; e < b.nodes.size(); ++e) {
            const auto& ends = b.mesh.edges.vertices[e];
            const auto is_on = [&](VertexId v) {
                const Vec<3>& p = b.mesh.linear.points[v];
                return std::fabs(p[2]) < 1e-12 && std::fabs(std::hypot(p[0], p[1]) - 1) < 1e-12;
            };
            if (!is_on(ends[0]) || !is_on(ends[1])) continue;
            CHECK(b.features.edge_kinds[e] == EdgeKind::ridge);
            ++ridges;
            on_circle = std::fmax(
                on_circle, std::hypot(std::hypot(b.nodes[e].point[0], b.nodes[e].point[1]) - 1, b.nodes[e].point[2]));
        }
        CHECK(ridges == n);
        return std::pair(on_circle, errors(b, off_turned(lines_at(degrees))));
    };
    const auto [coarse_circle, coarse] = measured(24);
    const auto [fine_circle, fine] = measured(48);
    MESSAGE("circle " << coarse_circle << " to " << fine_circle << ", P2 " << coarse.quadratic << " to "
                      << fine.quadratic);
    CHECK(coarse_circle < 1e-12);  // a circle's tangents are exact
    CHECK(fine_circle < 1e-12);
    CHECK(fine.edges < coarse.edges / 10);
    CHECK(fine.quadratic < coarse.quadratic / 8);
}

TEST_CASE("an open rim is a ridge: its nodes are on its curve, by tangents along it") {
    const auto rim = [](std::size_t n) {
        const auto b = build(tube(n, n / 4, 1).mesh());
        double largest = 0;
        for (std::size_t e = 0; e < b.nodes.size(); ++e) {
            if (b.features.edge_kinds[e] != EdgeKind::ridge) continue;
            const Vec<3>& p = b.nodes[e].point;
            const double off_plane = std::fmin(std::fabs(p[2]), std::fabs(p[2] - 1));
            largest = std::fmax(largest, std::hypot(std::hypot(p[0], p[1]) - 1, off_plane));
        }
        return largest;
    };
    CHECK(rim(48) < std::fmax(rim(24) / 10, 1e-14));
}

TEST_CASE("rows of facets along a ridge are in one plane on a cylinder as well: it is curved up to the ridge") {
    // A wall of half a cylinder in a lattice without anything at random.
    for (const std::size_t n : {std::size_t{24}, std::size_t{48}}) {
        const Grid grid{.n = n, .m = n / 2, .jitter = 0, .grading = 0};
        const auto wall =
            grid_mesh(grid, [](double u, double v) { return Vec<3>{{std::cos(pi * u), std::sin(pi * u), 2 * v}}; });
        const auto e = errors(build(wall.mesh()), off_surface(Cylinder{{}, {{0, 0, 1}}, 1}));
        CAPTURE(n);
        CHECK(e.edges < (n == 24 ? 0.04 : 0.01) * e.straight);
        CHECK(e.surrogate < (n == 24 ? 0.04 : 0.01) * e.straight);
    }
}
