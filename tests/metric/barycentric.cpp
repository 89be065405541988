// The barycentric formulation of the minimiser (paper §2.2.2) against the physical one. With the figures printed:
//     CAMBER_FIGURES=1 build/bin/test_metric -tc="barycentric*"
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "back.hpp"
#include "dice.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.metric;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
struct Chord {
    Vec<D> a, b;
};

/// A chord of about `length` whose ends and middle lie in the mesh.
template <int D>
Chord<D> random_chord(const KnownBack<D>& back, Dice& dice, double length) {
    for (;;) {
        const Vec<D> middle = random_point(back.mesh, dice);
        const Vec<D> half = 0.5 * length * dice.direction<D>();
        const Chord<D> chord{middle - half, middle + half};
        bool inside = true;
        for (const Vec<D>& p : {chord.a, chord.b})
            inside = inside && locate(back, p, ElementId(0)).placement == Placement::inside;
        if (inside) return chord;
    }
}

template <int D>
void derivative_laws(EdgeObjectiveKind kind, EdgeFieldKind field) {
    property(
        "the gradient in barycentric coordinates: differences, and Aᵀ times the physical one",
        [=](std::uint64_t seed) {
            Dice dice(seed);
            const auto back = rough_back(unit_box<D>(3, seed + 1), dice);
            const auto rule = gauss_legendre(4);
            const Chord<D> chord = random_chord(back, dice, 0.3);
            const ElementId e(dice.below(back.mesh.elements.size()));
            auto u = dice.barycentric<D>();
            const auto p = corners(back.mesh, e.index());
            Vec<D> node;
            for (int i = 0; i <= D; ++i) node += u[i] * p[i];
            const auto objective = edge_objective(back, rule, kind, field, chord.a, chord.b, ElementId(0));
            const auto sample = evaluate_in_element(objective, e, u);
            const auto physical = objective.evaluate(node);
            RC_ASSERT(std::abs(sample.value - physical.value) <= 1e-11 * physical.value);
            for (int i = 0; i < D; ++i) {
                const double expected = dot(physical.gradient, p[i] - p[D]);
                RC_ASSERT(std::abs(sample.gradient[i] - expected) <= 1e-9 * (physical.value + norm(physical.gradient)));
                RC_ASSERT(std::abs(sample.hessian(i, i) - dot(p[i] - p[D], physical.hessian * (p[i] - p[D]))) <=
                          1e-9 * (1 + sample.hessian(i, i)));
                if (field == EdgeFieldKind::back) continue;  // a sample may cross a face between the differences
                const double h = 1e-6;
                auto forth = u;
                auto aft = u;
                forth[i] += h;
                aft[i] -= h;
                const double difference =
                    (evaluate_in_element(objective, e, forth).value - evaluate_in_element(objective, e, aft).value) /
                    (2 * h);
                RC_ASSERT(std::abs(sample.gradient[i] - difference) <= 1e-6 * (1 + std::abs(difference)));
            }
        },
        {.count = 40});
}

struct Comparison {
    int edges = 0, same = 0, kinked = 0, bary_shorter = 0, physical_shorter = 0, outside = 0;
    double mean_apart = 0, mean_bary = 0, mean_physical = 0, largest_loss = 0;
    std::vector<double> apart;  ///< of the nodes, in chords
};

/// Both minimisers on the same chords; `field` as the objective sees it.
template <int D>
Comparison compared(const KnownBack<D>& back, double length, int edges, const EdgeMinimiserOptions& options,
                    std::uint64_t seed) {
    Dice dice(seed);
    const EdgeRules rules = edge_rules(options);
    Comparison c;
    for (int k = 0; k < edges; ++k) {
        const Chord<D> chord = random_chord(back, dice, length);
        const auto physical = minimise_edge(back, chord.a, chord.b, ElementId(0), rules, options);
        const auto bary = minimise_edge_barycentric(back, chord.a, chord.b, ElementId(0), rules, options);
        c.outside += physical.outside || bary.outside;
        if (physical.outside || bary.outside) continue;
        // Judged by the same rule on the same field, neither is longer than its chord.
        CHECK(bary.length <= bary.straight_length);
        CHECK(bary.straight_length == physical.straight_length);
        const double apart = distance(bary.node.point, physical.node.point) / length;
        const double difference = bary.length / physical.length - 1;
        ++c.edges;
        c.same += apart < 1e-3;
        c.kinked += bary.search == EdgeSearch::polished || physical.search == EdgeSearch::polished;
        c.bary_shorter += difference < -1e-5;
        c.physical_shorter += difference > 1e-5;
        c.largest_loss = std::max(c.largest_loss, difference);
        c.mean_apart += apart;
        c.mean_bary += bary.straight_length / bary.length - 1;
        c.mean_physical += physical.straight_length / physical.length - 1;
        c.apart.push_back(apart);
    }
    c.mean_apart /= c.edges;
    c.mean_bary /= c.edges;
    c.mean_physical /= c.edges;
    std::sort(c.apart.begin(), c.apart.end());
    return c;
}

