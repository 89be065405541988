#pragma once
// Poisson's equation by isoparametric P2 elements, and the error of its solution where that is known: for poisson.cpp.
// Imports come before it.
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

// The macro alloca, which Eigen takes otherwise, does not come along where the standard headers are one module.
#define EIGEN_ALLOCA __builtin_alloca
#include <Eigen/Dense>
#include <Eigen/Sparse>

namespace poisson {

using namespace camber;

/// What is to be found, in closed form.
template <int D>
struct KnownSolution {
    std::function<double(const Vec<D>&)> value;
    std::function<Vec<D>(const Vec<D>&)> gradient;
    std::function<double(const Vec<D>&)> source;  ///< −Δu
};

/// Of an element: a number a node, in the order of the vertices, then of `local_edges`.
template <int D>
using Local = Eigen::Matrix<double, quadratic_nodes<D>, 1>;
template <int D>
using Slopes = Eigen::Matrix<double, D, quadratic_nodes<D>>;

/// A point of the quadrature with the Lagrange basis of degree 2 there, and its derivatives by ξ_1 … ξ_D.
template <int D>
struct RulePoint {
    Barycentric<D> xi{};
    double weight = 1;
    Local<D> basis = Local<D>::Zero();
    Slopes<D> slopes = Slopes<D>::Zero();
};

template <int D>
void set_basis(RulePoint<D>& point) {
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

/// The conical Gauss product of n^D points, exact for polynomials of degree 2n − 1 in ξ.
template <int D>
std::vector<RulePoint<D>> conical_rule(int n) {
    std::vector<RulePoint<D>> rule(1);
    rule[0].xi[0] = 1;  // what the directions done leave of the simplex
    for (int d = D - 1; d >= 0; --d) {
        const GaussJacobi line = gauss_jacobi(n, d);
        std::vector<RulePoint<D>> finer;
        for (const auto& point : rule)
            for (std::size_t i = 0; i < line.nodes.size(); ++i) {
                RulePoint<D> next = point;
                next.weight *= line.weights[i];
                next.xi[d + 1] = point.xi[0] * line.nodes[i];
                next.xi[0] = point.xi[0] * (1 - line.nodes[i]);
                finer.push_back(next);
            }
        rule = std::move(finer);
    }
    for (auto& point : rule) set_basis(point);
    return rule;
}

/// Where a point of the rule is in an element.
template <int D>
struct Placed {
    Vec<D> place;
    double determinant = 0;
    Slopes<D> gradients;  ///< of the basis, by the coordinates
};

template <int D>
Placed<D> placed(const QuadraticSimplex<D, D>& element, const RulePoint<D>& point) {
    const auto columns = element.derivatives(point.xi);
    Eigen::Matrix<double, D, D> jacobian;
    for (int a = 0; a < D; ++a)
        for (int k = 0; k < D; ++k) jacobian(k, a) = columns[a][k];
    const Eigen::Matrix<double, D, D> inverse = jacobian.inverse();
    return {element.point(point.xi), jacobian.determinant(), inverse.transpose() * point.slopes};
}

/// The nodes: the vertices, then the edges' nodes. Those of the boundary have their value given.
template <int D>
std::array<std::size_t, quadratic_nodes<D>> nodes_of(const QuadraticMesh<D>& mesh, ElementId e) {
    std::array<std::size_t, quadratic_nodes<D>> nodes{};
    for (int i = 0; i <= D; ++i) nodes[i] = mesh.linear.elements.vertices[e][i].index();
    for (int k = 0; k < edges_per_simplex<D>; ++k)
        nodes[D + 1 + k] = mesh.linear.points.size() + mesh.edges.of_elements[e][k].index();
    return nodes;
}

inline constexpr int given = -1, unused = -2;

struct Numbering {
    std::vector<int> unknown_of;  ///< of each node: its unknown, or `given`, or `unused` by elements
    int unknowns = 0;
};

template <int D>
Outcome<Numbering> number_nodes(const QuadraticMesh<D>& mesh, const Execution& execution) {
    const auto around = balls(mesh.linear, execution);
    if (!around) return fail(around.error());
    const auto across = neighbours(mesh.linear, *around, execution);
    if (!across) return fail(across.error());
    Numbering numbering;
    numbering.unknown_of.assign(mesh.linear.points.size() + mesh.edges.size(), unused);
    for (const auto& face : boundary_faces<D>(*across)) {
        const auto nodes = nodes_of(mesh, face.element);
        const auto opposite = static_cast<int>(face.opposite);
        for (int i = 0; i <= D; ++i)
            if (i != opposite) numbering.unknown_of[nodes[i]] = given;
        for (int k = 0; k < edges_per_simplex<D>; ++k)
            if (local_edges<D>[k][0] != opposite && local_edges<D>[k][1] != opposite)
                numbering.unknown_of[nodes[D + 1 + k]] = given;
    }
    for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e)
        for (const std::size_t node : nodes_of(mesh, ElementId(e)))
            if (numbering.unknown_of[node] == unused) numbering.unknown_of[node] = numbering.unknowns++;
    return numbering;
}

struct System {
    Eigen::SparseMatrix<double> matrix;
    Eigen::VectorXd right;
    std::size_t turned = 0;  ///< elements with det J <= 0 at a point of the quadrature
};

/// ∫ ∇v·∇u = ∫ v f. Turned elements count with |det J|, so that the matrix stays positive; points with det J = 0 are
/// left out.
template <int D>
System assemble(const QuadraticMesh<D>& mesh, const std::vector<RulePoint<D>>& rule, const KnownSolution<D>& solution,
                const Numbering& numbering, const Eigen::VectorXd& values) {
    constexpr int n = quadratic_nodes<D>;
    System system{{numbering.unknowns, numbering.unknowns}, Eigen::VectorXd::Zero(numbering.unknowns)};
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e) {
        const auto element = element_of(mesh, ElementId(e));
        Eigen::Matrix<double, n, n> stiffness = Eigen::Matrix<double, n, n>::Zero();
        Local<D> load = Local<D>::Zero();
        bool turned = false;
        for (const auto& point : rule) {
            const auto at = placed(element, point);
            turned = turned || !(at.determinant > 0);
            if (at.determinant == 0) continue;
            const double weight = point.weight * std::abs(at.determinant);
            stiffness += weight * at.gradients.transpose() * at.gradients;
            load += weight * solution.source(at.place) * point.basis;
        }
        system.turned += turned;
        const auto nodes = nodes_of(mesh, ElementId(e));
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

struct Solved {
    Eigen::VectorXd values;
    std::string method;
};

/// Direct while the factor is small, else by conjugate gradients. Errors: a residual that is not small.
inline Outcome<Solved> solve(const System& system) {
    constexpr int max_direct = 5000;  // unknowns; 20 000 in 3D take 17 s, and conjugate gradients one
    Solved solved;
    if (system.matrix.rows() <= max_direct) {
        const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(system.matrix);
        solved.values = factor.solve(system.right);
        solved.method = "LDLT";
    } else {
        Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper,
                                 Eigen::IncompleteCholesky<double>>
            iteration;
        iteration.setTolerance(1e-12);
        iteration.compute(system.matrix);
        solved.values = iteration.solve(system.right);
        solved.method = "CG, " + std::to_string(iteration.iterations()) + " iterations";
    }
    const double residual = (system.matrix * solved.values - system.right).norm();
    if (!(residual <= 1e-9 * system.right.norm()))
        return fail(ErrorKind::input, "the equations were not solved: relative residual above 1e-9", {}, {},
                    "look for elements that are turned or nearly flat");
    return solved;
}

struct Row {
    int unknowns = 0;
    double l2 = 0, h1 = 0;  ///< (∫ (u − u_h)²)^½, (∫ |∇(u − u_h)|²)^½
    std::size_t turned = 0;
    std::string method;
    double seconds = 0;  ///< of the whole row
};

template <int D>
void measure(const QuadraticMesh<D>& mesh, const std::vector<RulePoint<D>>& rule, const KnownSolution<D>& solution,
             const Eigen::VectorXd& values, Row& row) {
    double l2 = 0, h1 = 0;
    for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e) {
        const auto element = element_of(mesh, ElementId(e));
        const auto nodes = nodes_of(mesh, ElementId(e));
        Local<D> local;
        for (int i = 0; i < local.size(); ++i) local[i] = values[static_cast<Eigen::Index>(nodes[i])];
        for (const auto& point : rule) {
            const auto at = placed(element, point);
            if (at.determinant == 0) continue;
            const double weight = point.weight * std::abs(at.determinant);
            const double error = solution.value(at.place) - point.basis.dot(local);
            const Eigen::Matrix<double, D, 1> slope = at.gradients * local;
            const Vec<D> exact = solution.gradient(at.place);
            l2 += weight * error * error;
            for (int k = 0; k < D; ++k) h1 += weight * (exact[k] - slope[k]) * (exact[k] - slope[k]);
        }
    }
    row.l2 = std::sqrt(l2);
    row.h1 = std::sqrt(h1);
}

template <int D>
Outcome<Row> solve_on(const QuadraticMesh<D>& mesh, const std::vector<RulePoint<D>>& rule,
                      const KnownSolution<D>& solution) {
    const auto begin = std::chrono::steady_clock::now();
    const auto numbering = number_nodes(mesh, Execution{});
    if (!numbering) return fail(numbering.error());
    if (numbering->unknowns == 0)
        return fail(ErrorKind::input, "no node is inside: nothing to solve", {}, {}, "give a finer mesh");
    Eigen::VectorXd values = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(numbering->unknown_of.size()));
    const std::size_t vertices = mesh.linear.points.size();
    for (std::size_t node = 0; node < numbering->unknown_of.size(); ++node)
        if (numbering->unknown_of[node] == given)
            values[static_cast<Eigen::Index>(node)] =
                solution.value(node < vertices ? mesh.linear.points[node] : mesh.mid_nodes[node - vertices].point);
    const System system = assemble(mesh, rule, solution, *numbering, values);
    if (!system.right.allFinite())
        return fail(ErrorKind::input, "the right-hand side is not finite", {}, {},
                    "a layer needs a mesh away from the origin, or a greater thickness");
    const auto solved = solve(system);
    if (!solved) return fail(solved.error());
    for (std::size_t node = 0; node < numbering->unknown_of.size(); ++node)
        if (const int unknown = numbering->unknown_of[node]; unknown >= 0)
            values[static_cast<Eigen::Index>(node)] = solved->values[unknown];
    Row row{.unknowns = numbering->unknowns, .turned = system.turned, .method = solved->method};
    measure(mesh, rule, solution, values, row);
    row.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return row;
}

}  // namespace poisson
