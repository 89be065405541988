// Detection of ridges, corners, patches and curves.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
#include <rapidcheck.h>

#include "meshes.hpp"
#include "property.hpp"

using namespace surface_tests;

namespace {

template <int D>
Features<D> features_of(const LinearMesh<D>& mesh, const FeatureOptions<D>& options = {}) {
    const Execution execution{.threads = 1};
    const auto edges = unique_edges(mesh, execution).value();
    return find_features(mesh, edges, options, execution).value();
}

template <int D>
std::size_t count(const Features<D>& features, VertexKind kind) {
    return static_cast<std::size_t>(std::count(features.vertex_kinds.begin(), features.vertex_kinds.end(), kind));
}

Soup<3> regular_solid(const std::vector<Vec<3>>& points, double edge) {
    Soup<3> soup;
    soup.points = points;
    const auto near = [&](std::size_t i, std::size_t j) { return distance(points[i], points[j]) < 1.01 * edge; };
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t j = i + 1; j < points.size(); ++j)
            for (std::size_t k = j + 1; k < points.size(); ++k)
                if (near(i, j) && near(j, k) && near(i, k)) soup.facets.push_back({i, j, k});
    return soup;
}

Soup<3> icosahedron() {
    const double g = (1 + std::sqrt(5.0)) / 2;
    std::vector<Vec<3>> points;
    for (const double a : {-1.0, 1.0})
        for (const double b : {-g, g}) {
            points.push_back({{0, a, b}});
            points.push_back({{a, b, 0}});
            points.push_back({{b, 0, a}});
        }
    return regular_solid(points, 2);
}

/// Returns the mesh with the chosen edges listed.
template <class Chosen>
LinearMesh<3> with_listed_edges(LinearMesh<3> mesh, const EdgeSet<3>& edges, Chosen&& chosen) {
    Buffer<SimplexVertices<1>> listed;
    for (std::size_t e = 0; e < edges.size(); ++e)
        if (chosen(e)) listed.push_back(edges.vertices[e]);
    mesh.edges.references = Buffer<Reference>(listed.size(), 7);
    mesh.edges.vertices = std::move(listed);
    return mesh;
}

/// True for the edges at which two facets meet at more than the default ridge angle.
std::vector<bool> folded_edges(const LinearMesh<3>& mesh, const EdgeSet<3>& edges) {
    const auto shells = facet_shells(edges, {.threads = 1}).value();
    const auto normal = [&](FacetId f) {
        const auto& [a, b, c] = mesh.facets.vertices[f];
        return normalised(cross(mesh.points[b] - mesh.points[a], mesh.points[c] - mesh.points[a]));
    };
    std::vector<bool> folded(edges.size());
    for (std::size_t e = 0; e < edges.size(); ++e)
        folded[e] = shells[e].size() == 2 && dot(normal(shells[e][0]), normal(shells[e][1])) <
                                                 std::cos(FeatureOptions<3>{}.ridge_angle_degrees * pi / 180);
    return folded;
}

}  // namespace

TEST_CASE("a cube has six faces, twelve curves and eight corners") {
    const auto f = features_of(cube(4).mesh());
    CHECK(f.patch_count == 6);
    CHECK(f.curve_count == 12);
    CHECK(f.corners == 8);
    CHECK(f.ridge_edges == 12 * 4);
    CHECK(count(f, VertexKind::ridge) == 12 * 3);
    CHECK(count(f, VertexKind::surface) == 6 * 9);
}

TEST_CASE("features do not depend on the orientation of the triangles") {
    auto soup = cube(3);
    for (std::size_t i = 0; i < soup.facets.size(); i += 3) std::swap(soup.facets[i][0], soup.facets[i][1]);
    const auto f = features_of(soup.mesh());
    CHECK(f.patch_count == 6);
    CHECK(f.ridge_edges == 36);
}

TEST_CASE("a half cylinder has four faces and six curves") {
    const auto f = features_of(half_cylinder(16, 6).mesh());
    CHECK(f.patch_count == 4);
    CHECK(f.curve_count == 6);
    CHECK(f.corners == 4);
}

