// The energy of displacements on straight elements, for shapes and degrees.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numbers>
#include <utility>
#include <vector>
#include <Eigen/Dense>

#include "dice.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.extension;

using namespace camber;
using namespace camber::testing;

namespace {

template <Shape shape>
constexpr int dimension = shape_table<shape>.dimension;

/// The matrix of an element, assembled from the rows of its moving nodes.
template <Shape shape, int degree>
Eigen::MatrixXd matrix_of(const ElementEnergy<shape, degree>& energy) {
    constexpr int moving = moving_nodes<shape, degree>;
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(moving, moving);
    for (int row = 0; row < moving; ++row)
        each_row_entry<shape, degree>(energy, row, [&](int column, double entry) { matrix(row, column) += entry; });
    return matrix;
}

/// Calls f<shape, degree>() for all supported shapes and degrees 2 to 5.
template <class F>
void each_shape_and_degree(const F& f) {
    const auto each_degree = [&]<Shape shape>() {
        f.template operator()<shape, 2>();
        f.template operator()<shape, 3>();
        f.template operator()<shape, 4>();
        f.template operator()<shape, 5>();
    };
    each_degree.template operator()<Shape::triangle>();
    each_degree.template operator()<Shape::quadrilateral>();
    each_degree.template operator()<Shape::tetrahedron>();
    each_degree.template operator()<Shape::prism>();
    each_degree.template operator()<Shape::hexahedron>();
}

/// The reference element under a random affine map, with corners displaced by up to `noise`.
template <Shape shape, int D>
CornerPoints<shape, D> random_corners(Dice& dice, double noise) {
    CornerPoints<shape, D> corners;
    std::array<Vec<D>, dimension<shape>> columns;
    for (std::size_t d = 0; d < columns.size(); ++d) {
        columns[d] = dice.vector<D>(-0.3, 0.3);
        columns[d][d] += 1;
    }
    for (std::size_t c = 0; c < corners.size(); ++c) {
        corners[c] = dice.vector<D>(-noise, noise);
        for (std::size_t d = 0; d < columns.size(); ++d)
            corners[c] += shape_table<shape>.coordinates[c][d] * columns[d];
    }
    return corners;
}

/// ∫ ∇φ_m · ∇φ_n dx of the moving nodes, by a rule with the given number of points.
template <Shape shape, int degree, int D>
Eigen::MatrixXd integrated_matrix(const CornerPoints<shape, D>& corners, int points) {
    constexpr int S = dimension<shape>, moving = moving_nodes<shape, degree>;
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(moving, moving);
    for (const auto& [x, weight] : reference_rule<shape>(points)) {
        const auto straight = lagrange_functions<shape, 1>(x);
        const auto functions = lagrange_functions<shape, degree>(x);
        Eigen::Matrix<double, D, S> jacobian = Eigen::Matrix<double, D, S>::Zero();
        for (std::size_t c = 0; c < corners.size(); ++c)
            for (int i = 0; i < D; ++i)
                for (int d = 0; d < S; ++d) jacobian(i, d) += corners[c][i] * straight.gradients[c][d];
        const Eigen::Matrix<double, S, S> gram = jacobian.transpose() * jacobian;
        Eigen::Matrix<double, S, Eigen::Dynamic> gradients(S, moving);
        for (int n = 0; n < moving; ++n)
            for (int d = 0; d < S; ++d) gradients(d, n) = functions.gradients[corners.size() + n][d];
        matrix += weight * std::sqrt(gram.determinant()) * gradients.transpose() * gram.inverse() * gradients;
    }
    return matrix;
}

constexpr double unit(int dimension) { return dimension == 2 ? 24.0 / 16 : 120.0 / 16; }  // (S + 2)!/16

template <Shape shape, int degree, int D>
void check_against_integral(Dice& dice) {
    // A rule of degree + 1 points is not exact for non-affine elements, so both use the same points.
    const double noise = is_simplex(shape) || dice.below(2) == 0 ? 0 : 0.1;
    const auto corners = random_corners<shape, D>(dice, noise);
    const Eigen::MatrixXd matrix = matrix_of(element_energy<shape, degree, D>(corners, {}));
    const Eigen::MatrixXd expected =
        unit(dimension<shape>) * integrated_matrix<shape, degree, D>(corners, noise > 0 ? degree + 1 : degree + 3);
    RC_ASSERT((matrix - expected).norm() <= 1e-12 * expected.norm());
}

/// A mesh of one shape whose corners are zeros of the harmonic polynomial Re (x + i y)^degree: triangles around the
/// origin between its zero lines, a rectangle with its corners on them, or two layers of prisms over these.
template <Shape shape, int degree>
std::vector<CornerPoints<shape, dimension<shape>>> mesh_with_zeros() {
    constexpr int rays = 2 * degree;
    const auto on_ray = [](int i) {
        const double angle = std::numbers::pi * (0.5 + i) / degree;
        return Vec<2>{{std::cos(angle), std::sin(angle)}};
    };
    if constexpr (shape == Shape::triangle) {
        std::vector<CornerPoints<shape, 2>> fan;
        fan.reserve(rays);
        for (int i = 0; i < rays; ++i) fan.push_back({Vec<2>{}, on_ray(i), on_ray(i + 1)});
        return fan;
    } else if constexpr (shape == Shape::quadrilateral) {
        const Vec<2> p = on_ray(0);
        return {{Vec<2>{{-p[0], -p[1]}}, {{p[0], -p[1]}}, p, {{-p[0], p[1]}}}};
    } else {
        constexpr Shape base = shape == Shape::hexahedron ? Shape::quadrilateral : Shape::triangle;
        std::vector<CornerPoints<shape, 3>> mesh;
        for (const auto& polygon : mesh_with_zeros<base, degree>())
            for (const auto& [low, high] : {std::pair{0.0, 0.7}, std::pair{0.7, 1.5}}) {
                std::vector<Vec<3>> points;
                for (const double z : {low, high})
                    for (const Vec<2>& p : polygon) points.push_back({{p[0], p[1], z}});
                if constexpr (shape == Shape::tetrahedron) {
                    // Neighbours in the fan agree on the diagonals over their common radius, which starts at the axis.
                    mesh.push_back({points[0], points[1], points[2], points[3]});
                    mesh.push_back({points[3], points[1], points[2], points[4]});
                    mesh.push_back({points[3], points[4], points[2], points[5]});
                } else {
                    CornerPoints<shape, 3> corners;
                    for (std::size_t c = 0; c < corners.size(); ++c) corners[c] = points[c];
                    mesh.push_back(corners);
                }
            }
        return mesh;
    }
}

/// Nodes of a mesh, with equal numbers where they coincide, and the mesh's matrix.
template <Shape shape, int degree>
struct Assembled {
    static constexpr int D = dimension<shape>;
    std::vector<Vec<D>> nodes;
    Eigen::MatrixXd matrix;

