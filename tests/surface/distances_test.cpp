// Distances in both directions and by entity, compared with brute force and known surfaces.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>
#include <rapidcheck.h>

#include "meshes.hpp"
#include "property.hpp"
#include "sanitized.hpp"

using namespace surface_tests;

namespace {

const Execution one_thread{.threads = 1};

Geometry<3> spheres(double radius) { return Geometry<3>(AnalyticGeometry<3>{{{Reference{1}, Sphere<3>{{}, radius}}}}); }

GeometryDistances<3> measured(const Built<3>& b, const Geometry<3>& geometry, const Execution& execution = one_thread) {
    const auto samples = sample_over_mesh(b.mesh, b.features, geometry, execution).value();
    return two_sided_distances<3>(b.mesh, b.nodes, b.features, geometry, samples, execution).value();
}

/// Minimum distance from p to a lattice of 24 intervals on each facet.
double brute_force(const Built<3>& b, const Vec<3>& p) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t f = 0; f < b.mesh.linear.facets.size(); ++f) {
        const auto shape = bezier_form<2, 3>(b.mesh.linear.points, b.nodes, b.mesh.linear.facets.vertices[f],
                                             b.mesh.edges.of_facets[f]);
        for (const auto& alpha : multi_indices<24, 2>)
            least = std::fmin(least, distance(p, shape.point({alpha[0] / 24.0, alpha[1] / 24.0, alpha[2] / 24.0})));
    }
    return least;
}

}  // namespace

TEST_CASE("the nearest point of a curved boundary is found from any start facet") {
    camber::testing::property(
        "the nearest point is on its facet, minimal, and the same from any start facet",
        [] {
            const auto seed = static_cast<unsigned>(*rc::gen::inRange(1, 1000));
            Built<3> b = build<3>(sphere(2, 1, seed).mesh());
            Random random(seed);
            for (auto& node : b.nodes) node.point += 0.05 * Vec<3>{{random(-1, 1), random(-1, 1), random(-1, 1)}};
            const auto boundary = curved_boundary<3>(b.mesh, b.nodes, one_thread).value();
            const Vec<3> p{{random(-1.5, 1.5), random(-1.5, 1.5), random(-1.5, 1.5)}};
            const auto foot = closest_on(boundary, p);
            RC_ASSERT(foot.facet.valid());
            const auto shape =
                bezier_form<2, 3>(b.mesh.linear.points, b.nodes, b.mesh.linear.facets.vertices[foot.facet],
                                  b.mesh.edges.of_facets[foot.facet]);
            RC_ASSERT(distance(shape.point(foot.xi), foot.point) < 1e-13);
            RC_ASSERT(std::fabs(distance(foot.point, p) - std::sqrt(foot.distance_squared)) < 1e-13);
            const double least = std::sqrt(foot.distance_squared), sampled = brute_force(b, p);
            RC_ASSERT(least <= sampled * (1 + 1e-12));
            RC_ASSERT(sampled - least < 0.02);  // the spacing of the lattice
            const FacetId other(
                static_cast<std::size_t>(*rc::gen::inRange(0, static_cast<int>(b.features.patches.size()))));
            RC_ASSERT(closest_on(boundary, p, other).distance_squared == foot.distance_squared);
        },
        {.count = 60});
}

TEST_CASE("distances between a sphere and its mesh are consistent in both directions") {
    for (const std::size_t n : {2, 4}) {
        const double radius = 2;
        const Built<3> b = build<3>(sphere(n, radius).mesh());
        const Geometry<3> geometry = spheres(radius);
        const auto found = measured(b, geometry);
        REQUIRE(found.entities.size() == 1);
        const auto& all = found.entities[0];
        CHECK(all.pieces == b.mesh.linear.facets.size());
        CHECK(all.references == std::vector<Reference>{1});
        CHECK(!all.is_flat);
        CHECK(all.measure <= 4 * pi * radius * radius);
        // The value of boundary_distance.
        const auto one_way = boundary_distance<3>(b.mesh, b.nodes, b.features, geometry, one_thread).value();
        CHECK(found.to_geometry.largest == one_way.largest);
        CHECK(found.to_geometry.mean == doctest::Approx(one_way.mean).epsilon(1e-12));
        CHECK(found.to_geometry.facet == one_way.worst);
        CHECK(all.to_geometry.largest == one_way.largest);
        for (const auto& direction : {found.to_geometry, found.to_boundary}) {
            CHECK(std::fabs(distance(direction.from, direction.to) - direction.largest) < 1e-13);
            CHECK(direction.mean <= direction.largest);
        }
        CHECK(std::fabs(norm(found.to_boundary.from) - radius) < 1e-13);
        // The normals of both surfaces nearly agree, so both distances do.
        CHECK(found.to_boundary.largest < 1.02 * found.to_geometry.largest);
        CHECK(found.to_boundary.largest > 0.5 * found.to_geometry.largest);
        // Sampled points of the sphere, by brute force over the boundary.
        Random random(7);
        for (int i = 0; i < camber::testing::less_if_sanitized(60, 10); ++i) {
            const Vec<3> p = radius * normalised(Vec<3>{{random(-1, 1), random(-1, 1), random(-1, 1)}});
            const double spacing = 1.5 * radius / static_cast<double>(n) / 24;
            const double most = found.to_boundary.largest;
            CHECK(brute_force(b, p) <= 1.05 * most + spacing * spacing / (2 * most));
        }
    }
}

