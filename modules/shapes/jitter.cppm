module;
#include <cstddef>
#include <cstdint>
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

/// The part of its volume that random moves leave an element.
inline constexpr double least_jittered = 0.2;

/// So many times a move is halved at most, and so many rings of elements around a point decide where it comes to lie.
inline constexpr int rings_of_move = 12;

/// Where a point is to go. It is asked for again where the way is halved.
template <int D>
using Moved = std::function<Vec<D>(std::size_t)>;
/// Elements that are made run by run: f(those that just moved, look) calls look(elements) for all runs, or all that
/// have a vertex which has just moved.
template <int D>
using ElementRuns =
    std::function<Outcome<Done>(std::span<const std::uint8_t> just_moved,
                                const std::function<Outcome<Done>(std::span<const SimplexVertices<D>>)>& look)>;

/// The same of elements that are not there all at once.
template <int D>
[[nodiscard]] Outcome<Done> move_points(Buffer<Vec<D>>& points, const Moved<D>& moved, const ElementRuns<D>& runs,
                                        double least, const Execution& execution = {});

}  // namespace camber
