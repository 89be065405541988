module;
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
module camber.transfer:integrals;
import camber.core;
import camber.bezier;
import :rule;
import :simplex;
import :sums;

namespace camber {

/// ∫ φ_α |det J| over elements: exact, the integrand is a polynomial of degree D + 2 at most where det J > 0.
template <int D, int K>
class Weights {
  public:
    using Functions = std::array<double, field_nodes<D, K>>;

    Weights() : rule_(conical_rule<D>(3)) {
        for (const auto& point : rule_) {
            functions_.push_back(lagrange<D, K>(point.xi));
            for (int i = 0; i < field_nodes<D, K>; ++i) reference_[i] += point.weight * functions_.back()[i];
        }
    }
    [[nodiscard]] Functions of(const QuadraticMesh<D>& mesh, std::size_t e) const {
        const ElementMap<D> map = element_map(mesh, e);
        Functions out{};
        if (map.is_straight) {
            const double determinant = std::abs(map.determinant(rule_[0].xi));
            for (int i = 0; i < field_nodes<D, K>; ++i) out[i] = determinant * reference_[i];
            return out;
        }
        for (std::size_t q = 0; q < rule_.size(); ++q) {
            const double weight = rule_[q].weight * std::abs(map.determinant(rule_[q].xi));
            for (int i = 0; i < field_nodes<D, K>; ++i) out[i] += weight * functions_[q][i];
        }
        return out;
    }

  private:
    std::vector<RulePoint<D>> rule_;
    std::vector<Functions> functions_;
    Functions reference_{};
};

/// The integrals of a field's components over elements, by group. `element(slot)`: the element's number.
template <int D, int K, class ElementOf>
[[nodiscard]] Outcome<std::vector<Sum>> integrals_by_group(const QuadraticMesh<D>& mesh, const ElementOf& element,
                                                           std::span<const std::uint32_t> group_of, std::size_t groups,
                                                           std::span<const double> values, std::size_t components,
                                                           const Execution& execution) {
    const Weights<D, K> weights;
    return sums_by_group(
        group_of, groups, components,
        [&](std::size_t slot, std::span<double> out) {
            const std::size_t e = element(slot);
            const auto weight = weights.of(mesh, e);
            const auto nodes = nodes_of<D, K>(mesh, e);
            for (std::size_t c = 0; c < components; ++c) {
                out[c] = 0;
                for (std::size_t i = 0; i < nodes.size(); ++i) out[c] += weight[i] * values[nodes[i] * components + c];
            }
        },
        execution);
}

}  // namespace camber
