#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <string>
#include <vector>

import camber.core;
import camber.bezier;
import camber.validity;

#include "generators.hpp"

using namespace camber;
using namespace generators;
using camber::testing::property;

namespace {

template <int D>
double largest(const std::array<double, jacobian_coefficients<D>>& c) {
    double most = 0;
    for (const double x : c) most = std::max(most, std::abs(x));
    return most;
}

template <int D>
void test_values_at_points() {
    property("the Bernstein sum of the coefficients is det J (" + std::to_string(D) + "D)", [] {
        auto random = random_source();
        const auto s = element<D>(random, 0.4);
        const auto c = jacobian(s);
        const auto xi = point_inside<D>(random);
        double sum = 0;
        for (int p = 0; p < jacobian_coefficients<D>; ++p) sum += c[p] * bernstein<D>(multi_indices<D, D>[p], xi);
        RC_ASSERT(std::abs(sum - elements::jacobian_at<D>(s, xi)) <= 1e-13 * (1 + largest<D>(c)));
    });
}

template <int D>
void test_interpolation() {
    property("the coefficients equal those of interpolated values (" + std::to_string(D) + "D)", [] {
        auto random = random_source();
        const auto s = element<D>(random, 0.4);
        const auto c = jacobian(s);
        std::array<double, jacobian_coefficients<D>> values{};
        for (int p = 0; p < jacobian_coefficients<D>; ++p) {
            Barycentric<D> xi{};
            for (int i = 0; i <= D; ++i) xi[i] = static_cast<double>(multi_indices<D, D>[p][i]) / D;
            values[p] = elements::jacobian_at<D>(s, xi);
        }
        const auto interpolated =
            transformed(inverted<jacobian_coefficients<D>>(bezier_to_lagrange<D, D>).matrix, values);
        for (int p = 0; p < jacobian_coefficients<D>; ++p)
            RC_ASSERT(std::abs(interpolated[p] - c[p]) <= 1e-12 * (1 + largest<D>(c)));
    });
}

template <int D>
void test_affine_maps() {
    property("an affine map multiplies the coefficients by its determinant (" + std::to_string(D) + "D)", [] {
        auto random = random_source();
        const auto s = element<D>(random, 0.4);
        std::array<Vec<D>, D> map;
        for (auto& column : map)
            for (int c = 0; c < D; ++c) column[c] = uniform(random, -2, 2);
        QuadraticSimplex<D, D> mapped;
        for (int i = 0; i < quadratic_nodes<D>; ++i) {
            for (int c = 0; c < D; ++c) mapped.control[i][c] = uniform(random, 0, 0) + 7;
            for (int c = 0; c < D; ++c) mapped.control[i] += s.control[i][c] * map[c];
        }
        double factor = 0;
        if constexpr (D == 2)
            factor = det(map[0], map[1]);
        else
            factor = det(map[0], map[1], map[2]);
        const auto before = jacobian(s);
        const auto after = jacobian(mapped);
        for (int p = 0; p < jacobian_coefficients<D>; ++p)
            RC_ASSERT(std::abs(after[p] - factor * before[p]) <= 1e-11 * (1 + largest<D>(before)));
    });
}

template <int D>
void test_straight() {
    property("the coefficients of a straight element are equal (" + std::to_string(D) + "D)", [] {
        auto random = random_source();
        auto s = element<D>(random, 0);
        const auto j = bounded_jacobian(s);
        for (const double c : j.coefficients) RC_ASSERT(std::abs(c - j.straight) <= 2 * j.error);
    });
}

template <int D>
void test_relabelling() {
    property("relabelling the vertices permutes the coefficients with the sign (" + std::to_string(D) + "D)", [] {
        auto random = random_source();
        const auto s = element<D>(random, 0.4);
        std::array<int, D + 1> order{};
        std::iota(order.begin(), order.end(), 0);
        std::shuffle(order.begin(), order.end(), random);
        int sign = 1;
        for (int i = 0; i <= D; ++i)
            for (int j = 0; j < i; ++j) sign = order[j] > order[i] ? -sign : sign;
        QuadraticSimplex<D, D> other;
        for (int i = 0; i <= D; ++i) other.control[i] = s.control[order[i]];
        for (int e = 0; e < edges_per_simplex<D>; ++e)
            other.control[D + 1 + e] = s.at(order[local_edges<D>[e][0]], order[local_edges<D>[e][1]]);
        const auto before = jacobian(s);
        const auto after = jacobian(other);
        for (int p = 0; p < jacobian_coefficients<D>; ++p) {
            MultiIndex<D> alpha{};
            for (int i = 0; i <= D; ++i) alpha[order[i]] = multi_indices<D, D>[p][i];
            RC_ASSERT(std::abs(after[p] - sign * before[position<D, D>(alpha)]) <= 1e-12 * (1 + largest<D>(before)));
        }
    });
}

/// |rounded − exact| ≤ error, compared in 113 bits.
__extension__ using Wide = __float128;

template <int D>
bool within_bound(const BoundedJacobian<D>& j, const std::vector<elements::Integer>& sixfold) {
    for (int p = 0; p < jacobian_coefficients<D>; ++p) {
        const Wide difference = 6 * static_cast<Wide>(j.coefficients[p]) - static_cast<Wide>(sixfold[p]);
        if ((difference < 0 ? -difference : difference) > 6 * static_cast<Wide>(j.error)) return false;
    }
    return true;
}

/// A thin, oblique element far from the origin: the last axis is scaled down by up to 2^20, sheared into the others,
/// then shifted.
template <int D>
elements::IntegerNodes<D> hard_element(std::mt19937_64& random) {
    const std::int64_t size = std::int64_t{1} << (4 + random() % 17);
    auto n = integer_element<D>(random, size, size / 2);
    const std::int64_t thin = std::int64_t{1} << (random() % 21);
    std::array<std::int64_t, D> shift{};
    for (auto& x : shift) x = integer(random, std::int64_t{1} << 30);
    for (auto& node : n) {
        node[D - 1] /= thin;
        for (int c = 0; c + 1 < D; ++c) node[D - 1] += node[c];
        for (int c = 0; c < D; ++c) node[c] += shift[c];
    }
    return n;
}

template <int D>
void test_error_bound() {
    property("rounding errors stay within the bound, also of thin and distant elements (" + std::to_string(D) + "D)",
             [] {
                 auto random = random_source();
                 const auto n = hard_element<D>(random);
                 const auto exact = elements::sixfold_coefficients<D>(n);
                 const auto s = elements::nodal<D>(n);
                 RC_ASSERT(within_bound<D>(bounded_jacobian(s), exact));
                 RC_ASSERT(within_bound<D>(bounded_jacobian(bezier_form(s)), exact));  // control points are exact here
                 RC_ASSERT(within_bound<D>(double_double_jacobian(s), exact));
                 RC_ASSERT(within_bound<D>(double_double_jacobian(bezier_form(s)), exact));
                 double most = 0;
                 for (const double c : double_double_jacobian(s).coefficients) most = std::max(most, std::abs(c));
                 RC_ASSERT(double_double_jacobian(s).error <= 0x1p-41 * bounded_jacobian(s).error + 0x1p-50 * most);
             },
             {2000});
}

}  // namespace

