// Curved meshes for the tests of degree-2 back meshes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "back.hpp"
#include "dice.hpp"
#include "meshes.hpp"
#include "restarts.hpp"

import camber.core;
import camber.bezier;
import camber.metric;

namespace camber::testing {

/// A random mesh with each node off its chord by up to a share of the chord.
template <int D>
QuadraticMesh<D> bent_mesh(std::uint64_t seed, Dice& dice, double share) {
    auto mesh = must(elevate(unit_box<D>(2, seed), one_thread));
    auto nodes = take(std::move(mesh.mid_nodes));
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        const double length = distance(mesh.linear.points[a], mesh.linear.points[b]);
        nodes[e].point += dice.vector<D>(-share * length, share * length);
    }
    mesh.mid_nodes = std::move(nodes);
    return mesh;
}

template <int D>
Column<LogMetric<D>> rough_logs(std::size_t n, Dice& dice) {
    Buffer<LogMetric<D>> logs(n);
    for (auto& log_metric : logs) log_metric.l = dice.symmetric<D>();
    return logs;
}

/// The P2 map by its Lagrange basis, independent of displacements.
template <int D>
Vec<D> point_in(const QuadraticMesh<D>& mesh, ElementId e, const std::array<double, D + 1>& xi) {
    Vec<D> x;
    for (int i = 0; i <= D; ++i) x += xi[i] * (2 * xi[i] - 1) * mesh.linear.points[mesh.linear.elements.vertices[e][i]];
    for (int k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        x += 4 * xi[i] * xi[j] * mesh.mid_nodes[mesh.edges.of_elements[e][k]].point;
    }
    return x;
}

template <int D>
std::array<double, D + 1> inner_place(Dice& dice) {
    std::array<double, D + 1> xi{};
    double sum = 0;
    for (double& u : xi) sum += u = dice.uniform(0.1, 1);
    for (double& u : xi) u /= sum;
    return xi;
}

/// A box mapped by `wave`, with nodes off their chords by a further share.
template <int D>
QuadraticMesh<D> wavy_mesh(int cells, std::uint64_t seed, Dice& dice, double share = 0.01) {
    auto mesh = mapped(unit_box<D>(cells, seed, 0.05), [](const Vec<D>& p) { return wave<D>(p); });
    auto nodes = take(std::move(mesh.mid_nodes));
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        const double length = distance(mesh.linear.points[a], mesh.linear.points[b]);
        nodes[e].point += dice.vector<D>(-share * length, share * length);
    }
    mesh.mid_nodes = std::move(nodes);
    return mesh;
}

}  // namespace camber::testing
