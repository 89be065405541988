// The linear and the quadratic program, compared with all bases and with each other.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;

#include "generators.hpp"

using namespace camber;
using namespace generators;
using camber::testing::property;

namespace {

template <int M>
Vec<M> vector(std::mt19937_64& random) {
    Vec<M> v;
    for (int c = 0; c < M; ++c) v[c] = uniform(random, -1, 1);
    return v;
}

/// Functions with a bounded maximum of the minimum: −Σ of the first M gradients is among the gradients.
template <int M>
std::vector<RaisedFunction<M>> raised_functions(std::mt19937_64& random, std::size_t more) {
    std::vector<RaisedFunction<M>> functions;
    functions.reserve(M + 1 + more);
    Vec<M> sum;
    for (int i = 0; i < M; ++i) {
        functions.push_back({{vector<M>(random), uniform(random, -1, 1)}, 1});
        sum += functions.back().function.gradient;
    }
    functions.push_back({{-1.0 * sum, uniform(random, -1, 1)}, 1});
    for (std::size_t i = 0; i < more; ++i) functions.push_back({{vector<M>(random), uniform(random, -1, 1)}, 1});
    return functions;
}

template <int M>
double lowest(const std::vector<RaisedFunction<M>>& functions, const Vec<M>& x) {
    double low = 1e300;
    for (const auto& f : functions)
        if (f.weight > 0) low = std::min(low, f.function(x) / f.weight);
    return low;
}

/// The solution of N linear equations by elimination; none if they are close to singular.
template <int N>
std::optional<std::array<double, N>> solved(std::array<std::array<double, N + 1>, N> rows) {
    for (int c = 0; c < N; ++c) {
        int p = c;
        for (int r = c + 1; r < N; ++r)
            if (std::abs(rows[r][c]) > std::abs(rows[p][c])) p = r;
        std::swap(rows[c], rows[p]);
        if (std::abs(rows[c][c]) < 1e-9) return {};
        for (int r = 0; r < N; ++r) {
            if (r == c) continue;
            const double m = rows[r][c] / rows[c][c];
            for (int k = c; k <= N; ++k) rows[r][k] -= m * rows[c][k];
        }
    }
    std::array<double, N> x{};
    for (int i = 0; i < N; ++i) x[i] = rows[i][N] / rows[i][i];
    return x;
}

/// All subsets of `count` of 0 … n−1.
template <class Visit>
void subsets(int n, int count, Visit&& visit) {
    std::vector<int> chosen;
    const auto more = [&](auto&& self, int first) -> void {
        if (static_cast<int>(chosen.size()) == count) return visit(chosen);
        for (int i = first; i < n; ++i) {
            chosen.push_back(i);
            self(self, i + 1);
            chosen.pop_back();
        }
    };
    more(more, 0);
}

/// The maximum of the minimum over all vertices of the linear program.
template <int M>
double highest_by_vertices(const std::vector<RaisedFunction<M>>& functions) {
    double best = -1e300;
    subsets(static_cast<int>(functions.size()), M + 1, [&](const std::vector<int>& chosen) {
        std::array<std::array<double, M + 2>, M + 1> rows{};
        for (int i = 0; i <= M; ++i) {
            const auto& f = functions[chosen[i]].function;
            for (int c = 0; c < M; ++c) rows[i][c] = f.gradient[c];
            rows[i][M] = -1;
            rows[i][M + 1] = -f.offset;
        }
        const auto z = solved<M + 1>(rows);
        if (!z) return;
        Vec<M> x;
        for (int c = 0; c < M; ++c) x[c] = (*z)[c];
        best = std::max(best, lowest(functions, x));
    });
    return best;
}

template <int M>
QuadraticModel<M> model(std::mt19937_64& random) {
    QuadraticModel<M> q;
    q.centre = vector<M>(random);
    q.hessian = 0.1 * Sym<M>::identity();
    for (int k = 0; k < M; ++k) {
        const Vec<M> v = vector<M>(random);
        for (int i = 0; i < M; ++i)
            for (int j = 0; j <= i; ++j) q.hessian(i, j) += v[i] * v[j];
    }
    return q;
}

/// The minimum cost over all feasible minimisers with up to M active functions; none if nothing is feasible.
template <int M>
std::optional<double> nearest_by_active_sets(const QuadraticModel<M>& q,
                                             const std::vector<AffineFunction<M>>& functions) {
    std::optional<double> best;
    const auto consider = [&](const Vec<M>& x) {
        for (const auto& f : functions)
            if (f(x) < -1e-9) return;
        if (!best || q(x) < *best) best = q(x);
    };
    consider(q.centre);
    const auto with_active = [&]<int K>(std::integral_constant<int, K>) {
        subsets(static_cast<int>(functions.size()), K, [&](const std::vector<int>& chosen) {
            // H (x − centre) = Σ u_i g_i and g_i · x = −o_i.
            std::array<std::array<double, M + K + 1>, M + K> rows{};
            for (int i = 0; i < M; ++i) {
                for (int j = 0; j < M; ++j) rows[i][j] = q.hessian(i, j);
                for (int k = 0; k < K; ++k) rows[i][M + k] = -functions[chosen[k]].gradient[i];
            }
            for (int k = 0; k < K; ++k) {
                for (int j = 0; j < M; ++j) rows[M + k][j] = functions[chosen[k]].gradient[j];
                rows[M + k][M + K] = -functions[chosen[k]](q.centre);
            }
            if (const auto z = solved<M + K>(rows)) {
                Vec<M> x = q.centre;
                for (int c = 0; c < M; ++c) x[c] += (*z)[c];
                consider(x);
            }
        });
    };
    with_active(std::integral_constant<int, 1>{});
    if constexpr (M > 1) with_active(std::integral_constant<int, 2>{});
    if constexpr (M > 2) with_active(std::integral_constant<int, 3>{});
    return best;
}

/// x ↦ A x with an anisotropy of 10^±6 in a rotated frame, as a change of the functions' variable.
template <int M>
Mat<M> anisotropic_map(std::mt19937_64& random) {
    Mat<M> rotation = Mat<M>::identity();
    for (int j = 0; j < M; ++j) {
        Vec<M> v = vector<M>(random);
        for (int k = 0; k < j; ++k) v -= dot(v, rotation.column[k]) * rotation.column[k];
        rotation.column[j] = normalised(v);
    }
    Mat<M> map;
    for (int j = 0; j < M; ++j) {
        const double stretch = std::pow(10.0, j == 0 ? 6 : uniform(random, 0, 6));
        for (int i = 0; i < M; ++i)
            for (int k = 0; k < M; ++k) map(i, k) += stretch * rotation.column[j][i] * rotation.column[j][k];
    }
    return map;
}

template <int M>
void check_linear_program() {
    property("highest_point is the best vertex of the linear program",
             [] {
                 auto random = random_source();
                 const auto functions = raised_functions<M>(random, random() % 7);
                 const auto highest = max_min_point<M>(functions, 1e6);
                 RC_ASSERT(highest.has_value());
                 const double expected = highest_by_vertices<M>(functions);
                 RC_ASSERT(std::abs(highest->lower - expected) <= 1e-9 * (1 + std::abs(expected)));
                 RC_ASSERT(highest->upper >= highest->lower);
                 RC_ASSERT(highest->upper <= highest->lower + 1e-9 * (1 + std::abs(expected)));
             },
             {200});
    property("highest_point does not depend on the order or frame of the functions",
             [] {
                 auto random = random_source();
                 const auto functions = raised_functions<M>(random, 90);
                 const double value = max_min_point<M>(functions, 1e6)->lower;
                 auto others = functions;
                 std::shuffle(others.begin(), others.end(), random);
                 const auto map = anisotropic_map<M>(random);
                 const Vec<M> shift = vector<M>(random);
                 for (auto& f : others) {
                     f.function.offset += dot(f.function.gradient, shift);
                     f.function.gradient = transposed_times(map, f.function.gradient);
                 }
                 const auto other = max_min_point<M>(others, 1e6);
                 RC_ASSERT(other.has_value());
                 RC_ASSERT(std::abs(other->lower - value) <= 1e-7);
                 RC_ASSERT(std::abs(other->upper - value) <= 1e-7);
             },
             {200});
    property("highest_point with a required minimum returns the same point or none",
             [] {
                 auto random = random_source();
                 const auto functions = raised_functions<M>(random, 40);
                 const auto highest = max_min_point<M>(functions, 1e6);
                 const double off = std::pow(10.0, uniform(random, -9, 0)) * (1 + std::abs(highest->upper));
                 const auto less = max_min_point<M>(functions, 1e6, highest->upper - off);
                 RC_ASSERT(less.has_value());
                 RC_ASSERT(less->x == highest->x);
                 RC_ASSERT(!max_min_point<M>(functions, 1e6, highest->upper + off).has_value());
             },
             {100});
    property("highest_point keeps functions of weight 0 nonnegative",
             [] {
                 auto random = random_source();
                 auto functions = raised_functions<M>(random, 20);
                 const Vec<M> inside = vector<M>(random);
                 for (int i = 0; i < 8; ++i) {
                     const Vec<M> g = vector<M>(random);
                     functions.push_back({{g, 0.05 - dot(g, inside)}, 0});
                 }
                 const auto highest = max_min_point<M>(functions, 1e6);
                 RC_ASSERT(highest.has_value());
                 RC_ASSERT(highest->lower >= lowest<M>(functions, inside) - 1e-10);
                 for (const auto& f : functions)
                     if (f.weight == 0) RC_ASSERT(f.function(highest->x) >= -1e-10);
                 const Vec<M> g = vector<M>(random);
                 functions.push_back({{g, -0.1}, 0});
                 functions.push_back({{-1.0 * g, 0.05}, 0});
                 RC_ASSERT(!max_min_point<M>(functions, 1e6).has_value());
             },
             {200});
}

template <int M>
void check_quadratic_program() {
    property("nearest_point is the best of all active sets",
             [] {
                 auto random = random_source();
                 const auto q = model<M>(random);
                 std::vector<AffineFunction<M>> functions;
                 functions.reserve(64);
                 const std::size_t n = 1 + random() % 9;
                 for (std::size_t i = 0; i < n; ++i)
                     functions.push_back({vector<M>(random), uniform(random, -0.5, 0.5)});
                 const auto nearest = nearest_point<M>(q, functions);
                 const auto expected = nearest_by_active_sets<M>(q, functions);
                 if (nearest.feasible != expected.has_value()) {
                     // Both verdicts are correct if the feasible set is a point.
                     std::vector<RaisedFunction<M>> raised;
                     raised.reserve(functions.size());
                     for (const auto& f : functions) raised.push_back({f, 1});
                     RC_ASSERT(std::abs(max_min_point<M>(raised, 1e3)->lower) < 1e-8);
                     return;
                 }
                 if (!nearest.feasible) return;
                 RC_ASSERT(std::abs(q(nearest.x) - *expected) <= 1e-8 * (1 + std::abs(*expected)));
                 RC_ASSERT(std::abs(q.value + nearest.cost - q(nearest.x)) <= 1e-9 * (1 + nearest.cost));
             },
             {300});
    property("nearest_point is feasible exactly if the highest minimum is nonnegative",
             [] {
                 auto random = random_source();
                 const auto q = model<M>(random);
                 auto raised = raised_functions<M>(random, random() % 30);
                 const double shift = uniform(random, -0.2, 0.2) - max_min_point<M>(raised, 1e6)->lower;
                 std::vector<AffineFunction<M>> functions;
                 functions.reserve(64);
                 for (auto& f : raised) {
                     f.function.offset += shift;
                     functions.push_back(f.function);
                 }
                 const auto nearest = nearest_point<M>(q, functions);
                 const double height = max_min_point<M>(raised, 1e6)->lower;
                 if (std::abs(height) > 1e-9) RC_ASSERT(nearest.feasible == (height > 0));
                 if (nearest.feasible)
                     for (const auto& f : functions) RC_ASSERT(f(nearest.x) >= -1e-9);
                 else {
                     // The active functions contradict each other.
                     std::vector<RaisedFunction<M>> named;
                     named.reserve(M + 1);
                     for (int i = 0; i < nearest.active_count; ++i) named.push_back({functions[nearest.active[i]], 1});
                     RC_ASSERT(max_min_point<M>(named, 1e6)->lower < 1e-9);
                 }
             },
             {300});
}

template <int M>
void check_anisotropy() {
    property("nearest_point is the same point at an anisotropy of 1e6",
             [] {
                 auto random = random_source();
                 const auto q = model<M>(random);
                 const Vec<M> inside = vector<M>(random);
                 std::vector<AffineFunction<M>> functions;
                 functions.reserve(64);
                 for (int i = 0; i < 60; ++i) {
                     const Vec<M> g = vector<M>(random);
                     functions.push_back({g, uniform(random, 0.01, 0.3) - dot(g, inside)});
                 }
                 const auto nearest = nearest_point<M>(q, functions);
                 RC_ASSERT(nearest.feasible);
                 // x = A z: the functions' gradients become Aᵀ g, the Hessian Aᵀ H A.
                 const auto map = anisotropic_map<M>(random);
                 QuadraticModel<M> p;
                 p.centre = inverse(map) * q.centre;
                 p.hessian = congruence(transposed(map), q.hessian);
                 auto mapped = functions;
                 for (auto& f : mapped) f.gradient = transposed_times(map, f.gradient);
                 const auto other = nearest_point<M>(p, mapped);
                 RC_ASSERT(other.feasible);
                 // The Hessian entries resolve its small eigenvalues only to 1e-16 · 1e12.
                 RC_ASSERT(std::abs(q(map * other.x) - q(nearest.x)) <= 1e-2 * (1e-3 + nearest.cost));
                 for (const auto& f : functions) RC_ASSERT(f(map * other.x) >= -1e-8);
             },
             {200});
}

}  // namespace

