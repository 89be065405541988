module;
#include <optional>
module camber.crossing:straight;
import camber.core;
import :facet;
import :pair;

/// Straight facets, exactly: what they have in common is a stretch of a line, or of a plane, and its ends are ratios of
/// integers.
namespace camber {

/// Its mid nodes are the middles of the chords, as doubles have them.
template <int D>
[[nodiscard]] inline bool is_straight(const NodalFacet<D>& facet) {
    for (int e = 0; e < edges_per_simplex<D - 1>; ++e) {
        const auto [i, j] = local_edges<D - 1>[e];
        if (!(facet.nodes[D + e] == midpoint(facet.nodes[i], facet.nodes[j]))) return false;
    }
    return true;
}

/// The verdict of the straight facets of the vertices, in integers. None if one has no area (no length), or a vertex
/// that is not finite.
[[nodiscard]] std::optional<Crossing> crossing_of_straight(const NodalFacet<2>& first, const NodalFacet<2>& second);
[[nodiscard]] std::optional<Crossing> crossing_of_straight(const NodalFacet<3>& first, const NodalFacet<3>& second);

/// All nodes of both lie in one plane, exactly.
[[nodiscard]] bool are_in_one_plane(const NodalFacet<3>& first, const NodalFacet<3>& second);

}  // namespace camber
