// Recovery is exact for polynomials of two degrees more than the field, on curved nodes, at any anisotropy and far from
// the origin.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>

#include "fields.hpp"
#include "property.hpp"

import camber.core;
import camber.recovery;

using namespace camber;
using namespace camber::testing;

namespace {

/// The largest error of any row, relative to the largest value.
template <int D>
double largest_error(const QuadraticMesh<D>& mesh, int degree, const Frame<D>& frame, const RandomPolynomial<D>& u,
                     const RecoveredDerivatives<D>& out) {
    double error = 0, largest = 0;
    const auto values = values_of<D>(mesh, degree, [&](const Vec<D>& x) { return std::abs(u(frame.inside(x))); });
    for (const double value : values) largest = std::max(largest, value);
    for (std::size_t v = 0; v < mesh.linear.points.size(); ++v)
        for (std::size_t r = out.rows.first(VertexId(v)); r < out.rows.materials.offsets[v + 1]; ++r)
            error = std::max(error, error_at<D>(out.fields[0], r, frame, mesh.linear.points[v], u));
    return error / largest;
}

template <int D>
double error_of_polynomial(int degree, const Frame<D>& frame, std::uint64_t seed) {
    Dice dice(seed);
    const auto mesh = bent_mesh<D>(cells_of<D>(D == 2 ? 6 : 4), seed, 0.12, 0.08, frame);
    const RandomPolynomial<D> u(degree + 2, dice);
    const auto out =
        recovered<D>(mesh, {values_of<D>(mesh, degree, [&](const Vec<D>& x) { return u(frame.inside(x)); })});
    RC_ASSERT(out.degree == degree);
    RC_ASSERT(out.lower_degree == 0U);
    RC_ASSERT(out.fields[0].thirds.size() == (degree == 2 ? out.rows.size() : 0));
    return largest_error<D>(mesh, degree, frame, u, out);
}

template <int D>
void check_exact() {
    for (const int degree : {1, 2})
        property("recovery is exact for polynomials of degree k + 2, stretched and distant",
                 [degree](std::uint64_t seed) {
                     Dice dice(seed);
                     Frame<D> frame;
                     for (double& s : frame.stretch.c) s = std::pow(10.0, dice.uniform(-6, 6));
                     frame.stretch[dice.below(D)] = 1;
                     RC_ASSERT(error_of_polynomial<D>(degree, frame, seed) < 1e-13);
                     // Details of 1e-6 at 1e6: coordinates have 13 bits per cell, and the field is evaluated at these
                     // rounded positions.
                     for (double& c : frame.origin.c) c = dice.uniform(-1e6, 1e6);
                     for (double& s : frame.stretch.c) s = std::max(s, 1e-6);
                     RC_ASSERT(error_of_polynomial<D>(degree, frame, seed) < 1e-13);
                 },
                 {.count = D == 2 ? 40 : 8});
}

/// The largest error of the derivatives of the highest order by x, relative to the largest derivative of that order.
template <int D>
double relative_error(const QuadraticMesh<D>& mesh, const Frame<D>& frame, const RandomPolynomial<D>& u,
                      const RecoveredDerivatives<D>& out) {
    const Mat<D> to_inside = inverse(frame.matrix());
    double error = 0, largest = 0;
    for (std::size_t v = 0; v < mesh.linear.points.size(); ++v) {
        const Vec<D> z = frame.inside(mesh.linear.points[v]);
        const std::size_t row = out.rows.first(VertexId(v));
        Sym<D> h;
        CubicForm<D> t;
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j) {
                h(i, j) = u(z, {i, j});
                for (int k = 0; k <= j; ++k) t(i, j, k) = u(z, {i, j, k});
            }
        if (out.degree == 1) {
            h = congruence(transposed(to_inside), h);
            error = std::max(error, norm(out.fields[0].hessians[row] - h));
            largest = std::max(largest, norm(h));
        } else {
            t = pulled_back(t, to_inside);
            error = std::max(error, norm(out.fields[0].thirds[row] + -1.0 * t));
            largest = std::max(largest, norm(t));
        }
    }
    return error / largest;
}

/// In rotated frames coordinates resolve the thin direction to ε times the anisotropy: 1e6 ε at 1e6.
template <int D>
void check_turned() {
    for (const int degree : {1, 2})
        property("recovery is exact for polynomials of degree k + 2, stretched and rotated",
                 [degree](std::uint64_t seed) {
                     Dice dice(seed);
                     Frame<D> frame;
                     frame.rotation = dice.rotation<D>();
                     frame.stretch[0] = std::pow(10.0, dice.uniform(-6, 0));
                     const auto mesh = bent_mesh<D>(cells_of<D>(D == 2 ? 6 : 4), seed, 0.12, 0.08, frame);
                     const RandomPolynomial<D> u(degree + 2, dice);
                     const auto out = recovered<D>(
                         mesh, {values_of<D>(mesh, degree, [&](const Vec<D>& x) { return u(frame.inside(x)); })});
                     RC_ASSERT(out.lower_degree == 0U);
                     RC_ASSERT(relative_error<D>(mesh, frame, u, out) < 1e-10 + 1e-13 / frame.stretch[0]);
                 },
                 {.count = D == 2 ? 40 : 8});
}

}  // namespace

TEST_CASE("recovery is exact for polynomials of degree k + 2, 2D") { check_exact<2>(); }
TEST_CASE("recovery is exact for polynomials of degree k + 2, 3D") { check_exact<3>(); }
TEST_CASE("recovery is exact for polynomials of degree k + 2 on rotated meshes, 2D") { check_turned<2>(); }
TEST_CASE("recovery is exact for polynomials of degree k + 2 on rotated meshes, 3D") { check_turned<3>(); }
