module;
#include <array>
#include <vector>
/// Quadrature rules: lines, simplices, and shapes that are products of simplices.
export module camber.bezier:quadrature;
import camber.core;
import :lagrange;

export namespace camber {

/// Quadrature rule ∫_0^1 f(t) (1 − t)^power dt ≈ Σ weight_i f(node_i), exact for polynomials of degree 2n − 1. The
/// nodes ascend.
struct GaussJacobi {
    std::vector<double> nodes, weights;
};

/// Computes the rule with n ≥ 1 points. Uses Newton's method on the Jacobi polynomial P_n^(power, 0) with deflation of
/// known roots.
[[nodiscard]] GaussJacobi gauss_jacobi(int n, int power);

template <int D>
struct RulePoint {
    std::array<double, D + 1> xi{};  ///< barycentric coordinates
    double weight = 1;
};

/// Stroud's conical product of Gauss–Jacobi rules with n points per direction, exact for polynomials of degree 2n − 1.
/// The weights are positive with sum 1/D!. ξ_D = t_D, ξ_{D−1} = t_{D−1} (1 − t_D), and so on; t_1 changes fastest.
template <int D>
[[nodiscard]] std::vector<RulePoint<D>> conical_rule(int n);

struct ReferenceRulePoint {
    ReferencePoint x{};
    double weight = 1;
};

/// Product of conical rules with n points per direction over the factors of a shape, exact for products of polynomials
/// of degree 2n − 1. The sum of the weights is the volume of the reference element. Not for pyramids.
template <Shape shape>
    requires(shape != Shape::pyramid)
[[nodiscard]] std::vector<ReferenceRulePoint> reference_rule(int n);

}  // namespace camber
