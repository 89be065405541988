// The figures of docs/algorithms/metric-from-solution.md. They take minutes and check nothing:
//     build/bin/test_solution_metric --no-skip -tc='figures*'
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <span>
#include <utility>
#include <vector>

#include "cubic_oracle.hpp"
#include "dice.hpp"
#include "layers.hpp"
#include "property.hpp"
#include "random_forms.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.solution_metric;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
void qualities(double anisotropy, int count) {
    Dice dice(3);
    const CubicModels<D> best({.max_anisotropy = 1e10}), cheap({.bound = CubicBound::diagonal, .max_anisotropy = 1e10});
    std::array<std::vector<double>, 2> shares;
    for (int i = 0; i < count; ++i) {
        const auto t = random_form<D>(dice, anisotropy);
        const std::array both{best(t).logs, cheap(t).logs};
        double least = oracle_least_log_det<D>(t, frame_by_entries(t));
        for (const auto& logs : both) least = std::min(least, oracle_least_log_det<D>(t, frame_of(logs)));
        for (std::size_t k = 0; k < 2; ++k) shares[k].push_back(std::exp(log_det(both[k]) - least));
    }
    for (auto& s : shares) std::sort(s.begin(), s.end());
    const std::size_t half = shares[0].size() / 2, last = shares[0].size() - 1;
    std::printf("%dD, anisotropy %g, %d forms: optimal %.4f, worst %.4f; diagonal %.2f, worst %.2f\n", D, anisotropy,
                count, shares[0][half], shares[0][last], shares[1][half], shares[1][last]);
}

/// CPU seconds, summed over threads.
double seconds_of(const auto& work) {
    const std::clock_t begin = std::clock();
    work();
    return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

template <int D>
void speeds(const char* name, const ModelOptions& options, bool of_fronts) {
    Dice dice(5);
    Buffer<CubicForm<D>> forms;
    for (int i = 0; i < 4000; ++i)
        forms.push_back(of_fronts ? front_form<D>(dice.direction<D>(), dice.uniform(-0.05, 0.05))
                                  : random_form<D>(dice, std::pow(10.0, dice.uniform(0, 5))));
    const Column<CubicForm<D>> column(std::move(forms));
    double least = 1e300;
    for (int i = 0; i < 5; ++i)
        least = std::min(least, seconds_of([&] { (void)must(cubic_models<D>(column, options, one_thread)); }));
    std::printf("%dD, %s, %s: %.0f models a second\n", D, name, of_fronts ? "fronts" : "random forms",
                static_cast<double>(column.size()) / least);
}

/// u = tanh(s/0.03) with s the distance from the sphere of radius 1.4 around (−½, −½, −½).
template <int D>
struct Front {
    Column<Sym<D>> hessians;
    Column<CubicForm<D>> thirds;

    explicit Front(const LinearMesh<D>& mesh) {
        Buffer<Sym<D>> h;
        Buffer<CubicForm<D>> t;
        for (const Vec<D>& p : mesh.points) {
            Vec<D> x = p;
            for (double& c : x.c) c += 0.5;
            const double w = 0.03, r = norm(x), th = std::tanh((r - 1.4) / w), d = 1 - th * th;
            const double f1 = d / w, f2 = -2 * th * d / (w * w), f3 = (4 * th * th * d - 2 * d * d) / (w * w * w);
            const Vec<D> n = x / r;
            Sym<D> hessian = f1 / r * Sym<D>::identity();
            for (int i = 0; i < D; ++i)
                for (int j = 0; j <= i; ++j) hessian(i, j) += (f2 - f1 / r) * n[i] * n[j];
            h.push_back(hessian);
            t.push_back(f3 * front_form<D>(n, 0) +
                        (f2 - f1 / r) / r * (front_form<D>(n, 1) + -1 * front_form<D>(n, 0)));
        }
        hessians = std::move(h);
        thirds = std::move(t);
    }
};

void print_metric(const char* what, double seconds, const SolutionMetric<3>& metric) {
    std::printf("  %s: %.2f s, complexity %.1f of %.0f, %d evaluations, %d gradations\n", what, seconds, metric.reached,
                metric.requested, metric.evaluations, metric.gradations);
}

/// The time of gap metrics: a plate of six cells, where most vertices are on the boundary.
void gaps() {
    const auto mesh = box_with_facets<3>({170, 170, 6}, 1, 0);
    auto points = take(Column<Vec<3>>(mesh.points));
    for (Vec<3>& p : points) p[2] = 0.02 * p[2] + 0.2 * p[0] * p[0] * p[1];
    auto plate = mesh;
    plate.points = std::move(points);
    const auto patches = patches_of(mesh);
    MetricsAtVertices<3> metrics;
    const double seconds = seconds_of([&] { metrics = must(gap_metrics<3>(plate, patches, {4}, 0.1, one_thread)); });
    std::printf("%zu tetrahedra, %zu facets: gaps at %zu vertices, %.2f s\n", mesh.elements.size(), mesh.facets.size(),
                metrics.vertices.size(), seconds);
}

}  // namespace

