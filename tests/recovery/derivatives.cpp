// Properties of recovery: linearity, scaling, orders of convergence, comparison with dense QR, threads, thin meshes.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <set>
#include <vector>

#define EIGEN_ALLOCA __builtin_alloca
#include <Eigen/Dense>

#include "fields.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.recovery;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
bool same(const FieldDerivatives<D>& a, const FieldDerivatives<D>& b) {
    return a.gradients == b.gradients && a.hessians == b.hessians && a.thirds == b.thirds;
}

/// A smooth function without symmetries, and its derivatives.
template <int D>
struct Wave {
    Vec<D> a;
    double operator()(const Vec<D>& x, std::initializer_list<int> axes = {}) const {
        double factor = 1, shift = 0;
        for (const int i : axes) {
            factor *= a[i];
            shift += 1.5707963267948966;
        }
        return factor * std::sin(dot(a, x) + 0.3 + shift);
    }
};
template <int D>
Wave<D> wave() {
    Wave<D> w;
    for (int i = 0; i < D; ++i) w.a[i] = 2.3 - 0.9 * i;
    return w;
}

template <int D>
void check_scales() {
    for (const int degree : {1, 2}) {
        const auto mesh = bent_mesh<D>(cells_of<D>(4), 5);
        const auto u = values_of<D>(mesh, degree, wave<D>());
        const auto times = [&](double factor) {
            Buffer<double> values(u.begin(), u.end());
            for (double& value : values) value *= factor;
            return Column<double>(std::move(values));
        };
        const auto out = recovered<D>(mesh, {u, times(0x1p660), times(0x1p-660), times(0)});
        for (const int e : {1, 2}) {
            const double factor = e == 1 ? 0x1p660 : 0x1p-660;
            bool equal = true;
            for (std::size_t r = 0; r < out.rows.size(); ++r) {
                equal = equal && out.fields[e].gradients[r] == factor * out.fields[0].gradients[r];
                equal = equal && out.fields[e].hessians[r] == factor * out.fields[0].hessians[r];
                if (degree == 2) equal = equal && out.fields[e].thirds[r] == factor * out.fields[0].thirds[r];
            }
            CHECK(equal);
        }
        // Constants have exactly zero derivatives.
        const auto flat = recovered<D>(mesh, {values_of<D>(mesh, degree, [](const Vec<D>&) { return 0.1; }), times(0)});
        for (std::size_t r = 0; r < flat.rows.size(); ++r) {
            CHECK(flat.fields[0].gradients[r] == Vec<D>{});
            CHECK(flat.fields[0].hessians[r] == Sym<D>{});
            if (degree == 2) CHECK(flat.fields[0].thirds[r] == CubicForm<D>{});
        }
        CHECK(same(flat.fields[0], flat.fields[1]));
    }
}

template <int D>
void check_together() {
    property("fields recovered together equal those recovered alone, for any threads",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto mesh = bent_mesh<D>(cells_of<D>(D == 2 ? 8 : 4), seed);
                 for (const int degree : {1, 2}) {
                     const auto noise = [&](const Vec<D>&) { return dice.uniform(-1, 1); };
                     const std::vector<Column<double>> fields{values_of<D>(mesh, degree, noise),
                                                              values_of<D>(mesh, degree, wave<D>())};
                     const auto both = recovered<D>(mesh, fields, {}, Execution{.threads = 2});
                     for (const std::size_t f : {0, 1}) {
                         const auto one = recovered<D>(mesh, {fields[f]});
                         RC_ASSERT(same(one.fields[0], both.fields[f]));
                         RC_ASSERT(one.sources == both.sources);
                     }
                 }
             },
             {.count = 4});
}

/// Errors of the highest recovered derivative on a lattice with the given number of cells in the unit box.
template <int D>
double error_of_order(int degree, int cells) {
    Frame<D> frame;
    for (double& s : frame.stretch.c) s = 1.0 / cells;
    const auto mesh = bent_mesh<D>(cells_of<D>(cells), 11, 0.12, 0.05, frame);
    const auto out = recovered<D>(mesh, {values_of<D>(mesh, degree, wave<D>())});
    double error = 0;
    for (std::size_t v = 0; v < mesh.linear.points.size(); ++v) {
        const std::size_t row = out.rows.first(VertexId(v));
        if (degree == 1)
            error =
                std::max(error, std::abs(out.fields[0].hessians[row](0, 1) - wave<D>()(mesh.linear.points[v], {0, 1})));
        else
            error = std::max(
                error, std::abs(out.fields[0].thirds[row](0, 0, 1) - wave<D>()(mesh.linear.points[v], {0, 0, 1})));
    }
    return error;
}

