// Packed Jacobians of eight elements are bitwise those of the single elements, with any instruction set.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <random>
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

constexpr std::array every_set{Instructions::baseline, Instructions::avx2, Instructions::avx512};

/// Elements of all kinds: regular, folded, thin, flat, very large and not finite.
template <int D>
NodalSimplex<D> any_element(std::mt19937_64& random) {
    NodalSimplex<D> s;
    const auto q = element<D>(random, uniform(random, 0, 0.6));
    const double thin = uniform(random, 0, 1) < 0.3 ? std::pow(10, -uniform(random, 0, 12)) : 1;
    const double scale = uniform(random, 0, 1) < 0.1 ? 1e200 : 1;
    for (int n = 0; n < quadratic_nodes<D>; ++n) {
        s.nodes[n] = scale * q.control[n];
        s.nodes[n][D - 1] *= thin;
    }
    if (uniform(random, 0, 1) < 0.1) s.nodes[1] = s.nodes[0];
    if (uniform(random, 0, 1) < 0.05) s.nodes[D + 1][0] = std::numeric_limits<double>::quiet_NaN();
    if (uniform(random, 0, 1) < 0.05) s.nodes[D + 1][1] = std::numeric_limits<double>::infinity();
    return s;
}

template <int D>
bool is_finite(const BoundedJacobian<D>& j) {
    double sum = j.error + j.straight;
    for (const double c : j.coefficients) sum += std::abs(c);
    return std::isfinite(sum);
}

template <int D>
void test_lanes() {
    property("each lane of a pack has the Jacobian of its element, " + std::to_string(D) + "D",
             [] {
                 auto random = random_source();
                 std::array<NodalSimplex<D>, pack_size> elements;
                 NodalPack<D> pack;
                 for (std::size_t lane = 0; lane < elements.size(); ++lane) {
                     elements[lane] = any_element<D>(random);
                     pack.set(lane, elements[lane]);
                 }
                 const double bound = uniform(random, -0.5, 0.9);
                 for (const Instructions set : every_set) {
                     if (!has(set)) continue;
                     const auto jacobians = jacobian_summaries(pack, set);
                     for (std::size_t lane = 0; lane < elements.size(); ++lane) {
                         const BoundedJacobian<D> single = bounded_jacobian(elements[lane]);
                         const JacobianSummary& low = jacobians[lane];
                         RC_ASSERT(low.is_finite() == is_finite(single));
                         RC_ASSERT(is_clear(low, bound) ==
                                   (decide_by_coefficients(single, bound) == Verdict::valid && !blurred(single)));
                         if (!low.is_finite()) continue;
                         RC_ASSERT(low.lowest == *std::ranges::min_element(single.coefficients));
                         RC_ASSERT(low.straight == single.straight);
                         RC_ASSERT(low.error == single.error);
                         RC_ASSERT(smallest_scaled_coefficient(low) == smallest_scaled_coefficient(single));
                     }
                 }
             },
             {300});
}

template <int D>
void test_runs() {
    property("each_low_jacobian visits each element of any run once, " + std::to_string(D) + "D", [] {
        auto random = random_source();
        std::vector<NodalSimplex<D>> elements(random() % 40);
        for (auto& s : elements) s = any_element<D>(random);
        const std::size_t begin = elements.empty() ? 0 : random() % elements.size();
        std::size_t next = begin;
        each_jacobian_summary<D>(
            begin, elements.size(), [&](std::size_t i) { return elements[i]; },
            [&](std::size_t i, const JacobianSummary& low) {
                RC_ASSERT(i == next++);
                RC_ASSERT(is_clear(low, 0.1) ==
                          (decide_by_coefficients(bounded_jacobian(elements[i]), 0.1) == Verdict::valid &&
                           !blurred(bounded_jacobian(elements[i]))));
            });
        RC_ASSERT(next == elements.size());
    });
}

}  // namespace

TEST_CASE("packed Jacobians equal those of the single elements") {
    test_lanes<2>();
    test_lanes<3>();
}

TEST_CASE("each_low_jacobian visits each element of a run once") {
    test_runs<2>();
    test_runs<3>();
}