TEST_CASE_TEMPLATE("the linear program finds the best vertex", Dimension, std::integral_constant<int, 1>,
                   std::integral_constant<int, 2>, std::integral_constant<int, 3>) {
    check_linear_program<Dimension::value>();
}

TEST_CASE_TEMPLATE("the quadratic program finds the best active set", Dimension, std::integral_constant<int, 1>,
                   std::integral_constant<int, 2>, std::integral_constant<int, 3>) {
    check_quadratic_program<Dimension::value>();
}

TEST_CASE_TEMPLATE("the quadratic program finds the same point at an anisotropy of 1e6", Dimension,
                   std::integral_constant<int, 2>, std::integral_constant<int, 3>) {
    check_anisotropy<Dimension::value>();
}

TEST_CASE("linear and quadratic programs handle degenerate functions") {
    // Without functions: the centre of the model, and no highest point.
    CHECK(nearest_point<2>(QuadraticModel<2>{{{3, 4}}}, {}).x == Vec<2>{{3, 4}});
    CHECK_FALSE(max_min_point<2>({}, 1).has_value());
    // Only the reach bounds the point: the coordinate may change the function by 5.
    const std::vector<RaisedFunction<2>> one{{{{{2, 0}}, 1}, 1}};
    REQUIRE(max_min_point<2>(one, 5).has_value());
    CHECK(max_min_point<2>(one, 5)->lower == doctest::Approx(6));
    // The same function many times, parallel and opposite ones, and constants.
    std::vector<RaisedFunction<3>> many;
    for (int i = 0; i < 50; ++i)
        for (const double sign : {1.0, -1.0}) many.push_back({{{{sign, 0, 0}}, 1}, 1});
    many.push_back({{{}, 0.5}, 1});
    REQUIRE(max_min_point<3>(many, 10).has_value());
    CHECK(max_min_point<3>(many, 10)->lower == 0.5);
    std::vector<AffineFunction<3>> planes;
    planes.reserve(many.size());
    for (const auto& f : many) planes.push_back({f.function.gradient, f.function.offset - 1});
    planes.pop_back();
    const auto between = nearest_point<3>(QuadraticModel<3>{{{4, 5, 6}}}, planes);
    REQUIRE(between.feasible);
    CHECK(distance(between.x, Vec<3>{{0, 5, 6}}) < 1e-12);
    // A negative constant is infeasible.
    planes.push_back({{}, -1});
    CHECK_FALSE(nearest_point<3>(QuadraticModel<3>{{{4, 5, 6}}}, planes).feasible);
}
