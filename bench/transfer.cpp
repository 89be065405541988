// Measures the time of a field transfer between meshes and the error after twenty transfers back and forth:
//     build/bin/transfer [cells in 2D [cells in 3D [threads [points]]]]
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <ctime>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "meshes.hpp"
#include "restarts.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.transfer;

using namespace camber;
using namespace camber::testing;

namespace {

enum class Sides { straight, curved };

/// Returns the unit box with n cells per side and inner vertices displaced by up to a fifth of a cell. If curved, the
/// box is mapped by a wave.
template <int D>
QuadraticMesh<D> box(int n, std::uint64_t seed, Sides sides) {
    Dice dice(seed);
    LatticeOptions<D> options;
    options.cells.fill(n);
    options.place = [&](const Vec<D>& p) {
        Vec<D> x = p / n;
        for (int i = 0; i < D; ++i)
            if (p[i] > 0.5 && p[i] < n - 0.5) x[i] += dice.uniform(-0.2, 0.2) / n;
        return x;
    };
    const auto mesh = lattice_mesh(options);
    if (sides == Sides::straight) return must(elevate(LinearMesh<D>(mesh), one_thread));
    return mapped(mesh, [](const Vec<D>& p) { return wave<D>(p); });
}

/// Returns a smooth field and a front with a thickness of two cells.
template <int D>
TransferField fields_on(const QuadraticMesh<D>& mesh, int n) {
    Buffer<double> values;
    const auto put = [&](const Vec<D>& x) {
        double product = 1;
        for (int i = 0; i < D; ++i) product *= std::sin(std::numbers::pi * x[i] + i);
        values.push_back(product);
        values.push_back(std::tanh((norm(x) - 0.7) * n));
    };
    for (const Vec<D>& x : mesh.linear.points) put(x);
    for (const auto& node : mesh.mid_nodes) put(node.point);
    return {2, 2, std::move(values)};
}

double seconds_since(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

template <int D>
void drift(int n, Sides sides, int points) {
    const auto a = box<D>(n, 1, sides), b = box<D>(n, 2, sides);
    const auto begin = fields_on(a, n);
    for (const auto& method : words(TransferMethod{})) {
        TransferField field = begin;
        std::printf(
            "%dD, %d cells per side, %s, %.*s: largest and root mean square difference, change of the integral\n", D, n,
            sides == Sides::straight ? "straight" : "curved", static_cast<int>(method.word.size()), method.word.data());
        std::vector<double> first;
        for (int k = 1; k <= 10; ++k) {
            auto there = must(transfer<D>(a, std::vector{field}, b, {.method = method.value, .points = points}, {}));
            auto back = must(transfer<D>(b, there.fields, a, {.method = method.value, .points = points}, {}));
            field = back.fields[0];
            if (k == 1) first = there.statistics.integrals[0][0].before;
            if (k != 1 && k != 2 && k != 5 && k != 10) continue;
            double largest[2] = {0, 0}, square[2] = {0, 0};
            for (std::size_t i = 0; i < field.values.size(); ++i) {
                const double d = std::abs(field.values[i] - begin.values[i]);
                largest[i % 2] = std::max(largest[i % 2], d);
                square[i % 2] += d * d;
            }
            for (int c = 0; c < 2; ++c)
                std::printf("    %s after %2d: %.2e %.2e %+.1e%s", c == 0 ? "smooth" : "front", 2 * k, largest[c],
                            std::sqrt(2 * square[c] / static_cast<double>(field.values.size())),
                            back.statistics.integrals[0][0].after[c] / first[c] - 1, c == 0 ? "" : "\n");
        }
    }
}

template <int D>
void rate(int n, Sides sides, int threads, int points) {
    const auto a = box<D>(n, 1, sides), b = box<D>(n, 2, sides);
    const auto field = fields_on(a, n);
    for (const auto& method : words(TransferMethod{})) {
        const auto begin = std::chrono::steady_clock::now();
        const std::clock_t clock = std::clock();
        const auto out = must(
            transfer<D>(a, std::vector{field}, b, {.method = method.value, .points = points}, {.threads = threads}));
        const double seconds = seconds_since(begin);
        const double processor = static_cast<double>(std::clock() - clock) / CLOCKS_PER_SEC;
        const std::size_t nodes = b.linear.points.size() + b.edges.size();
        std::printf(
            "%dD, %zu elements, %zu nodes, %s, %.*s: %.2f s (%.2f CPU s), %.0f nodes per CPU second; "
            "%zu outside, %zu lost\n",
            D, b.linear.elements.size(), nodes, sides == Sides::straight ? "straight" : "curved",
            static_cast<int>(method.word.size()), method.word.data(), seconds, processor,
            static_cast<double>(nodes) / processor, out.statistics.outside, out.statistics.lost);
        std::fflush(stdout);
    }
}

}  // namespace

int main(int argc, char** argv) {
    const int in_2d = argc > 1 ? std::stoi(argv[1]) : 16, in_3d = argc > 2 ? std::stoi(argv[2]) : 8,
              threads = argc > 3 ? std::stoi(argv[3]) : 0,
              points = argc > 4 ? std::stoi(argv[4]) : TransferOptions{}.points;
    for (const Sides sides : {Sides::straight, Sides::curved}) {
        if (in_2d > 0) rate<2>(in_2d, sides, threads, points);
        if (in_3d > 0) rate<3>(in_3d, sides, threads, points);
        if (in_2d > 0 && in_2d <= 64) drift<2>(in_2d, sides, points);
        if (in_3d > 0 && in_3d <= 16) drift<3>(in_3d, sides, points);
    }
}
