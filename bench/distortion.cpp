// Quality of curved elements in a metric (metric:unit_mesh): error of the 8-point rule against a dense rule, tightness
// of the bound, and cost of each. The program takes an argument and is not a timed test:
//
//     distortion [elements per family, 2000]
#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string_view>
#include <vector>

#include "dice.hpp"

import camber.core;
import camber.bezier;
import camber.metric;

using namespace camber;
using camber::testing::Dice;

namespace {

template <int D>
struct Element {
    QuadraticNodes<D> nodes;
    VertexLogMetrics<D> metrics;
};

/// Returns an element near the regular simplex. Nodes are displaced by up to `bent` edge lengths per coordinate,
/// entries of log M by up to `change`.
template <int D>
Element<D> element_of(Dice& dice, double bent, double change) {
    const Mat<D> w = regular_simplex<D>();
    Element<D> e;
    for (int i = 0; i <= D; ++i) e.nodes[i] = (i > 0 ? w.column[i - 1] : Vec<D>{}) + dice.vector<D>(-0.1, 0.1);
    for (int k = 0; k < edges_per_simplex<D>; ++k)
        e.nodes[D + 1 + k] =
            midpoint(e.nodes[local_edges<D>[k][0]], e.nodes[local_edges<D>[k][1]]) + dice.vector<D>(-bent, bent);
    for (LogMetric<D>& m : e.metrics) m.l = dice.symmetric<D>(change);
    return e;
}

/// Returns an element of a layer of anisotropy 1000 around a cylinder (2D: a circle). The sagitta of an edge is
/// `sagitta` layer heights. Edges follow the layer if `curved`, otherwise they are straight.
template <int D>
Element<D> layer_of(Dice& dice, double sagitta, bool curved) {
    constexpr double height = 1e-3;
    const double radius = 1 / (8 * sagitta * height);
    const Mat<D> turn = dice.rotation<D>();
    std::array<Vec<D>, D + 1> at;
    for (int i = 0; i <= D; ++i)
        at[i] = turn * ((i > 0 ? regular_simplex<D>().column[i - 1] : Vec<D>{}) + dice.vector<D>(-0.1, 0.1));
    const auto placed = [&](const Vec<D>& u) {
        Vec<D> x = u;
        const double angle = u[0] / radius;
        const double normal = radius + height * u[D - 1];
        x[0] = normal * std::sin(angle);
        x[D - 1] = normal * std::cos(angle) - radius;
        return x;
    };
    Element<D> e;
    for (int i = 0; i <= D; ++i) {
        e.nodes[i] = placed(at[i]);
        const double angle = at[i][0] / radius;
        Mat<D> axes = Mat<D>::identity();
        axes(0, 0) = axes(D - 1, D - 1) = std::cos(angle);
        axes(0, D - 1) = std::sin(angle);
        axes(D - 1, 0) = -std::sin(angle);
        Vec<D> sizes;
        for (double& h : sizes.c) h = 1;
        sizes[D - 1] = height;
        e.metrics[i] = log_metric_of_sizes<D>(sizes, axes);
    }
    for (int k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        e.nodes[D + 1 + k] = curved ? placed(midpoint(at[i], at[j])) : midpoint(e.nodes[i], e.nodes[j]);
    }
    return e;
}

/// Mean and minimum over 12 collapsed Gauss points per direction.
struct Dense {
    double mean = 0, minimum = 1;
};
template <int D>
Dense dense_quality(const Element<D>& e) {
    static const Quadrature rule = gauss_legendre(12);
    double distortion = 0, volume = 0;
    Dense out;
    const auto visit = [&](auto&& self, Barycentric<D> xi, int direction, double remaining, double weight) -> void {
        if (direction == 0) {
            xi[0] = remaining;
            const double quality = quality_at<D>(e.nodes, e.metrics, xi);
            out.minimum = std::min(out.minimum, quality);
            distortion += weight / quality;
            volume += weight;
            return;
        }
        for (std::size_t q = 0; q < rule.size(); ++q) {
            xi[direction] = remaining * rule.t[q];
            self(self, xi, direction - 1, remaining * (1 - rule.t[q]),
                 weight * rule.w[q] * std::pow(1 - rule.t[q], direction - 1));
        }
    };
    visit(visit, {}, D, 1, 1);
    out.mean = out.minimum > 0 ? volume / distortion : 0;
    return out;
}

template <int D, class Make>
void row(const char* name, std::size_t count, Make&& make) {
    Dice dice(1);
    double mean = 0, error = 0, largest = 0;
    std::size_t n = 0;
    constexpr std::array<int, 4> efforts{0, 16, 64, 128};
    std::array<double, efforts.size()> shares{};
    for (std::size_t i = 0; i < count; ++i) {
        const Element<D> e = make(dice);
        const Dense dense = dense_quality<D>(e);
        const double quality = curved_quality<D>(e.nodes, element_metric<D>(e.metrics)).mean;
        if (!(dense.mean > 0) || !(quality > 0)) continue;
        ++n;
        mean += dense.mean;
        const double off = std::abs(quality / dense.mean - 1);
        error += off;
        largest = std::max(largest, off);
        for (std::size_t k = 0; k < efforts.size(); ++k)
            shares[k] +=
                std::max(0.0, bound_quality<D>(e.nodes, e.metrics, {.share = 1, .bisections = efforts[k]}).bound /
                                  dense.minimum);
    }
    const double all = static_cast<double>(n);
    std::printf("%dD %-34s %6zu %8.4f %10.1e %10.1e   ", D, name, n, mean / all, error / all, largest);
    for (const double share : shares) std::printf(" %5.3f", share / all);
    std::printf("\n");
}

template <int D>
void rows(std::size_t count) {
    row<D>("constant, bent by 0.05", count, [](Dice& d) { return element_of<D>(d, 0.05, 0); });
    row<D>("constant, bent by 0.1", count, [](Dice& d) { return element_of<D>(d, 0.1, 0); });
    row<D>("straight, log M varies by 0.5", count, [](Dice& d) { return element_of<D>(d, 0, 0.5); });
    row<D>("straight, log M varies by 1", count, [](Dice& d) { return element_of<D>(d, 0, 1); });
    row<D>("bent by 0.05, log M varies by 0.5", count, [](Dice& d) { return element_of<D>(d, 0.05, 0.5); });
    row<D>("layer, sagitta 0.25, curved", count, [](Dice& d) { return layer_of<D>(d, 0.25, true); });
    row<D>("layer, sagitta 0.25, straight", count, [](Dice& d) { return layer_of<D>(d, 0.25, false); });
    row<D>("layer, sagitta 1, curved", count, [](Dice& d) { return layer_of<D>(d, 1, true); });
    row<D>("layer, sagitta 1, straight", count, [](Dice& d) { return layer_of<D>(d, 1, false); });
}

/// Returns the minimum time of several runs in nanoseconds per item.
template <class F>
double nanoseconds(std::size_t items, F&& f) {
    double best = HUGE_VAL;
    for (int run = 0; run < 15; ++run) {
        const auto begin = std::chrono::steady_clock::now();
        f();
        const std::chrono::duration<double, std::nano> spent = std::chrono::steady_clock::now() - begin;
        best = std::min(best, spent.count() / static_cast<double>(items));
    }
    return best;
}

template <int D>
void costs() {
    Dice dice(2);
    constexpr std::size_t n = 4000;
    std::vector<Element<D>> elements;
    std::vector<ElementMetric<D>> metrics;
    elements.reserve(n);
    metrics.reserve(n);
    for (std::size_t i = 0; i < n; ++i) {
        elements.push_back(layer_of<D>(dice, 0.25, true));
        metrics.push_back(element_metric<D>(elements.back().metrics));
    }
    double sum = 0;
    const auto print_time = [&](const char* what, std::size_t items, auto&& f) {
        std::printf("%dD %-52s %8.0f ns\n", D, what, nanoseconds(items, [&] {
                        for (std::size_t i = 0; i < items; ++i) sum += f(i);
                    }));
    };
    const auto corners = [&](std::size_t i) {
        std::array<Vec<D>, D + 1> c;
        for (int k = 0; k <= D; ++k) c[k] = elements[i].nodes[k];
        return c;
    };
    std::array<MeasuringMetric<D>, D + 1> measures;
    std::array<const MeasuringMetric<D>*, D + 1> at{};
    for (int k = 0; k <= D; ++k) {
        measures[k] = MeasuringMetric<D>(elements[0].metrics[k]);
        at[k] = &measures[k];
    }
    print_time("metric_quality (straight, metrics ready)", n,
               [&](std::size_t i) { return metric_quality<D>(corners(i), at); });
    print_time("element_metric", n,
               [&](std::size_t i) { return element_metric<D>(elements[i].metrics).root[0][0][0]; });
    print_time("curved_quality, metric ready", n,
               [&](std::size_t i) { return curved_quality<D>(elements[i].nodes, metrics[i]).mean; });
    print_time("curved_quality_gradient, metric ready", n, [&](std::size_t i) {
        return curved_quality_gradient<D>(elements[i].nodes, metrics[i]).by_node[D + 1][0];
    });
    for (const Instructions set : {Instructions::baseline, Instructions::avx2})
        if (has(set))
            print_time(
                set == Instructions::baseline ? "element_metric + curved_quality, SSE2"
                                              : "element_metric + curved_quality, AVX2",
                n, [&](std::size_t i) {
                    return curved_quality<D>(elements[i].nodes, element_metric<D>(elements[i].metrics, set), set).mean;
                });
    for (const int bisections : {0, 16})
        print_time(
            bisections == 0 ? "bound_quality, no bisection" : "bound_quality, 16 bisections", 400, [&](std::size_t i) {
                return bound_quality<D>(elements[i].nodes, elements[i].metrics, {.share = 1, .bisections = bisections})
                    .bound;
            });
    std::vector<MeasuringMetric<D>> ends;
    ends.reserve(n);
    for (const Element<D>& e : elements) ends.emplace_back(e.metrics[1]);
    print_time("edge_length, straight, metrics ready", n, [&](std::size_t i) {
        return edge_length(measures[0], ends[i], elements[i].nodes[1] - elements[i].nodes[0]);
    });
    print_time("bent_length, metrics ready", n, [&](std::size_t i) {
        const auto& p = elements[i].nodes;
        return quadratic_edge_length<D>({elements[0].metrics[0], measures[0]}, {elements[i].metrics[1], ends[i]},
                                        p[1] - p[0], p[D + 1] - midpoint(p[0], p[1]));
    });
    if (sum == 0) std::printf("\n");
}

}  // namespace

int main(int argc, char** argv) {
    std::size_t count = 2000;
    if (argc > 1) {
        const std::string_view text = argv[1];
        std::from_chars(text.data(), text.data() + text.size(), count);
    }
    std::printf("%-37s %6s %8s %10s %10s    bound / minimum after 0 16 64 128\n", "family", "of", "quality",
                "mean error", "largest");
    rows<2>(count);
    rows<3>(count);
    costs<2>();
    costs<3>();
}
