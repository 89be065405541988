// The geometry interface: an implementation of the test, and the properties of all implementations.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>
#include <rapidcheck.h>

#include "meshes.hpp"
#include "property.hpp"

using namespace surface_tests;

namespace {

const Execution one_thread{.threads = 1};

struct Ellipsoid {
    Vec<3> centre, axes;
};

/// The closest point q of p, with p − q = λ ∇f(q)/2, f = Σ (q_i/a_i)² − 1, by Newton's method in λ.
SurfaceFoot<3> foot_of(const Ellipsoid& e, const Vec<3>& p) {
    const Vec<3> d = p - e.centre;
    double lambda = 0;
    const auto at = [&](int i) { return e.axes[i] * d[i] / (e.axes[i] * e.axes[i] + lambda); };
    for (int step = 0; step < 60; ++step) {
        double f = -1, slope = 0;
        for (int i = 0; i < 3; ++i) {
            f += at(i) * at(i);
            slope -= 2 * at(i) * at(i) / (e.axes[i] * e.axes[i] + lambda);
        }
        if (std::fabs(f) < 1e-16) break;
        lambda -= f / slope;
    }
    Vec<3> q, n;
    for (int i = 0; i < 3; ++i) {
        q[i] = e.axes[i] * at(i);
        n[i] = at(i) / e.axes[i];
    }
    return {e.centre + q, normalised(n)};
}

/// Ellipsoids by reference 1, 2 …: an implementation of the required functions and of `prescribes` only.
class Ellipsoids final : public GeometryModel<3> {
  public:
    explicit Ellipsoids(std::vector<Ellipsoid> all) : all_(std::move(all)) {}

    [[nodiscard]] SurfacePoint<3> project(const SurfaceHint& hint, const Vec<3>& p) const override {
        const GeometryEntity entity = hint.entity.kind == GeometryKind::surface ? hint.entity
                                      : hint.reference                          ? of(*hint.reference)
                                                                                : GeometryEntity{};
        if (entity.kind == GeometryKind::none) return {.point = p, .normal = {}};
        const auto foot = foot_of(all_[static_cast<std::size_t>(entity.id) - 1], p);
        return {.point = foot.point, .normal = foot.normal, .distance = distance(foot.point, p), .entity = entity};
    }
    [[nodiscard]] GeometryEntity surface_at(const FacetSite<3>& facet) const override { return of(facet.reference); }
    [[nodiscard]] bool prescribes(Reference reference) const override {
        return of(reference).kind != GeometryKind::none;
    }
    [[nodiscard]] bool prescribes_any() const override { return true; }

  private:
    [[nodiscard]] GeometryEntity of(Reference reference) const {
        const bool known = reference >= 1 && static_cast<std::size_t>(reference) <= all_.size();
        return known ? GeometryEntity::surface(reference) : GeometryEntity{};
    }
    std::vector<Ellipsoid> all_;
};

/// A lens between two caps, open at both poles. The lower cap of reference 1 and the upper cap of reference 2 meet at a
/// rim that lies in no plane. It has n facets around.
struct Lens {
    Ellipsoid lower{{{0, 0, 0.4}}, {{1.8, 1.6, 0.8}}};
    Ellipsoid upper{{{0, 0, -0.5}}, {{2, 1.5, 1}}};

