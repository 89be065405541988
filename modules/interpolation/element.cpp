module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
module camber.interpolation;
import camber.core;
import camber.bezier;

namespace camber {

template <int D>
std::array<Vec<D>, quadratic_nodes<D>> nodes_of(const QuadraticMesh<D>& mesh, std::size_t e, Sides sides) {
    constexpr std::size_t corners = D + 1;
    std::array<Vec<D>, quadratic_nodes<D>> at;
    for (std::size_t i = 0; i < corners; ++i) at[i] = mesh.linear.points[mesh.linear.elements.vertices[e][i]];
    for (std::size_t k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        at[corners + k] = sides == Sides::curved
                              ? mesh.mid_nodes[mesh.edges.of_elements[e][k]].point
                              : midpoint(at[static_cast<std::size_t>(i)], at[static_cast<std::size_t>(j)]);
    }
    return at;
}

namespace {

/// An element's of the values at all nodes, vertices first.
template <int D>
std::array<double, quadratic_nodes<D>> values_of(const QuadraticMesh<D>& mesh, std::size_t e,
                                                 std::span<const double> nodal) {
    std::array<double, quadratic_nodes<D>> u{};
    for (std::size_t i = 0; i <= D; ++i) u[i] = nodal[mesh.linear.elements.vertices[e][i].index()];
    for (std::size_t k = 0; k < edges_per_simplex<D>; ++k)
        u[D + 1 + k] = nodal[mesh.linear.points.size() + mesh.edges.of_elements[e][k].index()];
    return u;
}

}  // namespace

template <int D>
Piece<D> piece_of(const QuadraticMesh<D>& mesh, std::size_t e, Sides sides, std::span<const double> nodal,
                  Integrator<D>& integrator) {
    constexpr std::size_t corners = D + 1, nodes = quadratic_nodes<D>;
    const std::array<Vec<D>, nodes> at = nodes_of(mesh, e, sides);
    std::array<double, nodes> u{};
    Piece<D> piece;
    piece.straight = sides == Sides::straight;
    piece.origin = at[0];
    for (std::size_t i = 0; i < corners; ++i) piece.places.corners[i] = at[i] - at[0];
    for (std::size_t k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        const Vec<D> middle = midpoint(at[static_cast<std::size_t>(i)], at[static_cast<std::size_t>(j)]);
        piece.places.bubbles[k] = at[corners + k] - middle;
    }
    if (nodal.empty())
        integrator.evaluate(at, u);
    else
        u = values_of(mesh, e, nodal);
    double largest = 0;
    for (std::size_t i = 0; i < nodes; ++i) largest = std::max(largest, std::abs(u[i]));
    for (std::size_t i = 0; i < corners; ++i) piece.values[0].corners[i] = u[i];
    for (std::size_t k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        piece.values[0].bubbles[k] =
            u[corners + k] - (u[static_cast<std::size_t>(i)] + u[static_cast<std::size_t>(j)]) / 2;
    }
    piece.interpolants = piece.straight && nodal.empty() ? 2 : 1;
    if (piece.interpolants == 2) piece.values[1].corners = piece.values[0].corners;

    // Values err by their own digits, and by those of the places where they are asked for: by |x_k| times the slope
    // along each axis, which the difference of two values by that of their places bounds from below.
    double slope = 0, distant = 0;
    for (std::size_t i = 1; i < nodes; ++i) slope = std::max(slope, std::abs(u[i] - u[0]) / distance(at[i], at[0]));
    for (int c = 0; c < D; ++c) distant = std::max(distant, std::abs(at[0][c]));
    piece.rounding = std::numeric_limits<double>::epsilon() * (2 * largest + slope * distant);
    return piece;
}

template std::array<Vec<2>, 6> nodes_of<2>(const QuadraticMesh<2>&, std::size_t, Sides);
template std::array<Vec<3>, 10> nodes_of<3>(const QuadraticMesh<3>&, std::size_t, Sides);
template Piece<2> piece_of<2>(const QuadraticMesh<2>&, std::size_t, Sides, std::span<const double>, Integrator<2>&);
template Piece<3> piece_of<3>(const QuadraticMesh<3>&, std::size_t, Sides, std::span<const double>, Integrator<3>&);

}  // namespace camber
