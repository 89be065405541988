module;
#include <cstddef>
#include <utility>
#include <vector>
module camber.transfer;
import :rule;
import camber.core;
import camber.bezier;
import camber.interpolation;

namespace camber {

template <int D>
std::vector<RulePoint<D>> conical_rule(int n) {
    // Direction after direction: ξ_d = t (what is left of the simplex), and ξ_0 is what is left at last.
    std::vector<RulePoint<D>> rule(1);
    rule[0].xi[0] = 1;
    for (int d = D - 1; d >= 0; --d) {
        const GaussJacobi line = gauss_jacobi(n, d);
        std::vector<RulePoint<D>> finer;
        for (const RulePoint<D>& point : rule)
            for (std::size_t i = 0; i < line.nodes.size(); ++i) {
                RulePoint<D> next = point;
                next.weight *= line.weights[i];
                next.xi[d + 1] = point.xi[0] * line.nodes[i];
                next.xi[0] = point.xi[0] * (1 - line.nodes[i]);
                finer.push_back(next);
            }
        rule = std::move(finer);
    }
    return rule;
}

#define CAMBER_INSTANTIATE(D) template std::vector<RulePoint<D>> conical_rule<D>(int);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
