#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <type_traits>
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

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

template <int D>
std::string in(const std::string& name) {
    return name + " (" + std::to_string(D) + "D)";
}

template <int D>
NodalSimplex<D> tuned(std::mt19937_64& random, double bound) {
    const auto family = static_cast<families::Family>(random() % 5);
    return families::tuned<D>(random, families::element<D>(random, family), [&](const NodalSimplex<D>& s) {
        return certify_exactly(s, bound).verdict == Verdict::valid;
    });
}

/// Checks the consistency of a certificate with the verdict of exact arithmetic.
template <int D>
void compare(const NodalSimplex<D>& s, double bound, const Certificate<D>& certificate, Answer answer) {
    if (certificate.verdict == Verdict::valid) RC_ASSERT(answer != Answer::invalid);
    if (certificate.verdict == Verdict::invalid) RC_ASSERT(answer != Answer::valid);
    if (answer == Answer::valid) RC_ASSERT(certificate.verdict == Verdict::valid);
    if (answer == Answer::invalid && D == 2) RC_ASSERT(certificate.verdict == Verdict::invalid);
    RC_ASSERT(!certificate.witness || certificate.verdict == Verdict::invalid);
    if (certificate.witness) RC_ASSERT(!oracle::holds_at<D>(s, *certificate.witness, bound));
}

double some_bound(std::mt19937_64& random) {
    constexpr std::array bounds{0.0, 0.0, 1e-12, 1e-3, 0.3, -1.0};
    return bounds[random() % bounds.size()];
}

template <int D>
void test_families() {
    for (int f = 0; f < families::count; ++f)
        property(in<D>(std::string("certificates agree with the oracle, and witnesses fail: ") + families::names[f]),
                 [f] {
                     auto random = random_source();
                     const double bound = some_bound(random);
                     const auto family = static_cast<families::Family>(f);
                     const auto s = family == families::Family::tuned ? tuned<D>(random, bound)
                                                                      : families::element<D>(random, family);
                     const Answer answer = oracle::answer<D>(s, bound);
                     const auto certificate = certify(s, bound);
                     const auto exact = certify_exactly(s, bound);
                     compare<D>(s, bound, certificate, answer);
                     compare<D>(s, bound, exact, answer);
                     RC_ASSERT(certificate.verdict != Verdict::undecided);
                     RC_ASSERT(certificate.verdict == exact.verdict);
                     RC_ASSERT(decide(s, bound) == exact.verdict);
                     RC_ASSERT(check_element(s, bound).verdict == exact.verdict);
                     if (certificate.verdict == Verdict::invalid && certificate.level != Level::exact)
                         RC_ASSERT(certificate.witness.has_value());
                     RC_CLASSIFY(certificate.verdict == Verdict::valid, "valid");
                     RC_CLASSIFY(certificate.level == Level::exact, "exact");
                     RC_CLASSIFY(certificate.level == Level::twice, "twice");
                 },
                 {D == 2 ? 400 : 200});
}

template <int D>
void test_lattice() {
    property(in<D>("certificates of lattice elements agree with 128-bit integers"),
             [] {
                 auto random = random_source();
                 const auto n =
                     families::lattice_element<D>(random, 1 + static_cast<int>(random() % 2), 1 + random() % 4);
                 const auto s = families::in_doubles<D>(n);
                 const Answer answer = oracle::answer<D, oracle::Wide, std::int64_t>(n, {}, {28, 10000, 24});
                 const auto certificate = certify(s, 0);
                 compare<D>(s, 0, certificate, answer);
                 RC_ASSERT(answer == Answer::unknown || certificate.verdict != Verdict::undecided);
                 if (certificate.verdict == Verdict::invalid) RC_ASSERT(certificate.witness.has_value());
                 RC_CLASSIFY(certificate.verdict == Verdict::valid, "valid");
                 RC_CLASSIFY(certificate.verdict == Verdict::undecided, "undecided");
                 RC_CLASSIFY(certificate.level == Level::exact, "exact");
             },
             {4000});
}

