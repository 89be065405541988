// Analytic surfaces on some references and the surrogate on the others.
#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>
#include <rapidcheck.h>

#include "meshes.hpp"
#include "property.hpp"

using namespace surface_tests;

namespace {

const Execution one_thread{.threads = 1};

template <int D>
Soup<D> referred(Soup<D> soup, Reference reference) {
    soup.references.assign(soup.facets.size(), reference);
    return soup;
}

template <int D>
Geometry<D> mixed(const Built<D>& b, AnalyticGeometry<D> analytic) {
    return with_surrogate<D>(std::move(analytic), b.mesh.linear,
                             [&](const auto&) { return Outcome<Surrogate<D>>(b.surrogate); })
        .value();
}

template <int D>
Buffer<LagrangeNode<D>> nodes_on(const Built<D>& b, const Geometry<D>& geometry) {
    return boundary_nodes(b.mesh, b.features, geometry, one_thread).value();
}

/// Returns the mesh with the facets of one reference only.
template <int D>
LinearMesh<D> part(const LinearMesh<D>& mesh, Reference reference) {
    Buffer<SimplexVertices<D - 1>> vertices;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        if (mesh.facets.references[f] == reference) vertices.push_back(mesh.facets.vertices[f]);
    LinearMesh<D> out = mesh;
    out.facets = {std::move(vertices), {}, {}};
    out.facets.references = Buffer<Reference>(out.facets.vertices.size(), reference);
    return out;
}

double largest_distance(const Built<3>& b, const Buffer<LagrangeNode<3>>& nodes, Reference reference, const Off& off) {
    double largest = 0;
    for (std::size_t f = 0; f < b.mesh.linear.facets.size(); ++f)
        if (b.mesh.linear.facets.references[f] == reference)
            for (const EdgeId e : b.mesh.edges.of_facets[f]) largest = std::fmax(largest, off(nodes[e.index()].point));
    return largest;
}

/// A can of radius 1 from z = 0 with n facets around. Its wall has reference 1. Its top of reference 2 is part of a
/// sphere whose centre is beside the axis, so the rim lies in no plane.
struct Can {
    static constexpr double beside = 0.5, radius = 2;
    const AnalyticSurface<3> wall = Cylinder{{}, {{0, 0, 1}}, 1};
    const AnalyticSurface<3> top = Sphere<3>{{{beside, 0, 0}}, radius};

    static Soup<3> soup(std::size_t n) {
        const Grid grid{.n = n, .m = 2 * (n / 2), .u = Closing::closed, .jitter = 0, .grading = 0};
        auto soup = grid_mesh(grid, [=](double u, double v) -> Vec<3> {
            const double angle = 2 * pi * u + 0.3 * std::sin(2 * pi * u);  // avoids symmetry
            const double r = v <= 0.5 ? 1 : 1 - 0.7 * (2 * v - 1);
            const double x = r * std::cos(angle), y = r * std::sin(angle);
            const double height = std::sqrt(radius * radius - (x - beside) * (x - beside) - y * y);
            return {{x, y, v <= 0.5 ? 2 * v * height : height}};
        });
        for (std::size_t f = 0; f < soup.facets.size(); ++f) soup.references[f] = f < soup.facets.size() / 2 ? 1 : 2;
        return soup;
    }
};

}  // namespace

// Guards against straight facets on references beside analytic ones.
TEST_CASE("prescribed surfaces on all references give the nodes without a surrogate") {
    const auto b = build(welded({referred(sphere(4, 5), 1), referred(sphere(4, 2, 7), 2)}).mesh());
    const AnalyticGeometry<3> both{{{1, Sphere<3>{{}, 5}}, {2, Sphere<3>{{}, 2}}}};
    const auto geometry = mixed(b, both);
    CHECK(geometry->prescribes(1));
    CHECK(geometry->prescribes(2));
    CHECK_FALSE(project<3>(geometry, {.facet = FacetId(std::size_t{0})}, Vec<3>{{1, 2, 3}}).facet.valid());
    CHECK(nodes_on(b, geometry) == nodes_on(b, Geometry<3>(both)));
    CHECK_FALSE(Geometry<3>(StraightGeometry<3>{})->prescribes_any());
    CHECK_FALSE(Geometry<3>(b.surrogate)->prescribes_any());
}

