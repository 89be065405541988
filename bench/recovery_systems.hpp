#pragma once
// Linear systems of −Δu = f with Dirichlet data u, of degree 2 and 1, used by recovery.cpp. The includer imports the
// modules before it.
#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include "poisson_domain.hpp"
#include "poisson_solve.hpp"

namespace poisson {

/// The exact solution in closed form.
template <int D>
struct KnownSolution {
    std::function<double(const Vec<D>&)> value;
    std::function<double(const Vec<D>&)> source;  ///< −Δu
};

struct System {
    Eigen::SparseMatrix<double> matrix;
    Eigen::VectorXd right;
};

/// Assembles ∫ ∇v·∇u = ∫ v f with isoparametric elements.
template <int D>
System assemble(const QuadraticMesh<D>& mesh, const std::vector<BasisPoint<D>>& rule, const KnownSolution<D>& solution,
                const Numbering& numbering, const Eigen::VectorXd& values) {
    constexpr int n = quadratic_nodes<D>;
    System system{{numbering.unknowns, numbering.unknowns}, Eigen::VectorXd::Zero(numbering.unknowns)};
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e) {
        const auto element = element_of(mesh, ElementId(e));
        Eigen::Matrix<double, n, n> stiffness = Eigen::Matrix<double, n, n>::Zero();
        Local<D> load = Local<D>::Zero();
        for (const auto& point : rule) {
            const auto at = placed(element, point);
            const double weight = point.weight * at.determinant;
            stiffness += weight * at.gradients.transpose() * at.gradients;
            load += weight * solution.source(at.place) * point.basis;
        }
        const auto nodes = nodes_of(mesh, e);
        for (int i = 0; i < n; ++i) {
            const int row = numbering.unknown_of[nodes[i]];
            if (row < 0) continue;
            system.right[row] += load[i];
            for (int j = 0; j < n; ++j)
                if (const int column = numbering.unknown_of[nodes[j]]; column >= 0)
                    entries.emplace_back(row, column, stiffness(i, j));
                else
                    system.right[row] -= stiffness(i, j) * values[static_cast<Eigen::Index>(nodes[j])];
        }
    }
    system.matrix.setFromTriplets(entries.begin(), entries.end());
    return system;
}

/// Assembles the equations of degree 1 on the straight elements.
template <int D>
System assemble_linear(const LinearMesh<D>& mesh, const KnownSolution<D>& solution, const Numbering& numbering,
                       const Eigen::VectorXd& values) {
    System system{{numbering.unknowns, numbering.unknowns}, Eigen::VectorXd::Zero(numbering.unknowns)};
    std::vector<Eigen::Triplet<double>> entries;
    const auto rule = basis_rule<D>(3);
    for (const auto& corners : mesh.elements.vertices) {
        Mat<D> jacobian;
        for (int i = 0; i < D; ++i) jacobian.column[i] = mesh.points[corners[i + 1]] - mesh.points[corners[0]];
        const Mat<D> inverted = inverse(jacobian);
        std::array<Vec<D>, D + 1> slopes{};
        for (int i = 1; i <= D; ++i)
            for (int k = 0; k < D; ++k) {
                slopes[i][k] = inverted(i - 1, k);
                slopes[0][k] -= inverted(i - 1, k);
            }
        const double volume = det(jacobian) / (D == 2 ? 2 : 6);
        for (int i = 0; i <= D; ++i) {
            const int row = numbering.unknown_of[corners[i].index()];
            if (row < 0) continue;
            for (const auto& point : rule) {
                Vec<D> x;
                for (int k = 0; k <= D; ++k) x += point.xi[k] * mesh.points[corners[k]];
                system.right[row] += point.weight * det(jacobian) * point.xi[i] * solution.source(x);
            }
            for (int j = 0; j <= D; ++j) {
                const double entry = volume * dot(slopes[i], slopes[j]);
                if (const int column = numbering.unknown_of[corners[j].index()]; column >= 0)
                    entries.emplace_back(row, column, entry);
                else
                    system.right[row] -= entry * values[static_cast<Eigen::Index>(corners[j].index())];
            }
        }
    }
    system.matrix.setFromTriplets(entries.begin(), entries.end());
    return system;
}

}  // namespace poisson
