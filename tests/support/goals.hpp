// Domains with a target metric.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "dice.hpp"
#include "domains.hpp"
#include "meshes.hpp"

import camber.core;
import camber.metric;
import camber.cavity;
import camber.surface;
import camber.operation;
import camber.adapt;

namespace camber::testing {

/// Sizes of about `size`, smaller towards a plane, anisotropic along random axes.
template <int D>
Column<LogMetric<D>> metrics_over(const LinearMesh<D>& mesh, double size, Dice& dice) {
    const Mat<D> axes = dice.rotation<D>();
    const double anisotropy = dice.uniform(1, 3);
    Buffer<LogMetric<D>> logs(mesh.points.size());
    for (std::size_t v = 0; v < logs.size(); ++v) {
        Vec<D> sizes;
        for (int i = 0; i < D; ++i) sizes[i] = size * (1 + 0.3 * mesh.points[v][0]);
        sizes[0] /= anisotropy;
        logs[v] = log_metric_of_sizes<D>(sizes, axes);
    }
    return logs;
}

template <int D>
AdaptationGoal<D> goal_over(const LinearMesh<D>& mesh, double size, Dice& dice) {
    return {must(make_back_mesh(mesh, must(balls(mesh, one_thread)), metrics_over(mesh, size, dice), one_thread)), {}};
}

template <int D>
Adaptation<D> start_adaptation(const LinearMesh<D>& mesh, const AdaptationGoal<D>& goal) {
    return must(begin_adaptation(mesh, must(unique_edges(mesh, one_thread)), {}, goal, one_thread));
}

/// A random domain and a target metric on it.
template <int D>
struct StraightDomain {
    Adaptation<D> state;
    AdaptationGoal<D> goal;
};
template <int D>
StraightDomain<D> straight_domain(std::uint64_t seed) {
    Dice dice(seed);
    const LinearMesh<D> mesh = random_domain<D>(seed);
    AdaptationGoal<D> goal = goal_over(mesh, dice.uniform(0.5, 1.5), dice);
    return {start_adaptation(mesh, goal), std::move(goal)};
}

}  // namespace camber::testing