TEST_CASE("figures: the ratio of the models to the optimum is printed" * doctest::skip()) {
    for (const double a : {1.0, 1e2, 1e4, 1e6}) {
        qualities<2>(a, 20);
        qualities<3>(a, 20);
    }
}
TEST_CASE("figures: the number of models per second is printed" * doctest::skip()) {
    for (const bool of_fronts : {false, true}) {
        speeds<2>("optimal", {}, of_fronts);
        speeds<3>("optimal", {}, of_fronts);
        speeds<2>("diagonal", {.bound = CubicBound::diagonal}, of_fronts);
        speeds<3>("diagonal", {.bound = CubicBound::diagonal}, of_fronts);
    }
}
TEST_CASE("figures: the time of composition is printed" * doctest::skip()) {
    const auto mesh = box_with_facets<3>(46, 1, 0.2);
    const auto edges = must(unique_edges(mesh, one_thread));
    const Front<3> front(mesh);
    const double n = 5e4;
    LocalModels<3> cubic, hessian;
    const double cubic_seconds = seconds_of([&] { cubic = must(cubic_models<3>(front.thirds, {}, one_thread)); });
    const double hessian_seconds =
        seconds_of([&] { hessian = must(hessian_models<3>(front.hessians, {}, one_thread)); });
    std::printf("%zu vertices, %zu tetrahedra: models %.2f s (third derivatives), %.3f s (Hessians)\n",
                mesh.points.size(), mesh.elements.size(), cubic_seconds, hessian_seconds);
    const std::array fields{SolutionField<3>{cubic.rows}, SolutionField<3>{hessian.rows, {.degree = 1}, 0.5}};
    const SolutionMetricOptions plain{.amount = n, .max_size = 0.3},
        graded{.amount = n, .max_size = 0.3, .gradation = GradationOptions{}};
    const Column<LogMetric<3>> fixed(
        Buffer<LogMetric<3>>(mesh.points.size(), LogMetric<3>{-2 * std::log(0.1) * Sym<3>::identity()}));
    const auto compose = [&](const char* what, std::size_t count, const Column<LogMetric<3>>& with,
                             const SolutionMetricOptions& options) {
        SolutionMetric<3> metric;
        const double seconds = seconds_of([&] {
            metric =
                must(make_solution_metric<3>(mesh, edges, std::span(fields).first(count), with, options, one_thread));
        });
        print_metric(what, seconds, metric);
    };
    compose("one field", 1, {}, plain);
    compose("two fields, a fixed metric", 2, fixed, plain);
    compose("one field, gradation 1.5", 1, {}, graded);
    compose("two fields, a fixed metric, gradation 1.5", 2, fixed, graded);
    const auto straight = must(elevate(LinearMesh<3>(mesh), one_thread));
    const auto h = must(element_means<Sym<3>, 3>(mesh, front.hessians, one_thread));
    const auto t = must(element_means<CubicForm<3>, 3>(mesh, front.thirds, one_thread));
    const auto ball = must(balls(mesh, one_thread));
    LocalModels<3> of_elements;
    const double elements =
        seconds_of([&] { of_elements = must(curved_cubic_models<3>(straight, h, t, {}, one_thread)); });
    const double means = seconds_of(
        [&] { (void)must(models_at_vertices<3>(mesh, ball, of_elements.rows, {{}, n, diameter(mesh)}, one_thread)); });
    std::printf("  models of elements %.2f s, brought to vertices %.2f s\n", elements, means);
}

TEST_CASE("figures: the time of gap metrics is printed" * doctest::skip()) { gaps(); }
