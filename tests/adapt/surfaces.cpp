// Surfaces alone go through the passes: what is flat stays, whatever shares its edges; what is curved lies on its
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

/// The facets of a mesh, and its listed edges.
LinearMesh<3> surface_of(LinearMesh<3> mesh) {
    mesh.elements = {};
    return mesh;
}

Vec<3> area_vector(const LinearMesh<3>& mesh, const SimplexVertices<2>& f) {
    return 0.5 * cross(mesh.points[f[1]] - mesh.points[f[0]], mesh.points[f[2]] - mesh.points[f[0]]);
}

/// By reference; a fold would have more of it.
std::map<Reference, double> areas(const LinearMesh<3>& mesh) {
    std::map<Reference, double> sums;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        sums[mesh.facets.references[f]] += norm(area_vector(mesh, mesh.facets.vertices[f]));
    return sums;
}

/// How many triangles an edge has, by the places of its ends, of edges that have other than two.
using Rims = std::map<std::array<Vec<3>, 2>, std::size_t, decltype([](const auto& a, const auto& b) {
                          return std::pair(a[0].c, a[1].c) < std::pair(b[0].c, b[1].c);
                      })>;
Rims rims(const LinearMesh<3>& mesh, std::size_t at_least) {
    const auto edges = must(unique_edges(mesh, alone));
    const auto around = must(facet_shells(edges, alone));
    Rims found;
    for (std::size_t e = 0; e < edges.size(); ++e) {
        std::array<Vec<3>, 2> ends{mesh.points[edges.vertices[e][0]], mesh.points[edges.vertices[e][1]]};
        if (ends[1].c < ends[0].c) std::swap(ends[0], ends[1]);
        if (around[e].size() != 2 && around[e].size() >= at_least) found[ends] = around[e].size();
    }
    return found;
}

LinearMesh<3> compact(const Adaptation<3>& r) { return must(compacted(r.mesh, alone)).mesh; }

void flat_surfaces_stay(std::uint64_t seed) {
    Dice dice(seed);
    const LinearMesh<3> mesh = surface_of(random_domain<3>(seed));
    const AdaptationGoal<3> goal = goal_over(mesh, dice.uniform(0.3, 1.5), dice);
    Adaptation<3> r = begun(mesh, goal);
    RC_ASSERT(compact(r) == compact(begun(compact(r), goal)));
    const auto before = areas(mesh);
    const auto shared = rims(mesh, 3);
    const auto apply = [&](auto pass) {
        r = must(pass(std::move(r))).state;
        const auto consistent = check_consistency(r.mesh, alone);
        if (!consistent) RC_FAIL(describe(consistent.error()));
        const LinearMesh<3> now = compact(r);
        RC_ASSERT(now.elements.size() == 0U);
        const auto after = areas(now);
        RC_ASSERT(after.size() == before.size());
        for (const auto& [reference, area] : before) RC_ASSERT(std::abs(after.at(reference) - area) < 1e-8);
        RC_ASSERT(rims(now, 3) == shared);
    };
    for (int round = 0; round < 2; ++round) {
        apply([&](Adaptation<3> s) { return collapse<3>(std::move(s), goal, {}, alone); });
        apply([&](Adaptation<3> s) { return split<3>(std::move(s), goal, {}, alone); });
        apply([&](Adaptation<3> s) { return swap<3>(std::move(s), goal, {}, alone); });
        apply([&](Adaptation<3> s) { return smooth<3>(std::move(s), goal, {}, alone); });
    }
    apply([&](Adaptation<3> s) { return mend<3>(std::move(s), goal, {}, alone); });
}

