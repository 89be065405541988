#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <numeric>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "dice.hpp"
#include "property.hpp"

import camber.core;
import camber.recipes;
import camber.reports;

using namespace camber::run;

namespace {

std::size_t sum(const Series& s) { return std::accumulate(s.counts.begin(), s.counts.end(), std::size_t{0}); }

/// Random values of both signs with magnitudes from 1e-12 to 1000.
std::vector<double> some_values(camber::testing::Dice& dice) {
    std::vector<double> values(dice.below(200));
    for (double& x : values) x = std::copysign(std::pow(10, dice.uniform(-12, 3)), dice.uniform(-1, 3));
    return values;
}

std::size_t bin_of(std::span<const double> limits, double x) {
    std::size_t bin = 0;
    while (bin < limits.size() && x >= limits[bin]) ++bin;
    return bin;
}

}  // namespace

TEST_CASE("a histogram counts each value once, in its bin") {
    camber::testing::property("each value is counted once, in the bin that contains it", [](std::uint64_t seed) {
        camber::testing::Dice dice(seed);
        const auto values = some_values(dice);
        for (std::size_t q = 0; q < quantity_count; ++q) {
            const auto limits = limits_of(static_cast<Quantity>(q));
            const Series s = counted("count", limits, values);
            RC_ASSERT(sum(s) == values.size());
            RC_ASSERT(s.not_numbers == 0);
            for (std::size_t bin = 0; bin < s.counts.size(); ++bin) {
                const auto inside = std::count_if(values.begin(), values.end(), [&](double x) {
                    return (bin == 0 || x >= limits[bin - 1]) && (bin == limits.size() || x < limits[bin]);
                });
                RC_ASSERT(static_cast<std::size_t>(inside) == s.counts[bin]);
            }
        }
    });
}

TEST_CASE("the extremes of a histogram are values in the first and last used bin") {
    camber::testing::property(
        "the extremes are those of the values, in the first and last used bin", [](std::uint64_t seed) {
            camber::testing::Dice dice(seed);
            const auto values = some_values(dice);
            for (std::size_t q = 0; q < quantity_count; ++q) {
                const auto limits = limits_of(static_cast<Quantity>(q));
                const Series s = counted("count", limits, values);
                RC_ASSERT(s.extremes.has_value() == !values.empty());
                if (values.empty()) continue;
                const auto [least, greatest] = *s.extremes;
                RC_ASSERT(least == *std::min_element(values.begin(), values.end()));
                RC_ASSERT(greatest == *std::max_element(values.begin(), values.end()));
                RC_ASSERT(least <= s.mean && s.mean <= greatest);
                const auto is_used = [](std::size_t count) { return count > 0; };
                const auto first = std::find_if(s.counts.begin(), s.counts.end(), is_used);
                const auto last = std::find_if(s.counts.rbegin(), s.counts.rend(), is_used);
                RC_ASSERT(static_cast<std::size_t>(first - s.counts.begin()) == bin_of(limits, least));
                RC_ASSERT(static_cast<std::size_t>(s.counts.rend() - last) == bin_of(limits, greatest) + 1);
            }
        });
}

TEST_CASE("infinite values count in the outer bins and NaN values separately") {
    camber::testing::property("infinite values count in the outer bins, NaN values in no bin", [](std::uint64_t seed) {
        constexpr double inf = std::numeric_limits<double>::infinity();
        camber::testing::Dice dice(seed);
        auto values = some_values(dice);
        const auto limits = limits_of(static_cast<Quantity>(dice.below(quantity_count)));
        const Series finite = counted("count", limits, values);
        const std::size_t low = dice.below(3), high = dice.below(3), none = dice.below(3);
        values.insert(values.end(), low, -inf);
        values.insert(values.end(), high, inf);
        values.insert(values.end(), none, std::nan(""));
        const Series s = counted("count", limits, values);
        RC_ASSERT(sum(s) + s.not_numbers == values.size());
        RC_ASSERT(s.not_numbers == none);
        RC_ASSERT(s.counts.front() == finite.counts.front() + low);
        RC_ASSERT(s.counts.back() == finite.counts.back() + high);
        RC_ASSERT(s.extremes == finite.extremes);
        RC_ASSERT(s.mean == finite.mean);
    });
}

TEST_CASE("histogram counts do not depend on the order of the values") {
    camber::testing::property("the counts do not depend on the order of the values", [](std::uint64_t seed) {
        camber::testing::Dice dice(seed);
        auto values = some_values(dice);
        const auto limits = limits_of(Quantity::length);
        const auto before = counted("count", limits, values).counts;
        std::shuffle(values.begin(), values.end(), dice.engine());
        RC_ASSERT(counted("count", limits, values).counts == before);
    });
}

TEST_CASE("bars and SVG pictures show the extremes of every series") {
    camber::testing::property("bars and pictures show the extremes of each series", [](std::uint64_t seed) {
        camber::testing::Dice dice(seed);
        for (std::size_t q = 0; q < quantity_count; ++q) {
            Histogram h{static_cast<Quantity>(q), limits_of(static_cast<Quantity>(q)), {}};
            h.series = {counted("before", h.limits, some_values(dice)), counted("after", h.limits, some_values(dice))};
            const std::string picture = svg(h);
            RC_ASSERT(picture.starts_with("<svg ") && picture.ends_with("</svg>\n"));
            RC_ASSERT(picture.find("nan") == std::string::npos && picture.find("inf") == std::string::npos);
            const bool empty = sum(h.series[0]) + sum(h.series[1]) == 0;
            const std::string rows = bars(h);
            RC_ASSERT(rows.find(empty ? "nothing to count" : "after correction") != std::string::npos);
            for (const Series& s : h.series) {
                if (!s.extremes) continue;
                const auto shown = [&](const std::string& text, double extreme) {
                    return text.find(fmt::format("{:.4g}", extreme)) != std::string::npos;
                };
                RC_ASSERT(shown(picture, s.extremes->least) && shown(picture, s.extremes->greatest));
                const bool is_bound = h.quantity == Quantity::scaled_jacobian;  // printed rounded down
                RC_ASSERT(is_bound || (shown(rows, s.extremes->least) && shown(rows, s.extremes->greatest)));
            }
        }
    });
}

