// Identities of Vec, Box, Sym, CubicForm and Mat.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "dice.hpp"
#include "property.hpp"

import camber.core;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
double difference(const Mat<D>& a, const Mat<D>& b) {
    double worst = 0;
    for (int j = 0; j < D; ++j) worst = std::max(worst, norm(a.column[j] - b.column[j]));
    return worst;
}

template <int D>
void check_matrices() {
    property("inverses, determinants, cofactors and transposes satisfy their identities", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto a = dice.matrix<D>();
        const auto b = dice.matrix<D>();
        const double d = det(a);
        RC_PRE(std::abs(d) > 1e-3);
        RC_ASSERT(difference(inverse(a) * a, Mat<D>::identity()) < 1e-15 * 100 / (d * d));
        RC_ASSERT(std::abs(det(a * b) - d * det(b)) < 1e-14);
        const auto rows = cofactors(a);
        for (int i = 0; i < D; ++i)
            for (int j = 0; j < D; ++j) RC_ASSERT(std::abs(dot(rows[i], a.column[j]) - (i == j ? d : 0.0)) < 1e-14);
        RC_ASSERT(difference(transposed(a * b), transposed(b) * transposed(a)) < 1e-15);
        const auto v = dice.vector<D>();
        RC_ASSERT(norm(transposed_times(a, v) - transposed(a) * v) < 1e-15);
    });
    property("congruence satisfies wᵀ (R S Rᵀ) v = (Rᵀw)ᵀ S (Rᵀv)", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto r = dice.matrix<D>();
        const auto s = dice.symmetric<D>();
        const auto v = dice.vector<D>();
        const auto w = dice.vector<D>();
        const double direct = dot(w, congruence(r, s) * v);
        RC_ASSERT(std::abs(direct - dot(transposed_times(r, w), s * transposed_times(r, v))) < 1e-13);
    });
    property("the inner product satisfies ⟨A, B⟩ = trace AB and ⟨A, v vᵀ⟩ = vᵀ A v", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto a = dice.symmetric<D>();
        const auto b = dice.symmetric<D>();
        double trace_ab = 0;
        for (int i = 0; i < D; ++i)
            for (int j = 0; j < D; ++j) trace_ab += a(i, j) * b(j, i);
        RC_ASSERT(std::abs(inner(a, b) - trace_ab) < 1e-14);
        const auto v = dice.vector<D>();
        Sym<D> vv;
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j) vv(i, j) = v[i] * v[j];
        RC_ASSERT(std::abs(inner(a, vv) - dot(v, a * v)) < 1e-14);
        RC_ASSERT(std::abs(trace(a) - inner(a, Sym<D>::identity())) < 1e-15);
        RC_ASSERT(std::abs(norm(a) * norm(a) - inner(a, a)) < 1e-14);
    });
    property("rotations are orthogonal and have determinant 1", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto r = dice.rotation<D>();
        RC_ASSERT(std::abs(det(r) - 1) < 1e-13);
        RC_ASSERT(difference(transposed(r) * r, Mat<D>::identity()) < 1e-13);
    });
    property("vectors form a normed space", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto a = dice.vector<D>();
        const auto b = dice.vector<D>();
        const double s = dice.uniform(-3, 3);
        RC_ASSERT(a + b == b + a);
        RC_ASSERT(a - b == -(b - a));
        RC_ASSERT(s * a == a * s);
        RC_ASSERT(std::abs(dot(a, b)) <= norm(a) * norm(b) * (1 + 1e-15));
        RC_ASSERT(norm(a + b) <= (norm(a) + norm(b)) * (1 + 1e-15));
        RC_ASSERT(std::abs(norm(normalised(a)) - 1) < 1e-15);
        RC_ASSERT(normalised(Vec<D>{}) == Vec<D>{});
        RC_ASSERT(is_finite(a));
    });
}

}  // namespace

template <int D>
void check_cubic_forms() {
    property("cubic forms equal the sum over their entries, are symmetric and can be pulled back",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 CubicForm<D> t;
                 for (double& x : t.c) x = dice.symmetric<D>().c[0];
                 const auto a = dice.vector<D>(), b = dice.vector<D>(), c = dice.vector<D>();
                 double sum = 0, squares = 0;
                 for (int i = 0; i < D; ++i)
                     for (int j = 0; j < D; ++j)
                         for (int k = 0; k < D; ++k) {
                             sum += t(i, j, k) * a[i] * b[j] * c[k];
                             squares += t(i, j, k) * t(k, i, j);
                         }
                 RC_ASSERT(std::abs(trilinear(t, a, b, c) - sum) < 1e-13);
                 RC_ASSERT(std::abs(trilinear(t, c, a, b) - sum) < 1e-13);
                 RC_ASSERT(std::abs(norm(t) - std::sqrt(squares)) < 1e-14);
                 const auto m = dice.matrix<D>();
                 RC_ASSERT(std::abs(trilinear(pulled_back(t, m), a, b, c) - trilinear(t, m * a, m * b, m * c)) < 1e-12);
             });
}

TEST_CASE("matrices and vectors of dimension 2 satisfy their identities") { check_matrices<2>(); }
TEST_CASE("matrices and vectors of dimension 3 satisfy their identities") { check_matrices<3>(); }

TEST_CASE("cubic forms are symmetric and can be pulled back in 2D") { check_cubic_forms<2>(); }
TEST_CASE("cubic forms are symmetric and can be pulled back in 3D") { check_cubic_forms<3>(); }

TEST_CASE("the storage order of Sym is that of GMF: xx xy yy xz yz zz") {
    CHECK(Sym<3>::index(0, 0) == 0);
    CHECK(Sym<3>::index(1, 0) == 1);
    CHECK(Sym<3>::index(1, 1) == 2);
    CHECK(Sym<3>::index(0, 2) == 3);
    CHECK(Sym<3>::index(2, 1) == 4);
    CHECK(Sym<3>::index(2, 2) == 5);
}

TEST_CASE("midpoints stay on coordinate planes to the last bit") {
    property("the midpoint keeps a coordinate that both ends share", [](std::uint64_t seed) {
        const auto x = *rc::gen::arbitrary<double>();
        RC_PRE(std::abs(x) < 1e300);
        Dice dice(seed);
        auto a = dice.vector<3>();
        auto b = dice.vector<3>();
        a[1] = b[1] = x;
        RC_ASSERT(midpoint(a, b)[1] == x);
        RC_ASSERT(midpoint(a, b) == midpoint(b, a));
    });
}

TEST_CASE("boxes contain their points and bound the distances to them") {
    property("a box contains its points and bounds the distances to them", [](std::uint64_t seed) {
        Dice dice(seed);
        Box<3> box;
        std::array<Vec<3>, 5> points;
        for (auto& p : points) {
            p = dice.vector<3>();
            box.include(p);
        }
        for (const auto& p : points) {
            RC_ASSERT(box.contains(p));
            RC_ASSERT(box.distance_squared(p) == 0);
        }
        const auto q = dice.vector<3>(-3, 3);
        RC_ASSERT(box.contains(q) == (box.distance_squared(q) == 0));
        for (const auto& p : points) RC_ASSERT(box.distance_squared(q) <= norm_squared(q - p) * (1 + 1e-15));
        Box<3> both = box;
        both.include(Box<3>{});
        RC_ASSERT(both.low == box.low);
        RC_ASSERT(both.high == box.high);
    });
    CHECK(Box<2>{}.diagonal() == 0);
    CHECK(!Box<2>{}.contains(Vec<2>{}));
}
