// Limit of the error increase for smooth functions: comparison with a second evaluation, and invariance.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
#include <rapidcheck.h>

#include "block.hpp"
#include "dice.hpp"
#include "meshes.hpp"
#include "property.hpp"

import camber.core;
import camber.curving;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
constexpr std::array<int, D> cells = [] {
    if constexpr (D == 2)
        return std::array<int, 2>{6, 8};
    else
        return std::array<int, 3>{3, 3, 6};
}();

template <int D>
std::vector<Vec<D>> random_offsets(const Block<D>& b, double size, std::uint64_t seed) {
    Dice dice(seed);
    std::vector<Vec<D>> offsets(b.mesh.edges.size());
    for (std::size_t e = 0; e < offsets.size(); ++e) {
        const auto& [p, q] = b.mesh.edges.vertices[EdgeId(e)];
        const double length = distance(b.mesh.linear.points[p], b.mesh.linear.points[q]);
        if (b.kinds[EdgeId(e)] == EdgeKind::volume) offsets[e] = size * length * dice.vector<D>(-1, 1);
    }
    return offsets;
}

/// The L2 part of the model, summed over elements: Σ_K |K|/n Σ_e (24 ℓ |e| |d|)² over Σ |K| h⁶.
template <int D>
double added_in_l2(const QuadraticMesh<D>& mesh, std::span<const Vec<D>> offsets) {
    double volume = 0, sixth = 0, added = 0;
    std::vector<double> volumes;
    std::vector<Vec<D>> centres;
    Vec<D> centre{};
    for (ElementId k(0); k.index() < mesh.linear.elements.size(); k = ElementId(k.index() + 1)) {
        const auto& v = mesh.linear.elements.vertices[k];
        Mat<D> edges;
        Vec<D> middle{};
        for (int i = 0; i <= D; ++i) middle += 1.0 / (D + 1) * mesh.linear.points[v[i]];
        for (int i = 0; i < D; ++i) edges.column[i] = mesh.linear.points[v[i + 1]] - mesh.linear.points[v[0]];
        volumes.push_back(std::abs(det(edges)) / (D == 2 ? 2 : 6));
        centres.push_back(middle);
        volume += volumes.back();
        centre += volumes.back() * middle;
        double square = 0, of_edges = 0;
        for (const EdgeId e : mesh.edges.of_elements[k]) {
            const auto& [p, q] = mesh.edges.vertices[e];
            const double length = distance(mesh.linear.points[p], mesh.linear.points[q]);
            square += length * length / edges_per_simplex<D>;
            of_edges += std::pow(24 * length * norm(offsets[e.index()]), 2) / edges_per_simplex<D>;
        }
        sixth += volumes.back() * std::pow(square, 3);
        added += volumes.back() * of_edges;
    }
    double gyration = 0;
    for (std::size_t k = 0; k < centres.size(); ++k)
        gyration += volumes[k] * norm_squared(centres[k] - 1 / volume * centre) / volume;
    return gyration * added / sixth;
}

template <int D>
void check_loss_limit() {
    property("limit_smooth_loss meets its limit, only shortens offsets and keeps cheap ones", [](std::uint64_t seed) {
        const auto b = shell_block<D>(cells<D>, seed + 1);
        Dice dice(seed);
        const double loss = dice.uniform(0.001, 0.2);
        const auto targets = random_offsets(b, std::exp(dice.uniform(-9, 0)), seed);
        auto limited = targets;
        const std::size_t halved = must(limit_smooth_loss<D>(b.mesh, b.shells, loss, limited, one_thread));
        RC_ASSERT(added_in_l2<D>(b.mesh, limited) <= 1.05 * ((1 + loss) * (1 + loss) - 1));
        std::size_t less_than_half = 0;
        for (std::size_t e = 0; e < limited.size(); ++e) {
            if (targets[e] == Vec<D>{}) continue;
            const double share = dot(limited[e], targets[e]) / norm_squared(targets[e]);
            RC_ASSERT(share >= 0 && share <= 1);
            RC_ASSERT(norm(limited[e] - share * targets[e]) <= 1e-14 * norm(targets[e]));
            less_than_half += share < 0.5;
        }
        RC_ASSERT(halved == less_than_half);
        auto small = random_offsets(b, 1e-7, seed);
        const auto before = small;
        RC_ASSERT(must(limit_smooth_loss<D>(b.mesh, b.shells, loss, small, one_thread)) == 0U);
        RC_ASSERT(small == before);
    });
    property("offsets are zero without a loss and independent of origin, unit and threads", [](std::uint64_t seed) {
        auto b = shell_block<D>(cells<D>, seed + 1);
        const auto targets = random_offsets(b, 0.1, seed);
        auto here = targets, none = targets, threads = targets;
        must(limit_smooth_loss<D>(b.mesh, b.shells, 0.02, here, one_thread));
        must(limit_smooth_loss<D>(b.mesh, b.shells, 0.02, threads, Execution{.threads = 3}));
        RC_ASSERT(threads == here);
        must(limit_smooth_loss<D>(b.mesh, b.shells, 0, none, one_thread));
        for (std::size_t e = 0; e < none.size(); ++e) RC_ASSERT(norm(none[e]) <= 1e-9 * norm(targets[e]));
        const double unit = std::exp2(Dice(seed).below(20));
        Buffer<Vec<D>> points(b.mesh.linear.points.begin(), b.mesh.linear.points.end());
        for (Vec<D>& p : points) {
            p *= unit;
            p[0] += 1e6 * unit;
        }
        b.mesh.linear.points = std::move(points);
        auto there = targets;
        for (Vec<D>& d : there) d *= unit;
        must(limit_smooth_loss<D>(b.mesh, b.shells, 0.02, there, one_thread));
        for (std::size_t e = 0; e < here.size(); ++e)
            RC_ASSERT(norm(1 / unit * there[e] - here[e]) <= 1e-3 * norm(targets[e]));
    });
}

}  // namespace

TEST_CASE("the error increase for smooth functions stays within its limit, 2D") { check_loss_limit<2>(); }
TEST_CASE("the error increase for smooth functions stays within its limit, 3D") { check_loss_limit<3>(); }
