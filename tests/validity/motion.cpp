#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

import camber.core;
import camber.bezier;
import camber.validity;

#include "element_families.hpp"
#include "exact_oracle.hpp"
#include "generators.hpp"

using namespace camber;
using namespace generators;
using camber::testing::property;
using oracle::Answer;
using oracle::Big;

namespace {

template <int D>
std::string in(const std::string& law) {
    return law + " (" + std::to_string(D) + "D)";
}

template <int D>
struct Motion {
    NodalSimplex<D> from, to;
};

/// The element at a moment, exactly, times a power of two.
template <int D>
oracle::Nodes<D, Big> at(const Motion<D>& motion, double s) {
    const auto ends = oracle::big_nodes<D, 2>({motion.from, motion.to});
    constexpr int bits = 60;
    const Big late(static_cast<std::int64_t>(std::ldexp(s, bits)));  // exact for the multiples of 2⁻⁵² in use here
    const Big early = (Big(1) << bits) - late;
    oracle::Nodes<D, Big> n;
    for (std::size_t i = 0; i < n.size(); ++i)
        for (std::size_t c = 0; c < D; ++c) n[i][c] = early * ends[0][i][c] + late * ends[1][i][c];
    return n;
}

template <int D>
Answer answer_at(const Motion<D>& motion, double s, double bound) {
    return oracle::answer<D, Big, Big>(at(motion, s), oracle::share_of(bound), {60, 400, 0});
}

template <int D>
bool fails_at(const Motion<D>& motion, const MotionWitness<D>& witness, double bound) {
    return !oracle::holds_at<D, Big>(at(motion, witness.step), oracle::big_weights<D>(witness.point),
                                     oracle::share_of(bound));
}

/// A vertex goes, and the nodes of its edges half as far.
template <int D>
Motion<D> vertex_motion(std::mt19937_64& random, double reach) {
    Motion<D> m{families::plain<D>(random, uniform(random, 0, 0.15)), {}};
    m.to = m.from;
    const int vertex = static_cast<int>(random() % (D + 1));
    Vec<D> way;
    for (int c = 0; c < D; ++c) way[c] = uniform(random, -reach, reach);
    m.to.nodes[vertex] += way;
    for (int j = 0; j <= D; ++j)
        if (j != vertex) m.to.nodes[elements::node_of<D>(vertex, j)] += 0.5 * way;
    return m;
}

/// All nodes go, each its own way.
template <int D>
Motion<D> free_motion(std::mt19937_64& random, double reach) {
    Motion<D> m{families::plain<D>(random, uniform(random, 0, 0.15)), {}};
    m.to = m.from;
    for (auto& p : m.to.nodes)
        for (int c = 0; c < D; ++c) p[c] += uniform(random, -reach, reach);
    return m;
}

/// The same, thin and turned.
template <int D>
Motion<D> thin_motion(std::mt19937_64& random, double reach) {
    Motion<D> m = free_motion<D>(random, reach);
    const double thin = std::pow(10, uniform(random, -8, 0));
    const auto seed = random();
    for (NodalSimplex<D>* s : {&m.from, &m.to}) {
        families::squeeze(*s, 1, thin);
        std::mt19937_64 same(seed);
        families::rotate(same, *s);
    }
    return m;
}

template <int D>
Motion<D> some_motion(std::mt19937_64& random) {
    switch (random() % 3) {
        case 0: return vertex_motion<D>(random, 0.6);
        case 1: return free_motion<D>(random, uniform(random, 0, 0.4));
        default: return thin_motion<D>(random, uniform(random, 0, 0.4));
    }
}

double some_bound(std::mt19937_64& random) {
    constexpr std::array bounds{0.0, 1e-9, 0.1};
    return bounds[random() % bounds.size()];
}

double moment(std::mt19937_64& random) { return std::ldexp(static_cast<double>(random() % 1025), -10); }

template <int D>
void test_verdicts() {
    property(in<D>("certify_motion: valid at every moment tried, or invalid where it says"),
             [] {
                 auto random = random_source();
                 const auto motion = some_motion<D>(random);
                 const double bound = some_bound(random);
                 const auto certificate = certify_motion(motion.from, motion.to, bound);
                 RC_ASSERT(certificate.verdict != Verdict::undecided);
                 if (certificate.verdict == Verdict::valid) {
                     for (int i = 0; i < 6; ++i) RC_ASSERT(answer_at(motion, moment(random), bound) != Answer::invalid);
                 } else {
                     RC_ASSERT(certificate.witness.has_value());
                     RC_ASSERT(fails_at(motion, *certificate.witness, bound));
                 }
                 RC_CLASSIFY(certificate.verdict == Verdict::valid, "valid");
                 RC_CLASSIFY(certificate.level == Level::filter, "filter");
                 RC_CLASSIFY(certificate.level == Level::bisection, "bisection");
                 RC_CLASSIFY(certificate.level == Level::exact, "exact");
             },
             {D == 2 ? 400 : 200});
}

template <int D>
void test_ends() {
    property(in<D>("certify_motion: one moving node is as good as both ends"),
             [] {
                 auto random = random_source();
                 Motion<D> motion{families::plain<D>(random, 0.15), {}};
                 motion.to = motion.from;
                 auto& node = motion.to.nodes[random() % quadratic_nodes<D>];
                 for (int c = 0; c < D; ++c) node[c] += uniform(random, -0.5, 0.5);
                 const double bound = some_bound(random);
                 const bool both = certify(motion.from, bound).verdict == Verdict::valid &&
                                   certify(motion.to, bound).verdict == Verdict::valid;
                 RC_ASSERT((certify_motion(motion.from, motion.to, bound).verdict == Verdict::valid) == both);
             },
             {300});
    property(
        in<D>("certify_motion: a rest is what its element is, and back is as forth"),
        [] {
            auto random = random_source();
            const auto motion = some_motion<D>(random);
            const double bound = some_bound(random);
            RC_ASSERT(certify_motion(motion.from, motion.from, bound).verdict == certify(motion.from, bound).verdict);
            RC_ASSERT(certify_motion(motion.from, motion.to, bound).verdict ==
                      certify_motion(motion.to, motion.from, bound).verdict);
        },
        {100});
}

template <int D>
void test_step() {
    property(in<D>("certified_step: nothing fails before it, and something soon after"),
             [] {
                 auto random = random_source();
                 const auto motion = some_motion<D>(random);
                 const double bound = some_bound(random);
                 const double step = certified_step(motion.from, motion.to, bound);
                 RC_ASSERT(0 <= step && step <= 1);
                 RC_ASSERT(std::fmod(step, step_resolution) == 0);
                 if (step > 0)
                     for (int i = 0; i < 6; ++i)
                         RC_ASSERT(answer_at(motion, step * moment(random), bound) != Answer::invalid);
                 const auto verdict = certify_motion(motion.from, motion.to, bound).verdict;
                 RC_ASSERT((step == 1) == (verdict == Verdict::valid));
                 if (step < 1) {
                     // The first failure is a crossing of 0, but for unlikely touches.
                     RC_ASSERT(answer_at(motion, std::min(1.0, step + 0x1p-8), bound) != Answer::valid);
                 }
                 RC_CLASSIFY(step == 0, "0");
                 RC_CLASSIFY(step == 1, "1");
             },
             {D == 2 ? 300 : 150});
}

}  // namespace

