// Passes on standalone surfaces: flat surfaces are preserved, also at non-manifold edges, and curved ones stay on their
// geometry.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "domains.hpp"
#include "goals.hpp"
#include "property.hpp"

import camber.core;
import camber.metric;
import camber.shapes;
import camber.cavity;
import camber.surface;
import camber.operation;
import camber.adapt;

using namespace camber;
using namespace camber::testing;

namespace {

/// The facets and listed edges of a mesh, without its elements.
LinearMesh<3> surface_of(LinearMesh<3> mesh) {
    mesh.elements = {};
    return mesh;
}

Vec<3> area_vector(const LinearMesh<3>& mesh, const SimplexVertices<2>& f) {
    return 0.5 * cross(mesh.points[f[1]] - mesh.points[f[0]], mesh.points[f[2]] - mesh.points[f[0]]);
}

/// Areas by reference. A fold would increase them.
std::map<Reference, double> areas(const LinearMesh<3>& mesh) {
    std::map<Reference, double> sums;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        sums[mesh.facets.references[f]] += norm(area_vector(mesh, mesh.facets.vertices[f]));
    return sums;
}

/// Numbers of triangles of the edges that do not have two, keyed by the positions of their ends.
using Rims = std::map<std::array<Vec<3>, 2>, std::size_t, decltype([](const auto& a, const auto& b) {
                          return std::pair(a[0].c, a[1].c) < std::pair(b[0].c, b[1].c);
                      })>;
Rims rims(const LinearMesh<3>& mesh, std::size_t at_least) {
    const auto edges = must(unique_edges(mesh, one_thread));
    const auto around = must(facet_shells(edges, one_thread));
    Rims found;
    for (std::size_t e = 0; e < edges.size(); ++e) {
        std::array<Vec<3>, 2> ends{mesh.points[edges.vertices[e][0]], mesh.points[edges.vertices[e][1]]};
        if (ends[1].c < ends[0].c) std::swap(ends[0], ends[1]);
        if (around[e].size() != 2 && around[e].size() >= at_least) found[ends] = around[e].size();
    }
    return found;
}

LinearMesh<3> compact(const Adaptation<3>& r) { return must(compacted(r.mesh, one_thread)).mesh; }

void check_flat_surfaces(std::uint64_t seed) {
    Dice dice(seed);
    const LinearMesh<3> mesh = surface_of(random_domain<3>(seed));
    const AdaptationGoal<3> goal = goal_over(mesh, dice.uniform(0.3, 1.5), dice);
    Adaptation<3> r = start_adaptation(mesh, goal);
    RC_ASSERT(compact(r) == compact(start_adaptation(compact(r), goal)));
    const auto before = areas(mesh);
    const auto shared = rims(mesh, 3);
    const auto apply = [&](auto pass) {
        r = must(pass(std::move(r))).state;
        const auto consistent = check_consistency(r.mesh, one_thread);
        if (!consistent) RC_FAIL(describe(consistent.error()));
        const LinearMesh<3> result = compact(r);
        RC_ASSERT(result.elements.size() == 0U);
        const auto after = areas(result);
        RC_ASSERT(after.size() == before.size());
        for (const auto& [reference, area] : before) RC_ASSERT(std::abs(after.at(reference) - area) < 1e-8);
        RC_ASSERT(rims(result, 3) == shared);
    };
    for (int round = 0; round < 2; ++round) {
        apply([&](Adaptation<3> s) { return collapse<3>(std::move(s), goal, {}, one_thread); });
        apply([&](Adaptation<3> s) { return split<3>(std::move(s), goal, {}, one_thread); });
        apply([&](Adaptation<3> s) { return swap<3>(std::move(s), goal, {}, one_thread); });
        apply([&](Adaptation<3> s) { return smooth<3>(std::move(s), goal, {}, one_thread); });
    }
    apply([&](Adaptation<3> s) { return mend<3>(std::move(s), goal, {}, one_thread); });
}

/// The surface of a generated ball after remeshing to one size.
struct OnSphere {
    LinearMesh<3> mesh;
    ToMetricStatistics statistics;
};
template <class Keep>
LinearMesh<3> sphere_surface(Keep&& keep) {
    ShellOptions<3> options;
    options.inner_size = options.outer_size = 0.5;
    LinearMesh<3> mesh = surface_of(must(generate(options)));
    Buffer<SimplexVertices<2>> facets;
    for (const auto& f : mesh.facets.vertices) {
        const Vec<3> centre = (mesh.points[f[0]] + mesh.points[f[1]] + mesh.points[f[2]]) / 3;
        if (norm(centre) < 1.2 && keep(centre)) facets.push_back(f);
    }
    Buffer<Reference> references(facets.size(), 1);
    mesh.facets = {std::move(facets), std::move(references), {}, {}};
    return mesh;
}
OnSphere on_sphere(const LinearMesh<3>& mesh, double size, const Execution& execution = one_thread) {
    Buffer<LogMetric<3>> logs(mesh.points.size(), log_metric_of_sizes<3>({{size, size, size}}));
    const AdaptationGoal<3> goal{
        must(make_back_mesh(mesh, must(balls(mesh, one_thread)), Column<LogMetric<3>>(std::move(logs)), one_thread)),
        Geometry<3>(AnalyticGeometry<3>{{{1, Sphere<3>{{}, 1}}}})};
    auto [r, statistics] = must(remesh_to_metric<3>(start_adaptation(mesh, goal), goal, {}, execution));
    CHECK(check_consistency(r.mesh, one_thread).has_value());
    return {compact(r), statistics};
}
bool all_of(const Vec<3>&) { return true; }

/// The Euler characteristic V − E + F.
std::ptrdiff_t euler(const LinearMesh<3>& mesh) {
    std::set<std::uint32_t> used;
    for (const auto& f : mesh.facets.vertices)
        for (const VertexId v : f) used.insert(v.value);
    const auto edges = must(unique_edges(mesh, one_thread));
    return static_cast<std::ptrdiff_t>(used.size()) - static_cast<std::ptrdiff_t>(edges.size()) +
           static_cast<std::ptrdiff_t>(mesh.facets.size());
}

/// A constant metric of size 1, without a geometry.
AdaptationGoal<3> unit_goal(const LinearMesh<3>& mesh) {
    Buffer<LogMetric<3>> logs(mesh.points.size(), log_metric_of_sizes<3>({{1, 1, 1}}));
    return {
        must(make_back_mesh(mesh, must(balls(mesh, one_thread)), Column<LogMetric<3>>(std::move(logs)), one_thread)),
        {}};
}

}  // namespace

