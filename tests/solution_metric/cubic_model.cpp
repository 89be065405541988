// Local models: the minimal Q of third derivatives is compared with an oracle and checked for its defining properties.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "cubic_oracle.hpp"
#include "dice.hpp"
#include "layers.hpp"
#include "property.hpp"
#include "random_forms.hpp"

import camber.core;
import camber.metric;
import camber.solution_metric;

using namespace camber;
using namespace camber::testing;

namespace {

/// The maximum of log(|T(v)|^{2/3}/vᵀQv).
template <int D>
double excess(const CubicForm<D>& t, const EigenSystem<D>& logs) {
    static const auto fine = oracle_directions<D>(D == 2 ? 1000 : 4000);
    const Mat<D> f = frame_of(logs);
    double most = 0;
    for (const Vec<D>& y : fine) most = std::max(most, std::abs(oracle_value(t, f * y)));
    return 2.0 / 3 * std::log(most);
}

/// Only the limit of rounding, as in the oracle.
constexpr ModelOptions unbounded{.max_anisotropy = 1e9};

template <int D>
void expect_optimal(double anisotropy, int count) {
    Dice dice(7 + D);
    const CubicModels<D> models(unbounded);
    for (int i = 0; i < count; ++i) {
        const auto t = random_form<D>(dice, anisotropy);
        const auto model = models(t).logs;
        CHECK(excess(t, model) < 1e-9);
        // The oracle starts from its own frame and, since there may be several optima, from that of the model.
        const double least =
            std::min(oracle_least_log_det<D>(t, frame_by_entries(t)), oracle_least_log_det<D>(t, frame_of(model)));
        CAPTURE(anisotropy);
        CHECK(std::exp(log_det(model) - least) < 1.03);
    }
}

template <int D>
void check_models() {
    property("the models bound the form everywhere, the diagonal one less tightly",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto t = random_form<D>(dice, std::pow(10.0, dice.uniform(0, 4)));
                 const auto best = CubicModels<D>(unbounded)(t);
                 const auto cheap = CubicModels<D>({.bound = CubicBound::diagonal, .max_anisotropy = 1e9})(t);
                 RC_ASSERT(excess(t, best.logs) < 1e-9);
                 RC_ASSERT(excess(t, cheap.logs) < 1e-3);
                 RC_ASSERT(log_det(best.logs) < log_det(cheap.logs) + 1e-6);
             },
             {.count = 60});
    property("the model of a multiple of T is scaled by the 2/3rd power of the factor",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto t = random_form<D>(dice, 30);
                 const double power = dice.uniform(-200, 200), factor = std::pow(10.0, power);
                 const CubicModels<D> models({});
                 const auto a = models(t), b = models(factor * t);
                 const Sym<D> shift = (2.0 / 3 * power * std::log(10.0)) * Sym<D>::identity();
                 RC_ASSERT(norm(composed(b.logs) - composed(a.logs) - shift) < 1e-5 * (1 + std::abs(power)));
             },
             {.count = 40});
    property("the determinant of the model does not depend on the frame of the form",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto t = random_form<D>(dice, 10);
                 const Mat<D> r = dice.rotation<D>();
                 const CubicModels<D> models(unbounded);
                 RC_ASSERT(std::abs(log_det(models(t).logs) - log_det(models(pulled_back(t, r)).logs)) < 0.1);
             },
             {.count = 40});
}

template <int D>
void check_degenerate_forms() {
    const CubicModels<D> models({.max_anisotropy = 1e4});
    CHECK(models(CubicForm<D>{}).kind == ModelKind::zero);
    Dice dice(3);
    for (int i = 0; i < 20; ++i) {
        // (a·v)³, which depends on one direction, and (a·v)(b·v)².
        const Vec<D> a = dice.direction<D>(), b = dice.direction<D>();
        CubicForm<D> one, two;
        for (int j = 0; j < D; ++j)
            for (int k = 0; k <= j; ++k)
                for (int l = 0; l <= k; ++l) {
                    one(j, k, l) = a[j] * a[k] * a[l];
                    two(j, k, l) = (a[j] * b[k] * b[l] + b[j] * a[k] * b[l] + b[j] * b[k] * a[l]) / 3;
                }
        const auto model = models(one);
        const auto system = model.logs;
        const auto [low, high] = std::minmax_element(system.values.c.begin(), system.values.c.end());
        CHECK(*high == doctest::Approx(0).epsilon(0.05));
        CHECK(*high - *low == doctest::Approx(2 * std::log(1e4)).epsilon(0.01));
        CHECK(std::abs(dot(system.vectors.column[high - system.values.c.begin()], a)) > 1 - 1e-6);
        for (const double x : models(two).logs.values.c) CHECK(std::isfinite(x));
        CHECK(excess(two, models(two).logs) < 1e-3);
    }
}

