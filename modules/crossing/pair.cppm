module;
#include <cstdint>
#include <string_view>
export module camber.crossing:pair;
import camber.core;
import :facet;

export namespace camber {

/// Do two facets cross?
enum class Crossing : std::uint8_t {
    clear,     ///< proved: they have nothing in common but what they share
    crossing,  ///< proved: they pass through each other
    undecided  ///< nearer to each other than the work or rounding allow to tell: they touch, or nearly do
};

/// "clear", "crossing", "undecided".
[[nodiscard]] constexpr std::string_view word(Crossing crossing) {
    return crossing == Crossing::clear ? "clear" : crossing == Crossing::crossing ? "crossing" : "undecided";
}

/// Pairs of pieces that are looked at before two facets are left undecided.
inline constexpr int default_effort = 4000;

/// Whether two P2 facets have points in common other than what they share by right: vertices at the same place, and
/// edges of which all three nodes are. Facets of which all nodes are at the same places are one (the two sides of a
/// slit), and clear. Both proofs hold for the nodes as they are stored, rounding included. Nodes that are not finite:
/// undecided.
template <int D>
[[nodiscard]] Crossing crossing_of(const NodalFacet<D>& first, const NodalFacet<D>& second,
                                   int effort = default_effort);

/// Whether a facet has a point twice. A curve in the plane has none unless it turns back on itself, where it is not
/// regular: clear.
template <int D>
[[nodiscard]] Crossing crossing_of_itself(const NodalFacet<D>& facet, int effort = default_effort);

}  // namespace camber
