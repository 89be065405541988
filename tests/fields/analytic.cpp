// Analytic metric fields compared with their definitions.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <variant>
#include <vector>

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
double size_along(const LogMetric<D>& m, const Vec<D>& direction) {
    return 1 / std::sqrt(SpectralMetric<D>(m).length_squared(normalised(direction)));
}

/// R diag(h_r⁻², h_t⁻², h_z⁻²) Rᵀ with t = atan2(y, x), as in UGAWG's definition.
Sym<3> ugawg_polar(const Vec<3>& x, double hr, double ht, double hz) {
    const double t = std::atan2(x[1], x[0]);
    const Mat<3> r{{Vec<3>{{std::cos(t), std::sin(t), 0}}, Vec<3>{{-std::sin(t), std::cos(t), 0}}, Vec<3>{{0, 0, 1}}}};
    return congruence(r, Sym<3>::diagonal(Vec<3>{{1 / (hr * hr), 1 / (ht * ht), 1 / (hz * hz)}}));
}

}  // namespace

TEST_CASE("UGAWG fields match their definitions") {
    property("linear, polar-1 and polar-2 equal their definitions", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto x = dice.vector<3>(0, 1);
        const auto near = [](const LogMetric<3>& m, const Sym<3>& expected) {
            return norm(exp(m).m - expected) <= 1e-9 * norm(expected);
        };
        const double hz = 0.001 + 2 * (0.1 - 0.001) * std::abs(x[2] - 0.5);
        RC_ASSERT(near(evaluate<3>(LinearField{}, x), Sym<3>::diagonal(Vec<3>{{100, 100, 1 / (hz * hz)}})));
        const double r = std::sqrt(x[0] * x[0] + x[1] * x[1]);
        const double hr = 0.001 + 2 * (0.1 - 0.001) * std::abs(r - 0.5);
        RC_ASSERT(near(evaluate<3>(PolarOneField{}, x), ugawg_polar(x, hr, 0.1, 0.1)));
        const double d = std::min(10 * std::abs(r - 0.5), 1.0);
        RC_ASSERT(near(evaluate<3>(PolarTwoField{}, x), ugawg_polar(x, hr, 0.1 * d + 0.025 * (1 - d), 0.1)));
        // In 2D the same without z.
        const Vec<2> flat{{x[0], x[1]}};
        const Vec<2> across{{-x[1], x[0]}};
        RC_ASSERT(std::abs(size_along(evaluate<2>(PolarOneField{}, flat), flat) / hr - 1) < 1e-9);
        RC_ASSERT(std::abs(size_along(evaluate<2>(PolarTwoField{}, flat), across) / (0.1 * d + 0.025 * (1 - d)) - 1) <
                  1e-9);
        // The scale applies to all sizes.
        RC_ASSERT(norm(evaluate<3>(PolarOneField{.scale = 1 / 1.3}, x).l - evaluate<3>(PolarOneField{}, x).l -
                       2 * std::log(1.3) * Sym<3>::identity()) < 1e-12);
    });
}

TEST_CASE("polar-1 scaled by 1/1.3 has the sizes of its formula at r = 0.26995") {
    // h_r = (0.001 + 2 (0.1 - 0.001) |r - 0.5|) / 1.3 and h_t = 0.1 / 1.3.
    const auto m = evaluate<3>(PolarOneField{.scale = 1 / 1.3}, Vec<3>{{0.26995, 0, 0.3}});
    CHECK(size_along(m, Vec<3>{{1, 0, 0}}) == doctest::Approx(0.035807).epsilon(2e-5));
    CHECK(size_along(m, Vec<3>{{0, 1, 0}}) == doctest::Approx(0.076923).epsilon(1e-5));
    CHECK(anisotropy(evaluate<3>(PolarOneField{}, Vec<3>{{0.3, 0.4, 0}})) == doctest::Approx(100));
}