    [[nodiscard]] static double height(const Ellipsoid& e, double x, double y, double side) {
        const double rest = 1 - x * x / (e.axes[0] * e.axes[0]) - y * y / (e.axes[1] * e.axes[1]);
        return e.centre[2] + side * e.axes[2] * std::sqrt(std::fmax(rest, 0));
    }
    [[nodiscard]] double rim(double angle) const {
        double inner = 0, outer = 1.8;
        for (int step = 0; step < 60; ++step) {
            const double r = 0.5 * (inner + outer), x = r * std::cos(angle), y = r * std::sin(angle);
            (height(upper, x, y, 1) > height(lower, x, y, -1) ? inner : outer) = r;
        }
        return inner;
    }
    [[nodiscard]] Soup<3> soup(std::size_t n) const {
        const Grid grid{.n = n, .m = 2 * (n / 3), .u = Closing::closed, .jitter = 0, .grading = 0};
        auto soup = grid_mesh(grid, [*this](double u, double v) -> Vec<3> {
            const double angle = 2 * pi * u + 0.2 * std::sin(2 * pi * u);
            const double r = rim(angle) * (v <= 0.5 ? 0.3 + 1.4 * v : 1 - 1.4 * (v - 0.5));
            const double x = r * std::cos(angle), y = r * std::sin(angle);
            return {{x, y, v <= 0.5 ? height(lower, x, y, -1) : height(upper, x, y, 1)}};
        });
        for (std::size_t f = 0; f < soup.facets.size(); ++f) soup.references[f] = f < soup.facets.size() / 2 ? 1 : 2;
        return soup;
    }
    [[nodiscard]] double off(Reference reference, const Vec<3>& p) const {
        return distance(foot_of(reference == 1 ? lower : upper, p).point, p);
    }
};

/// The edges of a mesh as arguments of a geometry.
std::vector<EdgeSite<3>> edges_of(const Built<3>& b) {
    const auto around = facet_shells(b.mesh.edges, one_thread).value();
    std::vector<EdgeSite<3>> sites;
    for (std::size_t e = 0; e < b.mesh.edges.size(); ++e) {
        const auto& [low, high] = b.mesh.edges.vertices[e];
        sites.push_back({EdgeId(e),
                         b.features.edge_kinds[e],
                         {b.mesh.linear.points[low], b.mesh.linear.points[high]},
                         facet_sites<3>(b.mesh.linear, around[e])});
    }
    return sites;
}

Buffer<LagrangeNode<3>> nodes_on(const Built<3>& b, const Geometry<3>& geometry) {
    return boundary_nodes(b.mesh, b.features, geometry, one_thread).value();
}

/// The largest value of `off` at the nodes of facets of a reference.
template <class Off>
double largest_off(const Built<3>& b, const Buffer<LagrangeNode<3>>& nodes, Reference reference, const Off& off) {
    double largest = 0;
    for (std::size_t f = 0; f < b.mesh.linear.facets.size(); ++f)
        if (b.mesh.linear.facets.references[f] == reference)
            for (const EdgeId e : b.mesh.edges.of_facets[f]) largest = std::fmax(largest, off(nodes[e.index()].point));
    return largest;
}

/// Checks that projection is idempotent and agrees with projection onto the entity and with evaluation.
void check_projection(const Geometry<3>& geometry, const SurfaceHint& hint, const Vec<3>& p, double tolerance) {
    const auto once = project<3>(geometry, hint, p);
    RC_ASSERT(once.entity.kind == GeometryKind::surface);
    RC_ASSERT(std::fabs(distance(once.point, p) - once.distance) < tolerance);
    const auto twice = project<3>(geometry, hint, once.point);
    RC_ASSERT(distance(twice.point, once.point) < tolerance);
    RC_ASSERT(twice.entity == once.entity);
    const auto of_entity = project<3>(geometry, {.entity = once.entity}, p);
    RC_ASSERT(of_entity.entity == once.entity);
    RC_ASSERT(of_entity.distance < once.distance + tolerance);
    if (!once.parameters) return;
    const auto there = geometry->evaluate(once.entity, *once.parameters);
    RC_ASSERT(there.has_value());
    RC_ASSERT(distance(there->point, once.point) < tolerance);
    RC_ASSERT(distance(there->normal, once.normal) < 1e-7);
    for (const Vec<3>& tangent : there->tangents)
        RC_ASSERT(std::fabs(dot(tangent, there->normal)) <= 1e-9 * norm(tangent));
}

Vec<3> point_near(const Vec<3>& p, double size) {
    Vec<3> q = p;
    for (std::size_t i = 0; i < 3; ++i) q[i] += size * *rc::gen::inRange(-1000, 1001) / 1000.0;
    return q;
}

}  // namespace

TEST_CASE("a custom geometry puts nodes on its surfaces and ridges on their intersections") {
    const Lens lens;
    const Geometry<3> geometry = Ellipsoids({lens.lower, lens.upper});
    std::vector<double> largest;
    for (const std::size_t n : {std::size_t{12}, std::size_t{24}}) {
        const auto b = build(lens.soup(n).mesh());
        const auto nodes = nodes_on(b, geometry);
        std::size_t on_both = 0;
        for (const Reference reference : {1, 2})
            CHECK(largest_off(b, nodes, reference, [&](const Vec<3>& p) { return lens.off(reference, p); }) < 1e-13);
        for (std::size_t e = 0; e < nodes.size(); ++e)
            on_both += lens.off(1, nodes[e].point) + lens.off(2, nodes[e].point) < 1e-13;
        CHECK(on_both == n);
        const auto curved = boundary_distance<3>(b.mesh, nodes, b.features, geometry, one_thread).value();
        const auto straight =
            boundary_distance<3>(b.mesh, b.mesh.mid_nodes.view(), b.features, geometry, one_thread).value();
        CHECK(curved.largest < 0.1 * straight.largest);
        largest.push_back(curved.largest);
    }
    CHECK(std::log2(largest[0] / largest[1]) > 2.5);  // P2: O(h³)
}