TEST_CASE("a shell takes nodes from one prescribed sphere and one surrogate sphere") {
    const auto b = build(welded({referred(sphere(6, 5), 1), referred(sphere(6, 2, 7), 2)}).mesh());
    const AnalyticGeometry<3> outer{{{1, Sphere<3>{{}, 5}}}};
    const auto geometry = mixed(b, outer);
    CHECK(geometry->prescribes(1));
    CHECK_FALSE(geometry->prescribes(2));
    const auto nodes = nodes_on(b, geometry), on_outer = nodes_on(b, Geometry<3>(outer));
    for (std::size_t f = 0; f < b.mesh.linear.facets.size(); ++f)
        for (const EdgeId e : b.mesh.edges.of_facets[f])
            CHECK(nodes[e.index()] ==
                  (b.mesh.linear.facets.references[f] == 1 ? on_outer[e.index()] : b.nodes[e.index()]));
    const auto off = off_surface(Sphere<3>{{}, 2});
    CHECK(largest_distance(b, nodes, 2, off) <
          0.01 * largest_distance(b, on_outer, 2, off));  // nodes of reference 2 are on
                                                          // straight edges there

    // Each part is measured from its own geometry.
    const auto within = [&](const Geometry<3>& g, std::span<const LagrangeNode<3>> n) {
        return boundary_distance<3>(b.mesh, n, b.features, g, one_thread).value();
    };
    const auto whole = within(geometry, nodes);
    const AnalyticGeometry<3> both{{{1, Sphere<3>{{}, 5}}, {2, Sphere<3>{{}, 2}}}};
    CHECK(whole.largest == doctest::Approx(within(Geometry<3>(both), nodes).largest).epsilon(0.2));
    const auto straight = within(geometry, b.mesh.mid_nodes.view());
    CHECK(straight.largest > 20 * whole.largest);
}

TEST_CASE("projection selects the surface by reference, by facet or by distance") {
    const auto b = build(welded({referred(sphere(6, 5), 1), referred(sphere(6, 2, 7), 2)}).mesh());
    const auto geometry = mixed<3>(b, {{{1, Sphere<3>{{}, 5}}}});
    camber::testing::property("a point is projected onto the surface of its reference, its facet or the nearest", [&] {
        Vec<3> p;
        for (std::size_t i = 0; i < 3; ++i) p[i] = *rc::gen::inRange(-1000, 1001) / 1000.0 + 0.0003;
        p = p * (*rc::gen::inRange(1500, 6000) / 1000.0 / norm(p));
        const auto f = FacetId(*rc::gen::inRange<std::size_t>(0, b.mesh.linear.facets.size()));
        const Reference reference = b.mesh.linear.facets.references[f];
        const auto on_reference = project<3>(geometry, {.reference = reference}, p);
        RC_ASSERT(std::fabs(norm(on_reference.point) - (reference == 1 ? 5 : 2)) < (reference == 1 ? 1e-14 : 1e-3));
        RC_ASSERT(on_reference.facet.valid() == (reference == 2));
        const auto near_facet = project<3>(geometry, {.facet = f}, p);
        RC_ASSERT(std::fabs(norm(near_facet.point) - (reference == 1 ? 5 : 2)) < (reference == 1 ? 1e-14 : 1e-3));
        const auto nearest = project<3>(geometry, {}, p);
        if (std::fabs(norm(p) - 3.5) > 0.1) RC_ASSERT((std::fabs(norm(nearest.point) - 5) < 1e-14) == (norm(p) > 3.5));
    });
}

TEST_CASE("a patch beside an analytic surface is fitted to its own facets only") {
    const auto b = build(Can::soup(12).mesh());
    const auto single = build(part(b.mesh.linear, 2));
    const std::size_t first = b.mesh.linear.facets.size() / 2;
    REQUIRE(single.mesh.linear.facets.size() == first);
    for (std::size_t f = 0; f < first; ++f) CHECK(b.surrogate.facets[first + f] == single.surrogate.facets[f]);
}

TEST_CASE("a ridge between an analytic surface and a curved patch lies on the analytic surface") {
    const Can can;
    const auto off_wall = off_surface(can.wall), off_top = off_surface(can.top);
    std::vector<double> off_rim;
    for (const std::size_t n : {std::size_t{12}, std::size_t{24}}) {
        const auto b = build(Can::soup(n).mesh());
        const auto nodes = nodes_on(b, mixed<3>(b, {{{1, can.wall}}}));
        double off = 0, straight = 0;
        std::size_t rim = 0;
        for (std::size_t e = 0; e < nodes.size(); ++e) {
            const auto& [low, high] = b.mesh.edges.vertices[e];
            const auto is_on_rim = [&](VertexId v) {
                return std::fmax(off_wall(b.mesh.linear.points[v]), off_top(b.mesh.linear.points[v])) < 1e-12;
            };
            if (b.features.edge_kinds[e] != EdgeKind::ridge || !is_on_rim(low) || !is_on_rim(high)) continue;
            ++rim;
            off = std::fmax(off, off_top(nodes[e].point));
            straight = std::fmax(straight, off_top(closest_point<3>(can.wall, b.mesh.mid_nodes[e].point).point));
        }
        CHECK(rim == n);
        CHECK(off < 0.1 * straight);
        CHECK(largest_distance(b, nodes, 1, off_wall) < 1e-15);
        CHECK(largest_distance(b, nodes, 2, off_top) <= std::fmax(off, largest_distance(b, b.nodes, 2, off_top)));
        off_rim.push_back(off);
    }
    CHECK(std::log2(off_rim[0] / off_rim[1]) > 3.5);
}

