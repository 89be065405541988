// Whole walls: smooth walls do not cross themselves, and walls that bulge through each other are found.
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

#include "facets.hpp"
#include "property.hpp"
#include "walls.hpp"

import camber.core;
import camber.bezier;
import camber.shapes;
import camber.crossing;

using namespace camber;
using camber::testing::property;
using namespace camber::testing;

namespace {

Vec<3> on_torus(const Vec<3>& p) {
    const double r = std::hypot(p[0], p[1]);
    const Vec<3> ring{{2 * p[0] / r, 2 * p[1] / r, 0}};
    return ring + 0.7 * normalised(p - ring);
}

/// A lattice of n × m cells on the torus, with points moved by up to `jitter` cells.
QuadraticMesh<3> torus(std::size_t n, std::size_t m, double jitter, Engine& engine) {
    std::vector<Vec<3>> points;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < m; ++j) {
            const auto angle = [&](std::size_t k, std::size_t of) {
                return 2 * std::numbers::pi * (static_cast<double>(k) + uniform(engine, -jitter, jitter)) /
                       static_cast<double>(of);
            };
            const double u = angle(i, n), v = angle(j, m);
            const double r = 2 + 0.7 * std::cos(v);
            points.push_back({{r * std::cos(u), r * std::sin(u), 0.7 * std::sin(v)}});
        }
    std::vector<SimplexVertices<2>> facets;
    const auto at = [&](std::size_t i, std::size_t j) { return VertexId(i % n * m + j % m); };
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < m; ++j) {
            facets.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            facets.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return wall_of<3>(points, facets, on_torus);
}

/// Two concentric circles in one mesh, cut into n and m chords, with nodes on the circles.
QuadraticMesh<2> circles(std::size_t n, double inner, std::size_t m, double outer, double turn) {
    std::vector<Vec<2>> points;
    std::vector<SimplexVertices<1>> facets;
    const auto add = [&](std::size_t count, double r, double from) {
        const std::size_t first = points.size();
        for (std::size_t i = 0; i < count; ++i) {
            const double t = from + 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
            points.push_back({{r * std::cos(t), r * std::sin(t)}});
            facets.push_back({VertexId(first + i), VertexId(first + (i + 1) % count)});
        }
    };
    add(n, inner, 0);
    add(m, outer, turn);
    const double middle = (inner + outer) / 2;
    return wall_of<2>(points, facets, [=](const Vec<2>& p) {
        // The middle of a long outer chord is closer to the inner circle, so the limit is that of the outer chords.
        const bool of_outer = norm(p) > middle * std::cos(std::numbers::pi / static_cast<double>(m));
        return normalised(p) * (of_outer ? outer : inner);
    });
}

}  // namespace

TEST_CASE("smooth walls do not cross themselves") {
    property("the facets of a bent torus are disjoint",
             [] {
                 Engine engine(*rc::gen::arbitrary<std::uint64_t>());
                 const auto n = static_cast<std::size_t>(*rc::gen::inRange(8, 30));
                 const auto m = static_cast<std::size_t>(*rc::gen::inRange(8, 20));
                 const auto mesh = torus(n, m, 0.12, engine);
                 const Crossings found = crossings_of(mesh);
                 RC_ASSERT(found.pairs >= 6 * n * m);
                 RC_ASSERT(found.crossing == 0U);
                 RC_ASSERT(found.undecided == 0U);
             },
             {.count = 20});
    property("the facets of concentric circles are disjoint",
             [] {
                 const auto n = static_cast<std::size_t>(*rc::gen::inRange(5, 60));
                 const Crossings found = crossings_of(circles(n, 1, 2 * n, 2, 0.1));
                 RC_ASSERT(found.all_disjoint());
             },
             {.count = 20});
}

