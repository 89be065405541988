// Properties of interpolation errors: exactness, orders of convergence, invariance, and a second evaluation with the
// exact gradient.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <initializer_list>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <utility>

import camber.core;
import camber.bezier;
import camber.interpolation;

#include "bent_meshes.hpp"
#include "property.hpp"

using namespace camber;
using namespace camber::testing;

namespace {

bool is_rounding(const ErrorNorm& norm) { return norm.value <= 4 * norm.rounding; }

template <int D>
void check_exact_spaces() {
    property("quadratic polynomials have only rounding errors on straight meshes",
             [](std::uint64_t seed) {
                 const auto c = *rc::gen::arbitrary<std::array<int, 6>>();
                 const auto mesh = mesh_of_cells<D>(2, 0.1, seed);
                 const auto quadratic = field_of<D>([=](const Vec<D>& x) {
                     return c[0] + c[1] * x[0] + c[2] * x[1] * x[1] + c[3] * x[0] * x[D - 1] +
                            c[4] * x[D - 1] * x[D - 1];
                 });
                 const auto error = error_of<D>(mesh, quadratic);
                 RC_ASSERT(is_rounding(error.straight.l2));
                 RC_ASSERT(is_rounding(error.straight.h1));
                 RC_ASSERT(is_rounding(error.curved.l2));
             },
             {.count = 20});
    property("linear fields have only rounding errors on curved meshes",
             [](std::uint64_t seed) {
                 const auto c = *rc::gen::arbitrary<std::array<int, 4>>();
                 const auto mesh = bent<D>(mesh_of_cells<D>(2, 0.1, seed), 0.08, seed);
                 const auto linear =
                     field_of<D>([=](const Vec<D>& x) { return c[0] + c[1] * x[0] + c[2] * x[1] + c[3] * x[D - 1]; });
                 const auto error = error_of<D>(mesh, linear);
                 RC_ASSERT(is_rounding(error.curved.l2));
                 RC_ASSERT(is_rounding(error.curved.h1));
                 RC_ASSERT(is_rounding(error.linear.h1));
                 RC_ASSERT(error.unresolved == 0U);
             },
             {.count = 20});
}

template <int D>
void check_orders() {
    const auto at = [](int cells) {
        const auto mesh = mapped<D>(mesh_of_cells<D>(cells, 0, 0), [=](const Vec<D>& x) { return x / cells; });
        return error_of<D>(mesh, field_of<D>(wave<D>), 1e-4);
    };
    const auto coarse = at(4), fine = at(8);
    CHECK(agree(coarse.straight.l2.value / fine.straight.l2.value, 8, 0.05));
    CHECK(agree(coarse.straight.h1.value / fine.straight.h1.value, 4, 0.05));
    CHECK(agree(coarse.linear.l2.value / fine.linear.l2.value, 4, 0.05));
    CHECK(agree(coarse.linear.h1.value / fine.linear.h1.value, 2, 0.05));
    CHECK(coarse.curved.l2.value == coarse.straight.l2.value);
}

template <int D>
void check_affine() {
    const auto mesh = bent<D>(mesh_of_cells<D>(2, 0.1, 7), 0.08, 8);
    const auto before = error_of<D>(mesh, field_of<D>(wave<D>), 1e-4);
    // x -> 3 x + shift, rotated: distances grow threefold.
    const double c = std::cos(0.7), s = std::sin(0.7);
    const auto moved = mapped<D>(mesh, [=](const Vec<D>& x) {
        Vec<D> y = x * 3;
        y[0] = 3 * (c * x[0] - s * x[1]) + 5;
        y[1] = 3 * (s * x[0] + c * x[1]) - 2;
        return y;
    });
    const auto back = [=](const Vec<D>& y) {
        Vec<D> x = y / 3;
        const double a = (y[0] - 5) / 3, b = (y[1] + 2) / 3;
        x[0] = c * a + s * b;
        x[1] = c * b - s * a;
        return wave<D>(x);
    };
    const auto after = error_of<D>(moved, field_of<D>(back), 1e-4);
    const double volume = std::pow(3.0, D);
    for (const auto member : {&InterpolationError::linear, &InterpolationError::straight,
                              &InterpolationError::same_boundary, &InterpolationError::curved}) {
        CHECK(agree((after.*member).l2.value, std::sqrt(volume) * (before.*member).l2.value, 1e-4));
        CHECK(agree((after.*member).h1.value, std::sqrt(volume) / 3 * (before.*member).h1.value, 1e-4));
    }
}

template <int D>
void check_threads() {
    const auto mesh = bent<D>(mesh_of_cells<D>(D == 2 ? 9 : 4, 0.1, 3), 0.08, 4);
    const auto layer = field_of<D>([](const Vec<D>& x) { return std::tanh((norm(x) - 2) / 0.2); });
    const auto one = error_of<D>(mesh, layer, 1e-3, Execution{.threads = 1});
    const auto two = error_of<D>(mesh, layer, 1e-3, Execution{.threads = 2});
    for (const auto member : {&InterpolationError::linear, &InterpolationError::straight,
                              &InterpolationError::same_boundary, &InterpolationError::curved}) {
        CHECK((one.*member).l2.squares == (two.*member).l2.squares);
        CHECK((one.*member).h1.squares == (two.*member).h1.squares);
        CHECK((one.*member).h1.value == (two.*member).h1.value);
    }
    CHECK(one.evaluations == two.evaluations);
}

/// The H1 error of the interpolant on one curved element, by the exact gradient and a tensor rule of 60 points a
/// direction.
double h1_by_gradient(const QuadraticSimplex<2, 2>& element, const std::function<double(const Vec<2>&)>& u,
                      const std::function<Vec<2>(const Vec<2>&)>& gradient, bool linear) {
    const GaussJacobi line = gauss_jacobi(60, 0);
    double sum = 0;
    std::array<double, 6> values{};
    const std::array<Barycentric<2>, 6> nodes{
        {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.5, 0.5, 0}, {0, 0.5, 0.5}, {0.5, 0, 0.5}}};
    for (std::size_t i = 0; i < 6; ++i) values[i] = u(element.point(nodes[i]));
    for (std::size_t i = 0; i < line.nodes.size(); ++i)
        for (std::size_t j = 0; j < line.nodes.size(); ++j) {
            const double t = line.nodes[j], y = t, x = line.nodes[i] * (1 - t), l = 1 - x - y;
            const auto columns = element.derivatives({l, x, y});
            const double area = det(columns[0], columns[1]);
            // Derivatives of the Lagrange basis by x and y.
            std::array<double, 2> slope{};
            const std::array<std::array<double, 2>, 6> basis{{{1 - 4 * l, 1 - 4 * l},
                                                              {4 * x - 1, 0},
                                                              {0, 4 * y - 1},
                                                              {4 * (l - x), -4 * x},
                                                              {4 * y, 4 * x},
                                                              {-4 * y, 4 * (l - y)}}};
            for (std::size_t k = 0; k < 6; ++k)
                for (std::size_t a = 0; a < 2; ++a) slope[a] += values[k] * basis[k][a];
            if (linear) slope = {values[1] - values[0], values[2] - values[0]};
            const Vec<2> g = gradient(element.point({l, x, y}));
            const Vec<2> interpolant{{(columns[1][1] * slope[0] - columns[0][1] * slope[1]) / area,
                                      (-columns[1][0] * slope[0] + columns[0][0] * slope[1]) / area}};
            sum += line.weights[i] * line.weights[j] * (1 - t) * area * norm_squared(g - interpolant);
        }
    return std::sqrt(sum);
}

