module;
#include <cstddef>
#include <vector>
module camber.transfer:rule;
import camber.core;
import camber.bezier;
import camber.interpolation;
import :simplex;

namespace camber {

/// A point of a quadrature on the reference simplex.
template <int D>
struct RulePoint {
    Barycentric<D> xi{};
    double weight = 1;
};

/// Stroud's conical product of Gauss–Jacobi rules of n points a direction, exact for polynomials of degree 2n − 1; its
/// weights are positive, their sum is 1/D!.
template <int D>
[[nodiscard]] std::vector<RulePoint<D>> conical_rule(int n);

}  // namespace camber
