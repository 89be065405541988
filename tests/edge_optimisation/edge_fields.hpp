// Metric fields for the searches of edge nodes.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string>

#include "back.hpp"

import camber.core;
import camber.metric;
import camber.edge_optimisation;

namespace camber::testing {

/// Layers of a sphere: thin along the radius near r = 1, coarser outwards.
template <int D>
KnownBack<D> layers(std::uint64_t seed, int n) {
    std::array<int, D> cells{};
    cells.fill(n);
    return back_of(shell_block<D>(cells, seed),
                   [](const Vec<D>& x) { return polar(x, 0.02 + 0.18 * (norm(x) - 1), 0.2); });
}

template <int D>
KnownBack<D> own_metric(std::uint64_t seed, int n) {
    std::array<int, D> cells{};
    cells.fill(n);
    const auto mesh = shell_block<D>(cells, seed);
    const auto around = must(balls(mesh, one_thread));
    const Column<LogMetric<D>> logs(must(natural_log_metrics(mesh, around, one_thread)));
    return {must(make_back_mesh(mesh, around, logs, one_thread)), mesh, logs};
}

/// Axes that rotate by 0.3 a cell, with an anisotropy that no cell resolves.
template <int D>
KnownBack<D> turning(std::uint64_t seed, int n) {
    const double apart = Dice(seed).uniform(10, 28);
    return back_of(unit_box<D>(n, seed), [&](const Vec<D>& x) {
        Vec<D> axis;
        axis[0] = std::cos(0.3 * n * x[0]);
        axis[1] = std::sin(0.3 * n * x[0]);
        LogMetric<D> l;
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j) l.l(i, j) = apart * axis[i] * axis[j] + (i == j ? 4.0 : 0.0);
        return l;
    });
}

/// A field for the searches, and the maximum ratio of mean lengths of packed and single searches. It is large in
/// `turning`: in these small boxes half of the edges are near the boundary, and only the single search samples beyond
/// it.
template <int D>
struct Field {
    std::string name;
    KnownBack<D> (*build)(std::uint64_t seed, int n);
    double max_mean;
};
template <int D>
const std::array fields{Field<D>{"natural", own_metric<D>, 1.002}, Field<D>{"layers", layers<D>, 1.005},
                        Field<D>{"turning", turning<D>, 1.15}};

template <int D>
bool same(const EdgeMinimum<D>& a, const EdgeMinimum<D>& b) {
    return a.node == b.node && a.search == b.search && a.shortened == b.shortened;
}

}  // namespace camber::testing
