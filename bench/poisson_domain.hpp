#pragma once
// Unknowns and matrices of Poisson's equation, which do not depend on the solution, used by poisson.hpp. The includer
// imports the modules before it.
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "poisson_rule.hpp"

namespace poisson {

/// Returns the nodes of an element: vertices first, then edge nodes. Values of boundary nodes are prescribed.
template <int D>
std::array<std::size_t, quadratic_nodes<D>> nodes_of(const QuadraticMesh<D>& mesh, std::size_t element) {
    const ElementId e(element);
    std::array<std::size_t, quadratic_nodes<D>> nodes{};
    for (int i = 0; i <= D; ++i) nodes[i] = mesh.linear.elements.vertices[e][i].index();
    for (int k = 0; k < edges_per_simplex<D>; ++k)
        nodes[D + 1 + k] = mesh.linear.points.size() + mesh.edges.of_elements[e][k].index();
    return nodes;
}

inline constexpr int prescribed = -1, unused = -2;

struct Numbering {
    std::vector<int> unknown_of;  ///< unknown of each node, or `prescribed`, or `unused` by elements
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
        const auto nodes = nodes_of(mesh, face.element.index());
        const auto opposite = static_cast<int>(face.opposite);
        for (int i = 0; i <= D; ++i)
            if (i != opposite) numbering.unknown_of[nodes[i]] = prescribed;
        for (int k = 0; k < edges_per_simplex<D>; ++k)
            if (local_edges<D>[k][0] != opposite && local_edges<D>[k][1] != opposite)
                numbering.unknown_of[nodes[D + 1 + k]] = prescribed;
    }
    for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e)
        for (const std::size_t node : nodes_of(mesh, e))
            if (numbering.unknown_of[node] == unused) numbering.unknown_of[node] = numbering.unknowns++;
    return numbering;
}

/// Data that does not depend on the solution.
template <int D>
struct Domain {
    QuadraticMesh<D> mesh;
    Numbering numbering;
    Eigen::SparseMatrix<double> stiffness, mass;  ///< ∫ ∇φ_i·∇φ_j, ∫ φ_i φ_j of the unknowns
    std::size_t inverted = 0;                     ///< elements with det J <= 0 at a quadrature point
};

/// Assembles the matrices. Inverted elements count with |det J|, so the matrices stay positive definite. Points with
/// det J = 0 are omitted.
template <int D>
Outcome<Domain<D>> assemble(QuadraticMesh<D> given_mesh, const Execution& execution) {
    auto numbering = number_nodes(given_mesh, execution);
    if (!numbering) return fail(numbering.error());
    if (numbering->unknowns == 0)
        return fail(ErrorKind::input, "the mesh has no inner node, so there is no unknown", {}, {},
                    "give a finer mesh");
    const int n = numbering->unknowns;
    Domain<D> domain{std::move(given_mesh), std::move(*numbering), {n, n}, {n, n}, 0};
    const Rule<D> rule = basis_rule<D>(4);
    std::vector<Eigen::Triplet<double>> stiff, heavy;
    for (std::size_t e = 0; e < domain.mesh.linear.elements.size(); ++e) {
        const auto element = element_of(domain.mesh, ElementId(e));
        LocalMatrix<D> stiffness = LocalMatrix<D>::Zero(), mass = LocalMatrix<D>::Zero();
        bool inverted = false;
        for (const auto& point : rule) {
            const auto at = placed(element, point);
            inverted = inverted || !(at.determinant > 0);
            if (at.determinant == 0) continue;
            const double weight = point.weight * std::abs(at.determinant);
            stiffness += weight * at.gradients.transpose() * at.gradients;
            mass += weight * point.basis * point.basis.transpose();
        }
        domain.inverted += inverted;
        const auto nodes = nodes_of(domain.mesh, e);
        for (int i = 0; i < quadratic_nodes<D>; ++i)
            for (int j = 0; j < quadratic_nodes<D>; ++j) {
                const int row = domain.numbering.unknown_of[nodes[i]], column = domain.numbering.unknown_of[nodes[j]];
                if (row < 0 || column < 0) continue;
                stiff.emplace_back(row, column, stiffness(i, j));
                heavy.emplace_back(row, column, mass(i, j));
            }
    }
    domain.stiffness.setFromTriplets(stiff.begin(), stiff.end());
    domain.mass.setFromTriplets(heavy.begin(), heavy.end());
    return domain;
}

}  // namespace poisson