TEST_CASE("distance fields of facets agree with the maxima for any number of threads") {
    const Built<3> b = build<3>(sphere(3, 1).mesh());
    const auto found = measured(b, spheres(1));
    REQUIRE(found.of_facets.size() == b.mesh.linear.facets.size());
    double of = 0, to = 0;
    for (std::size_t f = 0; f < found.of_facets.size(); ++f) {
        of = std::fmax(of, found.of_facets[f]);
        to = std::fmax(to, found.to_facets[f]);
    }
    CHECK(of == found.to_geometry.largest);
    CHECK(to == found.to_boundary.largest);
    CHECK(found.of_facets[found.to_geometry.facet] == found.to_geometry.largest);
    const auto again = measured(b, spheres(1), {.threads = 3});
    for (std::size_t f = 0; f < found.of_facets.size(); ++f) {
        CHECK(again.of_facets[f] == found.of_facets[f]);
        CHECK(again.to_facets[f] == found.to_facets[f]);
    }
    CHECK(again.to_boundary.mean == found.to_boundary.mean);
}

TEST_CASE("geometry that the boundary lacks appears only in the distance from the geometry") {
    const Built<3> b = build<3>(sphere(4, 1).mesh());
    // A point off the sphere stands for a model feature that is finer than the mesh.
    GeometrySamples<3> samples;
    samples.begin(GeometryEntity::surface(0));
    samples.add({{0, 0, 1.25}}, 1);
    samples.begin(GeometryEntity::surface(5));
    samples.add({{0, 0, -1.5}}, 1);
    const auto found = two_sided_distances<3>(b.mesh, b.nodes, b.features, spheres(1), samples, one_thread).value();
    CHECK(found.to_geometry.largest < 0.05);
    CHECK(found.to_boundary.largest == doctest::Approx(0.5).epsilon(0.05));
    REQUIRE(found.entities.size() == 2);
    CHECK(found.entities[0].to_boundary.largest == doctest::Approx(0.25).epsilon(0.1));
    CHECK(found.entities[1].entity == GeometryEntity::surface(5));
    CHECK(found.entities[1].pieces == 0);
    CHECK(found.entities[1].to_geometry.samples == 0);
    CHECK(found.entities[1].to_boundary.largest == doctest::Approx(0.5).epsilon(0.05));
}

TEST_CASE("distances are measured for each surface and curve of a surrogate") {
    const Built<3> b = build<3>(half_cylinder(16, 6).mesh());
    const Geometry<3> geometry(b.surrogate);
    const auto found = measured(b, geometry);
    std::size_t surfaces = 0, curves = 0, facets = 0, edges = 0;
    for (const auto& entity : found.entities) {
        const bool is_surface = entity.entity.kind == GeometryKind::surface;
        (is_surface ? surfaces : curves) += 1;
        (is_surface ? facets : edges) += entity.pieces;
        CHECK(entity.to_geometry.samples > 0);
        CHECK(entity.to_boundary.samples > 0);
        CHECK(entity.to_geometry.largest < 0.02);
        CHECK(entity.to_boundary.largest < 0.02);
        if (!entity.is_flat) continue;
        CHECK(entity.to_geometry.largest < 1e-12);
        CHECK(entity.to_boundary.largest < 1e-3);  // rims of degree 3 beside edges of degree 2
    }
    CHECK(surfaces == b.features.patch_count);
    CHECK(curves == b.features.curve_count);
    CHECK(facets == b.mesh.linear.facets.size());
    CHECK(edges == b.features.ridge_edges);
}