TEST_CASE("a custom geometry is combined with a surrogate by reference") {
    const Lens lens;
    const auto b = build(lens.soup(24).mesh());
    const Geometry<3> own = Ellipsoids({lens.lower, lens.upper});
    const auto on_own = nodes_on(b, own);

    // If both are prescribed, the ridge is on both in either order.
    for (const Reference first : {1, 2}) {
        const Geometry<3> both = MixedGeometry<3>{{first}, own, own};
        const auto nodes = nodes_on(b, both);
        for (std::size_t e = 0; e < nodes.size(); ++e) CHECK(distance(nodes[e].point, on_own[e].point) < 1e-13);
        CHECK(both->prescribes(1));
        CHECK(both->prescribes(2));
    }
    // The surrogate is not prescribed: the ridge lies on the ellipsoid only.
    const Geometry<3> mixed = MixedGeometry<3>{{1}, own, b.surrogate};
    const auto nodes = nodes_on(b, mixed);
    CHECK(largest_off(b, nodes, 1, [&](const Vec<3>& p) { return lens.off(1, p); }) < 1e-13);
    CHECK(largest_off(b, nodes, 2, [&](const Vec<3>& p) { return lens.off(2, p); }) < 1e-3);
    for (const EdgeSite<3>& edge : edges_of(b)) {
        const bool on_rest = edge.facets[0].reference == 2 && edge.facets.back().reference == 2;
        if (on_rest) CHECK(nodes[edge.id.index()] == b.nodes[edge.id.index()]);
        const auto entity = mixed->entity_at_edge(edge);
        for (const auto& facet : edge.facets) CHECK(entity.lies_on(mixed->surface_at(facet)));
    }
    CHECK(mixed->prescribes(1));
    CHECK_FALSE(mixed->prescribes(2));
}

TEST_CASE("projection is idempotent and agrees with evaluation and entities") {
    const Lens lens;
    const auto b = build(lens.soup(12).mesh());
    const Geometry<3> own = Ellipsoids({lens.lower, lens.upper});
    const Geometry<3> surrogate = b.surrogate;
    const Geometry<3> mixed = MixedGeometry<3>{{1}, own, surrogate};
    camber::testing::property("projection onto ellipsoids, a surrogate and mixed geometry is idempotent", [&] {
        const auto f = FacetId(*rc::gen::inRange<std::size_t>(0, b.mesh.linear.facets.size()));
        const auto facet = facet_site(b.mesh.linear, f);
        const Vec<3> p = point_near((facet.corners[0] + facet.corners[1] + facet.corners[2]) / 3, 0.02);
        for (const Geometry<3>& geometry : {own, surrogate, mixed}) {
            check_projection(geometry, {.reference = facet.reference}, p, 1e-7);
            RC_ASSERT(project<3>(geometry, {.reference = facet.reference}, p).entity == geometry->surface_at(facet));
        }
    });
    const AnalyticGeometry<3> surfaces{{{1, Plane<3>{{{1, 2, 3}}, {{1, -2, 0.5}}}},
                                        {2, Sphere<3>{{{0.1, 0, 0}}, 2}},
                                        {3, Cylinder{{{0, 0.2, 0}}, {{1, 1, 3}}, 0.5}},
                                        {4, Torus{{{0, 0, 0.3}}, {{0.2, -1, 1}}, 1, 0.25}}}};
    const Geometry<3> analytic = surfaces;
    camber::testing::property("projection onto analytic surfaces is idempotent", [&] {
        const Vec<3> p = point_near({{0.3, 0.4, 0.5}}, 1);
        for (const Reference reference : {1, 2, 3, 4}) check_projection(analytic, {.reference = reference}, p, 1e-12);
    });
    CHECK_FALSE(own->evaluate(GeometryEntity::surface(1), {}).has_value());
    CHECK_FALSE(analytic->evaluate(GeometryEntity::surface(9), {}).has_value());
}

