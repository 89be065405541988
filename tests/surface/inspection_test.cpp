// Inspection of boundaries of known shapes.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>
#include <rapidcheck.h>

#include "meshes.hpp"
#include "property.hpp"

using namespace surface_tests;

namespace {

const Execution one_thread{.threads = 1};

template <int D>
struct Inspected {
    Features<D> features;
    BoundaryInspection<D> found;

    [[nodiscard]] std::size_t count(GeometryWarning what) const {
        return static_cast<std::size_t>(std::count_if(found.located_warnings.begin(), found.located_warnings.end(),
                                                      [&](const auto& s) { return s.what == what; }));
    }
};

template <int D>
Inspected<D> inspected(const LinearMesh<D>& mesh, const InspectionLimits& limits = {}) {
    const auto edges = unique_edges(mesh, one_thread).value();
    auto features =
        find_features(mesh, edges, FeatureOptions<D>{.ridge_angle_degrees = limits.ridge_angle}, one_thread).value();
    auto found = inspect_boundary(mesh, edges, features, limits, one_thread).value();
    return {std::move(features), std::move(found)};
}

/// Two triangles that share the edge from (0,0,0) to (1,0,0) at this angle.
Soup<3> hinge(double degrees) {
    const double a = degrees * pi / 180;
    return {{{{0, 0, 0}}, {{1, 0, 0}}, {{0.5, -1, 0}}, {{0.5, std::cos(a), std::sin(a)}}}, {{0, 2, 1}, {0, 1, 3}}, {}};
}

/// A cone without its base: the tip at height h above a circle of radius 1.
Soup<3> cone(std::size_t n, double h) {
    Soup<3> soup{{{{0, 0, h}}}, {}, {}};
    for (std::size_t i = 0; i < n; ++i) {
        const double a = 2 * pi * static_cast<double>(i) / static_cast<double>(n);
        soup.points.push_back({{std::cos(a), std::sin(a), 0}});
        soup.facets.push_back({0, 1 + i, 1 + (i + 1) % n});
    }
    return soup;
}

}  // namespace

TEST_CASE("inspection of a cube finds its patches, ridges and corners and no suspect") {
    const auto mesh = cube(4).mesh();
    const auto [features, found] = inspected(mesh);
    CHECK(found.patches.size() == 6);
    CHECK(found.curves.size() == 12);
    CHECK(found.corners.size() == 8);
    for (const PatchFacts& patch : found.patches) {
        CHECK(patch.is_flat);
        CHECK(patch.area == doctest::Approx(1));
        CHECK(patch.size == doctest::Approx(std::sqrt(2)));
        CHECK(patch.facets == 32);
    }
    for (const CurveFacts& curve : found.curves) {
        CHECK(curve.length == doctest::Approx(1));
        CHECK(curve.min_turn == doctest::Approx(90));
        CHECK(curve.largest_turn == doctest::Approx(90));
        CHECK(curve.edges == 4);
    }
    CHECK(found.located_warnings.empty());
    CHECK(found.open.empty());
    CHECK(found.crowded.empty());
}

TEST_CASE("hinge angles do not depend on the orientation of the facets") {
    camber::testing::property("the reported angle of a hinge is that of its construction", [] {
        const double degrees = *rc::gen::inRange(0, 180001) / 1000.0;
        Soup<3> soup = transformed_soup(hinge(degrees), rotated);
        const bool turned = *rc::gen::arbitrary<bool>();
        if (turned) std::swap(soup.facets[0][0], soup.facets[0][1]);
        const auto mesh = soup.mesh();
        const auto [features, found] = inspected(mesh, {.ridge_angle = 180, .near = 0});
        RC_ASSERT(found.turned.size() == (turned ? 1U : 0U));
        RC_ASSERT(!found.located_warnings.empty());
        double reported_degrees = -1;
        for (const auto& s : found.located_warnings)
            if (s.what == GeometryWarning::near_ridge || s.what == GeometryWarning::knife_edge ||
                s.what == GeometryWarning::mild_ridge)
                reported_degrees = s.degrees;
        RC_ASSERT(std::fabs(reported_degrees - degrees) < 1e-6);
        RC_ASSERT(found.open.size() == 4);
    });
}