TEST_CASE("2D distances are measured to a circle and to straight geometry") {
    std::vector<Vec<2>> points;
    points.reserve(12);
    for (int i = 0; i < 12; ++i) points.push_back({{std::cos(2 * pi * i / 12), std::sin(2 * pi * i / 12)}});
    const Built<2> b = build<2>(polygon(points).mesh());
    const Geometry<2> circle(AnalyticGeometry<2>{{{Reference{1}, Sphere<2>{{}, 1}}}});
    const auto nodes = boundary_nodes(b.mesh, b.features, circle, one_thread).value();
    const auto samples = sample_over_mesh(b.mesh, b.features, circle, one_thread).value();
    const auto found = two_sided_distances<2>(b.mesh, nodes, b.features, circle, samples, one_thread).value();
    REQUIRE(found.entities.size() == 1);
    CHECK(found.to_geometry.largest > 0);
    CHECK(found.to_boundary.largest == doctest::Approx(found.to_geometry.largest).epsilon(0.2));
    const Geometry<2> straight{StraightGeometry<2>{}};
    const auto none = sample_over_mesh(b.mesh, b.features, straight, one_thread).value();
    CHECK(none.points.empty());
    const auto from_straight = two_sided_distances<2>(b.mesh, nodes, b.features, straight, none, one_thread).value();
    REQUIRE(from_straight.entities.size() == 1);
    CHECK(from_straight.entities[0].entity.kind == GeometryKind::none);
    CHECK(from_straight.to_geometry.largest == doctest::Approx(1 - std::cos(pi / 12)).epsilon(1e-9));
    CHECK(from_straight.to_boundary.samples == 0);
}

TEST_CASE("distances reject features and nodes of another mesh") {
    const Built<3> a = build<3>(sphere(2, 1).mesh()), b = build<3>(sphere(3, 1).mesh());
    const Geometry<3> geometry = spheres(1);
    CHECK(!sample_over_mesh(a.mesh, b.features, geometry, one_thread));
    CHECK(!two_sided_distances<3>(a.mesh, b.nodes, a.features, geometry, {}, one_thread));
    CHECK(!two_sided_distances<3>(a.mesh, a.nodes, b.features, geometry, {}, one_thread));
}

TEST_CASE("distances of an empty boundary are empty") {
    const Geometry<3> geometry = spheres(1);
    QuadraticMesh<3> empty;
    const auto result = two_sided_distances<3>(empty, {}, {}, geometry, {}, one_thread);
    REQUIRE(result);
    CHECK(result->entities.empty());
}

namespace {

/// A mesh whose vertices and nodes lie on the unit circle or sphere around the origin.
template <int D>
struct Exact {
    QuadraticMesh<D> mesh;
    Features<D> features;
    Geometry<D> geometry = AnalyticGeometry<D>{{{Reference{1}, Sphere<D>{{}, 1}}}};

    explicit Exact(const LinearMesh<D>& linear) : mesh(elevate<D>(linear, one_thread).value()) {
        features = find_features(linear, mesh.edges, FeatureOptions<D>{}, one_thread).value();
        mesh.mid_nodes = boundary_nodes(mesh, features, geometry, one_thread).value();
    }
    [[nodiscard]] double length(std::size_t e) const {
        const auto& [a, b] = mesh.edges.vertices[e];
        return distance(mesh.linear.points[a], mesh.linear.points[b]);
    }
    [[nodiscard]] BoundaryDeviation deviation(std::span<const LagrangeNode<D>> own_nodes = {}) const {
        return boundary_deviation<D>(mesh, features.edge_kinds.view(), geometry, own_nodes, {}, one_thread).value();
    }
};

LinearMesh<3> round_mesh(int n, unsigned seed, std::integral_constant<int, 3>) {
    return sphere(static_cast<std::size_t>(n), 1, seed).mesh();
}
LinearMesh<2> round_mesh(int n, unsigned seed, std::integral_constant<int, 2>) {
    Random random(seed);
    std::vector<Vec<2>> points;
    for (int i = 0; i < 4 * n; ++i) {
        const double angle = 2 * pi * (i + random(-0.3, 0.3)) / (4 * n);
        points.push_back({{std::cos(angle), std::sin(angle)}});
    }
    return polygon(points).mesh();
}

template <int D>
void check_deviations() {
    camber::testing::property(
        "deviations count exactly the moved nodes, by the distances of the moves",
        [] {
            const auto seed = static_cast<unsigned>(*rc::gen::inRange(1, 1000));
            Exact<D> exact(round_mesh(*rc::gen::inRange(2, 5), seed, std::integral_constant<int, D>{}));
            const BoundaryDeviation none = exact.deviation();
            RC_ASSERT(none.nodes.measured == exact.mesh.edges.size());
            RC_ASSERT(none.nodes.off + none.vertices.off == 0);
            RC_ASSERT(none.nodes.largest < 1e-12 && none.vertices.largest < 1e-12);
            Random random(seed);
            std::size_t off = 0;
            double share = 0;
            auto nodes = take(exact.mesh.mid_nodes);
            const auto original = nodes;
            for (std::size_t e = 0; e < nodes.size(); ++e) {
                const double by = std::pow(10, random(-7, -2));  // on both sides of the default tolerance
                if (random(0, 1) < 0.7) continue;
                nodes[e].point = (1 + by * exact.length(e)) * nodes[e].point;
                off += by > BoundaryTolerance{}.nodes ? 1 : 0;
                share = std::fmax(share, by);
            }
            exact.mesh.mid_nodes = std::move(nodes);
            const BoundaryDeviation found = exact.deviation();
            RC_ASSERT(found.nodes.off == off);
            RC_ASSERT(std::fabs(found.nodes.share - share) < 1e-9);
            RC_ASSERT(found.vertices.off == 0);
            // Nodes on prescribed surfaces count even if the input had nodes; other nodes are those of the input.
            RC_ASSERT(exact.deviation(original).nodes.off == off);
            exact.geometry = Geometry<D>(StraightGeometry<D>{});
            RC_ASSERT(exact.deviation(original).nodes.off == off);
        },
        {.count = 40});
}

}  // namespace

