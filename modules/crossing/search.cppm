module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
module camber.crossing:search;
import camber.core;
import camber.bezier;
import :graph;
import :net;
import :pair;
import :parabola;
import :separation;
import :transversal;

/// The search through the pieces of two facets for a proof: what no proof fits is divided.
namespace camber {

/// The local edge between two corners of a triangle.
[[nodiscard]] constexpr int edge_between(int i, int j) { return i + j == 1 ? 0 : i + j == 3 ? 1 : 2; }

[[nodiscard]] inline bool share_edge(const Net<3>& first, const Net<3>& second, const Common<3>& common) {
    return common.count == 2 && first.part[edge_between(common.first[0], common.first[1])].same_as(
                                    second.part[edge_between(common.second[0], common.second[1])]);
}
[[nodiscard]] inline bool share_edge(const Net<2>&, const Net<2>&, const Common<2>&) { return false; }

[[nodiscard]] inline bool unfold(const Net<3>& first, const Net<3>& second, const Common<3>& common) {
    const auto sheet = [](const Net<3>& net, int from, int to, double side) {
        return Sheet{&net, from, to, 3 - from - to, side};
    };
    const std::array<Sheet, 2> sheets{sheet(first, common.first[0], common.first[1], 1),
                                      sheet(second, common.second[0], common.second[1], -1)};
    return is_graph(sheets);
}
[[nodiscard]] inline bool unfold(const Net<2>&, const Net<2>&, const Common<2>&) { return false; }

template <int D>
[[nodiscard]] inline double extent(const Net<D>& net) {
    return box_of(net).diagonal();
}

/// The search through pairs of pieces, deepest first.
template <int D>
class Search {
  public:
    explicit Search(int effort) : effort_(effort), left_(effort) {}

    [[nodiscard]] bool cut_short() const { return left_ < 0; }
    [[nodiscard]] int steps() const { return effort_ - std::max(left_, 0); }

    [[nodiscard]] Crossing pair(const Net<D>& first, const Net<D>& second) {
        if (--left_ < 0) return Crossing::undecided;
        const Common<D> common = common_corners(first, second);
        const bool edge = share_edge(first, second, common);
        if (are_apart(first, second, common, edge)) return Crossing::disjoint;
        if (pass_through(first, second)) return Crossing::crossing;
        const bool both = common.count >= 2;
        const bool first_only = !both && extent(first) >= extent(second);
        return divided(first, second, both || first_only, both || !first_only);
    }

    [[nodiscard]] Crossing itself(const Net<3>& net) {
        if (--left_ < 0) return Crossing::undecided;
        const std::array<Sheet, 1> sheet{sheet_of(net)};
        if (is_graph(sheet)) return Crossing::disjoint;
        if (net.divisions == max_divisions) return Crossing::undecided;
        const auto parts = pieces(named(net));
        Crossing worst = Crossing::disjoint;
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t j = i + 1; j < 4; ++j)
                if (join(worst, pair(parts[i], parts[j])) == Crossing::crossing) return worst;
        for (const Net<3>& part : parts)
            if (join(worst, itself(part)) == Crossing::crossing) return worst;
        return worst;
    }

  private:
    static bool are_apart(const Net<D>& first, const Net<D>& second, const Common<D>& common, bool edge) {
        if constexpr (D == 2)
            if (separated_by_parabola(first, second, common)) return true;
        if (common.count == 0) return separated(first, second);
        if (common.count == 1) return separated_at(first, common.first[0], second, common.second[0]);
        return edge && unfold(first, second, common);
    }

    static Crossing join(Crossing& worst, Crossing found) {
        if (found != Crossing::disjoint) worst = found == Crossing::crossing ? found : std::max(worst, found);
        return worst;
    }

    Crossing divided(const Net<D>& first, const Net<D>& second, bool divide_first, bool divide_second) {
        if ((divide_first && first.divisions == max_divisions) || (divide_second && second.divisions == max_divisions))
            return Crossing::undecided;
        Crossing worst = Crossing::disjoint;
        const auto against = [&](const Net<D>& piece) {
            if (!divide_second) return join(worst, pair(piece, second));
            for (const Net<D>& other : pieces(second))
                if (join(worst, pair(piece, other)) == Crossing::crossing || left_ < 0) break;
            return worst;
        };
        if (!divide_first) return against(first);
        for (const Net<D>& piece : pieces(first))
            if (against(piece) == Crossing::crossing || left_ < 0) break;
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

    int effort_, left_;
};

}  // namespace camber
