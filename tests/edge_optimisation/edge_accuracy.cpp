// The closed form for accuracy: invariance, known special cases, and bounds.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>
#include <rapidcheck.h>

#include "dice.hpp"
#include "property.hpp"

import camber.core;
import camber.metric;
import camber.edge_optimisation;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
Vec<D> offset_by(const Vec<D>& chord, const EdgeEnd<D>& middle, const EdgeAccuracyOptions& options) {
    const EdgeEnds<D> ends{middle, middle};
    Vec<D> offset;
    accurate_offsets<D>({&chord, 1}, {&ends, 1}, options, {&offset, 1});
    return offset;
}
template <int D>
Vec<D> offset_of(const Vec<D>& chord, const EdgeEnd<D>& middle, double size_share = 0.5) {
    return offset_by(chord, middle, {.size_share = size_share});
}

/// A field at the middle of an edge whose sizes and axes change by `change` per unit length.
template <int D>
EdgeEnd<D> random_middle(Dice& dice, double size, double change) {
    EdgeEnd<D> s;
    s.log_metric.l = dice.symmetric<D>(size);
    for (auto& g : s.gradient) g = dice.symmetric<D>(change);
    return s;
}

template <int D>
void check_offsets() {
    property("the offset is zero without gradient and the same for the reversed chord", [](std::uint64_t seed) {
        Dice dice(seed);
        const Vec<D> chord = dice.vector<D>(-1, 1);
        RC_ASSERT(offset_of(chord, random_middle<D>(dice, 5, 0)) == Vec<D>{});
        const auto middle = random_middle<D>(dice, 3, 1);
        RC_ASSERT(norm(offset_of(chord, middle) - offset_of(-chord, middle)) <= 1e-12 * norm(chord));
    });
    property("offsets rotate and scale with the coordinates, for any coarse enough metric", [](std::uint64_t seed) {
        Dice dice(seed);
        const Vec<D> chord = dice.vector<D>(-1, 1);
        auto middle = random_middle<D>(dice, 3, 1);
        middle.log_metric.l += -10.0 * Sym<D>::identity();  // edges shorter than unit
        const Vec<D> d = offset_of(chord, middle);
        const Mat<D> r = dice.rotation<D>();
        EdgeEnd<D> turned;
        turned.log_metric.l = congruence(r, middle.log_metric.l);
        for (int i = 0; i < D; ++i)
            for (int j = 0; j < D; ++j) turned.gradient[i] += r(i, j) * congruence(r, middle.gradient[j]);
        RC_ASSERT(norm(offset_of(r * chord, turned) - r * d) <= 1e-9 * norm(chord));
        const double scale = std::exp(dice.uniform(-20, 20));
        EdgeEnd<D> scaled = middle;
        scaled.log_metric.l += dice.uniform(-40, 0) * Sym<D>::identity();
        scaled.log_metric.l += -2 * std::log(scale) * Sym<D>::identity();
        for (auto& g : scaled.gradient) g = (1 / scale) * g;
        RC_ASSERT(norm(offset_of(scale * chord, scaled) - scale * d) <= 1e-9 * scale * norm(chord));
    });
    property("the isotropic offset is a share of the first step to the geodesic", [](std::uint64_t seed) {
        Dice dice(seed);
        const Vec<D> chord = dice.vector<D>(-1, 1);
        const Vec<D> slope = dice.vector<D>(-0.05, 0.05);
        EdgeEnd<D> middle;
        middle.log_metric.l = dice.uniform(-9, -2) * Sym<D>::identity();
        for (int i = 0; i < D; ++i) middle.gradient[i] = slope[i] * Sym<D>::identity();
        // Γ(e, e)/8 of M = e^l I.
        const Vec<D> geodesic = (dot(slope, chord) * chord - 0.5 * norm_squared(chord) * slope) * 0.125;
        const double share = dice.uniform(0.01, 1);
        RC_ASSERT(norm(offset_of(chord, middle, share) - share * geodesic) <= 1e-3 * norm(geodesic) + 1e-15);
        // The natural metric of the mesh: only along the growth direction.
        const double along = dot(slope, chord);
        const Vec<D> layered = along * along / (16 * norm_squared(slope)) * slope;
        RC_ASSERT(norm(offset_by(chord, middle, {.metric_kind = MetricKind::natural}) - layered) <=
                  1e-3 * norm(geodesic) + 1e-15);
    });
    property("the offset in the Hessian metric of a cubic is its exact offset", [](std::uint64_t seed) {
        // u = |x|²/2 + T[x, x, x]/6: H = I + T[x, ·, ·], log H ≈ T[x, ·, ·], and d = T[e, e, ·]/24.
        Dice dice(seed);
        std::array<Sym<D>, D> third;
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j)
                for (int k = 0; k <= j; ++k) {
                    const double t = dice.uniform(-0.02, 0.02);
                    third[i](j, k) = third[j](i, k) = third[k](i, j) = t;
                }
        EdgeEnd<D> middle;
        middle.log_metric.l = -6.0 * Sym<D>::identity();
        for (int i = 0; i < D; ++i) middle.gradient[i] = third[i];
        const Vec<D> e = dice.vector<D>(-1, 1);
        Vec<D> expected;
        for (int i = 0; i < D; ++i) expected[i] = dot(e, third[i] * e) / 24;
        const Vec<D> d = offset_by(e, middle, {.metric_kind = MetricKind::hessian, .metric_norm = 0});
        RC_ASSERT(norm(d - expected) <= 1e-3 * norm(expected) + 1e-12);
    });
    property("ChangeAlong::of_ends uses the sizes at both ends", [](std::uint64_t seed) {
        Dice dice(seed);
        const Vec<D> e = dice.vector<D>(-1, 1);
        const double change = dice.uniform(-0.2, 0.2), size = dice.uniform(-9, -2);
        EdgeEnds<D> ends;
        ends.a.log_metric.l = (size - change / 2) * Sym<D>::identity();
        ends.b.log_metric.l = (size + change / 2) * Sym<D>::identity();
        Vec<D> d;
        accurate_offsets<D>({&e, 1}, {&ends, 1}, {.size_share = 1, .change = ChangeSource::of_ends}, {&d, 1});
        RC_ASSERT(norm(d - change / 16 * e) <= 1e-3 * std::abs(change) * norm(e));
    });
    property("the offset with thin radial axes is the sagitta of the circle", [](std::uint64_t seed) {
        Dice dice(seed);
        const double radius = dice.uniform(1, 10);
        const double thin = std::exp(dice.uniform(-14, -5));
        Vec<D> sizes;
        sizes.c.fill(1);
        sizes[0] = thin;  // the radius is along x at the middle
        EdgeEnd<D> middle;
        middle.log_metric = log_metric_of_sizes<D>(sizes);
        middle.gradient[1](0, 1) = (middle.log_metric.l(0, 0) - middle.log_metric.l(1, 1)) / radius;
        Vec<D> chord = dice.vector<D>(-0.1, 0.1);
        chord[1] = 0.2 * dice.uniform(0.5, 1);
        const double sagitta = chord[1] * chord[1] / (8 * radius);
        const Vec<D> d = offset_of(chord, middle);
        RC_ASSERT(std::abs(d[0] - sagitta) <= 0.01 * sagitta);
        RC_ASSERT(std::abs(d[1]) <= 1e-3 * sagitta);
    });
    property("offsets are finite and bounded for any anisotropy and gradient", [](std::uint64_t seed) {
        Dice dice(seed);
        const Vec<D> chord = std::exp(dice.uniform(-30, 30)) * dice.vector<D>(-1, 1);
        const auto middle = random_middle<D>(dice, 28, std::exp(dice.uniform(-30, 40)));
        const Vec<D> d = offset_of(chord, middle);
        RC_ASSERT(std::isfinite(norm(d)));
        RC_ASSERT(std::abs(dot(d, chord)) <= 0.2001 * norm_squared(chord));
    });
    property("the offset of an edge does not depend on its pack or the instruction set", [](std::uint64_t seed) {
        Dice dice(seed);
        std::vector<Vec<D>> chords(dice.below(20)), offsets(chords.size()), single(chords.size());
        std::vector<EdgeEnds<D>> ends(chords.size());
        for (std::size_t i = 0; i < chords.size(); ++i) {
            chords[i] = dice.vector<D>(-1, 1);
            ends[i] = {random_middle<D>(dice, 15, 1), random_middle<D>(dice, 15, 1), dice.below(2) == 0};
            if (!ends[i].is_curved) continue;
            for (Vec<D>& column : ends[i].a.jacobian.column) column += dice.vector<D>(-0.3, 0.3);
            for (Vec<D>& column : ends[i].b.jacobian.column) column += dice.vector<D>(-0.3, 0.3);
        }
        for (std::size_t i = 0; i < chords.size(); ++i)
            accurate_offsets<D>({&chords[i], 1}, {&ends[i], 1}, {}, {&single[i], 1}, Instructions::baseline);
        for (const Instructions set : {Instructions::baseline, Instructions::avx2, Instructions::avx512}) {
            if (!has(set)) continue;
            accurate_offsets<D>(chords, ends, {}, offsets, set);
            RC_ASSERT(offsets == single);
        }
    });
}

}  // namespace

