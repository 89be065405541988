module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
module camber.crossing;
import camber.core;
import camber.bezier;
import :facet;
import :graph;
import :net;
import :pair;
import :separation;
import :transversal;

namespace camber {

namespace {

/// Corners that two pieces have in common.
template <int D>
struct Common {
    int count = 0;
    std::array<int, D> first{}, second{};
};

template <int D>
Common<D> common_corners(const Net<D>& first, const Net<D>& second) {
    Common<D> common;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j)
            if (first.corner[i] != 0 && first.corner[i] == second.corner[j] && common.count < D) {
                common.first[common.count] = i;
                common.second[common.count++] = j;
            }
    return common;
}

/// The local edge between two corners of a triangle.
constexpr int edge_between(int i, int j) { return i + j == 1 ? 0 : i + j == 3 ? 1 : 2; }

bool share_edge(const Net<3>& first, const Net<3>& second, const Common<3>& common) {
    return common.count == 2 && first.part[edge_between(common.first[0], common.first[1])].same_as(
                                    second.part[edge_between(common.second[0], common.second[1])]);
}
bool share_edge(const Net<2>&, const Net<2>&, const Common<2>&) { return false; }

bool unfold(const Net<3>& first, const Net<3>& second, const Common<3>& common) {
    const auto sheet = [](const Net<3>& net, int from, int to, double side) {
        return Sheet{&net, from, to, 3 - from - to, side};
    };
    const std::array<Sheet, 2> sheets{sheet(first, common.first[0], common.first[1], 1),
                                      sheet(second, common.second[0], common.second[1], -1)};
    return is_graph(sheets);
}
bool unfold(const Net<2>&, const Net<2>&, const Common<2>&) { return false; }

template <int D>
double extent(const Net<D>& net) {
    return box_of(net).diagonal();
}

/// The search through pairs of pieces, deepest first.
template <int D>
class Search {
  public:
    explicit Search(int effort) : effort_(effort) {}

    Crossing pair(const Net<D>& first, const Net<D>& second) {
        if (--effort_ < 0) return Crossing::undecided;
        const Common<D> common = common_corners(first, second);
        const bool edge = share_edge(first, second, common);
        if (is_clear(first, second, common, edge)) return Crossing::clear;
        if (pass_through(first, second)) return Crossing::crossing;
        const bool both = common.count >= 2;
        const bool first_only = !both && extent(first) >= extent(second);
        return divided(first, second, both || first_only, both || !first_only);
    }

    Crossing itself(const Net<3>& net) {
        if (--effort_ < 0) return Crossing::undecided;
        const std::array<Sheet, 1> sheet{sheet_of(net)};
        if (is_graph(sheet)) return Crossing::clear;
        if (net.divisions == most_divisions) return Crossing::undecided;
        const auto parts = pieces(named(net));
        Crossing worst = Crossing::clear;
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t j = i + 1; j < 4; ++j)
                if (join(worst, pair(parts[i], parts[j])) == Crossing::crossing) return worst;
        for (const Net<3>& part : parts)
            if (join(worst, itself(part)) == Crossing::crossing) return worst;
        return worst;
    }

  private:
    static bool is_clear(const Net<D>& first, const Net<D>& second, const Common<D>& common, bool edge) {
        if (common.count == 0) return separated(first, second);
        if (common.count == 1) return separated_at(first, common.first[0], second, common.second[0]);
        return edge && unfold(first, second, common);
    }

    static Crossing join(Crossing& worst, Crossing found) {
        if (found != Crossing::clear) worst = found == Crossing::crossing ? found : std::max(worst, found);
        return worst;
    }

    Crossing divided(const Net<D>& first, const Net<D>& second, bool divide_first, bool divide_second) {
        if ((divide_first && first.divisions == most_divisions) ||
            (divide_second && second.divisions == most_divisions))
            return Crossing::undecided;
        Crossing worst = Crossing::clear;
        const auto against = [&](const Net<D>& piece) {
            if (!divide_second) return join(worst, pair(piece, second));
            for (const Net<D>& other : pieces(second))
                if (join(worst, pair(piece, other)) == Crossing::crossing || effort_ < 0) break;
            return worst;
        };
        if (!divide_first) return against(first);
        for (const Net<D>& piece : pieces(first))
            if (against(piece) == Crossing::crossing || effort_ < 0) break;
        return worst;
    }

    /// Its pieces know each other by corners and inner edges: names for all of them.
    static Net<3> named(Net<3> net) {
        for (int i = 0; i < 3; ++i) {
            net.corner[i] = static_cast<SharedPoint>(i) + 1;
            net.part[i] = {static_cast<std::uint32_t>(i) + 1, 1, false};
        }
        return net;
    }

    int effort_;
};

}  // namespace

template <int D>
Crossing crossing_of(const NodalFacet<D>& first, const NodalFacet<D>& second, int effort) {
    if (first == second) return Crossing::clear;
    const auto pair = net_pair(first, second);
    if (!pair) return Crossing::undecided;
    if (pair->same) return Crossing::clear;
    return Search<D>(effort).pair(pair->first, pair->second);
}

template <>
Crossing crossing_of_itself<2>(const NodalFacet<2>&, int) {
    return Crossing::clear;
}

template <>
Crossing crossing_of_itself<3>(const NodalFacet<3>& facet, int effort) {
    const Vec<3> origin = facet.nodes[0];
    const auto unit = unit_for(facet, facet, origin);
    if (!unit) return Crossing::undecided;
    return Search<3>(effort).itself(net_of(facet, origin, *unit));
}

template Crossing crossing_of<2>(const NodalFacet<2>&, const NodalFacet<2>&, int);
template Crossing crossing_of<3>(const NodalFacet<3>&, const NodalFacet<3>&, int);

}  // namespace camber
