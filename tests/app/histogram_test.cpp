#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "property.hpp"

import camber.core;
import camber.run;

using namespace camber::run;

namespace {

std::size_t sum(const Series& s) { return std::accumulate(s.counts.begin(), s.counts.end(), std::size_t{0}); }

std::vector<double> some_values(camber::testing::Dice& dice) {
    std::vector<double> values(dice.below(200));
    for (double& x : values) x = dice.uniform(-1, 9);
    return values;
}

}  // namespace

TEST_CASE("histograms") {
    camber::testing::property("each value is counted once, in the bin that holds it", [](std::uint64_t seed) {
        camber::testing::Dice dice(seed);
        const auto values = some_values(dice);
        for (std::size_t q = 0; q < quantity_count; ++q) {
            const auto limits = limits_of(static_cast<Quantity>(q));
            const Series s = counted("count", limits, values);
            RC_ASSERT(sum(s) == values.size());
            for (std::size_t bin = 0; bin < s.counts.size(); ++bin) {
                const auto inside = std::count_if(values.begin(), values.end(), [&](double x) {
                    return (bin == 0 || x >= limits[bin - 1]) && (bin == limits.size() || x < limits[bin]);
                });
                RC_ASSERT(static_cast<std::size_t>(inside) == s.counts[bin]);
            }
        }
    });
    camber::testing::property("the order of the values does not matter for the counts", [](std::uint64_t seed) {
        camber::testing::Dice dice(seed);
        auto values = some_values(dice);
        const auto limits = limits_of(Quantity::length);
        const auto before = counted("count", limits, values).counts;
        std::shuffle(values.begin(), values.end(), dice.engine());
        RC_ASSERT(counted("count", limits, values).counts == before);
    });
    camber::testing::property("bars and pictures show every series", [](std::uint64_t seed) {
        camber::testing::Dice dice(seed);
        for (std::size_t q = 0; q < quantity_count; ++q) {
            Histogram h{static_cast<Quantity>(q), limits_of(static_cast<Quantity>(q)), {}};
            h.series = {counted("before", h.limits, some_values(dice)), counted("after", h.limits, some_values(dice))};
            const std::string picture = svg(h);
            RC_ASSERT(picture.starts_with("<svg ") && picture.ends_with("</svg>\n"));
            RC_ASSERT(picture.find("nan") == std::string::npos && picture.find("inf") == std::string::npos);
            const bool empty = sum(h.series[0]) + sum(h.series[1]) == 0;
            RC_ASSERT(bars(h).find(empty ? "nothing to count" : "after correction") != std::string::npos);
        }
    });
}

TEST_CASE("limits rise, and have the numbers that the documentation says") {
    for (std::size_t q = 0; q < quantity_count; ++q) {
        const auto limits = limits_of(static_cast<Quantity>(q));
        CHECK(std::adjacent_find(limits.begin(), limits.end(), std::greater_equal<>()) == limits.end());
    }
    CHECK(limits_of(Quantity::length_gain).size() == 26);
    CHECK(limits_of(Quantity::length_gain).back() == 0.5);
    CHECK(limits_of(Quantity::length).front() == 0.125);
    CHECK(limits_of(Quantity::length).back() == 8);
    CHECK(limits_of(Quantity::normalised_jacobian).size() == 21);
    CHECK(limits_of(Quantity::normalised_jacobian).back() == 1);
}

TEST_CASE("what is not finite") {
    constexpr double inf = std::numeric_limits<double>::infinity();
    const auto limits = limits_of(Quantity::normalised_jacobian);
    const Series s = counted("count", limits, std::vector<double>{-inf, 0.5, inf, std::nan("")});
    CHECK(s.counts.front() == 1);
    CHECK(s.counts.back() == 1);
    CHECK(sum(s) == 3);
    CHECK(s.mean == 0.5);
}

TEST_CASE("a report gives its histograms back") {
    Report report;
    Histogram h{Quantity::length, limits_of(Quantity::length), {}};
    h.series = {counted("straight", h.limits, std::vector<double>{0.7, 1.3}),
                counted("before", h.limits, std::vector<double>{0.6, 1.1})};
    report.histograms = {h};
    const auto back = histograms_of_report(to_json(report));
    REQUIRE(back.has_value());
    CHECK(*back == report.histograms);
    CHECK_FALSE(histograms_of_report("{}").has_value());
    CHECK_FALSE(histograms_of_report("no json").has_value());
    CHECK_FALSE(
        histograms_of_report(R"({"histograms": {"curvature": {"edges": [0, 1], "count": [1], "mean": {"count": 0}}}})")
            .has_value());
}
