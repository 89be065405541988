module;
#include <algorithm>
#include <array>
#include <cstddef>
/// Lagrange functions on equispaced nodes, for shapes and degrees.
export module camber.bezier:lagrange;
import camber.core;

export namespace camber {

/// A point of a reference element; coordinates beyond the dimension are 0.
using ReferencePoint = std::array<double, 3>;

/// Nodes of the complete Lagrange element, as reference coordinates times the degree: the corners, then the inner nodes
/// of the edges (from first to second corner), of the faces (first along the face's first edge, then along its last),
/// and of the element (the first coordinate changes fastest).
template <Shape shape, int degree>
inline constexpr auto lagrange_nodes = [] {
    using Node = std::array<int, 3>;
    constexpr ShapeTable table = shape_table<shape>;
    std::array<Node, element_nodes<shape, degree>> nodes{};
    int count = 0;
    const auto add = [&](const Node& node) { nodes[count++] = node; };
    const auto along = [&](const Node& from, int corner, int towards, int steps) {
        Node node = from;
        for (int d = 0; d < 3; ++d) node[d] += steps * (table.coordinates[towards][d] - table.coordinates[corner][d]);
        return node;
    };
    for (int c = 0; c < table.corner_count; ++c) add(along({}, 0, c, degree));
    if constexpr (table.dimension > 1)
        for (int e = 0; e < table.edge_count; ++e)
            for (int i = 1; i < degree; ++i)
                add(along(nodes[table.edges[e][0]], table.edges[e][0], table.edges[e][1], i));
    for (int f = 0; f < table.face_count; ++f) {
        const auto& [face, corners] = table.faces[f];
        const bool is_triangle = face == Shape::triangle;
        for (int j = 1; j < degree; ++j)
            for (int i = 1; i < (is_triangle ? degree - j : degree); ++i)
                add(along(along(nodes[corners[0]], corners[0], corners[1], i), corners[0],
                          is_triangle ? corners[2] : corners[3], j));
    }
    const auto is_inside = [](const Node& node) {
        const int x = node[0], y = node[1], z = node[2];
        switch (shape) {
            case Shape::line:
            case Shape::quadrilateral:
            case Shape::hexahedron: return true;
            case Shape::triangle:
            case Shape::prism: return x + y < degree;
            case Shape::tetrahedron: return x + y + z < degree;
            case Shape::pyramid: return std::max(x, y) + z < degree;
        }
        return false;
    };
    constexpr int rows = table.dimension > 1 ? degree : 2, layers = table.dimension > 2 ? degree : 2;
    for (int z = 1; z < layers; ++z)
        for (int y = 1; y < rows; ++y)
            for (int x = 1; x < degree; ++x) {
                const Node node{x, table.dimension > 1 ? y : 0, table.dimension > 2 ? z : 0};
                if (is_inside(node)) add(node);
            }
    return nodes;
}();

/// The Lagrange functions of an element at a point, in the order of `lagrange_nodes`, and their derivatives by the
/// reference coordinates.
template <Shape shape, int degree>
struct LagrangeFunctions {
    std::array<double, element_nodes<shape, degree>> values{};
    std::array<ReferencePoint, element_nodes<shape, degree>> gradients{};
};

}  // namespace camber

namespace camber {

/// ∏_{m < n} (t − m)/(m + 1) and its derivative: a factor of a Lagrange function (Silvester's polynomial).
struct Silvester {
    double value = 1, derivative = 0;
};
constexpr Silvester silvester(int n, double t) {
    Silvester s;
    for (int m = 0; m < n; ++m) {
        s.derivative = (s.derivative * (t - m) + s.value) / (m + 1);
        s.value *= (t - m) / (m + 1);
    }
    return s;
}

}  // namespace camber

export namespace camber {

/// A shape as a product of simplices: the dimension of each, 0 for none. A pyramid is no product.
template <Shape shape>
inline constexpr std::array<int, 3> factors = [] {
    switch (shape) {
        case Shape::line: return std::array{1, 0, 0};
        case Shape::triangle: return std::array{2, 0, 0};
        case Shape::quadrilateral: return std::array{1, 1, 0};
        case Shape::tetrahedron: return std::array{3, 0, 0};
        case Shape::prism: return std::array{2, 1, 0};
        case Shape::hexahedron: return std::array{1, 1, 1};
        case Shape::pyramid: break;
    }
    return std::array{0, 0, 0};
}();

/// Evaluates the Lagrange functions at a reference point: products of Silvester's polynomials of the barycentric
/// coordinates of the shape's factors. Not for pyramids, whose functions are rational.
template <Shape shape, int degree>
    requires(shape != Shape::pyramid)
[[nodiscard]] constexpr LagrangeFunctions<shape, degree> lagrange_functions(const ReferencePoint& x) {
    LagrangeFunctions<shape, degree> functions;
    for (std::size_t a = 0; a < functions.values.size(); ++a) {
        const auto& node = lagrange_nodes<shape, degree>[a];
        double& value = functions.values[a] = 1;
        ReferencePoint& gradient = functions.gradients[a];
        const auto multiply = [&](const Silvester& s, int first, int last, double slope) {
            for (double& g : gradient) g *= s.value;
            for (int d = first; d < last; ++d) gradient[d] += value * slope * degree * s.derivative;
            value *= s.value;
        };
        int first = 0;
        for (const int dimension : factors<shape>) {
            const int last = first + dimension;
            double rest = 1;
            int rest_of_node = degree;
            for (int d = first; d < last; ++d) {
                multiply(silvester(node[d], degree * x[d]), d, d + 1, 1);
                rest -= x[d], rest_of_node -= node[d];
            }
            if (dimension > 0) multiply(silvester(rest_of_node, degree * rest), first, last, -1);
            first = last;
        }
    }
    return functions;
}

}  // namespace camber
