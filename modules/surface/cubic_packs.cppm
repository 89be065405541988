module;
#include <span>
export module camber.surface:cubic_packs;
import camber.core;
import camber.bezier;
import :cubic;

export namespace camber {

/// Distances of many points from one cubic triangle, in packs (core:pack): by Newton's method from each start, as
/// `closest_from` finds them, for those whose foot is inside the triangle. Not a number for the others: on the rim, or
/// where the plain method does not settle. The same bytes with any instructions.
void distances_inside(const CubicSimplex<2, 3>& simplex, std::span<const Barycentric<2>> starts,
                      std::span<const Vec<3>> points, std::span<double> distances,
                      Instructions set = widest_instructions());

}  // namespace camber
