module;
#include <cstdint>
#include <string_view>
export module camber.crossing:pair;
import camber.core;
import :facet;

export namespace camber {

/// Do two facets cross?
enum class Crossing : std::uint8_t {
    disjoint,  ///< proved: they have nothing in common but what they share
    crossing,  ///< proved: they pass through each other
    touching,  ///< proved: they have more in common than they share, and do not pass through each other: contact
    undecided  ///< nearer to each other than the work or rounding allow to tell
};

/// "disjoint", "crossing", "touching", "undecided".
[[nodiscard]] constexpr std::string_view word(Crossing crossing) {
    switch (crossing) {
        case Crossing::disjoint: return "disjoint";
        case Crossing::crossing: return "crossing";
        case Crossing::touching: return "touching";
        case Crossing::undecided: break;
    }
    return "undecided";
}

/// Pairs of pieces that are looked at before two facets are left undecided.
inline constexpr int default_effort = 4000;

/// Whether two P2 facets have points in common other than what they share by right: vertices at the same place, and
/// edges of which all three nodes are. Facets of which all nodes are at the same places are one (the two sides of a
/// slit), and disjoint. Proofs hold for the nodes as they are stored, rounding included; facets whose mid nodes are
/// `midpoint` of their edges' ends are straight, and two of them are always decided (those without area are not), in
/// integers if need be. Facets in one plane do not pass through each other: they are disjoint or touch. Nodes that are
/// not finite: undecided.
template <int D>
[[nodiscard]] Crossing crossing_of(const NodalFacet<D>& first, const NodalFacet<D>& second,
                                   int effort = default_effort);

/// Whether a facet has a point twice. A curve in the plane has none unless it turns back on itself, where it is not
/// regular: disjoint.
template <int D>
[[nodiscard]] Crossing crossing_of_itself(const NodalFacet<D>& facet, int effort = default_effort);

}  // namespace camber

namespace camber {

/// A verdict, and what it took.
struct Judgement {
    Crossing verdict = Crossing::undecided;
    int steps = 0;           ///< pairs of pieces that were looked at
    bool cut_short = false;  ///< undecided for want of effort: more of it may tell
};

/// `crossing_of` and `crossing_of_itself`, with what they took.
template <int D>
[[nodiscard]] Judgement judge_pair(const NodalFacet<D>& first, const NodalFacet<D>& second, int effort);
template <int D>
[[nodiscard]] Judgement judge_itself(const NodalFacet<D>& facet, int effort);

}  // namespace camber