/// The ball's surface by its own generator, to one size; `keep(centre)` of which triangles.
struct OnSphere {
    LinearMesh<3> mesh;
    ToMetricStatistics told;
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
OnSphere on_sphere(const LinearMesh<3>& mesh, double size, const Execution& execution = alone) {
    Buffer<LogMetric<3>> logs(mesh.points.size(), log_metric_of_sizes<3>({{size, size, size}}));
    const AdaptationGoal<3> goal{
        must(make_back_mesh(mesh, must(balls(mesh, alone)), Column<LogMetric<3>>(std::move(logs)), alone)),
        Geometry<3>(AnalyticGeometry<3>{{{1, Sphere<3>{{}, 1}}}})};
    auto [r, told] = must(bring_to_metric<3>(begun(mesh, goal), goal, {}, execution));
    CHECK(check_consistency(r.mesh, alone).has_value());
    return {compact(r), told};
}
bool all_of(const Vec<3>&) { return true; }

/// V − E + F.
std::ptrdiff_t euler(const LinearMesh<3>& mesh) {
    std::set<std::uint32_t> used;
    for (const auto& f : mesh.facets.vertices)
        for (const VertexId v : f) used.insert(v.value);
    const auto edges = must(unique_edges(mesh, alone));
    return static_cast<std::ptrdiff_t>(used.size()) - static_cast<std::ptrdiff_t>(edges.size()) +
           static_cast<std::ptrdiff_t>(mesh.facets.size());
}

}  // namespace

TEST_CASE("flat surfaces stay, with their references and the edges that more than two triangles share") {
    property("walls, interfaces and baffles", flat_surfaces_stay, {.count = 20});
}

TEST_CASE("a sphere stays one, finer and coarser") {
    const LinearMesh<3> mesh = sphere_surface(all_of);
    CHECK(euler(mesh) == 2);
    for (const auto& [size, min_share, min_quality] : {std::array{0.2, 0.95, 0.4}, std::array{0.9, 0.5, 0.3}}) {
        const auto [now, told] = on_sphere(mesh, size);
        CHECK(euler(now) == 2);
        CHECK(rims(now, 1).empty());
        double volume = 0, farthest = 0;
        for (const auto& f : now.facets.vertices) volume += dot(area_vector(now, f), now.points[f[0]]) / 3;
        for (const auto& f : now.facets.vertices)
            for (const VertexId v : f) farthest = std::max(farthest, std::abs(norm(now.points[v]) - 1));
        CHECK(farthest < 1e-12);
        CHECK(std::abs(std::abs(volume) - 4.18879) < 2.5 * size * size);  // and no triangle looks inward
        CHECK(told.after.unit_share() > min_share);
        CHECK(told.after.worst_quality > min_quality);
    }
}

TEST_CASE("a surface with a border keeps one") {
    const LinearMesh<3> mesh = sphere_surface([](const Vec<3>& c) { return c[2] > 0; });
    CHECK(euler(mesh) == 1);
    const auto [now, told] = on_sphere(mesh, 0.2);
    CHECK(euler(now) == 1);
    CHECK(told.after.unit_share() > 0.85);
    std::size_t borders = 0;
    for (const auto& [ends, triangles] : rims(now, 1)) borders += triangles == 1 ? 1 : 0;
    CHECK(borders > rims(mesh, 1).size());  // it was coarser
}

TEST_CASE("a surface alone is the same for any number of threads") {
    const LinearMesh<3> mesh = sphere_surface(all_of);
    CHECK(on_sphere(mesh, 0.2, {.threads = 1}).mesh == on_sphere(mesh, 0.2, {.threads = 2}).mesh);
}

TEST_CASE("a curved surface alone is refused, and so is a mesh of nothing") {
    const LinearMesh<3> mesh = sphere_surface(all_of);
    Buffer<LogMetric<3>> logs(mesh.points.size(), log_metric_of_sizes<3>({{1, 1, 1}}));
    const AdaptationGoal<3> goal{
        must(make_back_mesh(mesh, must(balls(mesh, alone)), Column<LogMetric<3>>(std::move(logs)), alone)), {}};
    const auto edges = must(unique_edges(mesh, alone));
    Buffer<LagrangeNode<3>> nodes(edges.size());
    const auto curved = begin_adaptation(QuadraticMesh<3>{mesh, edges, std::move(nodes)}, {}, goal, alone);
    REQUIRE(!curved.has_value());
    CHECK(curved.error().kind == ErrorKind::unsupported);
    const LinearMesh<3> none;
    const auto empty = begin_adaptation(none, must(unique_edges(none, alone)), {}, goal, alone);
    REQUIRE(!empty.has_value());
    CHECK(empty.error().kind == ErrorKind::input);
}