TEST_CASE("a closed smooth surface has no features") {
    const auto f = features_of(torus(24, 1, 0.4).mesh());
    CHECK(f.patch_count == 1);
    CHECK(f.ridge_edges == 0);
    CHECK(f.corners == 0);
    CHECK(count(f, VertexKind::surface) == f.vertex_kinds.size());
}

TEST_CASE("reference changes, listed ridges and open rims are ridges at any angle") {
    auto soup = grid_mesh({.n = 4, .m = 4}, [](double u, double v) { return Vec<3>{{u, v, 0}}; });
    const auto plain = features_of(soup.mesh());
    CHECK(plain.patch_count == 1);
    CHECK(plain.ridge_edges == 16);
    CHECK(plain.corners == 4);  // corners of the rim by its angles

    for (std::size_t i = 0; i < 16; ++i) soup.references[i] = 2;
    const auto coloured = features_of(soup.mesh());
    CHECK(coloured.patch_count == 2);
    CHECK(coloured.ridge_edges == 20);
    CHECK(coloured.corners == 6);  // the ridge between both references meets the rim twice

    auto mesh = grid_mesh({.n = 4, .m = 4}, [](double u, double v) { return Vec<3>{{u, v, 0}}; }).mesh();
    const auto& t = mesh.facets.vertices[15];
    const auto inner = [&](VertexId v) { return plain.vertex_kinds[v] == VertexKind::surface; };
    for (std::size_t i = 0; i < 3; ++i)
        if (inner(t[i]) && inner(t[(i + 1) % 3])) {
            mesh.edges.vertices = Buffer<SimplexVertices<1>>{{t[i], t[(i + 1) % 3]}};
            mesh.edges.references = Buffer<Reference>{7};
            CHECK(features_of(mesh) == plain);
            mesh.ridges = Buffer<std::uint32_t>{0};
            const auto listed = features_of(mesh);
            CHECK(listed.ridge_edges == 17);
            CHECK(listed.patch_count == 1);  // both sides are connected around its ends
            CHECK(listed.corners == 6);
            break;
        }
}

// Guards against smooth listed edges that become ridges, with errors up to 13 times larger.
TEST_CASE("a listed edge on a smooth surface is no ridge and keeps its node") {
    camber::testing::property(
        "listed edges on a smooth surface change no feature",
        [] {
            const auto seed = static_cast<unsigned>(*rc::gen::inRange(1, 1000));
            const auto soup = seed % 2 == 0 ? sphere(9, 1, seed) : half_cylinder(8, 4, seed);
            const auto plain = build(soup.mesh());
            // At thin triangles the surface may fold by more than the ridge angle. Listed edges are ridges there.
            const auto folded = folded_edges(plain.mesh.linear, plain.mesh.edges);
            const auto some = with_listed_edges(soup.mesh(), plain.mesh.edges,
                                                [&](std::size_t e) { return e % 3 == seed % 3 && !folded[e]; });
            const auto b = build(some);
            RC_ASSERT(b.mesh.linear.edges == some.edges);
            RC_ASSERT(b.features == plain.features);
            // Edges beside ridges are bent within the surface, listed ones are not.
            for (std::size_t e = 0; e < b.nodes.size(); ++e) {
                const auto& [v, w] = b.mesh.edges.vertices[e];
                const auto& points = b.mesh.linear.points;
                // The largest ratio is 0.0271 (of all 999 seeds), next to the rims of the half cylinder.
                RC_ASSERT(distance(b.nodes[e].point, plain.nodes[e].point) <= 0.03 * distance(points[v], points[w]));
            }
        },
        {.count = 10});
}

TEST_CASE("a listed edge makes a mild fold a ridge") {
    const auto soup = icosahedron();  // folds of 41.8°
    const auto edges = unique_edges(soup.mesh(), {.threads = 1}).value();
    CHECK(features_of(soup.mesh()).ridge_edges == 0);
    CHECK(features_of(with_listed_edges(soup.mesh(), edges, [](std::size_t) { return true; })).ridge_edges == 30);
}

TEST_CASE("three facets on an edge make it a ridge") {
    Soup<3> soup;
    soup.points = {{{0, 0, 0}}, {{1, 0, 0}}, {{0.5, 1, 0}}, {{0.5, -1, 0}}, {{0.5, 0, 1}}};
    soup.facets = {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}};
    const auto f = features_of(soup.mesh());
    CHECK(f.surface_edges == 0);
    CHECK(f.patch_count == 3);
}

