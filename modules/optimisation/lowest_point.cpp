module;
#include <algorithm>
#include <cmath>
#include <vector>
module camber.optimisation;
import camber.core;
import camber.bezier;
import camber.validity;

namespace camber {

template <int D>
LowestPoint<D> lowest_point(const BoundedJacobian<D>& jacobian) {
    constexpr int max_parts = 4000;
    constexpr int max_depth = 40;
    LowestPoint<D> lowest;
    lowest.at[0] = 1;
    lowest.jacobian = jacobian.coefficients[corner_coefficients<D>[0]];
    std::vector<JacobianPart<D>> open{whole(jacobian)};
    for (int parts = 0; !open.empty() && parts < max_parts; ++parts) {
        const JacobianPart<D> part = open.back();
        open.pop_back();
        for (int i = 0; i <= D; ++i) {
            const double value = part.coefficients[corner_coefficients<D>[i]];
            if (value < lowest.jacobian) lowest = {part.corners[i], value};
        }
        const double low = *std::min_element(part.coefficients.begin(), part.coefficients.end());
        const double slack = 1e-3 * std::max(std::abs(jacobian.straight), std::abs(lowest.jacobian));
        // Written so that NaN ends the search.
        if (!(low < lowest.jacobian - slack) || part.depth == max_depth) continue;
        const int edge = largest_bend(part).edge;
        open.push_back(half(part, edge, 0));
        open.push_back(half(part, edge, 1));
    }
    return lowest;
}

#define CAMBER_INSTANTIATE(D) template LowestPoint<D> lowest_point<D>(const BoundedJacobian<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