TEST_CASE("motions, moment by moment") {
    test_verdicts<2>();
    test_verdicts<3>();
}

TEST_CASE("motions and their ends") {
    test_ends<2>();
    test_ends<3>();
}

TEST_CASE("the certified step of a motion") {
    test_step<2>();
    test_step<3>();
}

TEST_CASE("a motion through a flat element between two valid ones") {
    // Half a turn about vertex 0: on straight lines all nodes meet there half way.
    NodalSimplex<2> from;
    for (int a = 1; a <= 2; ++a) from.nodes[a][a - 1] = 2;
    for (int e = 0; e < 3; ++e)
        from.nodes[3 + e] = midpoint(from.nodes[local_edges<2>[e][0]], from.nodes[local_edges<2>[e][1]]);
    NodalSimplex<2> to = from;
    for (auto& p : to.nodes) p = -p;
    const auto c = certify_motion(from, to, 0);
    CHECK(certify(to, 0).verdict == Verdict::valid);
    CHECK(c.verdict == Verdict::invalid);
    REQUIRE(c.witness.has_value());
    CHECK(c.witness->step == 0.5);
    const double step = certified_step(from, to, 0);
    CHECK(step < 0.5);
    CHECK(step > 0.499);
}

TEST_CASE("motions of what is no element") {
    NodalSimplex<3> s;
    for (int a = 1; a <= 3; ++a) s.nodes[a][a - 1] = 1;
    for (int e = 0; e < 6; ++e) s.nodes[4 + e] = midpoint(s.nodes[local_edges<3>[e][0]], s.nodes[local_edges<3>[e][1]]);
    auto broken = s;
    broken.nodes[5][0] = std::nan("");
    CHECK(certify_motion(s, broken, 0).verdict == Verdict::invalid);
    CHECK(certify_motion(broken, s, 0).verdict == Verdict::invalid);
    CHECK(certified_step(s, broken, 0) == 0);
    CHECK(certified_step(s, s, 0) == 1);
}