TEST_CASE("folds of an icosahedron are smooth, folds of an octahedron are ridges") {
    const auto round = features_of(icosahedron().mesh());  // folds of 41.8°
    CHECK(round.ridge_edges == 0);
    const auto sharp = features_of(
        regular_solid({{{1, 0, 0}}, {{-1, 0, 0}}, {{0, 1, 0}}, {{0, -1, 0}}, {{0, 0, 1}}, {{0, 0, -1}}}, std::sqrt(2.0))
            .mesh());  // 70.5°
    CHECK(sharp.ridge_edges == 12);
    CHECK(sharp.patch_count == 8);
}

TEST_CASE("a single fold is a ridge only if it is sharp") {
    // A hipped roof over a stadium: one ridge of length 1 between two half cones, with the same slope on all sides.
    const auto roof = [](double degrees) {
        Soup<3> soup;
        soup.points = {{{0, 0, std::tan(degrees * pi / 180)}}, {{1, 0, std::tan(degrees * pi / 180)}}};
        for (const std::size_t end : {0, 1})
            for (std::size_t k = 0; k <= 4; ++k) {
                const double a = pi / 2 + (end == 0 ? pi : -pi) * static_cast<double>(k) / 4;
                soup.points.push_back({{static_cast<double>(end) + std::cos(a), std::sin(a), 0}});
                if (k > 0) soup.facets.push_back({end, 1 + 5 * end + k, 2 + 5 * end + k});
            }
        for (const std::size_t side : {2, 6}) {
            soup.facets.push_back({0, 1, side + 5});
            soup.facets.push_back({0, side + 5, side});
        }
        return features_of(soup.mesh());
    };
    const std::size_t rim = 10;
    CHECK(roof(23).ridge_edges == rim);  // a fold of 46°
    CHECK(roof(33).ridge_edges == rim + 1);
}

TEST_CASE("a wall vertex that another surface touches is the only new corner") {
    const auto wall = grid_mesh({.n = 4, .m = 4}, [](double u, double v) { return Vec<3>{{u, v, 0}}; });
    const auto plain = features_of(wall.mesh());
    std::size_t middle = 0;
    for (std::size_t v = 0; v < wall.points.size(); ++v)
        if (norm(wall.points[v] - Vec<3>{{0.5, 0.5, 0}}) < norm(wall.points[middle] - Vec<3>{{0.5, 0.5, 0}}))
            middle = v;
    REQUIRE(plain.vertex_kinds[VertexId(middle)] == VertexKind::surface);
    const Vec<3> at = wall.points[middle];
    const auto expect_corner = [&](const Soup<3>& with) {
        const auto f = features_of(with.mesh());
        CHECK(f.vertex_kinds[VertexId(middle)] == VertexKind::corner);
        for (std::size_t v = 0; v < wall.points.size(); ++v)
            if (v != middle) CHECK(f.vertex_kinds[VertexId(v)] == plain.vertex_kinds[VertexId(v)]);
    };
    const std::size_t next = wall.points.size();
    SUBCASE("the tip of a baffle") {
        for (const double degrees : {10.0, 40.0, 70.0, 85.0, 89.0}) {  // half of its angle
            CAPTURE(degrees);
            Soup<3> with = wall;
            const double x = 0.1 * std::sin(degrees * pi / 180), z = 0.1 * std::cos(degrees * pi / 180);
            with.points.insert(with.points.end(),
                               {at + Vec<3>{{x, 0, z}}, at + Vec<3>{{0, 0, 0.3}}, at + Vec<3>{{-x, 0, z}}});
            with.facets.push_back({middle, next, next + 1});
            with.facets.push_back({middle, next + 1, next + 2});
            expect_corner(with);
        }
    }
    SUBCASE("the middle of a baffle") {
        Soup<3> with = wall;
        constexpr std::size_t around = 12;
        for (std::size_t k = 0; k < around; ++k) {
            const double a = 2 * pi * static_cast<double>(k) / around;
            with.points.push_back(at + Vec<3>{{0.1 * std::cos(a), 0.1 * std::sin(a), 0.02}});
            with.facets.push_back({middle, next + k, next + (k + 1) % around});
        }
        expect_corner(with);
    }
    SUBCASE("a closed surface") {
        Soup<3> with = wall;
        const Soup<3> ball = sphere(6, 0.3);
        const auto low = static_cast<std::size_t>(
            std::ranges::min_element(ball.points, {}, [](const Vec<3>& p) { return p[2]; }) - ball.points.begin());
        for (const Vec<3>& p : ball.points) with.points.push_back(at + p - ball.points[low]);
        for (auto facet : ball.facets) {
            for (std::size_t& v : facet) v = v == low ? middle : next + v;
            with.facets.push_back(facet);
        }
        expect_corner(with);
        // The normals of both surfaces are unchanged: neither has a tip.
        const auto single = build(wall.mesh());
        const auto both = build(with.mesh());
        for (std::size_t e = 0; e < single.mesh.edges.size(); ++e) {
            const auto& [a, b] = single.mesh.edges.vertices[e];
            CHECK(both.nodes[find_edge(both.mesh.edges, a, b).index()] == single.nodes[e]);
        }
    }
}

