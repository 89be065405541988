// Background meshes for tests of the metric.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "dice.hpp"
#include "meshes.hpp"

import camber.core;
import camber.bezier;
import camber.metric;

namespace camber::testing {

/// A background mesh with access to its mesh and to the field values at its vertices.
template <int D>
struct KnownBack : BackMesh<D> {
    LinearMesh<D> mesh;
    Column<LogMetric<D>> log_metrics;
};

template <int D, class Field>
KnownBack<D> back_of(const LinearMesh<D>& mesh, Field&& field) {
    Buffer<LogMetric<D>> logs(mesh.points.size());
    for (std::size_t v = 0; v < logs.size(); ++v) logs[v] = field(mesh.points[v]);
    const Column<LogMetric<D>> column(std::move(logs));
    return {must(make_back_mesh(mesh, must(balls(mesh, one_thread)), column, one_thread)), mesh, column};
}

/// A random value at each vertex: the field has kinks on every face.
template <int D>
KnownBack<D> rough_back(const LinearMesh<D>& mesh, Dice& dice, double size = 1) {
    return back_of(mesh, [&](const Vec<D>&) { return LogMetric<D>{dice.symmetric<D>(size)}; });
}

/// log M = constant + Σ x_i slope_i. The field is smooth, and linear elements represent it exactly.
template <int D>
struct AffineField {
    Sym<D> constant;
    LogGradient<D> slope{};

    LogMetric<D> operator()(const Vec<D>& x) const {
        LogMetric<D> value{constant};
        for (int i = 0; i < D; ++i) value.l += x[i] * slope[i];
        return value;
    }
    static AffineField random(Dice& dice, double size = 1) {
        AffineField f;
        f.constant = dice.symmetric<D>(size);
        for (auto& s : f.slope) s = dice.symmetric<D>(size);
        return f;
    }
};

/// Polar metric around the origin: size `h_radial` along the radius, `h_tangential` across it.
template <int D>
LogMetric<D> polar(const Vec<D>& x, double h_radial, double h_tangential) {
    const Vec<D> r = normalised(x);
    const double radial = -2 * std::log(h_radial);
    const double tangential = -2 * std::log(h_tangential);
    LogMetric<D> m;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j) m.l(i, j) = (i == j ? tangential : 0.0) + (radial - tangential) * r[i] * r[j];
    return m;
}

/// A jittered lattice of n cells per axis over the unit box.
template <int D>
LinearMesh<D> unit_box(int n, std::uint64_t seed, double jitter = 0.2) {
    LatticeOptions<D> options;
    options.cells.fill(n);
    options.jitter = jitter;
    options.seed = seed;
    options.place = [n](const Vec<D>& p) { return p / n; };
    return lattice_mesh(options);
}

/// A block of the shell between radii 1 and 2.
template <int D>
LinearMesh<D> shell_block(const std::array<int, D>& cells, std::uint64_t seed, double jitter = 0.1) {
    LatticeOptions<D> options;
    options.cells = cells;
    options.seed = seed;
    options.jitter = jitter;
    options.place = [cells](const Vec<D>& p) {
        const double r = 1 + p[D - 1] / cells[D - 1];
        const double a = 1.2 * (p[0] / cells[0] - 0.5);
        if constexpr (D == 2) {
            return Vec<2>{{r * std::sin(a), r * std::cos(a)}};
        } else {
            const double b = 1.2 * (p[1] / cells[1] - 0.5);
            return r * normalised(Vec<3>{{std::tan(a), std::tan(b), 1}});
        }
    };
    return lattice_mesh(options);
}

/// Returns the point that a location describes.
template <int D>
Vec<D> place_of(const KnownBack<D>& back, const Location<D>& location) {
    const auto p = corners(back.mesh, location.element.index());
    Vec<D> x;
    for (int i = 0; i <= D; ++i) x += location.xi[i] * p[i];
    return x;
}

template <int D>
Vec<D> random_point(const LinearMesh<D>& mesh, Dice& dice) {
    const auto p = corners(mesh, dice.below(mesh.elements.size()));
    const auto xi = dice.barycentric<D>();
    Vec<D> x;
    for (int i = 0; i <= D; ++i) x += xi[i] * p[i];
    return x;
}

}  // namespace camber::testing
