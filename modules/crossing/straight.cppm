module;
#include <cstdint>
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

/// How two touching facets meet, each with the inside of its body on the side against its normal. In 2D the normal of
/// an edge points to the right of it.
enum class Contact : std::uint8_t {
    rims,      ///< in points or lines that lie on the rim of one of them, or outside the other's body
    opposite,  ///< in an area (a length) of one plane (line), with the bodies on its two sides: contact of two bodies
    inside     ///< one of them lies on, or enters, the inner side of the other's interior: the bodies overlap there
};

/// The contact of the straight facets of the vertices, of which `crossing_of_straight` says that they touch. Decided
/// in integers. None if one has no area (no length), or a vertex that is not finite.
[[nodiscard]] std::optional<Contact> contact_of_straight(const NodalFacet<2>& first, const NodalFacet<2>& second);
[[nodiscard]] std::optional<Contact> contact_of_straight(const NodalFacet<3>& first, const NodalFacet<3>& second);

/// All nodes of both lie in one plane, exactly.
[[nodiscard]] bool are_in_one_plane(const NodalFacet<3>& first, const NodalFacet<3>& second);

}  // namespace camber