TEST_CASE("thin layers of long facets do not cross") {
    // The torus stretched by 1000: the facets are needles.
    Engine engine(1);
    auto mesh = torus(12, 10, 0.1, engine);
    CHECK(crossings_of(mesh).all_disjoint());
    const auto stretched = [](Vec<3> p) { return Vec<3>{{p[0], p[1], 1000 * p[2]}}; };
    Buffer<Vec<3>> points = take(std::move(mesh.linear.points));
    for (Vec<3>& p : points) p = stretched(p);
    mesh.linear.points = std::move(points);
    Buffer<LagrangeNode<3>> nodes = take(std::move(mesh.mid_nodes));
    for (auto& node : nodes) node.point = stretched(node.point);
    mesh.mid_nodes = std::move(nodes);
    const Crossings found = crossings_of(mesh);
    CHECK(found.crossing == 0);
    CHECK(found.undecided == 0);
}

TEST_CASE("walls that bulge through each other cross") {
    property("a node moved through the inner circle makes its facet cross that circle", [] {
        const std::size_t n = 8;
        // The outer chords reach down to outer · cos(π/n). One of their nodes is moved inside the inner circle.
        auto mesh = circles(n, 1, n, 1.2, 0.3);
        CHECK(crossings_of(mesh).all_disjoint());
        const auto k = static_cast<std::size_t>(*rc::gen::inRange(0, int(n)));
        const EdgeId edge = mesh.edges.of_facets[n + k][0];
        Buffer<LagrangeNode<2>> nodes = take(std::move(mesh.mid_nodes));
        nodes[edge.index()].point = nodes[edge.index()].point * (0.9 / 1.2);
        mesh.mid_nodes = std::move(nodes);
        const Crossings found = crossings_of(mesh);
        RC_ASSERT(found.crossing >= 1U);
        RC_ASSERT(found.undecided == 0U);
        for (const FacetCrossing& pair : found.found) {
            RC_ASSERT(pair.first.index() < n);
            RC_ASSERT(pair.second.index() == n + k);
        }
    });
    SUBCASE("two spheres cross although their straight facets are disjoint") {
        const UnitSphere<3> unit = icosphere<3>(1);
        const Vec<3> facing =
            normalised(unit.points[unit.facets[0][0].index()] + unit.points[unit.facets[0][1].index()] +
                       unit.points[unit.facets[0][2].index()]);
        const auto spheres = [&](double gap, bool curved) {
            // The second sphere is the mirror image of the first one in a plane across `facing` between the centres.
            const auto image = [&](const Vec<3>& p) { return p + (2 * (1 + gap / 2 - dot(p, facing))) * facing; };
            std::vector<Vec<3>> points(unit.points.begin(), unit.points.end());
            std::vector<SimplexVertices<2>> facets(unit.facets.begin(), unit.facets.end());
            const std::size_t n = points.size();
            for (std::size_t i = 0; i < n; ++i) points.push_back(image(points[i]));
            for (std::size_t f = 0; f < unit.facets.size(); ++f) {
                SimplexVertices<2> facet = unit.facets[f];
                for (VertexId& v : facet) v = VertexId(v.index() + n);
                facets.push_back(facet);
            }
            return wall_of<3>(points, facets, [&](const Vec<3>& p) {
                if (!curved) return p;
                return dot(p, facing) < 1 + gap / 2 ? normalised(p) : image(normalised(image(p)));
            });
        };
        CHECK(crossings_of(spheres(-0.1, false)).all_disjoint());
        CHECK(crossings_of(spheres(0.1, true)).all_disjoint());
        const Crossings found = crossings_of(spheres(-0.1, true));
        CHECK(found.crossing > 0);
        CHECK(found.undecided == 0);
        CHECK(found.found[0].first == FacetId(0));
        CHECK(found.found[0].second == FacetId(unit.facets.size()));
    }
}

TEST_CASE("find_crossings does not depend on the number of threads") {
    Engine engine(3);
    auto mesh = torus(20, 16, 0.3, engine);
    Buffer<LagrangeNode<3>> nodes = take(std::move(mesh.mid_nodes));
    for (std::size_t i = 0; i < nodes.size(); i += 7) nodes[i].point = nodes[i].point * 0.6;
    mesh.mid_nodes = std::move(nodes);
    const Crossings found = crossings_of(mesh);
    CHECK(found.crossing > 0);
    CHECK(crossings_of(mesh, 2) == found);
}