TEST_CASE("hinges are classified by their angle") {
    const auto kind = [](double degrees) {
        const auto result = inspected(hinge(degrees).mesh());
        return std::array{result.count(GeometryWarning::near_ridge), result.count(GeometryWarning::mild_ridge),
                          result.count(GeometryWarning::knife_edge)};
    };
    CHECK(kind(29) == std::array<std::size_t, 3>{0, 0, 0});
    CHECK(kind(31) == std::array<std::size_t, 3>{1, 0, 0});
    CHECK(kind(100) == std::array<std::size_t, 3>{0, 0, 0});
    CHECK(kind(149) == std::array<std::size_t, 3>{0, 0, 0});
    CHECK(kind(151) == std::array<std::size_t, 3>{0, 0, 1});
}

TEST_CASE("inspection reports the tip of a steep cone only") {
    const auto result = inspected(cone(24, 2).mesh());
    REQUIRE(result.count(GeometryWarning::tip) == 1);
    CHECK(result.count(GeometryWarning::spread_normals) == 0);
    const auto tip = std::find_if(result.found.located_warnings.begin(), result.found.located_warnings.end(),
                                  [](const auto& s) { return s.what == GeometryWarning::tip; });
    CHECK(tip->vertices == std::vector<VertexId>{VertexId(0)});
    CHECK(tip->facets.size() == 24);
    CHECK(distance(tip->point, Vec<3>{{0, 0, 2}}) == 0);
    CHECK(tip->degrees == doctest::Approx(std::atan2(2, 1) * 180 / pi).epsilon(0.01));
    CHECK(inspected(cone(24, 0.3).mesh()).count(GeometryWarning::tip) == 0);
    // A sphere has no tip.
    CHECK(inspected(sphere(4, 1).mesh()).count(GeometryWarning::tip) == 0);
}

TEST_CASE("inspection counts open and crowded edges") {
    Soup<3> three{{{{0, 0, 0}}, {{1, 0, 0}}, {{0.5, 1, 0}}, {{0.5, -1, 0.1}}, {{0.5, 0, 1}}},
                  {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}},
                  {}};
    const auto [features, found] = inspected(three.mesh());
    CHECK(found.crowded.size() == 1);
    CHECK(found.open.size() == 6);
    CHECK(found.interface_facets == 0);
}

TEST_CASE("inspection counts interface facets") {
    // Two tetrahedra with a facet between them.
    LinearMesh<3> two =
        Soup<3>{{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}, {{0, 0, -1}}}, {{0, 1, 2}}, {}}.mesh();
    const auto v = [](std::size_t i) { return VertexId(i); };
    two.elements = {
        Buffer<SimplexVertices<3>>{{v(0), v(1), v(2), v(3)}, {v(0), v(2), v(1), v(4)}}, Buffer<Reference>{1, 2}, {}};
    const auto between = inspected(two);
    CHECK(between.found.interface_facets == 1);
    CHECK(between.found.patches[0].interface_facets == 1);
    CHECK(between.found.isolated_facets == 0);
}

TEST_CASE("in 2D inspection takes vertices as hinges") {
    const auto corner = [](double degrees) {
        const double a = degrees * pi / 180;
        Soup<2> soup = polygon({{{-1, 0}}, {{0, 0}}, {{std::cos(a), std::sin(a)}}}, Closing::open);
        return inspected(soup.mesh());
    };
    CHECK(corner(0).found.located_warnings.empty());
    const auto near = corner(35);
    REQUIRE(near.count(GeometryWarning::near_ridge) == 1);
    CHECK(near.found.located_warnings[0].degrees == doctest::Approx(35));
    CHECK(near.found.located_warnings[0].vertices == std::vector<VertexId>{VertexId(1)});
    CHECK(near.found.open.size() == 2);
    CHECK(near.found.patches.size() == 1);
    CHECK(near.found.patches[0].area == doctest::Approx(2));
    CHECK(corner(170).count(GeometryWarning::knife_edge) == 1);
}

TEST_CASE("inspection rejects features of another mesh") {
    const auto a = sphere(2, 1).mesh(), b = sphere(3, 1).mesh();
    const auto edges = unique_edges(a, one_thread).value();
    const auto others = find_features(b, unique_edges(b, one_thread).value(), FeatureOptions<3>{}, one_thread).value();
    CHECK(!inspect_boundary(a, edges, others, {}, one_thread));
}