QuadraticMesh<2> one_triangle(double size) {
    LinearMesh<2> mesh;
    mesh.points = Buffer<Vec<2>>{{{0.49, 0}}, {{0.49 + size, 0.1 * size}}, {{0.49, size}}};
    mesh.point_references = Buffer<Reference>(3, 0);
    mesh.elements.vertices =
        Buffer<SimplexVertices<2>>{{VertexId(std::size_t{0}), VertexId(std::size_t{1}), VertexId(std::size_t{2})}};
    mesh.elements.references = Buffer<Reference>(1, 0);
    auto curved = elevate(std::move(mesh), one_thread);
    REQUIRE(curved.has_value());
    return bent<2>(*curved, 0.08 * size, 5);
}

}  // namespace

TEST_CASE("functions of the space have only rounding errors, 2D") { check_exact_spaces<2>(); }
TEST_CASE("functions of the space have only rounding errors, 3D") { check_exact_spaces<3>(); }
TEST_CASE("errors converge with the order of the space, 2D") { check_orders<2>(); }
TEST_CASE("errors converge with the order of the space, 3D") { check_orders<3>(); }
TEST_CASE("errors scale under similarity transformations, 2D") { check_affine<2>(); }
TEST_CASE("errors scale under similarity transformations, 3D") { check_affine<3>(); }
TEST_CASE("errors do not depend on the number of threads, 2D") { check_threads<2>(); }
TEST_CASE("errors do not depend on the number of threads, 3D") { check_threads<3>(); }