/// Moves that preserve det J: integer translations, permutations of the axes and, with the right sign, of the vertices.
template <int D>
void test_symmetries() {
    property(in<D>("verdicts do not change under translations and permutations"),
             [] {
                 auto random = random_source();
                 const auto n = families::lattice_element<D>(random, 1, 2);
                 const auto s = families::in_doubles<D>(n);
                 const double bound = some_bound(random);
                 std::array<int, D + 1> order{};
                 std::iota(order.begin(), order.end(), 0);
                 std::shuffle(order.begin(), order.end(), random);
                 bool odd = false;
                 for (int i = 0; i <= D; ++i)
                     for (int j = 0; j < i; ++j) odd = odd != (order[j] > order[i]);
                 const double shift = static_cast<double>(random() % (std::uint64_t{1} << 50));
                 NodalSimplex<D> other;
                 for (int i = 0; i <= D; ++i)
                     for (int j = 0; j <= D; ++j) {
                         const auto p = s.nodes[elements::node_of<D>(order[i], order[j])];
                         auto& q = other.nodes[elements::node_of<D>(i, j)];
                         for (int c = 0; c < D; ++c) q[c] = p[(c + 1) % D] + shift;
                     }
                 // A cyclic permutation of the axes is even in 3D and odd in 2D.
                 if (odd != (D == 2))
                     for (auto& p : other.nodes) p[0] = -p[0];
                 RC_ASSERT(certify(other, bound).verdict == certify(s, bound).verdict);
             },
             {1000});
}

}  // namespace

TEST_CASE("certificates agree with exact arithmetic") {
    test_families<2>();
    test_families<3>();
}

TEST_CASE("certificates of lattice elements agree with 128-bit integer arithmetic") {
    test_lattice<2>();
    test_lattice<3>();
}

TEST_CASE("certificates are invariant under translations and permutations") {
    test_symmetries<2>();
    test_symmetries<3>();
}

TEST_CASE("the exact check of triangles by formula agrees with bisection") {
    property("the closed form of the oracle agrees with bisection",
             [] {
                 auto random = random_source();
                 const auto n = families::lattice_element<2>(random, 1, 2);
                 const Answer formula = oracle::answer<2, oracle::Wide, std::int64_t>(n, {}, {});
                 const auto c = oracle::coefficients<2, oracle::Wide>(
                     [&] {
                         oracle::Nodes<2, oracle::Wide> wide;
                         for (std::size_t i = 0; i < n.size(); ++i)
                             for (std::size_t a = 0; a < 2; ++a) wide[i][a] = n[i][a];
                         return wide;
                     }(),
                     {});
                 int parts = 4000;
                 const Answer bisected = oracle::bisected<2>(c, 40, parts);
                 if (bisected != Answer::unknown) RC_ASSERT(formula == bisected);
             },
             {1000});
}

TEST_CASE("exact certificates decide elements whose Jacobian touches 0") {
    // z ↦ z²/2 about a point has det J = |z|², which vanishes only there. The map is scaled by 72 about (1/3, 1/3), so
    // nodes are integers.
    const auto squared = [](auto s) {
        for (auto& p : s.nodes) {
            const double x = 6 * p[0] - 2;
            const double y = 6 * p[1] - 2;
            p[0] = x * x - y * y;
            p[1] = 2 * x * y;
        }
        return s;
    };
    const auto unit_simplex = []<int D>(std::integral_constant<int, D>) {
        NodalSimplex<D> s;
        for (int a = 1; a <= D; ++a) s.nodes[a][a - 1] = 1;
        for (int e = 0; e < edges_per_simplex<D>; ++e)
            s.nodes[D + 1 + e] = midpoint(s.nodes[local_edges<D>[e][0]], s.nodes[local_edges<D>[e][1]]);
        return s;
    };
    SUBCASE("a triangle whose Jacobian vanishes at its centroid is invalid") {
        const auto c = certify(squared(unit_simplex(std::integral_constant<int, 2>{})), 0);
        CHECK(c.verdict == Verdict::invalid);
        CHECK(c.level == Level::exact);
        CHECK(c.witness == Barycentric<2>{1, 1, 1});
    }
    SUBCASE("a tetrahedron whose Jacobian vanishes along a line is invalid") {
        const auto s = squared(unit_simplex(std::integral_constant<int, 3>{}));
        const auto c = certify(s, 0);
        CHECK(c.verdict == Verdict::invalid);
        CHECK(c.level == Level::exact);
        REQUIRE(c.witness.has_value());
        CHECK_FALSE(oracle::holds_at<3>(s, *c.witness, 0));
    }
    SUBCASE("a flat tetrahedron is invalid") {
        NodalSimplex<3> s;
        for (int e = 0; e < 6; ++e)
            s.nodes[4 + e] = midpoint(s.nodes[local_edges<3>[e][0]], s.nodes[local_edges<3>[e][1]]);
        const auto c = certify(s, 0);
        CHECK(c.verdict == Verdict::invalid);
        CHECK(c.level == Level::exact);
        CHECK(c.witness.has_value());
    }
    SUBCASE("a straight element is valid for the bound 1 and invalid above it") {
        NodalSimplex<3> s;
        for (int a = 1; a <= 3; ++a) s.nodes[a][a - 1] = a;
        for (int e = 0; e < 6; ++e)
            s.nodes[4 + e] = midpoint(s.nodes[local_edges<3>[e][0]], s.nodes[local_edges<3>[e][1]]);
        CHECK(certify(s, 1).verdict == Verdict::valid);
        CHECK(certify(s, 1).level == Level::exact);
        const auto above = certify(s, std::nextafter(1, 2));
        CHECK(above.verdict == Verdict::invalid);
        CHECK(above.witness.has_value());
    }
}