    explicit Assembled(const std::vector<CornerPoints<shape, D>>& mesh) {
        std::map<std::array<long, D>, int> numbers;
        std::vector<std::vector<int>> of_elements;
        for (const auto& corners : mesh) {
            of_elements.emplace_back();
            for (std::size_t n = corners.size(); n < lagrange_nodes<shape, degree>.size(); ++n) {
                const auto& node = lagrange_nodes<shape, degree>[n];
                const auto straight = lagrange_functions<shape, 1>(
                    {double(node[0]) / degree, double(node[1]) / degree, double(node[2]) / degree});
                Vec<D> point;
                std::array<long, D> key{};
                for (std::size_t c = 0; c < corners.size(); ++c) point += straight.values[c] * corners[c];
                for (int d = 0; d < D; ++d) key[d] = std::lround(point[d] * 1e6);
                const auto [at, is_new] = numbers.try_emplace(key, static_cast<int>(numbers.size()));
                if (is_new) nodes.push_back(point);
                of_elements.back().push_back(at->second);
            }
        }
        const auto count = static_cast<Eigen::Index>(nodes.size());
        matrix = Eigen::MatrixXd::Zero(count, count);
        for (std::size_t e = 0; e < mesh.size(); ++e) {
            const Eigen::MatrixXd own = matrix_of(element_energy<shape, degree, D>(mesh[e], {}));
            for (int m = 0; m < own.rows(); ++m)
                for (int n = 0; n < own.cols(); ++n) matrix(of_elements[e][m], of_elements[e][n]) += own(m, n);
        }
    }
};

/// True if the node is on the boundary of the mesh of mesh_with_zeros.
template <Shape shape, int degree, int D>
bool is_on_boundary(const Vec<D>& node) {
    constexpr double near = 1e-9, half = std::numbers::pi / (2 * degree);
    if (D == 3 && (node[D - 1] < near || node[D - 1] > 1.5 - near)) return true;
    if (shape == Shape::quadrilateral || shape == Shape::hexahedron)
        return std::abs(node[0]) > std::cos(half) - near || std::abs(node[1]) > std::sin(half) - near;
    double farthest = 0;  // from the origin, along the normals of the sides
    for (int i = 0; i < 2 * degree; ++i)
        farthest = std::max(farthest, node[0] * std::cos(2 * half * i) + node[1] * std::sin(2 * half * i));
    return farthest > std::cos(half) - near;
}

}  // namespace

