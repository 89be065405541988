// SPD algebra: decompositions, exp and log, their derivatives, and precision.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "dice.hpp"
#include "property.hpp"

import camber.core;
import camber.metric;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
LogMetric<D> random_log(Dice& dice, double range) {
    return {congruence(dice.rotation<D>(), Sym<D>::diagonal(dice.vector<D>(-range, range)))};
}

template <int D>
Mat<D> as_matrix(const Sym<D>& s) {
    Mat<D> m;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) m(i, j) = s(i, j);
    return m;
}

template <int D>
double norm_of(const Mat<D>& m) {
    double s = 0;
    for (const auto& column : m.column) s += norm_squared(column);
    return std::sqrt(s);
}

template <int D>
Mat<D> difference(const Mat<D>& a, const Mat<D>& b) {
    Mat<D> r;
    for (int j = 0; j < D; ++j) r.column[j] = a.column[j] - b.column[j];
    return r;
}

template <int D>
double largest(const Vec<D>& v) {
    return *std::max_element(v.c.begin(), v.c.end());
}

template <int D>
void check_decompositions() {
    property("A = R Λ Rᵀ with orthonormal R, also at equal and nearly equal eigenvalues", [](std::uint64_t seed) {
        Dice dice(seed);
        Vec<D> values = dice.vector<D>(-30, 30);
        constexpr std::array gaps{0.0, 1e-15, 1e-12, 1e-8, 1e-3};
        if (dice.below(2) == 0) values[1] = values[0] * (1 + gaps[dice.below(gaps.size())]);
        if (D == 3 && dice.below(3) == 0) values[2] = values[0];
        const Sym<D> a = congruence(dice.rotation<D>(), Sym<D>::diagonal(values));
        const auto e = eigen_system(a);
        RC_ASSERT(norm(composed(e) - a) <= 4e-15 * norm(a));
        RC_ASSERT(norm_of(difference(transposed(e.vectors) * e.vectors, Mat<D>::identity())) <= 3e-15);
        auto found = e.values.c, expected = values.c;
        std::sort(found.begin(), found.end());
        std::sort(expected.begin(), expected.end());
        for (int i = 0; i < D; ++i) RC_ASSERT(std::abs(found[i] - expected[i]) <= 1e-14 * norm(a));
    });
    property("left singular vectors are orthogonal, and small singular values are accurate", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto c = dice.matrix<D>();
        RC_PRE(std::abs(det(c)) > 0.05);
        Mat<D> a = c;
        double scale = 1;
        for (int i = 1; i < D; ++i) {
            const double s = std::pow(10.0, dice.uniform(-12, 0));
            scale *= s;
            for (int j = 0; j < D; ++j) a(i, j) *= s;
        }
        const auto s = left_singular(a);
        double product = 1;
        for (int i = 0; i < D; ++i) {
            product *= s.values[i];
            const Vec<D> wi = transposed_times(a, s.vectors.column[i]);
            for (int j = 0; j < i; ++j) RC_ASSERT(std::abs(dot(s.vectors.column[i], s.vectors.column[j])) < 1e-14);
            RC_ASSERT(std::abs(norm(wi) - s.values[i]) <= 1e-15 * norm_of(a));
        }
        RC_ASSERT(std::abs(product - scale * std::abs(det(c))) <= 1e-13 * product);
    });
}

template <int D>
void check_exp_and_log() {
    property("exp and log are inverse up to the rounding of the entries of M", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto l = random_log<D>(dice, dice.uniform(0.1, 14));
        const double condition = anisotropy(l) * anisotropy(l);
        const Metric<D> m = exp(l);
        const LogMetric<D> again = log(m);
        RC_ASSERT(norm(again.l - l.l) <= 1e-14 * (condition + norm(l.l)));
        RC_ASSERT(norm(exp(again).m - m.m) <= 1e-13 * norm(m.m));
        // The determinant cancels D products of the size of the largest eigenvalue.
        const double cancelled = std::exp(D * largest(eigen_system(l.l).values) - trace(l.l));
        RC_PRE(cancelled < 1e12);
        RC_ASSERT(std::abs(std::log(det(as_matrix(m.m))) - trace(l.l)) <= 1e-14 * (cancelled + norm(l.l)));
    });
    property("lengths along the axes are exact to rounding at log-eigenvalues of ±30", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto r = dice.rotation<D>();
        const auto values = dice.vector<D>(-30, 30);
        const SpectralMetric<D> m(LogMetric<D>{composed(EigenSystem<D>{values, r})});
        const double top = std::exp(largest(values));
        for (int i = 0; i < D; ++i) {
            const double expected = std::exp(values[i]);
            // An axis is known to 1e-15; the largest eigenvalue contributes with the square of that.
            RC_ASSERT(std::abs(m.length_squared(r.column[i]) - expected) <= 1e-13 * expected + 1e-29 * top);
        }
        const auto v = dice.vector<D>();
        RC_ASSERT(std::abs(dot(v, m.times(v)) - m.length_squared(v)) <= 1e-14 * top);
        const Vec<D> back = m.times(m.solve(v));
        RC_ASSERT(norm(back - v) <= 1e-14 * anisotropy(LogMetric<D>{composed(EigenSystem<D>{values, r})}) *
                                        anisotropy(LogMetric<D>{composed(EigenSystem<D>{values, r})}));
    });
    property("log_metric_of_sizes has the sizes along the axes", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto r = dice.rotation<D>();
        Vec<D> sizes;
        for (double& h : sizes.c) h = std::pow(10.0, dice.uniform(-3, 3));
        const auto l = log_metric_of_sizes(sizes, r);
        const SpectralMetric<D> m(l);
        for (int i = 0; i < D; ++i) RC_ASSERT(std::abs(m.length_squared(sizes[i] * r.column[i]) - 1) < 1e-12);
        const auto [low, high] = std::minmax_element(sizes.c.begin(), sizes.c.end());
        RC_ASSERT(std::abs(anisotropy(l) / (*high / *low) - 1) < 1e-13);
    });
}

