// Lengths of curves whose ends have metrics with different axes.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "dice.hpp"
#include "property.hpp"
#include "random_metric.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.edge_optimisation;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
double length_of(const LogMetric<D>& from, const LogMetric<D>& to, const QuadraticEdge<D>& edge) {
    const MeasuringMetric<D> a(from), b(to);
    return quadratic_edge_length<D>({from, a}, {to, b}, edge.chord(), edge.offset());
}

void check_in_2d_and_3d(const auto& check) {
    property("2D", [&](std::uint64_t seed) {
        Dice dice(seed);
        check.template operator()<2>(dice);
    });
    property("3D", [&](std::uint64_t seed) {
        Dice dice(seed);
        check.template operator()<3>(dice);
    });
}

/// Size hn across circles (in 3D cylinders) about the origin, ht along them.
template <int D>
LogMetric<D> around_origin(const Vec<D>& x, double hn, double ht) {
    const double r = std::hypot(x[0], x[1]);
    const std::array<double, 2> n{x[0] / r, x[1] / r};
    LogMetric<D> m{-2 * std::log(ht) * Sym<D>::identity()};
    for (int i = 0; i < 2; ++i)
        for (int j = 0; j <= i; ++j) m.l(i, j) += 2 * std::log(ht / hn) * n[i] * n[j];
    return m;
}

}  // namespace

TEST_CASE("the length of a straight edge equals the degree-1 length from either end") {
    check_in_2d_and_3d([]<int D>(Dice& dice) {
        const LogMetric<D> from = random_metric<D>(dice, 3);
        const QuadraticEdge<D> edge = QuadraticEdge<D>::straight(dice.vector<D>(), dice.vector<D>());
        const MeasuringMetric<D> a(from);
        RC_ASSERT(std::abs(length_of(from, from, edge) / edge_length(a, a, edge.chord()) - 1) < 1e-12);
        // For metrics of one shape, sizes between the ends are geometric means.
        LogMetric<D> to = from;
        to.l += dice.uniform(-4, 4) * Sym<D>::identity();
        const MeasuringMetric<D> b(to);
        RC_ASSERT(std::abs(length_of(from, to, edge) / edge_length(a, b, edge.chord()) - 1) < 1e-12);
        const QuadraticEdge<D> back{edge.p02, edge.mid, edge.p20};
        RC_ASSERT(std::abs(length_of(from, to, edge) / length_of(to, from, back) - 1) < 1e-12);
    });
}

TEST_CASE("the length of a curve approximates the integral in a slowly varying metric") {
    check_in_2d_and_3d([]<int D>(Dice& dice) {
        QuadraticEdge<D> edge = QuadraticEdge<D>::straight(dice.vector<D>(), dice.vector<D>());
        edge.mid.point += 0.1 * norm(edge.chord()) * dice.direction<D>();
        const LogMetric<D> from = random_metric<D>(dice, 0.5);
        LogMetric<D> to = from;
        to.l += dice.symmetric<D>(0.5);
        const Quadrature fine = gauss_legendre(200);
        double length = 0;
        for (std::size_t q = 0; q < fine.size(); ++q) {
            const double t = fine.t[q];
            const SpectralMetric<D> m(LogMetric<D>{(1 - t) * from.l + t * to.l});
            length += fine.w[q] * std::sqrt(m.length_squared(edge.derivative(t)));
        }
        RC_ASSERT(std::abs(length_of(from, to, edge) / length - 1) < 0.05);
    });
}

/// At 0.3 rad and anisotropy 400 the chord has length 11 and the arc 0.75; the log-Euclidean mean alone would be a
/// third off.
TEST_CASE("the length of an arc in a turning metric is measured along the arc") {
    check_in_2d_and_3d([]<int D>(Dice& dice) {
        const double anisotropy = std::exp(dice.uniform(0, std::log(100.0))), turn = dice.uniform(0.02, 0.5);
        const double ht = dice.uniform(0.5, 2) * turn, hn = ht / anisotropy;
        const auto on_circle = [](double angle) {
            Vec<D> p{};
            p[0] = std::cos(angle);
            p[1] = std::sin(angle);
            return p;
        };
        const double from = dice.uniform(-3, 3);
        const Vec<D> a = on_circle(from), b = on_circle(from + turn);
        const QuadraticEdge<D> arc{a, {on_circle(from + turn / 2)}, b};
        const double length = length_of(around_origin(a, hn, ht), around_origin(b, hn, ht), arc);
        RC_ASSERT(std::abs(length / (turn / ht) - 1) < 0.02);
    });
}