// Guards against histograms with nearly all values in one bin.
TEST_CASE("values in the tails fall into different bins") {
    const auto bins = [](Quantity quantity, const std::vector<double>& values) {
        std::set<std::size_t> used;
        for (const double x : values) used.insert(bin_of(limits_of(quantity), x));
        return used.size();
    };
    const std::vector<double> jacobians{-100, -5,   -0.5, -0.05, -1e-3 / 2, -1e-12, 0,
                                        1e-9, 1e-8, 1e-5, 1e-3,  0.04,      0.5,    1};
    CHECK(bins(Quantity::scaled_jacobian, jacobians) == jacobians.size());
    CHECK(bins(Quantity::quality, jacobians) == jacobians.size());
    // Values on both sides of the default bound share a bin: relaxed elements lie at the bound.
    CHECK(bins(Quantity::scaled_jacobian, {0.00999, 0.01, 0.01001}) == 1);
    const std::vector<double> gains{-0.5, -0.05, -1e-5, 0, 1e-5, 0.001, 0.01, 0.1, 0.5, 1, 3, 10, 30, 1000};
    CHECK(bins(Quantity::length_reduction, gains) == gains.size());
    const std::vector<double> curvatures{0, 0.001, 0.01, 0.1, 0.5, 1, 2, 5, 20};
    CHECK(bins(Quantity::curvature, curvatures) == curvatures.size());
    const std::vector<double> lengths{1e-4, 1e-2, 0.1, 0.5, 0.8, 1, 1.2, 2, 10, 100, 1e4};
    CHECK(bins(Quantity::length, lengths) == lengths.size());
}

TEST_CASE("a histogram shows a few of many values with their number") {
    std::vector<double> values(100000, 0.5);
    values.insert(values.end(), 7, 1e-7);
    Histogram h{Quantity::scaled_jacobian, limits_of(Quantity::scaled_jacobian), {}};
    h.series = {counted("count", h.limits, values)};
    CHECK(svg(h).find(">7</text>") != std::string::npos);
    CHECK(svg(h).find("height=\"0.0") == std::string::npos);
    CHECK(bars(h).find("1e-07 to 1e-06          7 ▏") != std::string::npos);
    CHECK(bars(h).find("1e-06 to 0.5          0\n") != std::string::npos);  // empty bins share a row
}

TEST_CASE("bin limits increase and equal the documented numbers") {
    for (std::size_t q = 0; q < quantity_count; ++q) {
        const auto limits = limits_of(static_cast<Quantity>(q));
        CHECK(std::adjacent_find(limits.begin(), limits.end(), std::greater_equal<>()) == limits.end());
    }
    // The printed limits equal the limits bit for bit.
    for (const auto quantity : {Quantity::length_reduction, Quantity::curvature, Quantity::scaled_jacobian})
        for (const double limit : limits_of(quantity)) CHECK(std::stod(fmt::format("{:.2g}", limit)) == limit);
    CHECK(limits_of(Quantity::length_reduction).front() == -0.1);
    CHECK(limits_of(Quantity::length_reduction).back() == 100);
    CHECK(limits_of(Quantity::curvature).front() == 0);
    CHECK(limits_of(Quantity::curvature).back() == 10);
    CHECK(limits_of(Quantity::length).front() == 1.0 / 1024);
    CHECK(limits_of(Quantity::length).back() == 1024);
    CHECK(limits_of(Quantity::scaled_jacobian).front() == -10);
    CHECK(limits_of(Quantity::scaled_jacobian).back() == 1);
}

TEST_CASE("histograms are read back from a report") {
    Report report;
    Histogram h{Quantity::length, limits_of(Quantity::length), {}};
    h.series = {counted("straight", h.limits, std::vector<double>{0.7, 1.3}),
                counted("before", h.limits, std::vector<double>{0.6, 1.1})};
    h.series[1].not_numbers = 3;
    report.histograms = {h};
    const auto back = histograms_of_report(to_json(report));
    REQUIRE(back.has_value());
    CHECK(*back == report.histograms);
    // A report without extremes, and one with contradictory extremes.
    const auto older = histograms_of_report(
        R"({"histograms": {"curvature": {"edges": [0, 1], "count": [1, 2, 0], "mean": {"count": 0}}}})");
    REQUIRE(older.has_value());
    CHECK(older->front().series == std::vector{Series{"count", {1, 2, 0}, 0, {}, 0}});
    CHECK_FALSE(histograms_of_report(R"({"histograms": {"curvature": {"edges": [0, 1], "count": [1, 2, 0],
        "mean": {"count": 0}, "min": {"count": 1}, "max": {"count": 0}}}})")
                    .has_value());
    CHECK_FALSE(histograms_of_report("{}").has_value());
    CHECK_FALSE(histograms_of_report("no json").has_value());
    CHECK_FALSE(
        histograms_of_report(R"({"histograms": {"curvature": {"edges": [0, 1], "count": [1], "mean": {"count": 0}}}})")
            .has_value());
}
