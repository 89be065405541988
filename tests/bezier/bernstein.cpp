// Bernstein and Lagrange bases in degrees 1 … 5 on simplices of dimension 1 … 3.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <set>
#include <utility>

#include "dice.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;

using namespace camber;
using namespace camber::testing;

namespace {

template <int N, int K>
void check_bases() {
    constexpr int n = node_count<N, K>;
    CAPTURE(N);
    CAPTURE(K);
    std::set<MultiIndex<K>> indices;
    for (int i = 0; i < n; ++i) {
        const auto& alpha = multi_indices<N, K>[i];
        CHECK(std::accumulate(alpha.begin(), alpha.end(), 0) == N);
        for (const int a : alpha) CHECK(a >= 0);
        if (i > 0) CHECK(alpha < multi_indices<N, K>[i - 1]);
        CHECK(position<N, K>(alpha) == i);
        indices.insert(alpha);
    }
    CHECK(indices.size() == n);
    MultiIndex<K> elsewhere{};
    elsewhere[0] = N + 1;
    CHECK(position<N, K>(elsewhere) == -1);

    property("the bases sum to 1; Bernstein functions are nonnegative and reproduce coordinates",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto xi = dice.barycentric<K>();
                 double bernstein_sum = 0, lagrange_sum = 0;
                 std::array<double, K + 1> moment{};
                 for (const auto& alpha : multi_indices<N, K>) {
                     const double b = bernstein<K>(alpha, xi);
                     RC_ASSERT(b >= 0);
                     bernstein_sum += b;
                     lagrange_sum += lagrange<K>(alpha, xi);
                     for (int i = 0; i <= K; ++i) moment[i] += b * alpha[i] / N;
                 }
                 RC_ASSERT(std::abs(bernstein_sum - 1) < 1e-14);
                 RC_ASSERT(std::abs(lagrange_sum - 1) < 1e-12);
                 for (int i = 0; i <= K; ++i) RC_ASSERT(std::abs(moment[i] - xi[i]) < 1e-14);
             },
             {.count = 20});
    property("conversion to Bézier form and back restores the nodes",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 std::array<double, n> nodes{};
                 for (double& x : nodes) x = dice.uniform(-1, 1);
                 const auto control = transformed(lagrange_to_bezier<N, K>, nodes);
                 const auto again = transformed(bezier_to_lagrange<N, K>, control);
                 for (int i = 0; i < n; ++i) {
                     RC_ASSERT(std::abs(again[i] - nodes[i]) < 1e-12);
                     Barycentric<K> at{};
                     for (int k = 0; k <= K; ++k) at[k] = multi_indices<N, K>[i][k] / static_cast<double>(N);
                     double f = 0;
                     for (int j = 0; j < n; ++j) f += bernstein<K>(multi_indices<N, K>[j], at) * control[j];
                     RC_ASSERT(std::abs(f - nodes[i]) < 1e-12);
                     for (int j = 0; j < n; ++j)
                         RC_ASSERT(std::abs(lagrange<K>(multi_indices<N, K>[j], at) - (i == j ? 1.0 : 0.0)) < 1e-13);
                 }
                 // Both bases represent the same polynomial.
                 const auto xi = dice.barycentric<K>();
                 double by_bernstein = 0, by_lagrange = 0;
                 for (int j = 0; j < n; ++j) {
                     by_bernstein += bernstein<K>(multi_indices<N, K>[j], xi) * control[j];
                     by_lagrange += lagrange<K>(multi_indices<N, K>[j], xi) * nodes[j];
                 }
                 RC_ASSERT(std::abs(by_bernstein - by_lagrange) < 1e-11);
             },
             {.count = 20});
}

template <int K, int... N>
void all_degrees(std::integer_sequence<int, N...>) {
    (check_bases<N + 1, K>(), ...);
}

}  // namespace

TEST_CASE("Bernstein and Lagrange bases on edges are consistent") {
    all_degrees<1>(std::make_integer_sequence<int, 5>{});
}
TEST_CASE("Bernstein and Lagrange bases on triangles are consistent") {
    all_degrees<2>(std::make_integer_sequence<int, 5>{});
}
TEST_CASE("Bernstein and Lagrange bases on tetrahedra are consistent") {
    all_degrees<3>(std::make_integer_sequence<int, 5>{});
}

TEST_CASE("node counts and multinomials match their formulas") {
    CHECK(node_count<2, 1> == 3);
    CHECK(node_count<2, 2> == 6);
    CHECK(node_count<2, 3> == 10);
    CHECK(node_count<3, 3> == 20);
    CHECK(multinomial<2>({1, 1, 1}) == 6);
    CHECK(multinomial<3>({2, 1, 1, 0}) == 12);
}

TEST_CASE("inversion finds the inverse of a matrix and reports a singular one") {
    const SquareMatrix<3> a{{{0, 2, 1}, {3, 0, 0}, {1, 1, 4}}};
    const auto inverse = inverted(a);
    CHECK(inverse.is_regular);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            double sum = 0;
            for (int k = 0; k < 3; ++k) sum += a[i][k] * inverse.matrix[k][j];
            CHECK(std::abs(sum - (i == j ? 1 : 0)) < 1e-15);
        }
    CHECK_FALSE(inverted(SquareMatrix<2>{{{1, 2}, {2, 4}}}).is_regular);
    CHECK_FALSE(inverted(SquareMatrix<2>{{{0, 0}, {0, 1}}}).is_regular);
}
