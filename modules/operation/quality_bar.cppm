module;
#include <algorithm>
#include <limits>
#include <optional>
#include <vector>
export module camber.operation:quality_bar;
import camber.core;
import camber.metric;
import camber.cavity;
import :measures;
import :state;
import :request;

export namespace camber {

/// Of elements that are to be removed: the shape of the worst.
template <int D>
[[nodiscard]] double worst_shape_of(const Adaptation<D>& r, const std::vector<ElementId>& elements) {
    double worst = std::numeric_limits<double>::infinity();
    for (const ElementId e : elements) worst = std::min(worst, known_shape_of(r, e));
    return worst;
}

/// What the shape of each new element of a patch must be: the one place where that is judged, for every pass and either
/// degree. What its limits ask for, and whatever `min_shape` is: no new element is below `bad_quality` and below
/// the worst that is replaced. Where the limits allow it, that worst one is enough.
template <int D>
class QualityBar {
  public:
    QualityBar(const Adaptation<D>& r, const PatchLimits& limits, const std::vector<ElementId>& replaced)
        : r_(r), limits_(limits), replaced_(replaced) {}

    [[nodiscard]] bool is_met(double shape) {
        const double asked = limits_.min_shape;
        if (shape > asked && shape >= shape_of_quality(limits_.bad_quality, D)) return true;
        if (!(shape > asked) && limits_.below_least == BelowLeast::refused) return false;
        return shape >= worst_replaced();
    }

  private:
    /// But for the rounding of an element that is measured with its vertices in another order.
    [[nodiscard]] double worst_replaced() {
        constexpr double rounding = 1e-9;
        if (!worst_) worst_ = worst_shape_of(r_, replaced_);
        return (1 - rounding) * *worst_;
    }

    const Adaptation<D>& r_;
    const PatchLimits& limits_;
    const std::vector<ElementId>& replaced_;
    std::optional<double> worst_;
};

}  // namespace camber
