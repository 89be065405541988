module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.recipes;
import camber.core;

namespace camber::run {

Series counted(std::string name, std::span<const double> limits, std::span<const double> values) {
    Series series{.name = std::move(name), .counts = std::vector<std::size_t>(limits.size() + 1), .extremes = {}};
    double sum = 0;
    std::size_t finite = 0;
    for (const double x : values) {
        if (std::isnan(x)) {
            ++series.not_numbers;
            continue;
        }
        const auto bin = std::upper_bound(limits.begin(), limits.end(), x) - limits.begin();
        ++series.counts[static_cast<std::size_t>(bin)];
        if (!std::isfinite(x)) continue;
        sum += x;
        ++finite;
        const Extremes so_far = series.extremes.value_or(Extremes{x, x});
        series.extremes = Extremes{std::fmin(so_far.least, x), std::fmax(so_far.greatest, x)};
    }
    if (finite > 0) series.mean = sum / static_cast<double>(finite);
    return series;
}

const Series* find_series(const Histogram& histogram, std::string_view name) {
    for (const Series& s : histogram.series)
        if (s.name == name) return &s;
    return nullptr;
}

namespace {

constexpr std::array<QuantityInfo, quantity_count> infos{{
    {Quantity::length_reduction, "length_reduction", "Length reduction", "length of the chord / length of the edge - 1",
     "volume edges", 10},
    {Quantity::length, "riemannian_length", "Riemannian length", "length in the metric", "volume edges", 2},
    {Quantity::curvature, "curvature", "Curvature", "offset of the node / length of the chord", "volume edges", 10},
    {Quantity::scaled_jacobian, "scaled_jacobian", "Scaled Jacobian", "smallest det J / det J of the straight element",
     "elements", 10},
    {Quantity::quality, "quality", "Quality", "mean ratio: 1 equilateral, 0 flat, negative inverted", "elements", 10},
    {Quantity::edge_length, "edge_length", "Edge length", "length in the metric, of the straight edge", "edges", 2},
    {Quantity::metric_quality, "metric_quality", "Quality in the metric",
     "mean ratio in the metric: 1 unit, 0 flat, negative inverted", "elements", 10},
    {Quantity::curved_edge_length, "curved_edge_length", "Length of curved edges",
     "length in the metric, along the curve", "edges", 2},
    {Quantity::curved_metric_quality, "curved_metric_quality", "Quality of curved elements in the metric",
     "1 over the mean distortion: 1 unit, 0 folded, negative inverted", "elements", 10},
}};

/// Returns m · 10^k. Both operands are exact, so that the result is rounded once, as its decimal literal.
double decimal(double m, int k) {
    double power = 1;
    for (int i = 0; i < std::abs(k); ++i) power *= 10;
    return k < 0 ? m / power : m * power;
}

void add_decades(std::vector<double>& limits, int first, int last, std::initializer_list<double> leads) {
    for (int k = first; k < last; ++k)
        for (const double lead : leads) limits.push_back(decimal(lead, k));
    limits.push_back(decimal(1, last));
}

std::vector<double> of_reductions() {
    std::vector<double> limits{-0.1, -0.01, -0.001, 0, 1e-5, 1e-4};
    add_decades(limits, -3, 2, {1, 1.5, 2, 3, 5, 7});
    return limits;
}

std::vector<double> of_curvatures() {
    std::vector<double> limits{0};
    add_decades(limits, -3, 1, {1, 1.5, 2, 3, 5, 7});
    return limits;
}

std::vector<double> of_lengths() {
    constexpr int most = 10, fine = 3;
    std::vector<double> limits;
    for (int i = -most; i < -fine; ++i) limits.push_back(exp2(i));
    for (int i = -4 * fine; i <= 4 * fine; ++i) limits.push_back(exp2(i / 4.0));
    for (int i = fine + 1; i <= most; ++i) limits.push_back(exp2(i));
    return limits;
}

/// There is no limit at 0.01: elements relaxed to the recommended bound lie on both sides of it and belong together.
std::vector<double> of_jacobians() {
    std::vector<double> limits{-10, -1, -0.1, -0.01, -0.001, -1e-6, -1e-9, 0};
    add_decades(limits, -9, -3, {1});
    for (const double x : {0.005, 0.02}) limits.push_back(x);
    for (int i = 1; i <= 20; ++i) limits.push_back(i / 20.0);
    return limits;
}

}  // namespace

const QuantityInfo& info(Quantity quantity) { return infos[static_cast<std::size_t>(quantity)]; }

std::vector<double> limits_of(Quantity quantity) {
    switch (quantity) {
        case Quantity::length_reduction: return of_reductions();
        case Quantity::length:
        case Quantity::edge_length:
        case Quantity::curved_edge_length: return of_lengths();
        case Quantity::curvature: return of_curvatures();
        case Quantity::scaled_jacobian:
        case Quantity::quality:
        case Quantity::metric_quality:
        case Quantity::curved_metric_quality: return of_jacobians();
    }
    return {};
}

}  // namespace camber::run
