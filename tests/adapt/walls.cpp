// Smooth curved surfaces: no element gets two facets on one of them, and vertices off the geometry are moved onto it.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "dice.hpp"
#include "goals.hpp"
#include "meshes.hpp"
#include "named_domains.hpp"
#include "sanitized.hpp"

import camber.core;
import camber.metric;
import camber.cavity;
import camber.surface;
import camber.operation;
import camber.adapt;

using namespace camber;
using namespace camber::testing;

namespace {

/// The number of elements with two facets on the ball (reference 20), which has no ridge.
template <int D>
std::size_t folded_at_the_ball(const DynamicMesh<D>& mesh) {
    std::size_t count = 0;
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
        if (mesh.is_free(ElementId(e))) continue;
        int facets = 0;
        for (const FaceNeighbour across : mesh.face_neighbours[e])
            facets += across.valid() && across.is_facet() && mesh.facets.references[across.facet()] == 20 ? 1 : 0;
        count += facets > 1 ? 1 : 0;
    }
    return count;
}

/// The largest distance of a ball vertex from the ball.
template <int D>
double off_the_ball(const DynamicMesh<D>& mesh) {
    double most = 0;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        if (mesh.is_free(FacetId(f)) || mesh.facets.references[f] != 20) continue;
        for (const VertexId v : mesh.facets.vertices[f]) most = std::max(most, std::abs(norm(mesh.points[v]) - 1));
    }
    return most;
}

template <int D>
Adaptation<D> initial_state(const LinearMesh<D>& mesh, const AdaptationGoal<D>& goal) {
    const auto edges = must(unique_edges(mesh, one_thread));
    const auto features = must(find_features(mesh, edges, FeatureOptions<D>{.ridge_angle_degrees = 75}, one_thread));
    std::vector<VertexId> corners;
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
        if (features.vertex_kinds[v] == VertexKind::corner) corners.emplace_back(v);
    return must(begin_adaptation(mesh, edges, {features.edge_kinds.view(), corners}, goal, one_thread));
}

template <int D>
AdaptationGoal<D> ball_goal(const NamedDomain<D>& domain, double size) {
    Dice dice(7);
    AdaptationGoal<D> goal = goal_over(domain.mesh, size, dice);
    goal.geometry = Geometry<D>(domain.surfaces);
    return goal;
}

template <int D>
void expect_no_folds(int cells, double coarse, double fine) {
    const NamedDomain<D> domain = ball_in_box<D>(cells);
    Adaptation<D> r = initial_state(domain.mesh, ball_goal(domain, fine));
    for (const double size : {fine, coarse, fine}) {
        const AdaptationGoal<D> goal = ball_goal(domain, size);
        const CompactMesh<D> mesh = must(finished(r, one_thread)).compact;  // lists its breaks
        r = must(begin_adaptation(mesh.mesh, mesh.edges, {}, goal, one_thread));
        const std::size_t before = folded_at_the_ball(r.mesh);
        r = must(remesh_to_metric<D>(std::move(r), goal, {.rounds = 2}, one_thread)).state;
        CHECK(folded_at_the_ball(r.mesh) <= before);
        CHECK(must(unit_mesh_statistics(r, one_thread)).worst_quality > 0.02);
    }
}

/// Counts facets of the ball that exceed a bound before and after remeshing to a large size. The bound is a length or a
/// share of edge lengths.
template <int D>
void expect_bounded(int cells, const DistanceBound& bound) {
    const NamedDomain<D> domain = ball_in_box<D>(cells);
    AdaptationGoal<D> goal = ball_goal(domain, 10);
    goal.distance_bounds = DistanceBounds(std::span(&bound, 1));
    Adaptation<D> r = initial_state(domain.mesh, goal);
    REQUIRE(must(count_far_facets(r, goal, one_thread)) == 0);
    const std::size_t before = domain.mesh.elements.size();
    r = must(remesh_to_metric<D>(std::move(r), goal, {.rounds = 2}, one_thread)).state;
    CHECK(must(count_far_facets(r, goal, one_thread)) == 0);
    CHECK(must(finished(r, one_thread)).compact.mesh.elements.size() < before / 2);
    goal.distance_bounds = {};
    r = must(remesh_to_metric<D>(std::move(r), goal, {.rounds = 2}, one_thread)).state;
    goal.distance_bounds = DistanceBounds(std::span(&bound, 1));
    CHECK(must(count_far_facets(r, goal, one_thread)) > 0);
}

template <int D>
void expect_on_geometry(int cells) {
    NamedDomain<D> domain = ball_in_box<D>(cells);
    Dice dice(11);
    Buffer<Vec<D>> points(domain.mesh.points.begin(), domain.mesh.points.end());
    for (Vec<D>& p : points)
        if (std::abs(norm(p) - 1) < 1e-9) p = (1 + dice.uniform(-0.1, 0.1) * domain.cell) * p;
    domain.mesh.points = std::move(points);
    const AdaptationGoal<D> goal = ball_goal(domain, domain.cell);
    Adaptation<D> r = initial_state(domain.mesh, goal);
    CHECK(off_the_ball(r.mesh) > 0.01 * domain.cell);
    auto result = must(smooth<D>(std::move(r), goal, {}, one_thread));
    CHECK(off_the_ball(result.state.mesh) < 1e-12);
    must(check_consistency(result.state.mesh, one_thread));
}

}  // namespace

TEST_CASE("passes create no element with two facets on a smooth curved surface") {
    expect_no_folds<2>(8, 0.8, 0.15);
    if (!is_sanitized) expect_no_folds<3>(4, 1.2, 0.5);
}

TEST_CASE("passes create no facet beyond the distance bounds of the geometry") {
    expect_bounded<2>(16, {.largest = 0.03});
    expect_bounded<2>(16, {.references = {20}, .share = 0.0658});
    expect_bounded<3>(12, {.largest = 0.08});
    expect_bounded<3>(12, {.references = {20}, .share = 0.1});
}

TEST_CASE("the smallest distance bound of a reference applies") {
    const std::array<DistanceBound, 3> bounds{{{0.5, {2}, 0.1}, {0.2}, {0.1, {3}, 0.3}}};
    const DistanceBounds limits(bounds);
    CHECK(limits.of(2).at(10) == 0.2);
    CHECK(limits.of(2).at(1) == doctest::Approx(0.1));
    CHECK(limits.of(3).at(10) == 0.1);
    CHECK(limits.of(4).at(1e9) == 0.2);
    CHECK(std::isinf(DistanceBounds().of(1).at(1)));
}

TEST_CASE("smoothing moves boundary vertices onto the geometry") {
    expect_on_geometry<2>(8);
    expect_on_geometry<3>(8);
}
