// Failure points of invalid elements, confirmed by independent integer arithmetic, and lower bounds with the sign of
// the verdict.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>

import camber.core;
import camber.bezier;
import camber.validity;

#include "element_families.hpp"
#include "exact_oracle.hpp"
#include "generators.hpp"

using namespace camber;
using namespace generators;
using camber::testing::property;

namespace {

/// An element close to invalid, from any family, scaled by a power of two.
template <int D>
NodalSimplex<D> near_invalid(std::mt19937_64& random) {
    const auto family = static_cast<families::Family>(random() % families::count);
    auto s = family == families::Family::tuned
                 ? families::tuned<D>(random, families::element<D>(random, static_cast<families::Family>(random() % 5)),
                                      [](const NodalSimplex<D>& e) { return certify(e, 0).verdict == Verdict::valid; })
                 : families::element<D>(random, family);
    const int power = static_cast<int>(random() % 3) * 150 - 150;
    for (Vec<D>& node : s.nodes)
        for (double& x : node.c) x = std::ldexp(x, power);
    return s;
}

template <int D>
void check_failures() {
    const std::string d = D == 2 ? " (2D)" : " (3D)";
    property("find_failure returns an exact point that violates the bound" + d,
             [] {
                 auto random = random_source();
                 const auto s = near_invalid<D>(random);
                 const double bound = random() % 2 == 0 ? 0.0 : 0.25;
                 Barycentric<D> near{};
                 for (double& x : near) x = 1.0 / (D + 1);
                 const auto certificate = certify(s, bound);
                 const auto failure = find_failure(s, bound, near);
                 if (certificate.verdict != Verdict::invalid) RC_ASSERT(!failure);
                 RC_ASSERT(failure.has_value() ==
                           (certificate.verdict == Verdict::invalid && certificate.witness.has_value()));
                 if (!failure) return;
                 RC_ASSERT(!oracle::holds_at<D>(s, failure->at, bound));
                 if (bound == 0) RC_ASSERT(failure->jacobian <= 0 && failure->scaled <= 0);
                 RC_ASSERT(!(failure->scaled > bound * (1 + 1e-15)));
                 const double sum = std::accumulate(failure->at.begin(), failure->at.end(), 0.0);
                 RC_ASSERT(sum == 1.0 || sum == std::floor(sum));
             },
             {.count = 300});
    property("min_scaled_jacobian is nonnegative if det J > 0 and at most the value at a point" + d,
             [] {
                 auto random = random_source();
                 const auto s = near_invalid<D>(random);
                 const double bound = random() % 2 == 0 ? 0.0 : 0.25;
                 const double least = check_element(s, bound).min_scaled_jacobian;
                 if (certify(s, 0).verdict == Verdict::valid) RC_ASSERT(least >= 0);
                 if (const auto failure = find_failure(s, bound, Barycentric<D>{1}))
                     RC_ASSERT(!std::isfinite(least) || least <= failure->scaled);
             },
             {.count = 200});
}

}  // namespace

// Guards against reported points of invalid elements with a positive det J.
TEST_CASE("find_failure returns a point where the exact Jacobian violates the bound") {
    check_failures<2>();
    check_failures<3>();
}

// Guards against a negative minimum scaled Jacobian with "0 invalid".
TEST_CASE("validation with a bound keeps a small positive minimum Jacobian positive") {
    // The node of an edge close to a quarter of it, where det J vanishes at the end of the edge.
    for (const double least : {1e-3, 5e-4, 1e-5, 1e-9}) {
        NodalSimplex<3> s;
        for (int i = 1; i <= 3; ++i) s.nodes[i][i - 1] = 1;
        for (int e = 0; e < 6; ++e) {
            const auto [i, j] = local_edges<3>[e];
            s.nodes[4 + e] = midpoint(s.nodes[i], s.nodes[j]);
        }
        s.nodes[4][0] = 0.25 + least / 4;  // edge 0–1: the slope at vertex 0 is 4 n − 1
        for (const double bound : {0.0, 0.1}) {
            const auto validity = check_element(s, bound);
            CHECK(validity.verdict == (bound > 0 ? Verdict::invalid : Verdict::valid));
            CHECK(validity.min_scaled_jacobian > 0);
            CHECK(validity.min_scaled_jacobian <= least * (1 + 1e-6));
        }
    }
}

TEST_CASE("a failure point has short binary coordinates") {
    NodalSimplex<2> s{
        {{Vec<2>{{0, 0}}, Vec<2>{{1, 0}}, Vec<2>{{0, 1}}, Vec<2>{{0.5, 0.9}}, Vec<2>{{0.5, 0.5}}, Vec<2>{{0, 0.5}}}}};
    const auto failure = find_failure(s, 0, certify(s, 0).witness.value());
    REQUIRE(failure);
    for (const double x : failure->at) CHECK(std::ldexp(x, 16) == std::floor(std::ldexp(x, 16)));
    CHECK(failure->jacobian < 0);
}

TEST_CASE("the failure of a degenerate triangle has Jacobian 0") {
    CHECK(find_failure(NodalSimplex<2>{}, 0, Barycentric<2>{1})->jacobian == 0);
}
