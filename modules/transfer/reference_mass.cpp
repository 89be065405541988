module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

// The macro alloca, which Eigen takes otherwise, does not come along where the standard headers are one module.
#define EIGEN_ALLOCA __builtin_alloca
#include <Eigen/Dense>
module camber.transfer;
import :reference_mass;
import :rule;
import :simplex;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// Of the nodes of any element: of one size for all, so that Eigen's decomposition is compiled once.
constexpr int most_nodes = field_nodes<3, 2>;
using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, most_nodes, most_nodes>;

/// The least and the largest eigenvalue of a symmetric matrix.
std::array<double, 2> extremes(const Square& symmetric) {
    const Eigen::SelfAdjointEigenSolver<Square> solver(symmetric, Eigen::EigenvaluesOnly);
    return {solver.eigenvalues()[0], solver.eigenvalues()[symmetric.rows() - 1]};
}

}  // namespace

template <int D, int K>
ReferenceMass<D, K>::ReferenceMass(int points_a_direction) : rule(conical_rule<D>(points_a_direction)) {
    for (const RulePoint<D>& point : rule) {
        const Functions phi = lagrange<D, K>(point.xi);
        functions.push_back(phi);
        for (int i = 0; i < nodes; ++i)
            for (int j = 0; j <= i; ++j) matrix[packed_index(i, j)] += point.weight * phi[i] * phi[j];
    }
    const auto bounds = eigenvalues(matrix);
    low = bounds[0];
    high = bounds[1];
}

template <int D, int K>
auto ReferenceMass<D, K>::curved(const ElementMap<D>& map) const -> Curved {
    Curved out;
    out.least = std::numeric_limits<double>::infinity();
    out.largest = -out.least;
    for (std::size_t q = 0; q < rule.size(); ++q) {
        const double determinant = map.determinant(rule[q].xi);
        out.least = std::min(out.least, determinant);
        out.largest = std::max(out.largest, determinant);
        const double weight = rule[q].weight * std::abs(determinant);
        for (int i = 0; i < nodes; ++i)
            for (int j = 0; j <= i; ++j) out.matrix[packed_index(i, j)] += weight * functions[q][i] * functions[q][j];
    }
    return out;
}

template <int D, int K>
std::array<double, 2> ReferenceMass<D, K>::eigenvalues(const Matrix& matrix) {
    Square scaled(nodes, nodes);
    for (int i = 0; i < nodes; ++i)
        for (int j = 0; j < nodes; ++j)
            scaled(i, j) =
                matrix[packed_index(i, j)] / std::sqrt(matrix[packed_index(i, i)] * matrix[packed_index(j, j)]);
    if (!scaled.allFinite()) return {0, nodes};
    return extremes(scaled);
}

template class ReferenceMass<2, 1>;
template class ReferenceMass<2, 2>;
template class ReferenceMass<3, 1>;
template class ReferenceMass<3, 2>;

}  // namespace camber
