module;
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
export module camber.recovery:own_unit;
import camber.core;

export namespace camber {

/// The exponent of the power of two in which the range of these values is about 1; 0 of a constant, of none, and of
/// values that are not finite.
[[nodiscard]] inline int own_exponent(std::span<const double> values) {
    if (values.empty()) return 0;
    const auto [least, largest] = std::minmax_element(values.begin(), values.end());
    const double half_range = *largest / 2 - *least / 2;
    return half_range > 0 && std::isfinite(half_range) ? std::ilogb(half_range) : 0;
}

/// A field in a unit of its own, a power of two, in which its range is about 1: products of derivatives neither vanish
/// nor overflow, whatever the user's unit, and not a bit of what is made of it depends on that.
[[nodiscard]] inline Column<double> in_own_unit(const Column<double>& values) {
    const int exponent = own_exponent(values);
    if (exponent == 0) return values;
    Buffer<double> scaled(values.begin(), values.end());
    for (double& x : scaled) x = std::scalbn(x, -exponent);
    return Column<double>(std::move(scaled));
}

}  // namespace camber