TEST_CASE("the Bernstein sum of the coefficients is the Jacobian determinant") {
    test_values_at_points<2>();
    test_values_at_points<3>();
}

TEST_CASE("the coefficients equal those of interpolated values") {
    test_interpolation<2>();
    test_interpolation<3>();
}

TEST_CASE("an affine map multiplies the coefficients by its determinant") {
    test_affine_maps<2>();
    test_affine_maps<3>();
}

TEST_CASE("the coefficients of a straight element are equal") {
    test_straight<2>();
    test_straight<3>();
}

TEST_CASE("relabelling the vertices permutes the coefficients") {
    test_relabelling<2>();
    test_relabelling<3>();
}

TEST_CASE("rounding errors of the coefficients stay within their bound") {
    test_error_bound<2>();
    test_error_bound<3>();
}

TEST_CASE("the error bound does not depend on the distance from the origin") {
    auto n = elements::IntegerNodes<3>{};
    std::mt19937_64 random(1);
    n = integer_element<3>(random, 8, 1);
    const auto near = bounded_jacobian(elements::nodal<3>(n));
    for (auto& node : n)
        for (auto& x : node) x += 1000000;
    const auto far = bounded_jacobian(elements::nodal<3>(n));
    CHECK(near.coefficients == far.coefficients);
    CHECK(near.error == far.error);
}
