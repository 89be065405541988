// Metrics from files: rounded ones are floored and counted, invalid ones are rejected.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "dice.hpp"
#include "meshes.hpp"
#include "property.hpp"

import camber.core;
import camber.metric;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
void append(std::vector<double>& rows, const Sym<D>& m) {
    rows.insert(rows.end(), m.c.begin(), m.c.end());
}

template <int D>
Sym<D> rounded_to_float(Sym<D> m) {
    for (double& x : m.c) x = static_cast<float>(x);
    return m;
}

double largest_log(const LogMetric<3>& l) {
    const auto values = eigen_system(l.l).values;
    return *std::max_element(values.c.begin(), values.c.end());
}

}  // namespace

TEST_CASE("valid tensors are converted to their logarithms") {
    property("log M of the tensors of a file is the original log M",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 std::vector<double> rows;
                 std::vector<LogMetric<3>> expected;
                 for (int i = 0; i < 50; ++i) {
                     expected.push_back({dice.symmetric<3>(3)});
                     append(rows, exp(expected.back()).m);
                 }
                 const auto found = *log_metrics_of_tensors<3>(rows, TensorPrecision::eight_bytes, one_thread);
                 RC_ASSERT(found.floored == 0U);
                 for (std::size_t i = 0; i < expected.size(); ++i)
                     RC_ASSERT(norm(found.log_metrics[i].l - expected[i].l) < 1e-10);
             },
             {.count = 20});
}

TEST_CASE("4-byte tensors made indefinite by rounding are floored, not rejected") {
    Dice dice(7);
    std::vector<double> rows;
    std::size_t indefinite = 0;
    for (int i = 0; i < 200; ++i) {
        const Vec<3> values{{1e12, std::pow(10.0, dice.uniform(0, 12)), 1}};
        const Sym<3> m = rounded_to_float(congruence(dice.rotation<3>(), Sym<3>::diagonal(values)));
        const auto e = eigen_system(m).values;
        indefinite += *std::min_element(e.c.begin(), e.c.end()) < 0;
        append(rows, m);
    }
    CHECK(indefinite > 60);  // 107 of 200 in the sample of the theory
    CHECK(indefinite < 140);
    const auto logs = must(log_metrics_of_tensors<3>(rows, TensorPrecision::four_bytes, one_thread));
    CHECK(logs.floored >= indefinite);
    CHECK(logs.floored <= 200);
    for (const auto& l : logs.log_metrics) {
        CHECK(std::isfinite(norm(l.l)));
        CHECK(largest_log(l) == doctest::Approx(std::log(1e12)).epsilon(1e-5));
        CHECK(anisotropy(l) < 1e6);
    }
}

TEST_CASE("an axis-aligned layer of anisotropy 10^6 in 4-byte reals keeps its digits") {
    std::vector<double> rows;
    append(rows, Sym<3>::diagonal(Vec<3>{{1, static_cast<float>(1e12), 4}}));
    const auto logs = must(log_metrics_of_tensors<3>(rows, TensorPrecision::four_bytes, one_thread));
    CHECK(logs.floored == 0);
    CHECK(logs.log_metrics[0].l(0, 0) == doctest::Approx(0).epsilon(1e-12));
    CHECK(logs.log_metrics[0].l(2, 2) == doctest::Approx(std::log(4)));
    CHECK(anisotropy(logs.log_metrics[0]) == doctest::Approx(1e6).epsilon(1e-6));
}

TEST_CASE("invalid tensors are rejected with their vertex") {
    const auto refused = [](const Sym<2>& bad, TensorPrecision precision) {
        std::vector<double> rows;
        append(rows, Sym<2>::identity());
        append(rows, bad);
        append(rows, Sym<2>::identity());
        const auto logs = log_metrics_of_tensors<2>(rows, precision, one_thread);
        REQUIRE(!logs.has_value());
        CHECK(logs.error().kind == ErrorKind::input);
        REQUIRE(logs.error().entity.has_value());
        CHECK(logs.error().entity->kind == "metric at vertex");
        CHECK(logs.error().entity->number == 2);
    };
    for (const auto precision : {TensorPrecision::four_bytes, TensorPrecision::eight_bytes}) {
        refused(Sym<2>::diagonal(Vec<2>{{1, -1e-3}}), precision);
        refused(Sym<2>::diagonal(Vec<2>{{-1, -1}}), precision);
        refused(Sym<2>{}, precision);
        refused(Sym<2>{{1, 2, 1}}, precision);
        refused(Sym<2>{{1, std::numeric_limits<double>::quiet_NaN(), 1}}, precision);
        refused(Sym<2>{{std::numeric_limits<double>::infinity(), 0, 1}}, precision);
    }
}

