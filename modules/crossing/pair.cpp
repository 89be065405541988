module;
#include <optional>
module camber.crossing;
import camber.core;
import camber.bezier;
import :facet;
import :net;
import :pair;
import :planar;
import :search;
import :straight;

namespace camber {

namespace {

/// What is left when one look has not told.
template <int D>
Judgement search_pair(const NetPair<D>& pair, int effort, int steps, bool cut_short) {
    Search<D> search(effort);
    const Crossing verdict = search.pair(pair.first, pair.second);
    return {verdict, steps + search.steps(), verdict == Crossing::undecided && (cut_short || search.cut_short())};
}

Judgement judge_bent(const NodalFacet<2>&, const NodalFacet<2>&, const NetPair<2>& pair, int effort) {
    return search_pair(pair, effort, 1, false);
}

Judgement judge_bent(const NodalFacet<3>& first, const NodalFacet<3>& second, const NetPair<3>& pair, int effort) {
    PlanarTest planar(pair.first, pair.second, effort);
    const auto seen = planar.verdict([&] { return are_in_one_plane(first, second); });
    if (seen) return {*seen, planar.steps() + 1, false};
    return search_pair(pair, effort, planar.steps() + 1, planar.cut_short());
}

}  // namespace

template <int D>
Judgement judge_pair(const NodalFacet<D>& first, const NodalFacet<D>& second, int effort) {
    if (first == second) return {Crossing::disjoint, 0, false};
    const auto pair = net_pair(first, second);
    if (pair) {
        if (pair->same) return {Crossing::disjoint, 0, false};
        const Crossing found = Search<D>(1).pair(pair->first, pair->second);
        if (found != Crossing::undecided) return {found, 1, false};
    }
    if (is_straight(first) && is_straight(second))
        if (const auto exact = crossing_of_straight(first, second)) return {*exact, 1, false};
    if (!pair) return {Crossing::undecided, 0, false};
    return judge_bent(first, second, *pair, effort);
}

template <>
Judgement judge_itself<2>(const NodalFacet<2>&, int) {
    return {Crossing::disjoint, 0, false};
}

template <>
Judgement judge_itself<3>(const NodalFacet<3>& facet, int effort) {
    const Vec<3> origin = facet.nodes[0];
    const auto unit = unit_for(facet, facet, origin);
    if (!unit) return {Crossing::undecided, 0, false};
    const Net<3> net = net_of(facet, origin, *unit);
    if (Search<3>(1).itself(net) == Crossing::disjoint || is_simple_in_plane(net))
        return {Crossing::disjoint, 1, false};
    Search<3> search(effort);
    const Crossing verdict = search.itself(net);
    return {verdict, 1 + search.steps(), verdict == Crossing::undecided && search.cut_short()};
}

template <int D>
Crossing crossing_of(const NodalFacet<D>& first, const NodalFacet<D>& second, int effort) {
    return judge_pair(first, second, effort).verdict;
}

template <int D>
Crossing crossing_of_itself(const NodalFacet<D>& facet, int effort) {
    return judge_itself(facet, effort).verdict;
}

#define CAMBER_INSTANTIATE(D)                                                          \
    template Judgement judge_pair<D>(const NodalFacet<D>&, const NodalFacet<D>&, int); \
    template Crossing crossing_of<D>(const NodalFacet<D>&, const NodalFacet<D>&, int); \
    template Crossing crossing_of_itself<D>(const NodalFacet<D>&, int);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