TEST_CASE("certificates are exact for very small and very large coordinates") {
    property("powers of two on the axes do not change the verdict",
             [] {
                 auto random = random_source();
                 const auto n = families::lattice_element<3>(random, 1, 2);
                 auto s = families::in_doubles<3>(n);
                 const auto before = certify(s, 0).verdict;
                 for (int c = 0; c < 3; ++c) {
                     const int exponent = static_cast<int>(random() % 2090) - 1074;
                     for (auto& p : s.nodes) p[c] = std::ldexp(p[c], exponent);
                 }
                 const auto after = certify(s, 0);
                 RC_ASSERT(after.verdict == before);
                 if (after.witness) RC_ASSERT(!oracle::holds_at<3>(s, *after.witness, 0));
             },
             {300});
    property("random exponents within an axis are decided as by the oracle",
             [] {
                 auto random = random_source();
                 NodalSimplex<2> s;
                 for (auto& p : s.nodes)
                     for (int c = 0; c < 2; ++c)
                         p[c] = std::ldexp(uniform(random, -1, 1), static_cast<int>(random() % 2000) - 1000);
                 compare<2>(s, 0, certify(s, 0), oracle::answer<2>(s, 0));
                 NodalSimplex<3> t;
                 for (auto& p : t.nodes)
                     for (int c = 0; c < 3; ++c)
                         p[c] = std::ldexp(uniform(random, -1, 1), static_cast<int>(random() % 2000) - 1000);
                 compare<3>(t, 0, certify(t, 0), oracle::answer<3>(t, 0));
             },
             {100});
}

TEST_CASE("certificates reject coordinates and bounds that are not finite") {
    NodalSimplex<3> s;
    for (int a = 1; a <= 3; ++a) s.nodes[a][a - 1] = 1;
    for (int e = 0; e < 6; ++e) s.nodes[4 + e] = midpoint(s.nodes[local_edges<3>[e][0]], s.nodes[local_edges<3>[e][1]]);
    CHECK(certify(s, std::numeric_limits<double>::quiet_NaN()).verdict == Verdict::undecided);
    CHECK(certify(s, infinity).verdict == Verdict::undecided);
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), infinity, -infinity})
        for (auto& node : s.nodes) {
            const auto was = std::exchange(node[1], bad);
            CHECK(certify(s, 0).verdict == Verdict::invalid);
            CHECK(certify_exactly(s, 0).verdict == Verdict::invalid);
            CHECK(decide(s, 0) == Verdict::invalid);
            node[1] = was;
        }
    CHECK(certify(s, 0).verdict == Verdict::valid);
}

TEST_CASE("certificates of Bézier points equal those of the Lagrange nodes") {
    property("certificates of control points equal those of their exact nodes", [] {
        auto random = random_source();
        const auto n = families::lattice_element<3>(random, 1, 2);
        const auto s = families::in_doubles<3>(n);
        const double bound = some_bound(random);
        RC_ASSERT(certify(bezier_form(s), bound).verdict == certify(s, bound).verdict);
        RC_ASSERT(certify_exactly(bezier_form(s), bound).verdict == certify_exactly(s, bound).verdict);
        RC_ASSERT(check_element(bezier_form(s), bound).verdict == certify(s, bound).verdict);
    });
}
