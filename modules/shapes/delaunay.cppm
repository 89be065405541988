module;
#include <span>
export module camber.shapes:delaunay;
import camber.core;
import :random;

export namespace camber {

/// The Delaunay triangulation of points (of their convex hull), positively oriented, in a fixed order.
///
/// Points are compared on a grid of 2^23 steps across their box, where the predicates are exact in 128-bit integers:
/// the result is sound on the grid; an element flatter than the grid's step may be inverted in the points themselves.
/// Errors: usage (fewer than D + 1 points, all in one plane, two in the same place on the grid).
template <int D>
[[nodiscard]] Outcome<Buffer<SimplexVertices<D>>> delaunay(std::span<const Vec<D>> points, const Noise& noise);

}  // namespace camber
