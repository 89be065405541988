module;
#include <functional>
#include <span>
export module camber.shapes:jitter;
import camber.core;

export namespace camber {

/// Moves the points to `moved`, but where that would leave an element less than `least` of its volume, only a half, a
/// quarter … of the way (its vertices, again and again until no element complains). Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Done> move_points(Buffer<Vec<D>>& points, std::span<const Vec<D>> moved,
                                        std::span<const SimplexVertices<D>> elements, double least,
                                        const Execution& execution = {});

}  // namespace camber