/// Least squares over a number of rings by a dense QR of monomials. Coordinates are whitened with the symmetric root of
/// the covariance.
template <int D>
CubicForm<D> by_dense_qr(const QuadraticMesh<D>& mesh, const Column<double>& u, std::size_t v, int count, int degree) {
    const auto rings = [&] {
        std::set<std::size_t> found{v};
        for (int ring = 0; ring < count; ++ring) {
            const std::set<std::size_t> before = found;
            for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e) {
                const auto& corners = mesh.linear.elements.vertices[e];
                if (std::none_of(corners.begin(), corners.end(),
                                 [&](VertexId w) { return before.contains(w.index()); }))
                    continue;
                for (const VertexId w : corners) found.insert(w.index());
                for (const EdgeId edge : mesh.edges.of_elements[e])
                    found.insert(mesh.linear.points.size() + edge.index());
            }
        }
        return found;
    }();
    const auto n = static_cast<Eigen::Index>(rings.size());
    Eigen::MatrixXd x(n, D);
    Eigen::VectorXd values(n);
    Eigen::Index i = 0;
    for (const std::size_t node : rings) {
        const std::size_t vertices = mesh.linear.points.size();
        const Vec<D> at = node < vertices ? mesh.linear.points[node] : mesh.mid_nodes[node - vertices].point;
        for (int c = 0; c < D; ++c) x(i, c) = at[c] - mesh.linear.points[v][c];
        values[i++] = u[node];
    }
    const Eigen::MatrixXd covariance = x.transpose() * x / static_cast<double>(n);
    Eigen::MatrixXd b = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(covariance).operatorInverseSqrt();
    Eigen::MatrixXd y = x * b;
    const double farthest = y.rowwise().norm().maxCoeff();
    y /= farthest;
    b /= farthest;
    std::vector<std::array<int, 3>> exponents;
    for (int p = 0; p <= degree; ++p)
        for (int q = 0; q + p <= degree; ++q)
            for (int r = 0; r + p + q <= (D == 3 ? degree : p + q); ++r) exponents.push_back({p, q, r});
    Eigen::MatrixXd a(n, static_cast<Eigen::Index>(exponents.size()));
    for (Eigen::Index k = 0; k < n; ++k) {
        const double weight = 1 / (0.3 + y.row(k).norm());
        values[k] *= weight;
        for (Eigen::Index m = 0; m < a.cols(); ++m) {
            double product = weight;
            for (int c = 0; c < D; ++c)
                product *= std::pow(y(k, c), exponents[static_cast<std::size_t>(m)][static_cast<std::size_t>(c)]);
            a(k, m) = product;
        }
    }
    const Eigen::VectorXd c = a.householderQr().solve(values);
    CubicForm<D> t;
    for (std::size_t m = 0; m < exponents.size(); ++m) {
        const auto& e = exponents[m];
        if (e[0] + e[1] + e[2] != 3) continue;
        std::vector<int> axes;
        double factor = 1;
        for (int axis = 0; axis < D; ++axis)
            for (int k = 0; k < e[static_cast<std::size_t>(axis)]; ++k) {
                axes.push_back(axis);
                factor *= k + 1;
            }
        t(axes[0], axes[1], axes[2]) = factor * c[static_cast<Eigen::Index>(m)];
    }
    Mat<D> matrix;
    for (int k = 0; k < D; ++k)
        for (int l = 0; l < D; ++l) matrix(k, l) = b(k, l);
    return pulled_back(t, matrix);
}

template <int D>
void check_second_evaluation() {
    property("third derivatives at inner vertices equal those of a dense QR",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 Frame<D> frame;
                 for (double& s : frame.stretch.c) s = std::pow(10.0, dice.uniform(-2, 2));
                 const auto mesh = bent_mesh<D>(cells_of<D>(D == 2 ? 6 : 4), seed, 0.12, 0.08, frame);
                 const auto u = values_of<D>(mesh, 2, [&](const Vec<D>&) { return dice.uniform(-1, 1); });
                 const auto out = recovered<D>(mesh, {u});
                 int compared = 0;
                 for (std::size_t v = 0; v < mesh.linear.points.size() && compared < 3; ++v) {
                     const std::size_t row = out.rows.first(VertexId(v));
                     if (out.sources[row] != RowSource::own_fit) continue;
                     ++compared;
                     // Recovery does not report the number of rings, so each possible number is compared.
                     double least = 1;
                     for (const int rings : {2, 3, 4, 5}) {
                         const CubicForm<D> t = by_dense_qr<D>(mesh, u, v, rings, out.polynomial_degrees[row]);
                         least = std::min(least, norm(out.fields[0].thirds[row] + -1.0 * t) / norm(t));
                     }
                     RC_ASSERT(least < 1e-9);
                 }
                 RC_ASSERT(compared > 0);
             },
             {.count = 3});
}

