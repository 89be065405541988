module;
#include <array>
module camber.cavity:orientation;
import camber.core;

namespace camber {

/// D! times the volume of the straight simplex with these corners to rounding, and its sign without any, as long as
/// no product underflows: zero means that the corners lie in one plane (2D: on one line).
struct ExactlySigned {
    double volume = 0;
    int sign = 0;
};
template <int D>
[[nodiscard]] ExactlySigned exactly_signed_volume(const std::array<Vec<D>, D + 1>& corners);

}  // namespace camber