TEST_CASE("the mean of two rotated metrics in their frame keeps their sizes") {
    check_in_2d_and_3d([]<int D>(Dice& dice) {
        const double angle = dice.uniform(-0.5, 0.5);
        const Vec<D> a = [] {
            Vec<D> p{};
            p[0] = 1;
            return p;
        }();
        Vec<D> b{};
        b[0] = std::cos(angle);
        b[1] = std::sin(angle);
        const auto from = around_origin(a, 0.01, 1), to = around_origin(b, 0.01, 1);
        const auto mean = frame_mean(from, MeasuringMetric<D>(from).log_sizes, to, MeasuringMetric<D>(to).log_sizes);
        Vec<D> sizes = mean.values;
        std::ranges::sort(sizes.c);
        for (int i = 0; i < D; ++i) RC_ASSERT(std::abs(sizes[i] - MeasuringMetric<D>(from).log_sizes[i]) < 1e-12);
    });
}

TEST_CASE("edges in packs equal single edges for any instruction set") {
    check_in_2d_and_3d([]<int D>(Dice& dice) {
        const std::size_t n = dice.below(20);
        std::vector<Vec<D>> chords(n), offsets(n), expected(n);
        std::vector<EdgeEnds<D>> ends(n);
        std::vector<MeasuringMetric<D>> measures(2 * n);
        std::vector<EndSamples<D>> of_ends(n);
        std::vector<double> lengths(n);
        for (std::size_t i = 0; i < n; ++i) {
            chords[i] = dice.vector<D>(-1, 1);
            for (EdgeEnd<D>* end : {&ends[i].a, &ends[i].b}) {
                end->log_metric = random_metric<D>(dice, 3);
                for (auto& g : end->gradient) g = dice.symmetric<D>(1);
            }
            const bool is_of_one_metric = dice.below(3) == 0;
            if (is_of_one_metric && dice.below(2) == 0) ends[i].a.gradient = {};
            if (is_of_one_metric) ends[i].b = ends[i].a;
            measures[2 * i] = MeasuringMetric<D>(ends[i].a.log_metric);
            measures[2 * i + 1] = MeasuringMetric<D>(ends[i].b.log_metric);
            of_ends[i] = {EndSample<D>{&ends[i].a.log_metric, &ends[i].a.gradient, &measures[2 * i]},
                          EndSample<D>{&ends[i].b.log_metric, &ends[i].b.gradient, &measures[2 * i + 1]}};
        }
        const EdgeAccuracyOptions options{
            .size_share = 0.5, .change = dice.below(2) == 0 ? ChangeSource::recovered : ChangeSource::of_ends};
        accurate_offsets<D>(chords, ends, options, expected);
        for (const Instructions set : {Instructions::baseline, Instructions::avx2, Instructions::avx512}) {
            if (!has(set)) continue;
            bent_edges<D>(chords, of_ends, options, offsets, lengths, set);
            for (std::size_t i = 0; i < n; ++i)
                RC_ASSERT(offsets[i] == expected[i] || norm(offsets[i] - expected[i]) < 1e-12 * norm(chords[i]));
            for (std::size_t i = 0; i < n; ++i) {
                const double one =
                    quadratic_edge_length<D>({ends[i].a.log_metric, measures[2 * i]},
                                             {ends[i].b.log_metric, measures[2 * i + 1]}, chords[i], offsets[i]);
                RC_ASSERT(std::abs(lengths[i] - one) <= 1e-9 * one);
            }
        }
    });
}
