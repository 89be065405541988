module;
#include <algorithm>
#include <cstddef>
#include <iterator>
#include <map>
#include <span>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import :grown_places;
import :ranks;
import :ringed_parts;
import :routing;
import :simplex_row;

namespace camber {

namespace {

template <int D>
SimplexRow<D> row_of(const RingedPart<D>& part, ElementId e) {
    SimplexRow<D> row{part.elements[e], {}, part.mesh.elements.references[e]};
    for (int i = 0; i <= D; ++i) row.vertices[i] = part.vertices[part.mesh.elements.vertices[e][i]];
    return row;
}

/// Those of the given elements that this rank's parts own.
template <int D>
std::vector<SimplexRow<D>> own_seeds(const RingedParts<D>& parts, const std::vector<GlobalNumber>& elements) {
    std::vector<SimplexRow<D>> own;
    for (const RingedPart<D>& part : parts.own)
        for (std::size_t e = 0; e < part.elements.size(); ++e)
            if (part.owns(part.mesh.elements.vertices[e]) && std::ranges::binary_search(elements, part.elements[e]))
                own.push_back(row_of(part, ElementId(e)));
    return own;
}

/// What is around the vertices that each rank asks for, of all parts.
template <int D>
Outcome<std::vector<SimplexRow<D>>> around_vertices(const RingedParts<D>& parts,
                                                    std::span<const Incidence<ElementId>> balls,
                                                    const std::vector<GlobalNumber>& mine, Ranks& ranks) {
    std::vector<std::vector<GlobalNumber>> of_ranks(ranks.size());
    for (const GlobalNumber v : mine) of_ranks[parts.layout.rank_of(parts.layout.part_with(v))].push_back(v);
    const auto asked = exchanged_lists(ranks, std::move(of_ranks));
    if (!asked) return fail(asked.error());
    std::vector<std::vector<SimplexRow<D>>> answers(ranks.size());
    for (std::size_t r = 0; r < ranks.size(); ++r)
        for (const GlobalNumber v : (*asked)[r]) {
            const std::size_t b = parts.layout.part_with(v) - parts.layout.begin_of(ranks.rank());
            const RingedPart<D>& part = parts.own[b];
            const VertexId local(std::ranges::lower_bound(part.vertices, v) - part.vertices.begin());
            for (const ElementId e : balls[b][local]) answers[r].push_back(row_of(part, e));
        }
    return exchanged_values<SimplexRow<D>>(ranks, std::move(answers));
}

template <int D>
void sort_rows(std::vector<SimplexRow<D>>& rows) {
    std::ranges::sort(rows, {}, &SimplexRow<D>::row);
    const auto again = std::ranges::unique(rows, {}, &SimplexRow<D>::row);
    rows.erase(again.begin(), again.end());
}

/// Around what each rank gives, ring by ring.
template <int D>
Outcome<GrownPlaces<D>> grown(const RingedParts<D>& parts, std::span<const Incidence<ElementId>> balls,
                              std::vector<SimplexRow<D>> seeds, int rings, Ranks& ranks) {
    GrownPlaces<D> made{std::move(seeds), {}};
    sort_rows(made.rows);
    for (int ring = 0; ring < rings; ++ring) {
        auto all = vertices_of<D>(made.rows);
        std::vector<GlobalNumber> front;
        std::ranges::set_difference(all, made.inner, std::back_inserter(front));
        const auto more = around_vertices<D>(parts, balls, front, ranks);
        if (!more) return fail(more.error());
        made.rows.insert(made.rows.end(), more->begin(), more->end());
        sort_rows(made.rows);
        made.inner = std::move(all);
    }
    return made;
}

/// A vertex, or what else is called by one, and the place that it is of: called by its lowest vertex.
struct OfPlace {
    GlobalNumber number = 0, place = 0;
    auto operator<=>(const OfPlace&) const = default;
};

/// Each vertex of what a rank has grown, as far as it knows by itself; rising.
template <int D>
std::vector<OfPlace> places_here(const std::vector<SimplexRow<D>>& rows) {
    const auto vertices = vertices_of<D>(rows);
    const auto at = [&](GlobalNumber v) {
        return static_cast<std::size_t>(std::ranges::lower_bound(vertices, v) - vertices.begin());
    };
    DisjointSets sets(vertices.size());
    for (const auto& row : rows)
        for (const GlobalNumber v : row.vertices) sets.unite(at(row.vertices[0]), at(v));
    std::vector<OfPlace> places;
    places.reserve(vertices.size());
    for (std::size_t v = 0; v < vertices.size(); ++v) places.push_back({vertices[v], vertices[sets.lowest(v)]});
    return places;
}

/// Places of several ranks that have a vertex in common, in pairs: all ranks have all.
Outcome<std::vector<OfPlace>> places_that_meet(const std::vector<OfPlace>& own, Ranks& ranks) {
    std::vector<std::vector<OfPlace>> to(ranks.size());
    for (const OfPlace& one : own) to[one.number % ranks.size()].push_back(one);
    auto all = exchanged_values<OfPlace>(ranks, std::move(to));
    if (!all) return fail(all.error());
    std::ranges::sort(*all);
    std::vector<OfPlace> pairs;
    for (std::size_t i = 1; i < all->size(); ++i)
        if ((*all)[i - 1].number == (*all)[i].number && (*all)[i - 1].place != (*all)[i].place)
            pairs.push_back({(*all)[i].place, (*all)[i - 1].place});
    std::ranges::sort(pairs);
    pairs.erase(std::ranges::unique(pairs).begin(), pairs.end());
    return gather_all(ranks, Outcome<std::vector<OfPlace>>(std::move(pairs)));
}

/// What places are called once those that meet are one.
class PlacesTogether {
  public:
    explicit PlacesTogether(const std::vector<OfPlace>& pairs) {
        for (const OfPlace& pair : pairs) {
            const GlobalNumber a = name_of(pair.number), b = name_of(pair.place);
            if (a != b) called_[std::max(a, b)] = std::min(a, b);
        }
    }
    [[nodiscard]] GlobalNumber name_of(GlobalNumber place) const {
        for (auto at = called_.find(place); at != called_.end(); at = called_.find(place)) place = at->second;
        return place;
    }