namespace {

/// The values of the function at all nodes, vertices first.
template <int D, class F>
Buffer<double> at_nodes(const QuadraticMesh<D>& mesh, F&& f) {
    Buffer<double> values;
    values.reserve(mesh.linear.points.size() + mesh.edges.size());
    for (const Vec<D>& x : mesh.linear.points) values.push_back(f(x));
    for (const LagrangeNode<D>& node : mesh.mid_nodes) values.push_back(f(node.point));
    return values;
}

template <int D>
void check_functions() {
    const auto mesh = bent<D>(mesh_of_cells<D>(3, 0.1, 5), 0.08, 5);
    const ScalarField<D> field = field_of<D>(wave<D>);
    const auto values = at_nodes(mesh, wave<D>);
    const auto interpolated = interpolation_error<D>(as_mesh(mesh), field, {}, {});
    const auto same = function_error<D>(as_mesh(mesh), values, field, {}, {});
    REQUIRE(interpolated);
    REQUIRE(same);
    CHECK(agree(same->l2.value, interpolated->curved.l2.value, 2e-3));
    CHECK(agree(same->h1.value, interpolated->curved.h1.value, 2e-3));
    // A function shifted by 3 has the L2 error 3 √volume, up to the small error of the interpolant.
    Buffer<double> shifted(values.begin(), values.end());
    for (double& x : shifted) x += 3;
    const auto beside = function_error<D>(as_mesh(mesh), shifted, field, {}, {});
    REQUIRE(beside);
    const double volume = interpolated->volume.curved;
    CHECK(std::abs(beside->l2.value - 3 * std::sqrt(volume)) <= interpolated->curved.l2.value);
    CHECK(agree(beside->h1.value, interpolated->curved.h1.value, 2e-3));
    CHECK(function_error<D>(as_mesh(mesh), std::span(values).first(3), field, {}, {}).error().kind ==
          ErrorKind::internal);
}

}  // namespace

TEST_CASE("function_error of the nodal interpolant equals the interpolation error, 2D") { check_functions<2>(); }
TEST_CASE("function_error of the nodal interpolant equals the interpolation error, 3D") { check_functions<3>(); }

TEST_CASE("H1 errors equal those of the exact gradient to 1e-4") {
    for (const double width : {0.005, 0.02, 1.0}) {
        const auto u = [=](const Vec<2>& x) { return std::tanh((norm(x) - 0.5) / width); };
        const auto gradient = [=](const Vec<2>& x) {
            const double t = u(x);
            return normalised(x) * ((1 - t * t) / width);
        };
        const QuadraticMesh<2> mesh = one_triangle(0.03);
        const auto error = error_of<2>(mesh, field_of<2>(u));
        const auto exact = h1_by_gradient(element_of(mesh, ElementId(std::size_t{0})), u, gradient, false);
        CHECK(agree(error.curved.h1.value, exact, 1e-4));
        CHECK(error.curved.h1.uncertainty <= 1e-3);
        auto straightened = elevate(mesh.linear, one_thread);
        REQUIRE(straightened.has_value());
        const auto straight = element_of(*straightened, ElementId(std::size_t{0}));
        CHECK(agree(error.straight.h1.value, h1_by_gradient(straight, u, gradient, false), 1e-4));
        CHECK(agree(error.linear.h1.value, h1_by_gradient(straight, u, gradient, true), 1e-4));
    }
}

TEST_CASE("errors of details of 1e-6 at a distance of 1e6 equal those at the origin") {
    const double far = 1e6, detail = 1e-6;
    const auto distant = mapped<3>(bent<3>(mesh_of_cells<3>(2, 0.1, 1), 0.08, 2), [=](const Vec<3>& x) {
        return Vec<3>{{far + detail * x[0], -far + detail * x[1], detail * x[2]}};
    });
    const auto near = mapped<3>(distant, [=](const Vec<3>& x) { return Vec<3>{{x[0] - far, x[1] + far, x[2]}}; });
    const auto u = [=](const Vec<3>& x) { return wave<3>(x / detail); };
    const auto there =
        error_of<3>(distant, field_of<3>([=](const Vec<3>& x) { return u({{x[0] - far, x[1] + far, x[2]}}); }));
    const auto here = error_of<3>(near, field_of<3>(u));
    for (const auto member : {&InterpolationError::linear, &InterpolationError::straight,
                              &InterpolationError::same_boundary, &InterpolationError::curved}) {
        const InterpolantError &a = there.*member, &b = here.*member;
        CHECK(std::abs(a.l2.value - b.l2.value) <= 1e-3 * b.l2.value + a.l2.rounding);
        CHECK(std::abs(a.h1.value - b.h1.value) <= 1e-3 * b.h1.value + a.h1.rounding);
        CHECK(a.l2.rounding < 0.1 * a.l2.value);
    }
    CHECK(there.unresolved == 0);
}

