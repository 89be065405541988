// Metric fields by expressions: values against formulas, and what is said of a wrong one.
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "dice.hpp"
#include "meshes.hpp"

import camber.core;
import camber.fields;
import camber.metric;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
std::vector<Vec<D>> places(std::size_t n) {
    Dice dice(4);
    std::vector<Vec<D>> out(n);
    for (auto& p : out) p = dice.vector<D>(0, 1);
    return out;
}

template <int D>
std::string error_of(const MetricExpression& expression, const std::vector<Vec<D>>& points) {
    const auto made = log_metrics_of<D>(expression, points, alone);
    REQUIRE_FALSE(made.has_value());
    CHECK(made.error().kind == ErrorKind::usage);
    return describe(made.error());
}

}  // namespace

TEST_CASE("expressions give the metrics of their formulas") {
    const auto points = places<3>(10000);
    const auto one = must(log_metrics_of<3>(SizeExpression{"0.1 + 0.2*x"}, points, alone));
    const auto sizes =
        must(log_metrics_of<3>(SizesExpression{{"0.1", "0.001 + abs(z - 0.5)", "max(x, 0.1)^2"}}, points, alone));
    const auto tensor = must(log_metrics_of<3>(
        TensorExpression{{"2 + x", "sin(pi*y)", "4", "0", "0", "x > 0.5 ? 1 : exp(z)"}}, points, alone));
    for (std::size_t v = 0; v < points.size(); ++v) {
        const Vec<3>& p = points[v];
        CHECK(norm(one[v].l + 2 * std::log(0.1 + 0.2 * p[0]) * Sym<3>::identity()) < 1e-12);
        const Vec<3> h{{0.1, 0.001 + std::abs(p[2] - 0.5), std::pow(std::max(p[0], 0.1), 2)}};
        CHECK(norm(sizes[v].l - log_metric_of_sizes(h).l) < 1e-11);
        const Sym<3> m{{2 + p[0], std::sin(3.14159265358979323846 * p[1]), 4, 0, 0, p[0] > 0.5 ? 1 : std::exp(p[2])}};
        CHECK(norm(exp(tensor[v]).m - m) < 1e-11);
    }
    CHECK(must(log_metrics_of<3>(SizeExpression{"0.1 + 0.2*x"}, points, Execution{.threads = 3})) == one);
    const auto flat = must(log_metrics_of<2>(SizesExpression{{"1", "exp(-y)"}}, places<2>(3), alone));
    CHECK(flat.size() == 3);
}

TEST_CASE("what cannot be read is named, with the place in it and what may be written") {
    const auto points = places<3>(3);
    const std::string unknown = error_of<3>(SizeExpression{"0.1 + 0.2*q"}, points);
    CHECK(unknown.find("\"0.1 + 0.2*q\"") != std::string::npos);
    CHECK(unknown.find("position 11") != std::string::npos);
    CHECK(unknown.find("it may use x, y, z") != std::string::npos);
    CHECK(error_of<2>(SizeExpression{"z"}, places<2>(3)).find("position 1") != std::string::npos);
    CHECK(error_of<3>(SizeExpression{"(1 + x"}, points).find("cannot be read") != std::string::npos);
    CHECK(error_of<3>(SizeExpression{""}, points).find("cannot be read") != std::string::npos);
    CHECK(error_of<3>(SizeExpression{"1, 2"}, points).find("gives 2 values") != std::string::npos);
    CHECK(error_of<3>(SizeExpression{"\"text\""}, points).find("cannot be read") != std::string::npos);
    CHECK(error_of<3>(SizeExpression{std::string(100000, '(')}, points).find("cannot be read") != std::string::npos);
    CHECK(error_of<3>(SizeExpression{std::string(300000, 'q')}, points).size() < 400);
    CHECK(error_of<3>(SizesExpression{{"1", "1"}}, points).find("expected 3 expressions") != std::string::npos);
    CHECK(error_of<3>(TensorExpression{{"1", "0", "1"}}, points).find("expected 6 expressions") != std::string::npos);
}

TEST_CASE("a value that is no size names its vertex and the coordinates there") {
    const std::vector<Vec<3>> points{Vec<3>{{1, 2, 3}}, Vec<3>{{0.25, 0, -1.5}}};
    const std::string negative = error_of<3>(SizeExpression{"x - 0.5"}, points);
    CHECK(negative.find("vertex 2") != std::string::npos);
    CHECK(negative.find("-0.25 at (0.25, 0, -1.5)") != std::string::npos);
    CHECK(error_of<3>(SizeExpression{"1/y"}, points).find("vertex 2") != std::string::npos);
    CHECK(error_of<3>(SizeExpression{"log(z)"}, points).find("vertex 2") != std::string::npos);
    const std::string tensor = error_of<3>(TensorExpression{{"1", "0", "1", "0", "0", "z"}}, points);
    CHECK(tensor.find("vertex 2") != std::string::npos);
    CHECK(tensor.find("(0.25, 0, -1.5)") != std::string::npos);
}