TEST_CASE("the element matrix is the integral of the products of gradients") {
    property("element matrices of all shapes and degrees equal the integral",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 each_shape_and_degree([&]<Shape shape, int degree>() {
                     check_against_integral<shape, degree, dimension<shape>>(dice);
                     if constexpr (dimension<shape> == 2) check_against_integral<shape, degree, 3>(dice);
                 });
             },
             {.count = 10});
}

TEST_CASE("a degenerate element contributes nothing") {
    each_shape_and_degree([]<Shape shape, int degree>() {
        const auto energy = element_energy<shape, degree, dimension<shape>>({}, {});
        CHECK(matrix_of(energy).norm() == 0);
    });
}

TEST_CASE("the height is the smallest height of the element") {
    const double h = 1e-4;
    const auto prism = element_energy<Shape::prism, 2, 3>(
        {Vec<3>{}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, h}}, {{1, 0, h}}, {{0, 1, h}}}, {});
    CHECK(prism.height == doctest::Approx(h));
    const auto triangle = element_energy<Shape::triangle, 2, 2>({Vec<2>{}, {{1, 0}}, {{0.3, h}}}, {});
    CHECK(triangle.height == doctest::Approx(h));
}

TEST_CASE("an extension reproduces harmonic polynomials of the degree of the elements") {
    each_shape_and_degree([]<Shape shape, int degree>() {
        CAPTURE(static_cast<int>(shape));
        CAPTURE(degree);
        const Assembled<shape, degree> mesh(mesh_with_zeros<shape, degree>());
        const auto harmonic = [](const auto& p) {
            return std::pow(std::hypot(p[0], p[1]), degree) * std::cos(degree * std::atan2(p[1], p[0]));
        };
        std::vector<int> unknowns, known;
        for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
            (is_on_boundary<shape, degree>(mesh.nodes[n]) ? known : unknowns).push_back(static_cast<int>(n));
        REQUIRE(!unknowns.empty());
        Eigen::VectorXd boundary(known.size()), expected(unknowns.size());
        for (std::size_t n = 0; n < known.size(); ++n)
            boundary[static_cast<Eigen::Index>(n)] = harmonic(mesh.nodes[known[n]]);
        for (std::size_t n = 0; n < unknowns.size(); ++n)
            expected[static_cast<Eigen::Index>(n)] = harmonic(mesh.nodes[unknowns[n]]);
        REQUIRE(boundary.norm() > 0.01);
        const Eigen::MatrixXd among = mesh.matrix(unknowns, unknowns), beside = mesh.matrix(unknowns, known);
        const Eigen::VectorXd solution = among.ldlt().solve(-(beside * boundary));
        CHECK((solution - expected).norm() < 1e-11);
    });
}