TEST_CASE("the error of a kink is accurate at a bounded number of evaluations") {
    // |x - 0.3| on one element. The L2 error is integrated over strips of the triangle, since u depends on x alone.
    LinearMesh<2> mesh;
    mesh.points = Buffer<Vec<2>>{{{0, 0}}, {{1, 0}}, {{0, 1}}};
    mesh.point_references = Buffer<Reference>(3, 0);
    mesh.elements.vertices =
        Buffer<SimplexVertices<2>>{{VertexId(std::size_t{0}), VertexId(std::size_t{1}), VertexId(std::size_t{2})}};
    mesh.elements.references = Buffer<Reference>(1, 0);
    auto elevated = elevate(mesh, one_thread);
    REQUIRE(elevated.has_value());
    const auto error = error_of<2>(*elevated, field_of<2>([](const Vec<2>& x) { return std::abs(x[0] - 0.3); }));
    double square = 0;
    constexpr int strips = 100000;
    for (int i = 0; i < strips; ++i) {
        const double x = (i + 0.5) / strips;
        // The interpolant of 0.3, 0.2, 0.7 at x = 0, 1/2, 1 is a function of x alone.
        const double interpolant = 0.3 * (1 - x) * (1 - 2 * x) + 0.2 * 4 * x * (1 - x) + 0.7 * x * (2 * x - 1);
        square += (1 - x) / strips * std::pow(std::abs(x - 0.3) - interpolant, 2);
    }
    CHECK(agree(error.straight.l2.value, std::sqrt(square), 1e-3));
    CHECK(std::abs(error.straight.l2.value - std::sqrt(square)) <=
          error.straight.l2.uncertainty * error.straight.l2.value);
    CHECK(error.evaluations < 3000000);
}

TEST_CASE("a zero field has no error") {
    const auto mesh = bent<2>(mesh_of_cells<2>(2, 0, 0), 0.05, 1);
    const auto nothing = error_of<2>(mesh, field_of<2>([](const Vec<2>&) { return 0.0; }));
    CHECK(nothing.curved.l2.value == 0);
    CHECK(nothing.curved.h1.value == 0);
}

TEST_CASE("a field that is not finite is an error with its position") {
    const auto mesh = bent<2>(mesh_of_cells<2>(2, 0, 0), 0.05, 1);
    const auto pole =
        field_of<2>([](const Vec<2>& x) { return x[0] > 1.5 ? std::numeric_limits<double>::infinity() : x[1]; });
    const auto failed = interpolation_error<2>(as_mesh(mesh), pole, {}, one_thread);
    REQUIRE_FALSE(failed.has_value());
    CHECK(failed.error().kind == ErrorKind::usage);
    CHECK(failed.error().what.find("the field is inf at (") == 0);
    CHECK_FALSE(interpolation_error<2>(as_mesh(mesh), pole, {.tolerance = 1}, one_thread).has_value());
}

TEST_CASE("a field whose error overflows is an error") {
    const auto mesh = bent<2>(mesh_of_cells<2>(2, 0, 0), 0.05, 1);
    const auto huge = interpolation_error<2>(
        as_mesh(mesh), field_of<2>([](const Vec<2>& x) { return 1e200 * x[0] * x[0]; }), {}, one_thread);
    REQUIRE_FALSE(huge.has_value());
    CHECK(huge.error().what.find("too large for a floating-point number") != std::string::npos);
}

TEST_CASE("elements with non-positive Jacobians are counted and need no extra quadrature") {
    auto mesh = mesh_of_cells<2>(2, 0, 0);
    auto nodes = take(std::move(mesh.mid_nodes));
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        const Vec<2> chord = mesh.linear.points[b] - mesh.linear.points[a];
        if (e == 5) nodes[e].point += Vec<2>{{-chord[1], chord[0]}} * 0.8;
    }
    mesh.mid_nodes = std::move(nodes);
    const auto error = error_of<2>(mesh, field_of<2>(wave<2>));
    CHECK(error.straight_inverted == 0);
    CHECK(error.curved_inverted > 0);
    CHECK(std::isfinite(error.curved.h1.value));
    CHECK(error.unresolved == 0);
}