  private:
    std::map<GlobalNumber, GlobalNumber> called_;
};

}  // namespace

template <int D>
Outcome<GrownPlaces<D>> grown_places(const RingedParts<D>& parts, std::span<const Incidence<ElementId>> balls,
                                     const std::vector<GlobalNumber>& elements, int rings, Ranks& ranks) {
    const auto seeds = own_seeds(parts, elements);
    auto alone = grown<D>(parts, balls, seeds, rings, ranks);
    if (!alone || ranks.size() == 1) return alone;
    const auto here = places_here<D>(alone->rows);
    const auto pairs = places_that_meet(here, ranks);
    if (!pairs) return fail(pairs.error());
    const PlacesTogether together(*pairs);
    struct Seed {
        SimplexRow<D> element;
        GlobalNumber place = 0;
    };
    std::vector<Seed> own;
    own.reserve(seeds.size());
    for (const SimplexRow<D>& seed : seeds) {
        const auto at = std::ranges::lower_bound(here, seed.vertices[0], {}, &OfPlace::number);
        own.push_back({seed, together.name_of(at->place)});
    }
    auto all = gather_all(ranks, Outcome<std::vector<Seed>>(std::move(own)));
    if (!all) return fail(all.error());
    std::ranges::sort(*all, {}, [](const Seed& s) { return std::pair(s.place, s.element.row); });
    std::vector<SimplexRow<D>> mine;
    std::size_t owner = 0;
    for (std::size_t i = 0; i < all->size(); ++i) {
        const Seed& seed = (*all)[i];
        if (i == 0 || seed.place != (*all)[i - 1].place)
            owner = parts.layout.rank_of(parts.layout.part_with(std::ranges::min(seed.element.vertices)));
        if (owner == ranks.rank()) mine.push_back(seed.element);
    }
    return grown<D>(parts, balls, std::move(mine), rings, ranks);
}

template Outcome<GrownPlaces<2>> grown_places<2>(const RingedParts<2>&, std::span<const Incidence<ElementId>>,
                                                 const std::vector<GlobalNumber>&, int, Ranks&);
template Outcome<GrownPlaces<3>> grown_places<3>(const RingedParts<3>&, std::span<const Incidence<ElementId>>,
                                                 const std::vector<GlobalNumber>&, int, Ranks&);

}  // namespace camber
