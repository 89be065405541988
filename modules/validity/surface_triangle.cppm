module;
#include <array>
#include <cstddef>
#include <optional>
#include <span>
export module camber.validity:surface_triangle;
import camber.core;
import camber.bezier;
import :certificate;
import :coefficients;
import :jacobian;
import :twice;
import :verdict;

export namespace camber {

/// How many verdicts a mesh has: one an element, or one a triangle of a surface alone.
template <int D>
[[nodiscard]] inline std::size_t judged_count(const LinearMesh<D>& mesh) {
    return is_surface_alone(mesh) ? mesh.facets.size() : mesh.elements.size();
}

/// A P2 triangle in space by its Lagrange nodes, as a mesh stores them: the vertices, then the nodes of e01 e12 e20.
///
/// Its normal N = x_u × x_v is quadratic. What is judged is N · n with n the unit normal of the straight triangle of
/// the same vertices, over twice that one's area: the det J of the triangle's shadow in its own straight plane over
/// that of the straight triangle, and in a plane what a triangle in 2D has (of either side: a surface has none). Valid:
/// regular, and nowhere turned by 90° or more from its straight triangle. A straight triangle without area has no
/// normal: invalid.
struct SurfaceTriangle {
    std::array<Vec<3>, quadratic_nodes<2>> nodes{};
};

/// Triangle f of a mesh, with other mid nodes.
[[nodiscard]] inline SurfaceTriangle surface_triangle(const QuadraticMesh<3>& mesh,
                                                      std::span<const LagrangeNode<3>> mid_nodes, std::size_t f) {
    SurfaceTriangle t;
    for (int i = 0; i < 3; ++i) t.nodes[i] = mesh.linear.points[mesh.linear.facets.vertices[f][i]];
    for (int e = 0; e < 3; ++e) t.nodes[3 + e] = mid_nodes[mesh.edges.of_facets[f][e].index()].point;
    return t;
}

/// The coefficients of N · n up to a factor, which `straight` (N · n of the straight triangle) has too.
[[nodiscard]] BoundedJacobian<2> bounded_jacobian(const SurfaceTriangle& triangle);
[[nodiscard]] BoundedJacobian<2> sharp_jacobian(const SurfaceTriangle& triangle);

/// As of an element: by coefficients, bisections, twice the digits and integers; no triangle stays undecided.
[[nodiscard]] Certificate<2> certify(const SurfaceTriangle& triangle, double bound);
[[nodiscard]] Certificate<2> certify_exactly(const SurfaceTriangle& triangle, double bound);
[[nodiscard]] std::optional<Failure<2>> find_failure(const SurfaceTriangle& triangle, double bound,
                                                     const Barycentric<2>& near);
[[nodiscard]] Verdict decide(const SurfaceTriangle& triangle, double bound);
[[nodiscard]] ElementValidity check_element(const SurfaceTriangle& triangle, double bound);

}  // namespace camber

namespace camber {

/// Its two columns at three vertices.
template <class Real>
using SurfaceColumns = std::array<std::array<std::array<Real, 3>, 3>, 2>;

/// Σ over the ordered ways to write α = e_j + e_k of d_1[j] × d_2[k]: multinomial(α)/4 times the coefficient of N.
template <class Real>
[[nodiscard]] inline std::array<std::array<Real, 3>, jacobian_coefficients<2>> normal_sums(
    const SurfaceColumns<Real>& d) {
    std::array<std::array<Real, 3>, jacobian_coefficients<2>> sums{};
    for (int p = 0; p < jacobian_coefficients<2>; ++p) {
        int j = -1, k = -1;
        for (int i = 0; i < 3; ++i)
            for (int m = 0; m < jacobian_indices<2>[p][i]; ++m) (j < 0 ? j : k) = i;
        sums[p] = product(d[0][j], d[1][k]);
        if (j == k) continue;
        const auto other = product(d[0][k], d[1][j]);
        for (int c = 0; c < 3; ++c) sums[p][c] += other[c];
    }
    return sums;
}

}  // namespace camber