TEST_CASE("share_of_sizes depends on the kind and norm of the metric") {
    const auto share = [](MetricKind kind, double norm, int dimension) {
        return share_of_sizes({.metric_kind = kind, .metric_norm = norm}, dimension);
    };
    CHECK(share(MetricKind::hessian, 0, 2) == doctest::Approx(2.0 / 3));
    CHECK(share(MetricKind::hessian, 2, 2) == doctest::Approx(1));
    CHECK(share(MetricKind::hessian, 2, 3) == doctest::Approx(7.0 / 6));
    CHECK(share(MetricKind::third_derivatives, 0, 3) == doctest::Approx(1));
    CHECK(share(MetricKind::third_derivatives, 2, 3) == doctest::Approx(1.5));
    CHECK(share(MetricKind::geometry, 2, 3) == 0);
    CHECK(share_of_sizes({.metric_kind = MetricKind::geometry, .size_share = 0.3}, 2) == 0.3);
}
TEST_CASE("accurate offsets are invariant, bounded and exact for known fields, 2D") { check_offsets<2>(); }
TEST_CASE("accurate offsets are invariant, bounded and exact for known fields, 3D") { check_offsets<3>(); }

TEST_CASE("the offset in evenly rotating axes is the sagitta of the arc") {
    for (const double turn : {0.05, 0.1, 0.2, 0.3, 0.4}) {
        const auto at = [](double angle) {
            EdgeEnd<2> end;
            const double anisotropy = 2 * std::log(100.0), c = std::cos(angle), s = std::sin(angle);
            end.log_metric.l(0, 0) = anisotropy * c * c;
            end.log_metric.l(0, 1) = anisotropy * c * s;
            end.log_metric.l(1, 1) = anisotropy * s * s;
            return end;
        };
        const EdgeEnds<2> ends{at(-turn / 2), at(turn / 2)};
        const Vec<2> chord{{0, 2 * std::sin(turn / 2)}};
        Vec<2> offset;
        accurate_offsets<2>({&chord, 1}, {&ends, 1},
                            {.metric_kind = MetricKind::geometry, .change = ChangeSource::of_ends}, {&offset, 1});
        const double sagitta = 1 - std::cos(turn / 2);
        CHECK(std::abs(offset[0] / sagitta - 1) < 0.012);
        CHECK(std::abs(offset[1]) < 1e-12);
    }
}

// u = e^{-x/ε} and the size of its Hessian, h ~ e^{x/(2ε)}: the third derivative of u∘F vanishes at the middle.
TEST_CASE("the offset for a Hessian metric removes the third derivative in one direction") {
    for (const double eps : {1.0, 3.0, -2.0}) {
        const double chord = 0.05;
        EdgeEnd<2> middle;
        middle.gradient[0] = (-1 / eps) * Sym<2>::identity();  // log |u''|
        middle.gradient[0](1, 1) = 0;
        middle.log_metric.l(0, 0) = 0;
        middle.log_metric.l(1, 1) = -20;  // a constant size across
        const double d = offset_of<2>({chord, 0}, middle, 2.0 / 3)[0];
        const double third = -chord * chord * chord / (eps * eps * eps) - 24 * chord * d / (eps * eps);
        CHECK(std::abs(third) < 1e-3 * std::abs(chord * chord * chord / (eps * eps * eps)));
    }
}
