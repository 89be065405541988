// Optimisation problems of one edge: six tetrahedra around it, with their other nodes slightly off the midpoints.
// items_per_second counts problems.
#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;

using namespace camber;

namespace {

EdgeShell<3> ring(std::mt19937_64& random, double amplitude) {
    constexpr int count = 6;
    const auto uniform = [&] { return amplitude * (2 * (static_cast<double>(random() >> 11) * 0x1p-53) - 1); };
    std::vector<Vec<3>> points{{{0, 0, -0.6}}, {{0, 0, 0.6}}};
    points.reserve(2 + count);
    for (int i = 0; i < count; ++i) {
        const double angle = 2 * std::numbers::pi * i / count;
        points.push_back({{std::cos(angle), std::sin(angle), 0}});
    }
    std::vector<std::vector<Vec<3>>> nodes(points.size(), std::vector<Vec<3>>(points.size()));
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t j = 0; j <= i; ++j)
            nodes[i][j] = nodes[j][i] = midpoint(points[i], points[j]) + Vec<3>{{uniform(), uniform(), uniform()}};
    EdgeShell<3> shell{{nodes[0][1]}, {}};
    shell.elements.reserve(count);
    for (int i = 0; i < count; ++i) {
        const std::array<int, 4> v{0, 1, 2 + i, 2 + (i + 1) % count};
        ShellElement<3> s;
        for (int k = 0; k < 4; ++k) s.element.nodes[k] = nodes[v[k]][v[k]];
        for (int e = 0; e < 6; ++e) s.element.nodes[4 + e] = nodes[v[local_edges<3>[e][0]]][v[local_edges<3>[e][1]]];
        shell.elements.push_back(s);
    }
    return shell;
}

const std::vector<EdgeShell<3>>& rings() {
    static const std::vector<EdgeShell<3>> shells = [] {
        std::mt19937_64 random(1);
        std::vector<EdgeShell<3>> all;
        all.reserve(256);
        for (int i = 0; i < 256; ++i) all.push_back(ring(random, 0.15));
        return all;
    }();
    return shells;
}

template <class Program>
void run(benchmark::State& state, Program&& program) {
    std::size_t i = 0;
    for (auto _ : state) benchmark::DoNotOptimize(program(rings()[i++ % rings().size()]));
    state.SetItemsProcessed(state.iterations());
}

void coefficients_alone(benchmark::State& state) {
    run(state, [](const EdgeShell<3>& s) {
        double sum = 0;
        for (const auto& e : s.elements) sum += affine_jacobian(e.element, e.edge).error;
        return sum;
    });
}

void highest_by_coefficients(benchmark::State& state) {
    run(state, [](const EdgeShell<3>& s) { return max_min_node(s, {.max_cuts = 0}); });
}

void highest_with_cuts(benchmark::State& state) {
    run(state, [](const EdgeShell<3>& s) { return max_min_node(s); });
}

QuadraticModel<3> model(const EdgeShell<3>& s, double away) {
    return {s.node.point + Vec<3>{{away, 0.5 * away, 0.2 * away}}, Sym<3>::diagonal({{1, 2, 4}}), 1};
}

void nearest_inside(benchmark::State& state) {
    run(state, [](const EdgeShell<3>& s) { return nearest_node(s, model(s, 0.02), 0); });
}

void nearest_held_back(benchmark::State& state) {
    run(state, [](const EdgeShell<3>& s) { return nearest_node(s, model(s, 0.5), 0, {.max_cuts = 0}); });
}

void nearest_with_cuts(benchmark::State& state) {
    run(state, [](const EdgeShell<3>& s) { return nearest_node(s, model(s, 0.5), 0); });
}

BENCHMARK(coefficients_alone);
BENCHMARK(highest_by_coefficients);
BENCHMARK(highest_with_cuts);
BENCHMARK(nearest_inside);
BENCHMARK(nearest_held_back);
BENCHMARK(nearest_with_cuts);

}  // namespace