template <int D>
void check_exp_derivatives() {
    property("D exp equals central differences", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto l = random_log<D>(dice, dice.uniform(0, 3));
        const auto e = dice.symmetric<D>();
        const double h = 1e-5;
        const SpectralMetric<D> s(l);
        const Sym<D> derivative = exp_derivative(s, e);
        const Sym<D> differences =
            (exp(LogMetric<D>{l.l + h * e}).m - exp(LogMetric<D>{l.l - h * e}).m) * (1 / (2 * h));
        RC_ASSERT(norm(derivative - differences) <= 1e-8 * std::exp(largest(s.log_values)));
    });
    property("D exp at ±30 satisfies the adjoint identity and the product rule of squares", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto l = random_log<D>(dice, dice.uniform(0, 30));
        const auto e = dice.symmetric<D>();
        const auto v = dice.vector<D>();
        const SpectralMetric<D> s(l);
        const double top = std::exp(largest(s.log_values));
        const Sym<D> derivative = exp_derivative(s, e);
        RC_ASSERT(std::abs(inner(length_squared_adjoint(s, v), e) - dot(v, derivative * v)) <= 1e-13 * top);
        // exp(L) = exp(L/2)², so its derivative is that of the square (theory, section 2).
        const SpectralMetric<D> half(LogMetric<D>{0.5 * l.l});
        const Mat<D> root = as_matrix(exp(LogMetric<D>{0.5 * l.l}).m);
        const Mat<D> droot = as_matrix(exp_derivative(half, 0.5 * e));
        Mat<D> square = droot * root;
        for (int j = 0; j < D; ++j) square.column[j] += (root * droot).column[j];
        RC_ASSERT(norm_of(difference(square, as_matrix(derivative))) <= 1e-13 * top);
    });
    property("D exp is exp(L) E if L and E commute", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto r = dice.rotation<D>();
        const auto values = dice.vector<D>(-3, 3);
        const auto slopes = dice.vector<D>();
        Vec<D> expected;
        for (int i = 0; i < D; ++i) expected[i] = std::exp(values[i]) * slopes[i];
        const SpectralMetric<D> s(EigenSystem<D>{values, r});
        RC_ASSERT(norm(exp_derivative(s, congruence(r, Sym<D>::diagonal(slopes))) -
                       congruence(r, Sym<D>::diagonal(expected))) < 1e-12);
    });
}

/// With v on the long axis, the sum over eigenvectors keeps all digits at any anisotropy.
template <int D>
void check_precision(double aspect) {
    property("lengths along the long axis have all digits", [aspect](std::uint64_t seed) {
        Dice dice(seed);
        const auto r = dice.rotation<D>();
        Vec<D> sizes;
        for (double& h : sizes.c) h = 1 / aspect;
        const double length = dice.uniform(0.5, 2);
        sizes[0] = length;
        const SpectralMetric<D> m(log_metric_of_sizes(sizes, r));
        RC_ASSERT(std::abs(m.length_squared(r.column[0]) * length * length - 1) < 2e-13);
    });
}

}  // namespace

TEST_CASE("matrix decompositions are orthonormal and accurate in 2D") { check_decompositions<2>(); }
TEST_CASE("matrix decompositions are orthonormal and accurate in 3D") { check_decompositions<3>(); }
TEST_CASE("exp and log are inverse and keep lengths along axes in 2D") { check_exp_and_log<2>(); }
TEST_CASE("exp and log are inverse and keep lengths along axes in 3D") { check_exp_and_log<3>(); }
TEST_CASE("derivatives of exp match differences and exact identities in 2D") { check_exp_derivatives<2>(); }
TEST_CASE("derivatives of exp match differences and exact identities in 3D") { check_exp_derivatives<3>(); }
TEST_CASE("lengths along the long axis keep all digits up to anisotropy 10^8") {
    for (const double aspect : {1.0, 1e3, 1e6, 1e8}) {
        check_precision<2>(aspect);
        check_precision<3>(aspect);
    }
}

TEST_CASE("divided differences of exp are accurate to 1e-14") {
    property("divided differences equal those in long double",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const double a = dice.uniform(-30, 30);
                 const double b = a + std::pow(10.0, dice.uniform(-17, 1.7)) * (dice.below(2) == 0 ? 1 : -1);
                 const long double difference = static_cast<long double>(a) - b;
                 const long double expected =
                     difference == 0 ? std::exp(static_cast<long double>(a))
                                     : std::exp(static_cast<long double>(b)) * std::expm1(difference) / difference;
                 const auto relative = [&](double x) { return std::abs(static_cast<double>(x / expected - 1)); };
                 RC_ASSERT(relative(exp_divided_difference(a, b)) < 1e-14);
                 RC_ASSERT(relative(exp_divided_difference(b, a)) < 1e-14);
                 RC_ASSERT(relative(exp_divided_difference(a, b, std::exp(a), std::exp(b))) < 1e-14);
             },
             {.count = 1000});
}

TEST_CASE("the zero matrix and diagonal matrices are decomposed exactly") {
    const auto zero = eigen_system(Sym<3>{});
    CHECK(zero.values == Vec<3>{});
    CHECK(zero.vectors == Mat<3>::identity());
    const auto diagonal = eigen_system(Sym<3>::diagonal(Vec<3>{{1, 1e16, -5}}));
    CHECK(diagonal.values == Vec<3>{{1, 1e16, -5}});
    CHECK(exp(LogMetric<2>{}).m == Sym<2>::identity());
}