/// n³ + 3c n t², the form of a front. For one sign of c the best ellipsoid is thin along n; for the other ever thinner
/// ellipsoids are slightly better. The model is no larger than the diagonal bound, and its sizes are not far below
/// those of n³.
template <int D>
void check_fronts() {
    Dice dice(11);
    for (int i = 0; i < 40; ++i) {
        const Vec<D> n = i % 2 == 0 ? dice.direction<D>() : Vec<D>{{1}};
        const double c = std::pow(10.0, dice.uniform(-6, -1)) * (i % 4 < 2 ? 1 : -1);
        const auto t = front_form<D>(n, c);
        for (const double most : {1e3, 1e5}) {
            const auto model = CubicModels<D>({.max_anisotropy = most})(t);
            const auto values = model.logs.values.c;
            // |n|³ + 3|c| |n| |t|² ≤ 1 where n² + 3|c| t² ≤ 1.
            CHECK(log_det(model.logs) < (D - 1) * std::log(3 * std::abs(c)) + 0.02);
            CHECK(*std::max_element(values.begin(), values.end()) < 2);
            CHECK(excess(t, model.logs) < 1e-8);
        }
    }
}

template <int D>
void check_hessians() {
    property("the model of a Hessian has its absolute eigenvalues",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const double power = dice.uniform(-200, 200);
                 const Sym<D> h = dice.symmetric<D>() * std::pow(10.0, power);
                 const auto e = eigen_system(h * std::pow(10.0, -power));
                 const auto model = hessian_model(h, {.max_anisotropy = 1e12});
                 for (int i = 0; i < D; ++i)
                     RC_ASSERT(std::abs(model.logs.values[i] - std::log(std::abs(e.values[i])) -
                                        power * std::log(10.0)) < 1e-6);
             },
             {.count = 60});
    CHECK(hessian_model(Sym<D>{}, {}).kind == ModelKind::zero);
    Sym<D> one;
    one(0, 0) = -3;
    const auto model = hessian_model(one, {.max_anisotropy = 100});
    CHECK(model.kind == ModelKind::floored);
    CHECK(std::exp(model.logs.values[0]) == doctest::Approx(3));
    CHECK(std::exp(model.logs.values[1]) == doctest::Approx(3e-4));
}

}  // namespace

TEST_CASE("models of third derivatives are within 3 % of the optimum") {
    for (const double a : {1.0, 1e2, 1e4, 1e6}) {
        expect_optimal<2>(a, less_if_sanitized(4, 1));
        expect_optimal<3>(a, 1);
    }
}
TEST_CASE("models of third derivatives bound the form and follow its scale and frame") {
    check_models<2>();
    check_models<3>();
}
TEST_CASE("models of degenerate forms are zero or have the maximum anisotropy") {
    check_degenerate_forms<2>();
    check_degenerate_forms<3>();
}
TEST_CASE("models of fronts stay within the diagonal bound") {
    check_fronts<2>();
    check_fronts<3>();
}
TEST_CASE("models of Hessians have their absolute eigenvalues") {
    check_hessians<2>();
    check_hessians<3>();
}
TEST_CASE("cubic_models does not depend on the number of threads") {
    Dice dice(9);
    Buffer<CubicForm<3>> rows;
    for (int i = 0; i < 300; ++i) rows.push_back(random_form<3>(dice, 100));
    rows[7] = {};
    const auto one = must(cubic_models<3>(Column<CubicForm<3>>(rows), {}, one_thread));
    const auto three = must(cubic_models<3>(Column<CubicForm<3>>(rows), {}, Execution{.threads = 3}));
    CHECK(one.zero == 1);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        CHECK(one.rows[i].logs.values == three.rows[i].logs.values);
        CHECK(one.rows[i].logs.vectors == three.rows[i].logs.vectors);
    }
}

TEST_CASE("cubic_models rejects a form that is not finite and returns its number") {
    Dice dice(9);
    Buffer<CubicForm<3>> rows;
    for (int i = 0; i < 300; ++i) rows.push_back(random_form<3>(dice, 100));
    rows[41].c[3] = std::numeric_limits<double>::quiet_NaN();
    const auto bad = cubic_models<3>(Column<CubicForm<3>>(rows), {}, one_thread);
    REQUIRE(!bad);
    CHECK(bad.error().entity->number == 42);
}

TEST_CASE("cubic_models accepts an empty list and rejects a maximum anisotropy below 1") {
    CHECK(must(cubic_models<3>({}, {}, one_thread)).rows.empty());
    CHECK(!cubic_models<3>({}, {.max_anisotropy = 0.5}, one_thread));
}
