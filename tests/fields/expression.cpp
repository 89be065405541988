// Metric fields by expressions: values compared with formulas, and errors.
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <rapidcheck.h>

#include "dice.hpp"
#include "meshes.hpp"
#include "property.hpp"

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
    const auto result = log_metrics_of<D>(expression, points, one_thread);
    REQUIRE_FALSE(result.has_value());
    CHECK(result.error().kind == ErrorKind::usage);
    return describe(result.error());
}

/// A random formula of the coordinates with operators, functions, comparisons and choices, of depth `depth`.
std::string formula(Dice& dice, int depth) {
    constexpr std::array<const char*, 6> leaves{"x", "y", "z", "pi", "0.5", "2"};
    if (depth == 0) return leaves[dice.below(leaves.size())];
    const auto part = [&] { return formula(dice, depth - 1); };
    switch (dice.below(6)) {
        case 0: return "(" + part() + ")+(" + part() + ")";
        case 1: return "sin(" + part() + ")";
        case 2: return "max(" + part() + ", " + part() + ")";
        case 3: return "((" + part() + ")<=(" + part() + ") ? " + part() + " : " + part() + ")";
        case 4: return "((" + part() + ")==(" + part() + "))";
        default: return "-(" + part() + ")";
    }
}

/// A random sequence of the parser's words, which is rarely a formula.
std::string words_at_random(Dice& dice) {
    constexpr std::array<std::string_view, 24> words{
        "x", "y", "z", "1",  "0.5", "+", "-",    "*",    "/", "^",  "(",     ")",
        "?", ":", "=", "==", "<",   ",", "max(", "sin(", ";", "pi", "\"a\"", "<="};
    std::string text;
    for (std::size_t n = 1 + dice.below(8); n > 0; --n) text += words[dice.below(words.size())];
    return text;
}

std::uint64_t value_at(const ScalarExpression<3>& expression, const std::vector<Vec<3>>& points, std::size_t of) {
    std::vector<double> values(points.size());
    expression.evaluator()(points, values);
    return std::bit_cast<std::uint64_t>(values[of]);
}

}  // namespace

TEST_CASE("an assignment is rejected with its position and the comparison operator") {
    const auto points = places<3>(3);
    for (const auto& [text, position] : std::vector<std::pair<std::string, int>>{{"x=0.5 ? 1 : 0", 2},
                                                                                 {"x = 0.5", 3},
                                                                                 {"(x=1)+y", 3},
                                                                                 {"max(x=1,2)", 6},
                                                                                 {"x==y=z", 5},
                                                                                 {"x<=y = z", 6},
                                                                                 {"x===y", 4},
                                                                                 {"x := 1", 4},
                                                                                 {"x += 1", 4},
                                                                                 {"x = y = 1", 3},
                                                                                 {"1 + (pi = 3)", 9}}) {
        CAPTURE(text);
        const std::string error = error_of<3>(SizeExpression{text}, points);
        CHECK(error.find("assigns with \"=\" at position " + std::to_string(position)) != std::string::npos);
        CHECK(error.find("write ==") != std::string::npos);
    }
}

TEST_CASE("statements, texts and calls that change a variable are rejected") {
    const auto points = places<3>(3);
    for (const std::string text :
         {"x; y", "x = 1; x", "var a := 1; a", "return 1", "for (x; 1; 2) 1", "while (1) 1", "'text'", "\"text\"",
          "{x}", "[x]", "x++", "++x", "swap(x, y)", "x <=> y", "1, 2", "(1, 2)", "x // y", "# x"}) {
        CAPTURE(text);
        CHECK_FALSE(log_metrics_of<3>(SizeExpression{text}, points, one_thread).has_value());
    }
    CHECK(error_of<3>(SizeExpression{std::string("1\0 + x", 6)}, points).find("has a NUL character at position 2") !=
          std::string::npos);
}

TEST_CASE("inserting a statement makes a formula invalid") {
    property("a formula is valid, and invalid with an assignment or statement in it", [](std::uint64_t seed) {
        Dice dice(seed);
        std::string text = formula(dice, 3);
        RC_ASSERT(ScalarExpression<3>::parsed(text).has_value());
        constexpr std::array<std::string_view, 6> intruders{" = 1", " = ", ";", " := 1 ", "'a'", "{"};
        text.insert(dice.below(text.size() + 1), intruders[dice.below(intruders.size())]);
        RC_ASSERT(!ScalarExpression<3>::parsed(text).has_value());
    });
}

