// Rows of thin elements whose edges have a sagitta of many row heights: passes coarsen and refine them along their
// curves.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "goals.hpp"
#include "meshes.hpp"
#include "restarts.hpp"
#include "sanitized.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.edge_optimisation;
import camber.cavity;
import camber.surface;
import camber.soundness;
import camber.validity;
import camber.operation;
import camber.adapt;

using namespace camber;
using namespace camber::testing;

namespace {

constexpr double height = 1e-3;  ///< height of a row; edges along the row have length 1

/// Bends rows around an axis. An edge of length 1 gets a sagitta of `bow` heights; 0 leaves the rows straight.
template <int D>
struct Bending {
    double radius = 0;  ///< 0 if straight

    explicit Bending(double bow) : radius(bow > 0 ? 1 / (8 * bow * height) : 0) {}
    [[nodiscard]] Vec<D> operator()(const Vec<D>& x) const {
        if (radius == 0) return x;
        Vec<D> p = x;
        p[0] = (radius + x[D - 1]) * std::sin(x[0] / radius);
        p[D - 1] = (radius + x[D - 1]) * std::cos(x[0] / radius) - radius;
        return p;
    }
    /// The metric at a point of the bent mesh, from the sizes along the rows (and the axis) and across them.
    [[nodiscard]] LogMetric<D> metric_at(const Vec<D>& x, const Vec<D>& sizes) const {
        Mat<D> frame = Mat<D>::identity();
        if (radius != 0) {
            const double r = std::hypot(x[0], x[D - 1] + radius), s = x[0] / r, c = (x[D - 1] + radius) / r;
            frame(0, 0) = c;
            frame(D - 1, 0) = -s;
            frame(0, D - 1) = s;
            frame(D - 1, D - 1) = c;
        }
        return log_metric_of_sizes<D>(sizes, frame);
    }
};

template <int D>
Features<D> features_of(const QuadraticMesh<D>& mesh) {
    return must(find_features(mesh.linear, mesh.edges, FeatureOptions<D>{.ridge_angle_degrees = 60}, one_thread));
}

template <int D>
QuadraticMesh<D> bent_rows(const Bending<D>& bending) {
    LatticeOptions<D> options;
    options.cells.fill(D == 2 ? 8 : 3);
    options.jitter = 0.1;
    options.seed = 3;
    options.place = [](Vec<D> p) {
        p[D - 1] *= height;
        return p;
    };
    return mapped(must(as_linear(must(prepare(as_mesh(lattice_mesh(options)), one_thread)).mesh)), bending);
}

/// A surrogate of the curved boundary of the mesh.
template <int D>
Geometry<D> geometry_of(const QuadraticMesh<D>& mesh) {
    const auto features = features_of(mesh);
    auto straight = must(build_surrogate(mesh.linear, mesh.edges, features, SurrogateOptions{}, one_thread));
    return Geometry<D>(
        must(build_curved_surrogate<D>(std::move(straight), {mesh.linear, mesh.edges, features, mesh.mid_nodes.view()},
                                       StraightGeometry<D>{}, SurrogateOptions{}, one_thread))
            .surrogate);
}

template <int D>
AdaptationGoal<D> goal_along(const QuadraticMesh<D>& mesh, const Geometry<D>& geometry, const Bending<D>& bending,
                             double size) {
    Vec<D> sizes;
    sizes.c.fill(size);
    sizes[D - 1] *= height;
    Buffer<LogMetric<D>> logs(mesh.linear.points.size());
    for (std::size_t v = 0; v < logs.size(); ++v) logs[v] = bending.metric_at(mesh.linear.points[v], sizes);
    auto nodal = must(framed_logs(mesh.edges, Column<LogMetric<D>>(std::move(logs)), one_thread));
    AdaptationGoal<D> goal{
        must(make_nodal_back_mesh(mesh, must(balls(mesh.linear, one_thread)), std::move(nodal), one_thread)), geometry};
    goal.accuracy.change = ChangeSource::of_ends;
    return goal;
}

template <int D>
Adaptation<D> initial_state(const QuadraticMesh<D>& mesh, const AdaptationGoal<D>& goal) {
    const auto features = features_of(mesh);
    std::vector<VertexId> corners;
    for (std::size_t v = 0; v < mesh.linear.points.size(); ++v)
        if (features.vertex_kinds[v] == VertexKind::corner) corners.emplace_back(v);
    return must(begin_adaptation(mesh, {features.edge_kinds.view(), corners}, goal, one_thread));
}

template <int D>
void expect_passes_along_rows(double bow, double least_unit) {
    const Bending<D> bending(bow);
    QuadraticMesh<D> mesh = bent_rows<D>(bending);
    REQUIRE(must(validate(mesh, 0, one_thread)).all_valid());
    const Geometry<D> geometry = geometry_of(mesh);
    std::size_t straight_inverted = 0;
    for (const double size : {1.5, 0.8, 1.2}) {
        CAPTURE(bow);
        CAPTURE(size);
        const AdaptationGoal<D> goal = goal_along(mesh, geometry, bending, size);
        auto result = must(remesh_to_metric(initial_state(mesh, goal), goal, ToMetricOptions{}, one_thread));
        must(check_consistency(result.state.mesh, one_thread));
        auto compact = must(finished(result.state, one_thread)).compact;
        mesh = {std::move(compact.mesh), std::move(compact.edges), std::move(compact.nodes)};
        CHECK(must(validate(mesh, 0, one_thread)).all_valid());
        CHECK(result.statistics.after.unit_share() >= least_unit);
        CHECK(result.statistics.after.worst_quality > (D == 2 ? 0.1 : 0.03));
        straight_inverted += result.statistics.collapse.straight_inverted;
    }
    if (bow >= 5) CHECK(straight_inverted > 0);
}

}  // namespace

TEST_CASE("remeshing coarsens and refines rows whose sagitta is 5 to 45 times their height") {
    expect_passes_along_rows<2>(20, 0.65);
    if (is_sanitized) return;
    for (const double bow : {5.0, 45.0}) expect_passes_along_rows<2>(bow, bow < 40 ? 0.65 : 0.5);
    for (const double bow : {5.0, 20.0}) expect_passes_along_rows<3>(bow, 0.55);
}