void print(const char* name, int dimension, const Comparison& c) {
    if (std::getenv("CAMBER_FIGURES") == nullptr) return;
    const auto at = [&](double share) {
        return c.apart[static_cast<std::size_t>(share * static_cast<double>(c.apart.size() - 1))];
    };
    std::printf(
        "  %dD %-22s %3d edges: nodes apart (chords) median %.1e, 90%% %.1e, largest %.1e; within 1e-3: %d; at kinks "
        "%d\n"
        "       mean gain barycentric %.6f physical %.6f; shorter by 1e-5: %d and %d; largest loss %.1e\n",
        dimension, name, c.edges, at(0.5), at(0.9), at(1), c.same, c.kinked, c.mean_bary, c.mean_physical,
        c.bary_shorter, c.physical_shorter, c.largest_loss);
}

template <int D>
KnownBack<D> fine_polar() {
    const std::array<int, D> cells = [] {
        std::array<int, D> n{};
        n.fill(D == 2 ? 96 : 24);
        return n;
    }();
    return back_of(shell_block<D>(cells, 3, 0.0), [](const Vec<D>& x) { return polar<D>(x, 0.1 * norm(x), 0.4); });
}

template <int D>
void smooth() {
    const auto back = fine_polar<D>();
    for (const auto kind : {EdgeObjectiveKind::energy, EdgeObjectiveKind::length}) {
        EdgeMinimiserOptions options;
        options.objective = kind;
        const auto c = compared(back, 0.8, 60, options, 7);
        print(kind == EdgeObjectiveKind::energy ? "smooth, energy" : "smooth, length", D, c);
        CHECK(c.edges >= 40);
        CHECK(std::abs(c.mean_bary - c.mean_physical) <= 2e-3 * c.mean_physical);
        CHECK(c.largest_loss < 1e-3);
    }
}

template <int D>
void piecewise() {
    Dice dice(23);
    const auto back = rough_back(unit_box<D>(4, 9), dice, 1);
    for (const auto field : {EdgeFieldKind::back, EdgeFieldKind::edge}) {
        EdgeMinimiserOptions options;
        options.field = field;
        const auto c = compared(back, 0.35, 60, options, 8);
        print(field == EdgeFieldKind::back ? "piecewise, true field" : "piecewise, 3-node field", D, c);
        CHECK(c.edges >= 20);
        CHECK(c.mean_bary > 0.9 * c.mean_physical);
    }
}

}  // namespace

TEST_CASE("barycentric objective: derivatives") {
    for (const auto kind : {EdgeObjectiveKind::energy, EdgeObjectiveKind::length})
        for (const auto field : {EdgeFieldKind::back, EdgeFieldKind::edge}) {
            derivative_laws<2>(kind, field);
            derivative_laws<3>(kind, field);
        }
}
TEST_CASE("barycentric minimiser on a smooth field, 2D") { smooth<2>(); }
TEST_CASE("barycentric minimiser on a smooth field, 3D") { smooth<3>(); }
TEST_CASE("barycentric minimiser on piecewise fields, 2D") { piecewise<2>(); }
TEST_CASE("barycentric minimiser on piecewise fields, 3D") { piecewise<3>(); }

TEST_CASE("barycentric minimiser: the same node from any start of the location, and an affine field's minimum") {
    Dice dice(31);
    const auto field = AffineField<3>::random(dice, 1);
    const auto back = back_of(unit_box<3>(4, 5), field);
    const EdgeMinimiserOptions options;
    const EdgeRules rules = edge_rules(options);
    for (int k = 0; k < 10; ++k) {
        const auto chord = random_chord(back, dice, 0.4);
        const auto one = minimise_edge_barycentric(back, chord.a, chord.b, ElementId(0), rules, options);
        const auto other =
            minimise_edge_barycentric(back, chord.a, chord.b, ElementId(back.mesh.elements.size() - 1), rules, options);
        const auto physical = minimise_edge(back, chord.a, chord.b, ElementId(0), rules, options);
        CHECK(distance(one.node.point, other.node.point) < 1e-6);
        CHECK(distance(one.node.point, physical.node.point) < 1e-3);
        CHECK(std::abs(one.length / physical.length - 1) < 1e-6);
    }
}