namespace {

/// Error message for a tensor that is the second of two.
template <int D>
std::string message_for(const Sym<D>& bad, TensorPrecision precision) {
    std::vector<double> rows;
    append(rows, Sym<D>::identity());
    append(rows, bad);
    const auto logs = log_metrics_of_tensors<D>(rows, precision, one_thread);
    return logs ? std::string() : describe(logs.error());
}

}  // namespace

// Guards against zero tensors reported as negative and singular tensors that are accepted.
TEST_CASE("zero and singular tensors are reported as such") {
    const std::string zero = "metric at vertex 2: is zero (sizes would be infinite: give each direction a size)";
    const std::string singular =
        "metric at vertex 2: is singular (a size would be infinite: give each direction a size)";
    for (const auto precision : {TensorPrecision::four_bytes, TensorPrecision::eight_bytes}) {
        CHECK(message_for(Sym<2>{}, precision) == zero);
        CHECK(message_for(Sym<3>{}, precision) == zero);
        CHECK(message_for(Sym<2>::diagonal(Vec<2>{{0, 4}}), precision) == singular);
        CHECK(message_for(Sym<2>::diagonal(Vec<2>{{1e12, 0}}), precision) == singular);
        CHECK(message_for(Sym<3>{{2, 1, 2, 0, 0, 0}}, precision) == singular);
        CHECK(message_for(Sym<2>::diagonal(Vec<2>{{-1, 0}}), precision).find("not positive definite") < 30);
        CHECK(message_for(Sym<2>{{0, 1, 1}}, precision).find("not positive definite") < 30);
    }
    property("a tensor with one infinite size is reported as singular",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const double scale = std::pow(10.0, dice.uniform(-30, 30));
                 const Sym<2> others = exp(LogMetric<2>{dice.symmetric<2>(3)}).m;
                 const Sym<3> m{{scale * others.c[0], scale * others.c[1], scale * others.c[2], 0, 0, 0}};
                 RC_ASSERT(message_for(m, TensorPrecision::eight_bytes) ==
                           "metric at vertex 2: is singular (a size would be infinite: give each direction a size)");
             },
             {.count = 50});
}

TEST_CASE("tensors of sizes beyond the range of lengths are rejected") {
    for (const double entry : {1e-300, 1e-140, 1e140, 1e300})
        for (const double across : {0.0, 0.5 * entry})
            CHECK(message_for(Sym<2>{{entry, across, entry}}, TensorPrecision::eight_bytes) ==
                  "metric at vertex 2: has sizes that are not between 1e-60 and 1e60 (use another unit of length)");
    CHECK(message_for(Sym<2>::diagonal(Vec<2>{{1e-120, 1e-120}}), TensorPrecision::eight_bytes).empty());
    CHECK(message_for(Sym<2>::diagonal(Vec<2>{{1e120, 1}}), TensorPrecision::eight_bytes).empty());
}

TEST_CASE("a tensor flattened by rounding is floored in either precision") {
    std::vector<double> rows;
    append(rows, Sym<2>{{1, 1, 1}});
    for (const auto precision : {TensorPrecision::four_bytes, TensorPrecision::eight_bytes}) {
        const auto logs = must(log_metrics_of_tensors<2>(rows, precision, one_thread));
        CHECK(logs.floored == 1);
        CHECK(std::isfinite(norm(logs.log_metrics[0].l)));
    }
    CHECK(must(log_metrics_of_tensors<2>({}, TensorPrecision::eight_bytes, one_thread)).log_metrics.empty());
}
