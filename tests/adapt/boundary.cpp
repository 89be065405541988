// Boundary vertices move only where the shape of their surface is preserved or known.
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include <doctest/doctest.h>

#include "dice.hpp"
#include "domains.hpp"
#include "goals.hpp"
#include "meshes.hpp"

import camber.core;
import camber.metric;
import camber.cavity;
import camber.surface;
import camber.operation;
import camber.adapt;

using namespace camber;
using namespace camber::testing;

namespace {

/// A box of 4 × 4 × 4 cells of one material. Its lateral sides have one reference.
LinearMesh<3> box(double jitter) {
    LatticeOptions<3> options;
    options.cells = {4, 4, 4};
    options.seed = 3;
    LinearMesh<3> mesh = with_references<3>(lattice_mesh(options), options.cells, false);
    options.jitter = jitter;  // same lattice: references follow from the positions before the jitter
    mesh.points = lattice_mesh(options).points;
    Buffer<SimplexVertices<2>> facets;
    Buffer<Reference> references;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        if (mesh.facets.references[f] == 20) continue;
        facets.push_back(mesh.facets.vertices[f]);
        references.push_back(mesh.facets.references[f] < 5 ? 1 : mesh.facets.references[f]);
    }
    mesh.facets = {std::move(facets), std::move(references), {}};
    mesh.elements.references = Buffer<Reference>(mesh.elements.size(), 1);
    return mesh;
}

/// The box mapped to a cylinder of radius and height 2 about the z axis.
LinearMesh<3> cylinder() {
    LinearMesh<3> mesh = box(0);
    Buffer<Vec<3>> points(mesh.points.begin(), mesh.points.end());
    for (Vec<3>& p : points) {
        const double x = p[0] / 2 - 1;
        const double y = p[1] / 2 - 1;
        p = {{2 * x * std::sqrt(1 - y * y / 2), 2 * y * std::sqrt(1 - x * x / 2), p[2] / 2}};
    }
    mesh.points = std::move(points);
    return mesh;
}

AdaptationGoal<3> goal_of_size(const LinearMesh<3>& mesh, const Vec<3>& sizes) {
    Buffer<LogMetric<3>> logs(mesh.points.size(), log_metric_of_sizes<3>(sizes));
    return {
        must(make_back_mesh(mesh, must(balls(mesh, one_thread)), Column<LogMetric<3>>(std::move(logs)), one_thread)),
        {}};
}

/// The number of vertices of the given place that have moved.
std::size_t moved(const DynamicMesh<3>& mesh, const LinearMesh<3>& before, VertexPlace place) {
    std::size_t count = 0;
    for (std::size_t v = 0; v < before.points.size(); ++v)
        if (mesh.states[v].place == place && mesh.points[v] != before.points[v]) ++count;
    return count;
}

}  // namespace

TEST_CASE("without a geometry boundary vertices move only in planes and along straight lines") {
    LinearMesh<3> mesh = box(0);
    Buffer<Vec<3>> points(mesh.points.begin(), mesh.points.end());
    for (Vec<3>& p : points) p[0] += 0.4 * std::sin(p[0] * 0.78539816339744831) * (p[1] - 2) / 2;  // 0 and 4 are fixed
    mesh.points = std::move(points);
    const AdaptationGoal<3> goal = goal_of_size(mesh, {{1, 1, 1}});
    const auto result = must(smooth<3>(start_adaptation(mesh, goal), goal, {.target_quality = 1}, one_thread));
    const auto& after = result.state.mesh;
    CHECK(moved(after, mesh, VertexPlace::surface) > 5);
    CHECK(moved(after, mesh, VertexPlace::line) > 3);
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
        for (int axis = 0; axis < 3; ++axis)
            if (const double x = mesh.points[v][axis]; x == 0 || x == 4) CHECK(after.points[v][axis] == x);
}

