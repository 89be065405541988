#pragma once
// Systems of equations with a matrix that is symmetric and positive: for poisson.hpp. Imports come before it.
#include <string>

#include "poisson_rule.hpp"

namespace poisson {

using Vector = Eigen::VectorXd;

struct Solved {
    Vector values;
    std::string method;
};

/// Direct while the factor is small, else by conjugate gradients to a relative residual. Errors: one above a thousand
/// times that.
inline Outcome<Solved> solve(const Eigen::SparseMatrix<double>& matrix, const Vector& right, double tolerance) {
    constexpr int max_direct = 5000;  // unknowns; 20 000 in 3D take 17 s, and conjugate gradients one
    Solved solved;
    if (matrix.rows() <= max_direct) {
        const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
        solved.values = factor.solve(right);
        solved.method = "LDLT";
    } else {
        Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper,
                                 Eigen::IncompleteCholesky<double>>
            iteration;
        iteration.setTolerance(tolerance);
        iteration.compute(matrix);
        solved.values = iteration.solve(right);
        solved.method = "CG, " + std::to_string(iteration.iterations()) + " iterations";
    }
    const double residual = (matrix * solved.values - right).norm();
    if (!(residual <= 1e3 * tolerance * right.norm()))
        return fail(ErrorKind::input, "the equations were not solved: the residual is not small", {}, {},
                    "look for elements that are turned or nearly flat");
    return solved;
}

}  // namespace poisson
