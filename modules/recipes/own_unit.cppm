module;
#include <algorithm>
#include <cmath>
#include <utility>
export module camber.recipes:own_unit;
import camber.core;

namespace camber {

/// A field in a unit of its own, a power of two, in which its range is about 1: products of derivatives neither vanish
/// nor overflow, whatever the user's unit, and not a bit of what is made of it depends on that.
[[nodiscard]] inline Column<double> in_own_unit(const Column<double>& values) {
    if (values.empty()) return values;
    const auto [least, largest] = std::minmax_element(values.begin(), values.end());
    const double range = *largest / 2 - *least / 2;
    if (!(range > 0) || !std::isfinite(range)) return values;
    const int exponent = std::ilogb(range);
    Buffer<double> scaled(values.begin(), values.end());
    for (double& x : scaled) x = std::scalbn(x, -exponent);
    return Column<double>(std::move(scaled));
}

}  // namespace camber