/// Meshes without inner vertices: one element, and a layer of cells.
template <int D>
void check_thin() {
    const Frame<D> frame;
    for (const int degree : {1, 2}) {
        // One element determines a polynomial of the degree of the field.
        LinearMesh<D> one = mesh_of<D>(
            [] {
                Buffer<Vec<D>> corners(D + 1, Vec<D>{});
                for (int i = 0; i < D; ++i) corners[i + 1][i] = 1 + i;
                return corners;
            }(),
            [] {
                Buffer<SimplexVertices<D>> simplex(1);
                for (std::size_t i = 0; i <= D; ++i) simplex[0][i] = VertexId(i);
                return simplex;
            }());
        const auto mesh = must(elevate(std::move(one), one_thread));
        Dice dice(7);
        const RandomPolynomial<D> u(degree, dice);
        const auto out = recovered<D>(mesh, {values_of<D>(mesh, degree, u)});
        CHECK(out.rows.size() == D + 1);
        CHECK(out.lower_degree == D + 1);
        CHECK(out.missing == D + 1);
        CHECK(out.from_inner_fits == 0U);
        for (std::size_t r = 0; r < out.rows.size(); ++r) {
            CHECK(out.polynomial_degrees[r] == degree);
            CHECK(error_at<D>(out.fields[0], r, frame, mesh.linear.points[r], u) < 1e-12);
        }

        // A plate of one layer of cells has no inner vertices, and degree + 1 nodes across.
        auto cells = cells_of<D>(7);
        cells[D - 1] = 1;
        const auto plate = bent_mesh<D>(cells, 3, 0, 0);
        const auto of_plate = recovered<D>(plate, {values_of<D>(plate, degree, u)});
        CHECK(of_plate.from_inner_fits == 0U);
        CHECK(of_plate.lower_degree == of_plate.rows.size());
        for (std::size_t r = 0; r < of_plate.rows.size(); ++r) {
            CHECK(of_plate.polynomial_degrees[r] == degree);
            CHECK(error_at<D>(of_plate.fields[0], r, frame, plate.linear.points[r], u) < 1e-10);
        }
    }
}

}  // namespace

TEST_CASE("recovered derivatives scale with the field and vanish for constants") {
    check_scales<2>();
    check_scales<3>();
}
TEST_CASE("recovery of several fields equals that of each field, for any number of threads, 2D") {
    check_together<2>();
}
TEST_CASE("recovery of several fields equals that of each field, for any number of threads, 3D") {
    check_together<3>();
}
TEST_CASE("third derivatives of quadratic and Hessians of linear fields converge with h²") {
    for (const int degree : {1, 2}) {
        CHECK(error_of_order<2>(degree, 32) < error_of_order<2>(degree, 16) / 3);
        CHECK(error_of_order<3>(degree, 12) < error_of_order<3>(degree, 6) / 3);
    }
}
TEST_CASE("third derivatives agree with a dense QR solution") {
    check_second_evaluation<2>();
    check_second_evaluation<3>();
}
TEST_CASE("recovery on thin meshes lowers the degree to what the nodes determine") {
    check_thin<2>();
    check_thin<3>();
}
TEST_CASE("recovery of an empty mesh returns no rows") {
    QuadraticMesh<2> empty;
    CHECK(recovered<2>(empty, {}).rows.size() == 0U);
    CHECK(recovered<2>(empty, {Column<double>()}).fields.size() == 1U);
}

TEST_CASE("a vertex without elements has no rows") {
    auto mesh = lattice_mesh<3>({.cells = {1, 1, 1}});
    auto points = take(std::move(mesh.points));
    points.push_back({{9, 9, 9}});
    mesh.points = std::move(points);
    const auto out = must(recover_derivatives<3>(
        mesh, std::array{Column<double>(Buffer<double>(mesh.points.size(), 1.0))}, {}, one_thread));
    CHECK(out.rows.size() == 8U);
    CHECK(out.rows.materials[VertexId(std::size_t{8})].empty());
}