TEST_CASE("passes keep the area of each reference and the non-manifold edges of flat surfaces") {
    property("passes preserve areas, interfaces and baffles of random flat surfaces", check_flat_surfaces,
             {.count = 20});
}

TEST_CASE("a standalone sphere stays closed and on its geometry when refined or coarsened") {
    const LinearMesh<3> mesh = sphere_surface(all_of);
    CHECK(euler(mesh) == 2);
    for (const auto& [size, min_share, min_quality] : {std::array{0.2, 0.95, 0.4}, std::array{0.9, 0.5, 0.3}}) {
        const auto [result, statistics] = on_sphere(mesh, size);
        CHECK(euler(result) == 2);
        CHECK(rims(result, 1).empty());
        double volume = 0, farthest = 0;
        for (const auto& f : result.facets.vertices) volume += dot(area_vector(result, f), result.points[f[0]]) / 3;
        for (const auto& f : result.facets.vertices)
            for (const VertexId v : f) farthest = std::max(farthest, std::abs(norm(result.points[v]) - 1));
        CHECK(farthest < 1e-12);
        // 4π/3 is the volume of the ball. An inverted triangle would reduce it.
        CHECK(std::abs(std::abs(volume) - 4.18879) < 2.5 * size * size);
        CHECK(statistics.after.unit_share() > min_share);
        CHECK(statistics.after.worst_quality > min_quality);
    }
}

TEST_CASE("a standalone surface keeps its border curve") {
    const LinearMesh<3> mesh = sphere_surface([](const Vec<3>& c) { return c[2] > 0; });
    CHECK(euler(mesh) == 1);
    const auto [result, statistics] = on_sphere(mesh, 0.2);
    CHECK(euler(result) == 1);
    CHECK(statistics.after.unit_share() > 0.85);
    std::size_t borders = 0;
    for (const auto& [ends, triangles] : rims(result, 1)) borders += triangles == 1 ? 1 : 0;
    CHECK(borders > rims(mesh, 1).size());  // the input is coarser
}

TEST_CASE("remeshing a standalone surface does not depend on the number of threads") {
    const LinearMesh<3> mesh = sphere_surface(all_of);
    CHECK(on_sphere(mesh, 0.2, {.threads = 1}).mesh == on_sphere(mesh, 0.2, {.threads = 2}).mesh);
}

TEST_CASE("remeshing rejects a curved standalone surface") {
    const LinearMesh<3> mesh = sphere_surface(all_of);
    const AdaptationGoal<3> goal = unit_goal(mesh);
    const auto edges = must(unique_edges(mesh, one_thread));
    Buffer<LagrangeNode<3>> nodes(edges.size());
    const auto curved = begin_adaptation(QuadraticMesh<3>{mesh, edges, std::move(nodes)}, {}, goal, one_thread);
    REQUIRE(!curved.has_value());
    CHECK(curved.error().kind == ErrorKind::unsupported);
}

TEST_CASE("remeshing rejects an empty mesh") {
    const AdaptationGoal<3> goal = unit_goal(sphere_surface(all_of));
    const LinearMesh<3> none;
    const auto empty = begin_adaptation(none, must(unique_edges(none, one_thread)), {}, goal, one_thread);
    REQUIRE(!empty.has_value());
    CHECK(empty.error().kind == ErrorKind::input);
}
