// Gauss–Jacobi and conical rules against the beta function.
#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>

import camber.core;
import camber.bezier;

using namespace camber;

TEST_CASE("a rule of n points is exact for polynomials of degree 2n - 1") {
    for (int power = 0; power <= 2; ++power)
        for (int n = 1; n <= 20; ++n) {
            const GaussJacobi rule = gauss_jacobi(n, power);
            REQUIRE(rule.nodes.size() == static_cast<std::size_t>(n));
            for (int degree = 0; degree <= 2 * n - 1; ++degree) {
                double sum = 0;
                for (std::size_t i = 0; i < rule.nodes.size(); ++i)
                    sum += rule.weights[i] * std::pow(rule.nodes[i], degree);
                const double exact =
                    std::tgamma(degree + 1.0) * std::tgamma(power + 1.0) / std::tgamma(degree + power + 2.0);
                CHECK(std::abs(sum - exact) < 1e-13 * exact * n);
            }
        }
}

TEST_CASE("Gauss–Jacobi nodes increase within the interval and weights are positive") {
    for (int power = 0; power <= 2; ++power) {
        const GaussJacobi rule = gauss_jacobi(20, power);
        double before = 0;
        for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
            CHECK(rule.nodes[i] > before);
            CHECK(rule.weights[i] > 0);
            before = rule.nodes[i];
        }
        CHECK(before < 1);
    }
}

TEST_CASE("a conical rule of n points a direction is exact for polynomials of degree 2n - 1") {
    for (int n = 1; n <= 6; ++n)
        for (int i = 0; i <= 2 * n - 1; ++i) {
            const int j = 2 * n - 1 - i;  // ∫ ξ_1^i ξ_2^j
            double triangle = 0, tetrahedron = 0;
            for (const auto& [xi, weight] : conical_rule<2>(n)) {
                CHECK(weight > 0);
                triangle += weight * std::pow(xi[1], i) * std::pow(xi[2], j);
            }
            for (const auto& [xi, weight] : conical_rule<3>(n))
                tetrahedron += weight * std::pow(xi[1], i) * std::pow(xi[3], j);
            const double numerator = std::tgamma(i + 1.0) * std::tgamma(j + 1.0);
            CHECK(std::abs(triangle * std::tgamma(2 * n + 2.0) - numerator) < 1e-12 * numerator);
            CHECK(std::abs(tetrahedron * std::tgamma(2 * n + 3.0) - numerator) < 1e-12 * numerator);
        }
}

TEST_CASE("the rule of a shape is exact for products of polynomials of its factors") {
    const auto check = []<Shape shape>(auto exact) {
        for (int n = 1; n <= 5; ++n)
            for (int i = 0; i <= 2 * n - 1; ++i) {
                const int j = 2 * n - 1 - i, k = shape_table<shape>.dimension == 3 ? 2 * n - 1 : 0;
                double sum = 0;  // ∫ x^i y^j z^k
                for (const auto& [x, weight] : reference_rule<shape>(n))
                    sum += weight * std::pow(x[0], i) * std::pow(x[1], j) * std::pow(x[2], k);
                CHECK(std::abs(sum - exact(i, j, k)) < 1e-13);
            }
    };
    const auto triangle = [](int i, int j) {
        return std::tgamma(i + 1.0) * std::tgamma(j + 1.0) / std::tgamma(i + j + 3.0);
    };
    check.template operator()<Shape::triangle>([&](int i, int j, int) { return triangle(i, j); });
    check.template operator()<Shape::quadrilateral>([](int i, int j, int) { return 1.0 / ((i + 1) * (j + 1)); });
    check.template operator()<Shape::prism>([&](int i, int j, int k) { return triangle(i, j) / (k + 1); });
    check.template operator()<Shape::hexahedron>(
        [](int i, int j, int k) { return 1.0 / ((i + 1) * (j + 1) * (k + 1)); });
}
