// Degenerate input does not crash, does not hang and gives finite nodes.
#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <vector>
#include <rapidcheck.h>

#include "meshes.hpp"
#include "property.hpp"

using namespace surface_tests;

namespace {

template <int D>
bool is_finite_result(const Built<D>& b) {
    for (const auto& node : b.nodes)
        if (!is_finite(node.point)) return false;
    for (const auto& facet : b.surrogate.facets)
        for (const auto& c : facet.control)
            if (!is_finite(c)) return false;
    const auto d = distance_of(b);
    return std::isfinite(d.largest) && std::isfinite(d.mean);
}

Soup<3> fan(std::size_t n, double height) {
    Soup<3> soup;
    soup.points.push_back({{0, 0, height}});
    for (std::size_t i = 0; i < n; ++i) {
        const double a = 2 * pi * static_cast<double>(i) / static_cast<double>(n);
        soup.points.push_back({{std::cos(a), std::sin(a), 0}});
        soup.facets.push_back({0, i + 1, (i + 1) % n + 1});
    }
    return soup;
}

}  // namespace

TEST_CASE("an empty mesh has an empty surrogate") {
    CHECK(is_finite_result(build(Soup<3>{}.mesh())));
    CHECK(is_finite_result(build(Soup<2>{}.mesh())));
    const auto empty = build(Soup<3>{}.mesh());
    CHECK(distance_of(empty).largest == 0);
    CHECK_FALSE(project<3>(Geometry<3>(empty.surrogate), {}, Vec<3>{{1, 2, 3}}).facet.valid());
}

TEST_CASE("single triangles, fans and isolated edges have finite surrogates") {
    const auto three_facets = build(fan(3, 0.3).mesh());
    CHECK(is_finite_result(three_facets));
    Soup<3> triangle{{{{0, 0, 0}}, {{1, 0, 0.5}}, {{0, 1, 0.2}}}, {{0, 1, 2}}, {}};
    const auto b = build(triangle.mesh());
    for (std::size_t e = 0; e < 3; ++e) CHECK(b.nodes[e] == b.mesh.mid_nodes[e]);
    for (const std::size_t n : {3, 4, 5, 7, 40, 200})
        for (const double height : {0.0, 0.1, 0.5, 3.0}) CHECK(is_finite_result(build(fan(n, height).mesh())));

    CHECK(is_finite_result(build(polygon({{{0, 0}}, {{1, 0}}}, Closing::open).mesh())));
    CHECK(is_finite_result(build(polygon({{{0, 0}}, {{1, 0}}, {{1.9, 0.3}}}, Closing::open).mesh())));
    CHECK(is_finite_result(build(polygon({{{0, 0}}, {{1, 0}}, {{0.5, 0.9}}}).mesh())));

    auto edge_only = Soup<3>{{{{0, 0, 0}}, {{1, 0, 0}}}, {}, {}}.mesh();
    edge_only.edges.vertices = Buffer<SimplexVertices<1>>{{VertexId(std::size_t{0}), VertexId(std::size_t{1})}};
    edge_only.edges.references = Buffer<Reference>{1};
    const auto e = build(edge_only);
    CHECK(is_finite_result(e));
    CHECK(e.features.ridge_edges == 0);
}

TEST_CASE("coincident points, flat triangles and repeated facets have finite surrogates") {
    Soup<3> flat{{{{0, 0, 0}}, {{1, 0, 0}}, {{2, 0, 0}}, {{1, 1, 0}}, {{1, 1, 0}}},
                 {{0, 1, 2}, {0, 1, 3}, {1, 2, 4}, {1, 3, 4}},
                 {}};
    CHECK(is_finite_result(build(flat.mesh())));
    auto twice = sphere(3, 1);
    twice.facets.push_back(twice.facets[0]);
    twice.references.push_back(1);
    CHECK(is_finite_result(build(twice.mesh())));
    auto pinched = polygon({{{0, 0}}, {{1, 0}}, {{1, 0}}, {{0, 1}}});
    CHECK(is_finite_result(build(pinched.mesh())));
}

TEST_CASE("a Möbius strip has a finite surrogate") {
    const std::size_t n = 24;
    Soup<3> soup;
    for (std::size_t i = 0; i < n; ++i) {
        const double a = 2 * pi * static_cast<double>(i) / n;
        for (const double s : {-0.3, 0.3})
            soup.points.push_back({{(1 + s * std::cos(a / 2)) * std::cos(a), (1 + s * std::cos(a / 2)) * std::sin(a),
                                    s * std::sin(a / 2)}});
    }
    for (std::size_t i = 0; i < n; ++i) {
        const std::size_t a = 2 * i, b = 2 * i + 1;
        const std::size_t c = i + 1 == n ? 1 : a + 2, d = i + 1 == n ? 0 : b + 2;
        soup.facets.push_back({a, c, b});
        soup.facets.push_back({b, c, d});
    }
    CHECK(is_finite_result(build(soup.mesh())));
}

TEST_CASE("random triangles have finite surrogates") {
    camber::testing::property(
        "random triangles on random points have finite surrogates",
        [] {
            const auto points = static_cast<std::size_t>(*rc::gen::inRange(3, 12));
            Soup<3> soup;
            for (std::size_t i = 0; i < points; ++i)
                soup.points.push_back(
                    {{*rc::gen::inRange(-3, 4) / 3.0, *rc::gen::inRange(-3, 4) / 3.0, *rc::gen::inRange(-3, 4) / 3.0}});
            const auto facets = *rc::gen::inRange(1, 20);
            for (int f = 0; f < facets; ++f) {
                const auto a = *rc::gen::inRange<std::size_t>(0, points), b = *rc::gen::inRange<std::size_t>(0, points),
                           c = *rc::gen::inRange<std::size_t>(0, points);
                if (a != b && b != c && a != c) soup.facets.push_back({a, b, c});
            }
            RC_ASSERT(is_finite_result(build(soup.mesh())));
        },
        {.count = 200});
}

TEST_CASE("edges, features and nodes of another mesh are rejected") {
    const Execution execution{.threads = 1};
    const auto a = build(sphere(2, 1).mesh()), b = build(sphere(3, 1).mesh());
    CHECK_FALSE(find_features(a.mesh.linear, b.mesh.edges, FeatureOptions<3>{}, execution).has_value());
    CHECK_FALSE(build_surrogate(a.mesh.linear, a.mesh.edges, b.features, {}, execution).has_value());
    CHECK_FALSE(boundary_nodes(a.mesh, b.features, Geometry<3>(b.surrogate), execution).has_value());
    CHECK_FALSE(boundary_distance<3>(a.mesh, b.nodes, a.features, Geometry<3>(a.surrogate), execution).has_value());
}
