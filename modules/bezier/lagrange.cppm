module;
#include <algorithm>
#include <array>
#include <cstddef>
/// Lagrange functions on equispaced nodes, for shapes and degrees.
export module camber.bezier:lagrange;
import camber.core;

export namespace camber {

/// Reference coordinates of a point. Coordinates beyond the dimension are 0.
using ReferencePoint = std::array<double, 3>;

/// Values of the Lagrange functions, and their derivatives by the reference coordinates, in the order of
/// `lagrange_nodes`.
template <Shape shape, int degree>
struct LagrangeFunctions {
    std::array<double, element_nodes<shape, degree>> values{};
    std::array<ReferencePoint, element_nodes<shape, degree>> gradients{};
};

}  // namespace camber

namespace camber {

/// ∏_{m < n} (t − m)/(m + 1) and its derivative: a factor of a Lagrange function.
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

/// Dimensions of the simplices whose product is the shape; 0: no further factor. A pyramid is no such product.
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

/// Computes Lagrange functions as products of Silvester's polynomials in the barycentric coordinates of the shape's
/// factors. Not for pyramids, whose functions are rational.
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