TEST_CASE("a vertex where the rim of a baffle leaves a wall is a corner at any slope") {
    for (const double rise : {0.001, 0.1, 0.3}) {
        CAPTURE(rise);
        auto soup = grid_mesh({.n = 4, .m = 4, .jitter = 0}, [](double u, double v) { return Vec<3>{{u, v, 0}}; });
        const auto vertex_at = [&](const Vec<3>& p) {
            return static_cast<std::size_t>(
                std::ranges::min_element(soup.points, {}, [&](const Vec<3>& q) { return norm(p - q); }) -
                soup.points.begin());
        };
        // The baffle is on the wall from x = 0.25 to 0.5; its rim continues to x = 0.75.
        const std::size_t from = vertex_at({{0.25, 0.5, 0}}), to = vertex_at({{0.5, 0.5, 0}}), top = soup.points.size();
        soup.points.push_back({{0.75, 0.5, 0.25 * rise}});
        soup.points.push_back({{0.25, 0.5, 0.5}});
        soup.facets.push_back({from, to, top + 1});
        soup.facets.push_back({to, top, top + 1});
        CHECK(features_of(soup.mesh()).vertex_kinds[VertexId(to)] == VertexKind::corner);
    }
}

TEST_CASE("corners of the file split curves") {
    auto mesh = tube(24, 4, 1).mesh();
    CHECK(features_of(mesh).curve_count == 2);
    CHECK(features_of(mesh).corners == 0);
    mesh.corners = Buffer<VertexId>{VertexId(std::size_t{0}), VertexId(std::size_t{12})};
    const auto f = features_of(mesh);
    CHECK(f.curve_count == 3);
    CHECK(f.corners == 2);
}

TEST_CASE("2D corners follow from angles, references, the file and branching") {
    std::vector<Vec<2>> square;
    for (int side = 0; side < 4; ++side)
        for (int i = 0; i < 4; ++i) {
            const double s = i / 4.0;
            square.push_back(side == 0   ? Vec<2>{{s, 0}}
                             : side == 1 ? Vec<2>{{1, s}}
                             : side == 2 ? Vec<2>{{1 - s, 1}}
                                         : Vec<2>{{0, 1 - s}});
        }
    auto soup = polygon(square);
    const auto f = features_of(soup.mesh());
    CHECK(f.surface_edges == 16);
    CHECK(f.ridge_edges == 0);
    CHECK(f.corners == 4);
    CHECK(f.patch_count == 4);
    CHECK(f.curve_count == 4);

    soup.references.assign(16, 1);
    soup.references[0] = soup.references[1] = 2;
    CHECK(features_of(soup.mesh()).corners == 5);

    auto listed = polygon(square).mesh();
    listed.corners = Buffer<VertexId>{VertexId(std::size_t{2})};
    CHECK(features_of(listed).corners == 5);

    auto branching = polygon(square);
    branching.points.push_back({{0.5, 0.5}});
    branching.facets.push_back({2, 16});
    CHECK(features_of(branching.mesh()).corners == 6);  // the branching and the free end
}