TEST_CASE("shock fields are thin at the jump along its normal") {
    const PlanarShock<3> plane{
        .point = {{0, 0, 1}}, .normal = {{0, 0, -2}}, .min_size = 0.001, .size = 1, .width = 0.1};
    CHECK(size_along(evaluate<3>(plane, Vec<3>{{5, 5, 1}}), Vec<3>{{0, 0, 1}}) == doctest::Approx(0.001));
    CHECK(size_along(evaluate<3>(plane, Vec<3>{{5, 5, 1}}), Vec<3>{{0, 1, 0}}) == doctest::Approx(1));
    CHECK(size_along(evaluate<3>(plane, Vec<3>{{5, 5, 9}}), Vec<3>{{0, 0, 1}}) == doctest::Approx(1));
    const double u = std::tanh(0.5);
    CHECK(size_along(evaluate<3>(plane, Vec<3>{{0, 0, 1.05}}), Vec<3>{{0, 0, 1}}) ==
          doctest::Approx(std::pow(0.001, 1 - u * u)));
    const SphericalShock<2> sphere{.centre = {{1, 0}}, .radius = 2, .min_size = 0.01, .size = 0.5};
    CHECK(size_along(evaluate<2>(sphere, Vec<2>{{3, 0}}), Vec<2>{{1, 0}}) == doctest::Approx(0.01));
    CHECK(size_along(evaluate<2>(sphere, Vec<2>{{1, 2}}), Vec<2>{{0, 1}}) == doctest::Approx(0.01));
    CHECK(size_along(evaluate<2>(sphere, Vec<2>{{1, 2}}), Vec<2>{{1, 0}}) == doctest::Approx(0.5));
}

TEST_CASE("the rotating field turns with its period") {
    const RotatingField turning{.min_size = 0.1, .size = 1, .period = 2};
    CHECK(size_along(evaluate<2>(turning, Vec<2>{{0, 7}}), Vec<2>{{1, 0}}) == doctest::Approx(0.1));
    CHECK(size_along(evaluate<2>(turning, Vec<2>{{0.5, 7}}), Vec<2>{{0, 1}}) == doctest::Approx(0.1));
    CHECK(size_along(evaluate<3>(turning, Vec<3>{{0.25, 7, 1}}), Vec<3>{{1, 1, 0}}) == doctest::Approx(0.1));
}

TEST_CASE("analytic fields are finite everywhere, also on axes and at centres") {
    const std::vector<Vec<3>> points{Vec<3>{}, Vec<3>{{0, 0, 0.5}}, Vec<3>{{1e9, -1e9, 1e9}}};
    for (const AnalyticField<3>& field :
         {AnalyticField<3>(LinearField{}), AnalyticField<3>(PolarOneField{}), AnalyticField<3>(PolarTwoField{}),
          AnalyticField<3>(PlanarShock<3>{.point = {}, .normal = {{1, 0, 0}}}), AnalyticField<3>(SphericalShock<3>{}),
          AnalyticField<3>(RotatingField{})}) {
        const auto logs = must(log_metrics_of<3>(field, points, one_thread));
        for (const auto& m : logs)
            for (const double x : m.l.c) CHECK(std::isfinite(x));
        CHECK(must(log_metrics_of<3>(field, points, Execution{.threads = 2})) == logs);
    }
}

TEST_CASE("analytic fields reject invalid parameters") {
    const std::vector<Vec<3>> points{Vec<3>{}, Vec<3>{{0, 0, 0.5}}, Vec<3>{{1e9, -1e9, 1e9}}};
    const auto kind = [&](const AnalyticField<3>& field) {
        return log_metrics_of<3>(field, points, one_thread).error().kind;
    };
    CHECK(kind(LinearField{.size = 0}) == ErrorKind::usage);
    CHECK(kind(PolarTwoField{.layer_width = -1}) == ErrorKind::usage);
    CHECK(kind(PlanarShock<3>{}) == ErrorKind::usage);
    CHECK(kind(SphericalShock<3>{.width = 0}) == ErrorKind::usage);
}
