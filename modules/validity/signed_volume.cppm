module;
#include <array>
export module camber.validity:signed_volume;
import camber.core;
import camber.bezier;
import :jacobian;

export namespace camber {

/// Of the straight simplex with these corners: D! times its volume (area in 2D), the sign certain; 0 where the sign is
/// not to be told, in numbers of twice the digits either.
template <int D>
[[nodiscard]] double signed_volume(const std::array<Vec<D>, D + 1>& corners);

/// The same of a curved element: ∫ det J over the reference element's volume; of the straight one where its sign is not
/// to be told.
template <int D>
[[nodiscard]] double signed_volume(const NodalSimplex<D>& element);

}  // namespace camber