namespace {

/// Two disjoint copies of a mesh, with the facets in reverse order if `is_reversed`.
template <int D>
LinearMesh<D> two_of(LinearMesh<D> one, bool is_reversed) {
    const std::size_t n = one.points.size();
    auto points = take(std::move(one.points));
    auto vertices = take(std::move(one.facets.vertices));
    auto references = take(std::move(one.facets.references));
    for (std::size_t v = 0; v < n; ++v) points.push_back(points[v] + Vec<D>{{3, 1}});
    for (std::size_t f = 0, m = vertices.size(); f < m; ++f) {
        auto facet = vertices[f];
        for (VertexId& v : facet) v = VertexId(v.index() + n);
        vertices.push_back(facet);
        references.push_back(references[f]);
    }
    if (is_reversed) std::ranges::reverse(vertices);
    one.points = std::move(points);
    one.facets.vertices = std::move(vertices);
    one.facets.references = std::move(references);
    return one;
}

template <int D>
void check_facets_of_another_mesh() {
    const LinearMesh<D> one = round_mesh(4, 3, std::integral_constant<int, D>{});
    const Geometry<D> geometry(build<D>(two_of(one, false)).surrogate);
    const QuadraticMesh<D> other = elevate<D>(two_of(one, true), one_thread).value();
    const Column<EdgeKind> kinds(Buffer<EdgeKind>(other.edges.size(), EdgeKind::fixed));
    const auto found = boundary_deviation<D>(other, kinds.view(), geometry, {}, {}, one_thread).value();
    CHECK(found.vertices.measured == other.linear.points.size());
    CHECK(found.vertices.largest < 1e-12);
}

}  // namespace

TEST_CASE("boundary deviation of another mesh does not depend on its facet numbers") {
    check_facets_of_another_mesh<2>();
    check_facets_of_another_mesh<3>();
}

TEST_CASE("boundary deviation counts nodes off the geometry") {
    check_deviations<2>();
    check_deviations<3>();
}

TEST_CASE("boundary deviation counts vertices off the geometry and skips fixed nodes") {
    Exact<3> exact(round_mesh(3, 7, std::integral_constant<int, 3>{}));
    Buffer<EdgeKind> kinds(exact.features.edge_kinds.begin(), exact.features.edge_kinds.end());
    kinds[0] = EdgeKind::fixed;
    exact.features.edge_kinds = std::move(kinds);
    auto points = take(exact.mesh.linear.points);
    points[4] = 1.2 * points[4];    // by more than 5 % of the adjacent edges
    points[5] = 1.001 * points[5];  // by less
    exact.mesh.linear.points = std::move(points);
    const BoundaryDeviation found = exact.deviation();
    CHECK(found.nodes.measured == exact.mesh.edges.size() - 1);
    CHECK(found.vertices.off == 1);
    CHECK(found.vertices.worst == VertexId(4));
    CHECK(found.vertices.largest == doctest::Approx(0.2));
    CHECK(!boundary_deviation<3>(exact.mesh, {}, exact.geometry, {}, {}, one_thread));
}
