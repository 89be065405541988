#pragma once
// Lagrange elements of degree 2 at quadrature points, used by poisson.hpp. The includer imports the modules before it.
#include <array>
#include <cstddef>
#include <vector>

// Eigen uses the macro alloca otherwise, which is not exported if the standard headers are one module.
#define EIGEN_ALLOCA __builtin_alloca
#include <Eigen/Dense>
#include <Eigen/Sparse>

namespace poisson {

using namespace camber;

/// One number per node of an element, in the order of the vertices, then of `local_edges`.
template <int D>
using Local = Eigen::Matrix<double, quadratic_nodes<D>, 1>;
template <int D>
using LocalMatrix = Eigen::Matrix<double, quadratic_nodes<D>, quadratic_nodes<D>>;
template <int D>
using Slopes = Eigen::Matrix<double, D, quadratic_nodes<D>>;

/// A quadrature point with the Lagrange basis of degree 2 there and its derivatives by ξ_1 … ξ_D.
template <int D>
struct BasisPoint {
    Barycentric<D> xi{};
    double weight = 1;
    Local<D> basis = Local<D>::Zero();
    Slopes<D> slopes = Slopes<D>::Zero();
};
template <int D>
using Rule = std::vector<BasisPoint<D>>;

template <int D>
void set_basis(BasisPoint<D>& point) {
    const auto& xi = point.xi;
    const auto add_slope = [&](int node, int i, double slope) {  // by λ_i; λ_0 = 1 − ξ_1 − … − ξ_D
        if (i > 0)
            point.slopes(i - 1, node) += slope;
        else
            point.slopes.col(node).array() -= slope;
    };
    for (int i = 0; i <= D; ++i) {
        point.basis[i] = xi[i] * (2 * xi[i] - 1);
        add_slope(i, i, 4 * xi[i] - 1);
    }
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        const auto [i, j] = local_edges<D>[e];
        point.basis[D + 1 + e] = 4 * xi[i] * xi[j];
        add_slope(D + 1 + e, i, 4 * xi[j]);
        add_slope(D + 1 + e, j, 4 * xi[i]);
    }
}

/// Returns the conical Gauss product of n^D points, which is exact for polynomials of degree 2n − 1 in ξ.
template <int D>
Rule<D> basis_rule(int n) {
    Rule<D> rule;
    for (const auto& [xi, weight] : conical_rule<D>(n)) set_basis(rule.emplace_back(xi, weight));
    return rule;
}

/// Position of a quadrature point in an element.
template <int D>
struct Placed {
    Vec<D> place;
    double determinant = 0;
    Slopes<D> gradients;  ///< gradients of the basis by the coordinates
};

template <int D>
Placed<D> placed(const QuadraticSimplex<D, D>& element, const BasisPoint<D>& point) {
    const auto columns = element.derivatives(point.xi);
    Eigen::Matrix<double, D, D> jacobian;
    for (int a = 0; a < D; ++a)
        for (int k = 0; k < D; ++k) jacobian(k, a) = columns[a][k];
    const Eigen::Matrix<double, D, D> inverse = jacobian.inverse();
    return {element.point(point.xi), jacobian.determinant(), inverse.transpose() * point.slopes};
}

}  // namespace poisson
