// Lattices with bent edges, and interpolation errors on them.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <span>
#include <utility>

import camber.core;
import camber.bezier;
import camber.interpolation;

#include "mapped.hpp"
#include "meshes.hpp"

namespace camber::testing {

template <int D>
QuadraticMesh<D> mesh_of_cells(int cells, double jitter, std::uint64_t seed) {
    LatticeOptions<D> options;
    options.cells.fill(cells);
    options.jitter = jitter;
    options.seed = seed;
    auto mesh = elevate(lattice_mesh<D>(options), one_thread);
    REQUIRE(mesh.has_value());
    return *mesh;
}

/// Moves the nodes by up to `amplitude`.
template <int D>
QuadraticMesh<D> bent(QuadraticMesh<D> mesh, double amplitude, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> move(-amplitude, amplitude);
    auto nodes = take(std::move(mesh.mid_nodes));
    for (auto& n : nodes)
        for (int c = 0; c < D; ++c) n.point[c] += move(random);
    mesh.mid_nodes = std::move(nodes);
    return mesh;
}

template <int D, class F>
ScalarField<D> field_of(F f) {
    return [f] {
        return PointFunction<D>([f](std::span<const Vec<D>> points, std::span<double> values) {
            for (std::size_t i = 0; i < points.size(); ++i) values[i] = f(points[i]);
        });
    };
}

template <int D>
InterpolationError error_of(const QuadraticMesh<D>& mesh, const ScalarField<D>& field, double tolerance = 1e-3,
                            const Execution& execution = one_thread) {
    auto error = interpolation_error<D>(as_mesh(mesh), field, {.tolerance = tolerance}, execution);
    REQUIRE(error.has_value());
    return *error;
}

inline bool agree(double a, double b, double tolerance) { return std::abs(a - b) <= tolerance * std::max(a, b); }

/// A smooth function without symmetries.
template <int D>
double wave(const Vec<D>& x) {
    double phase = 0.3;
    for (int c = 0; c < D; ++c) phase += (0.7 + 0.2 * c) * x[c];
    return std::sin(phase) + 0.2 * x[0] * std::cos(x[1]);
}

}  // namespace camber::testing