TEST_CASE("evaluating an expression has no side effects") {
    property("the value at a point does not depend on other evaluations",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto expression = ScalarExpression<3>::parsed(words_at_random(dice));
                 if (!expression) return;
                 const Vec<3> p = dice.vector<3>(), q = dice.vector<3>();
                 RC_ASSERT(value_at(*expression, {p, q, p}, 0) == value_at(*expression, {p, q, p}, 2));
                 RC_ASSERT(value_at(*expression, {p}, 0) == value_at(*expression, {q, p}, 1));
             },
             {.count = 3000});
}

TEST_CASE("expressions give the metrics of their formulas") {
    const auto points = places<3>(10000);
    const auto one = must(log_metrics_of<3>(SizeExpression{"0.1 + 0.2*x"}, points, one_thread));
    const auto sizes =
        must(log_metrics_of<3>(SizesExpression{{"0.1", "0.001 + abs(z - 0.5)", "max(x, 0.1)^2"}}, points, one_thread));
    const auto tensor = must(log_metrics_of<3>(
        TensorExpression{{"2 + x", "sin(pi*y)", "4", "0", "0", "x > 0.5 ? 1 : exp(z)"}}, points, one_thread));
    for (std::size_t v = 0; v < points.size(); ++v) {
        const Vec<3>& p = points[v];
        CHECK(norm(one[v].l + 2 * std::log(0.1 + 0.2 * p[0]) * Sym<3>::identity()) < 1e-12);
        const Vec<3> h{{0.1, 0.001 + std::abs(p[2] - 0.5), std::pow(std::max(p[0], 0.1), 2)}};
        CHECK(norm(sizes[v].l - log_metric_of_sizes(h).l) < 1e-11);
        const Sym<3> m{{2 + p[0], std::sin(3.14159265358979323846 * p[1]), 4, 0, 0, p[0] > 0.5 ? 1 : std::exp(p[2])}};
        CHECK(norm(exp(tensor[v]).m - m) < 1e-11);
    }
    CHECK(must(log_metrics_of<3>(SizeExpression{"0.1 + 0.2*x"}, points, Execution{.threads = 3})) == one);
    const auto flat = must(log_metrics_of<2>(SizesExpression{{"1", "exp(-y)"}}, places<2>(3), one_thread));
    CHECK(flat.size() == 3);
}

// Guards against an error that echoes 300 kB of an expression.
TEST_CASE("unreadable expressions are rejected with the position and the allowed names") {
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

TEST_CASE("an invalid size is reported with its vertex and coordinates") {
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

// The functions of the C library are not used, so the bytes are the same on every processor.
TEST_CASE("functions and powers in expressions equal those of camber.core") {
    const auto value = [](const std::string& text, double x, double y) {
        std::vector<double> values(1);
        must(ScalarExpression<2>::parsed(text)).evaluator()(std::vector{Vec<2>{{x, y}}}, values);
        return values[0];
    };
    struct Function {
        const char* name;
        double (*of)(double);
    };
    const std::array functions{
        Function{"exp", camber::exp},     Function{"ln", camber::log},      Function{"log", camber::log},
        Function{"log2", camber::log2},   Function{"log10", camber::log10}, Function{"sin", camber::sin},
        Function{"cos", camber::cos},     Function{"tan", camber::tan},     Function{"asin", camber::asin},
        Function{"acos", camber::acos},   Function{"atan", camber::atan},   Function{"sinh", camber::sinh},
        Function{"cosh", camber::cosh},   Function{"tanh", camber::tanh},   Function{"asinh", camber::asinh},
        Function{"acosh", camber::acosh}, Function{"atanh", camber::atanh},
    };
    for (const Function& f : functions)
        for (int i = 1; i < 200; ++i) {
            const double x = f.name == std::string("acosh") ? 1 + 0.01 * i : 0.005 * i;
            REQUIRE(value(f.name + std::string("(x)"), x, 0) == f.of(x));
            REQUIRE(value("atan2(y, x)", x, 0.3) == camber::atan2(0.3, x));
            REQUIRE(value("x^y", x, 1.7) == camber::pow(x, 1.7));
        }
    CHECK(value("-x^2", 3, 0) == -9);
    CHECK(value("2^3^2", 0, 0) == 512);
    CHECK(value("x*y^2 + 1", 3, 4) == 49);
    CHECK(value("x^-1", 4, 0) == 0.25);
    CHECK(value("(x + 1)^2 < 10 && y^0 == 1 ? 1 : 2", 2, 0) == 1);
    const auto refused = ScalarExpression<2>::parsed("x ^^ 2");
    REQUIRE(!refused);
    CHECK(refused.error().what.find("position 4, at \"^") != std::string::npos);
}