TEST_CASE("flat patches beside an analytic surface keep their planes") {
    for (const double slope : {0.0, 0.5}) {
        auto mesh = transformed_soup(half_cylinder(12, 5), [=](Vec<3> p) {
                        p[2] += slope * p[0];
                        return p;
                    }).mesh();
        const auto before = build(mesh);
        Buffer<Reference> references(mesh.facets.size());
        Reference wall = 0;
        for (std::size_t f = 0; f < references.size(); ++f) {
            references[f] = static_cast<Reference>(before.features.patches[f]) + 1;
            if (!before.surrogate.flats[before.features.patches[f]].is_flat()) wall = references[f];
        }
        mesh.facets.references = std::move(references);
        const auto b = build(mesh);
        const AnalyticGeometry<3> cylinder{{{wall, Cylinder{{}, {{0, 0, 1}}, 1}}}};
        const auto nodes = nodes_on(b, mixed(b, cylinder));
        for (std::size_t f = 0; f < mesh.facets.size(); ++f)
            for (const EdgeId e : b.mesh.edges.of_facets[f]) {
                const Vec<3> p = nodes[e.index()].point;
                const auto& flat = b.surrogate.flats[b.features.patches[f]];
                if (mesh.facets.references[f] == wall)
                    CHECK(std::fabs(std::hypot(p[0], p[1]) - 1) < 1e-14);
                else if (flat.axis >= 0)
                    CHECK(p[static_cast<std::size_t>(flat.axis)] == flat.point[static_cast<std::size_t>(flat.axis)]);
                else
                    CHECK(flat.height(p) == 0);
            }
    }
}

TEST_CASE("an annulus takes nodes from one prescribed circle and one surrogate circle") {
    const auto circle = [](std::size_t n, double radius, Reference reference) {
        std::vector<Vec<2>> points;
        for (std::size_t i = 0; i < n; ++i) {
            const double t = static_cast<double>(i) / static_cast<double>(n);
            const double angle = 2 * pi * t + 0.2 * std::sin(2 * pi * t);
            points.push_back({{radius * std::cos(angle), radius * std::sin(angle)}});
        }
        return referred(polygon(std::move(points)), reference);
    };
    auto soup = circle(16, 3, 1);
    const auto inner = circle(16, 1, 2);
    for (const auto& f : inner.facets) soup.facets.push_back({f[0] + soup.points.size(), f[1] + soup.points.size()});
    soup.points.insert(soup.points.end(), inner.points.begin(), inner.points.end());
    soup.references.insert(soup.references.end(), inner.references.begin(), inner.references.end());
    const auto b = build(soup.mesh());
    const auto geometry = mixed<2>(b, {{{1, Sphere<2>{{}, 3}}}});
    const auto nodes = nodes_on(b, geometry);
    for (std::size_t f = 0; f < b.mesh.linear.facets.size(); ++f) {
        const std::size_t e = b.mesh.edges.of_facets[f][0].index();
        if (b.mesh.linear.facets.references[f] == 1)
            CHECK(std::fabs(norm(nodes[e].point) - 3) < 1e-15);
        else
            CHECK(nodes[e] == b.nodes[e]);
    }
    const auto d = boundary_distance<2>(b.mesh, nodes, b.features, geometry, one_thread).value();
    const auto straight =
        boundary_distance<2>(b.mesh, b.mesh.mid_nodes.view(), b.features, geometry, one_thread).value();
    CHECK(d.largest < 0.02 * straight.largest);
    CHECK(project<2>(geometry, {.reference = 1}, Vec<2>{{0.5, 0}}).point == Vec<2>{{3, 0}});
    CHECK(std::fabs(norm(project<2>(geometry, {.reference = 2}, Vec<2>{{0.5, 0.1}}).point) - 1) < 1e-4);
    CHECK(std::fabs(norm(project<2>(geometry, {}, Vec<2>{{2.6, 0.1}}).point) - 3) < 1e-15);
}