TEST_CASE("are_within agrees with the distances of the points") {
    const Lens lens;
    const auto b = build(lens.soup(12).mesh());
    const Geometry<3> own = Ellipsoids({lens.lower, lens.upper});
    const Geometry<3> surrogate = b.surrogate;
    const Geometry<3> mixed = MixedGeometry<3>{{1}, own, surrogate};
    const Geometry<3> analytic =
        AnalyticGeometry<3>{{{1, Sphere<3>{{{0, 0, 0.2}}, 1.1}}, {2, Plane<3>{{}, {{0, 0, 1}}}}}};
    std::size_t within = 0, beyond = 0;
    camber::testing::property("are_within accepts the exact distances and rejects smaller ones", [&] {
        auto facet = facet_site(b.mesh.linear, FacetId(*rc::gen::inRange<std::size_t>(0, b.mesh.linear.facets.size())));
        facet.id = {};
        std::vector<Vec<3>> points(facet.corners.begin(), facet.corners.end());
        for (Vec<3>& p : points) p = point_near(p, 0.02);
        for (const Geometry<3>& geometry : {own, surrogate, mixed, analytic}) {
            std::vector<double> distances(points.size());
            RC_ASSERT(geometry->distances(facet, {}, points, distances));
            std::vector<double> bounds = distances;
            for (double& bound : bounds) bound = 1.001 * bound + 1e-12;
            RC_ASSERT(geometry->are_within(facet, points, bounds));
            ++within;
            const auto far = static_cast<std::size_t>(*rc::gen::inRange(0, 3));
            if (distances[far] < 1e-6) continue;
            bounds[far] = 0.99 * distances[far];
            RC_ASSERT(!geometry->are_within(facet, points, bounds));
            ++beyond;
        }
    });
    CHECK(within > 40);
    CHECK(beyond > 40);
    for (const Geometry<3>& geometry : {surrogate, analytic})  // without a facet there is no surface
        CHECK(geometry->are_within({{}, 9, {}}, std::vector<Vec<3>>{{{9, 9, 9}}}, std::vector<double>{0}));
}

TEST_CASE("points on a ridge lie on the surfaces of both sides") {
    const Lens lens;
    const auto b = build(lens.soup(12).mesh());
    const Geometry<3> own = Ellipsoids({lens.lower, lens.upper});
    const Geometry<3> surrogate = b.surrogate;
    std::size_t ridges = 0;
    for (const EdgeSite<3>& edge : edges_of(b)) {
        if (edge.facets.size() != 2 || edge.facets[0].reference == edge.facets[1].reference) continue;
        ++ridges;
        const Vec<3> p = edge.ends[0] + 0.3 * (edge.ends[1] - edge.ends[0]);
        for (const auto& [geometry, tolerance] : {std::pair{own, 1e-13}, std::pair{surrogate, 1e-12}}) {
            const auto there = geometry->on_edge(edge, p);
            CHECK(there.entity.kind == GeometryKind::curve);
            CHECK(there.entity == geometry->entity_at_edge(edge));
            CHECK(distance(geometry->on_edge(edge, there.point).point, there.point) < 1e-9);
            for (const auto& facet : edge.facets) {
                CHECK(there.entity.lies_on(geometry->surface_at(facet)));
                CHECK(project<3>(geometry, {.reference = facet.reference}, there.point).distance < tolerance);
            }
            if (!there.parameters) continue;
            const auto again = geometry->evaluate(there.entity, *there.parameters);
            REQUIRE(again.has_value());
            CHECK(distance(again->point, there.point) < 1e-13);
        }
        // An edge without an id is given by its ends and facets.
        const EdgeSite<3> unnumbered{{}, edge.kind, edge.ends, edge.facets};
        CHECK(own->on_edge(unnumbered, p).point == own->on_edge(edge, p).point);
    }
    CHECK(ridges == 12);
    const auto around = facet_balls(b.mesh.linear, one_thread).value();
    for (std::size_t v = 0; v < b.mesh.linear.points.size(); ++v) {
        const auto facets = facet_sites<3>(b.mesh.linear, around[v]);
        const auto entity = own->entity_at_vertex(facets);
        for (const auto& facet : facets) CHECK(entity.lies_on(own->surface_at(facet)));
    }
}