TEST_CASE("remeshing keeps boundary vertices exactly in coordinate planes") {
    const LinearMesh<3> mesh = box(0);
    const AdaptationGoal<3> goal = goal_of_size(mesh, {{0.4, 0.7, 0.5}});
    const auto after =
        must(remesh_to_metric(start_adaptation(mesh, goal), goal, ToMetricOptions{}, one_thread)).state.mesh;
    std::size_t in_planes = 0;
    for (std::size_t v = 0; v < after.points.size(); ++v) {
        if (after.is_free(VertexId(v)) || after.states[v].place == VertexPlace::inside) continue;
        for (const double x : after.points[v].c) {
            if (std::abs(x * (4 - x)) > 1e-9) continue;
            CHECK((x == 0 || x == 4));
            ++in_planes;
        }
    }
    CHECK(in_planes > 100);
}

TEST_CASE("smoothing keeps the vertices of a rough surface without a geometry") {
    const LinearMesh<3> mesh = box(0.1);
    const AdaptationGoal<3> goal = goal_of_size(mesh, {{0.6, 1, 1.2}});
    const auto after =
        must(smooth<3>(start_adaptation(mesh, goal), goal, {.target_quality = 1}, one_thread)).state.mesh;
    CHECK(moved(after, mesh, VertexPlace::inside) > 5);
    CHECK(moved(after, mesh, VertexPlace::surface) == 0);
    CHECK(moved(after, mesh, VertexPlace::line) == 0);
}

TEST_CASE("smoothing moves vertices along the intersection curve of two known surfaces") {
    const LinearMesh<3> mesh = cylinder();
    AdaptationGoal<3> goal = goal_of_size(mesh, {{1, 0.7, 0.8}});
    goal.geometry = Geometry<3>(AnalyticGeometry<3>{
        {{1, Cylinder{{}, {{0, 0, 1}}, 2}}, {5, Plane<3>{{}, {{0, 0, 1}}}}, {6, Plane<3>{{{0, 0, 2}}, {{0, 0, 1}}}}}});
    const auto after =
        must(smooth<3>(start_adaptation(mesh, goal), goal, {.target_quality = 1}, one_thread)).state.mesh;
    CHECK(check_consistency(after, one_thread).has_value());
    CHECK(moved(after, mesh, VertexPlace::line) > 5);
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
        const Vec<3>& p = after.points[v];
        if (after.states[v].place != VertexPlace::line) continue;
        CHECK(std::abs(std::hypot(p[0], p[1]) - 2) < 1e-12);
        CHECK(std::abs(p[2] * (2 - p[2])) < 1e-12);
    }
}

TEST_CASE("collapse is rejected where its facets would leave the geometry") {
    const LinearMesh<3> mesh = cylinder();
    AdaptationGoal<3> goal = goal_of_size(mesh, {{3, 3, 3}});
    goal.geometry = Geometry<3>(AnalyticGeometry<3>{{{1, Cylinder{{}, {{0, 0, 1}}, 2}}}});
    const auto near = must(collapse<3>(start_adaptation(mesh, goal), goal, {.distance = 0.02}, one_thread));
    const auto far = must(collapse<3>(start_adaptation(mesh, goal), goal, {.distance = 1}, one_thread));
    CHECK(near.statistics.of(RejectionReason::geometry) > far.statistics.of(RejectionReason::geometry));
    CHECK(near.state.mesh.facet_count() > far.state.mesh.facet_count());
}

TEST_CASE("mend improves flat elements and changes nothing in a second run") {
    // A layer of flat elements: inner vertices are moved close to the wall.
    LinearMesh<3> mesh = box(0);
    Buffer<Vec<3>> points(mesh.points.begin(), mesh.points.end());
    for (Vec<3>& p : points)
        if (p[0] == 1) p[0] = 0.02;
    mesh.points = std::move(points);
    const AdaptationGoal<3> goal = goal_of_size(mesh, {{1, 1, 1}});
    const Adaptation<3> r = start_adaptation(mesh, goal);
    const double before = must(unit_mesh_statistics(r, one_thread)).worst_quality;
    const auto result = must(mend<3>(r, goal, {}, one_thread));
    CHECK(check_consistency(result.state.mesh, one_thread).has_value());
    CHECK(before < 0.15);
    CHECK(must(unit_mesh_statistics(result.state, one_thread)).worst_quality > 0.3);
    const auto again = must(mend<3>(result.state, goal, {}, one_thread));
    CHECK(again.statistics.accepted == 0);
}
