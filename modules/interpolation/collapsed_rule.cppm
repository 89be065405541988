module;
#include <array>
#include <cstddef>
#include <vector>
module camber.interpolation:collapsed_rule;
import camber.core;
import camber.bezier;

namespace camber {

/// Stroud's conical product rule on the reference simplex: n Gauss–Jacobi points a direction in collapsed coordinates
/// t, exact for polynomials of degree 2n − 1. ξ_D = t_D, ξ_{D−1} = t_{D−1} (1 − t_D), and so on. Its points are also
/// nodes of interpolation, so that what is known at them can be differentiated. All tables point after point, t_1
/// fastest.
template <int D>
struct CollapsedRule {
    explicit CollapsedRule(int points_a_direction);

    int n;
    std::size_t count;
    std::vector<double> weights;  ///< their sum is 1/D!
    std::array<std::vector<double>, D + 1> barycentric;
    /// 4 λ_i λ_j of each local edge, and its derivatives by ξ_1 … ξ_D.
    std::array<std::vector<double>, edges_per_simplex<D>> bubbles;
    std::array<std::array<std::vector<double>, D>, edges_per_simplex<D>> bubble_slopes;
    /// Of the derivatives by ξ: the sum of the squares of the factors that the values have in them, by which
    /// independent errors of the values grow.
    std::array<std::vector<double>, D> amplification;

    /// ∂/∂ξ_1 … ∂/∂ξ_D of the polynomial through the values at the points.
    void differentiate(const std::vector<double>& values, std::array<std::vector<double>, D>& slopes) const;

  private:
    /// t-derivatives to ξ-derivatives, point by point.
    void to_reference(std::array<std::vector<double>, D>& slopes) const;

    std::array<std::vector<double>, D> nodes_;     ///< of each direction
    std::array<std::vector<double>, D> matrices_;  ///< n × n: the derivative at node r by the value at node c
};

}  // namespace camber
