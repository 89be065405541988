// Collects elements and rings around them on one rank.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <numeric>
#include <span>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.bezier;
import camber.metric;

namespace camber {

namespace {

class DisjointSets {
  public:
    explicit DisjointSets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
    [[nodiscard]] std::size_t lowest(std::size_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void unite(std::size_t i, std::size_t j) {
        const auto [low, high] = std::minmax({lowest(i), lowest(j)});
        parent_[high] = low;
    }

  private:
    std::vector<std::size_t> parent_;
};

template <int D>
[[nodiscard]] std::vector<GlobalNumber> vertices_of(std::span<const SimplexRow<D>> rows) {
    std::vector<GlobalNumber> vertices;
    for (const auto& row : rows) vertices.insert(vertices.end(), row.vertices.begin(), row.vertices.end());
    std::ranges::sort(vertices);
    vertices.erase(std::ranges::unique(vertices).begin(), vertices.end());
    return vertices;
}

template <int D>
struct GrownElements {
    std::vector<SimplexRow<D>> rows;
    std::vector<GlobalNumber> inner;
};

template <int D>
SimplexRow<D> row_of(const RingedPart<D>& part, ElementId e) {
    SimplexRow<D> row{part.elements[e], {}, part.mesh.elements.references[e]};
    for (int i = 0; i <= D; ++i) row.vertices[i] = part.vertices[part.mesh.elements.vertices[e][i]];
    return row;
}

template <int D>
std::vector<SimplexRow<D>> own_seeds(const RingedParts<D>& parts, const std::vector<GlobalNumber>& elements) {
    std::vector<SimplexRow<D>> own;
    for (const RingedPart<D>& part : parts.own)
        for (std::size_t e = 0; e < part.elements.size(); ++e)
            if (part.owns(part.mesh.elements.vertices[e]) && std::ranges::binary_search(elements, part.elements[e]))
                own.push_back(row_of(part, ElementId(e)));
    return own;
}

template <int D>
Outcome<std::vector<SimplexRow<D>>> around_vertices(const RingedParts<D>& parts,
                                                    std::span<const Incidence<ElementId>> balls,
                                                    const std::vector<GlobalNumber>& own_numbers, Ranks& ranks) {
    std::vector<std::vector<GlobalNumber>> of_ranks(ranks.size());
    for (const GlobalNumber v : own_numbers) of_ranks[parts.layout.rank_of(parts.layout.part_with(v))].push_back(v);
    const auto requests = exchanged_lists(ranks, std::move(of_ranks));
    if (!requests) return fail(requests.error());
    std::vector<std::vector<SimplexRow<D>>> answers(ranks.size());
    for (std::size_t r = 0; r < ranks.size(); ++r)
        for (const GlobalNumber v : (*requests)[r]) {
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

template <int D>
Outcome<GrownElements<D>> add_rings(const RingedParts<D>& parts, std::span<const Incidence<ElementId>> balls,
                                    std::vector<SimplexRow<D>> seeds, int rings, Ranks& ranks) {
    GrownElements<D> result{std::move(seeds), {}};
    sort_rows(result.rows);
    for (int ring = 0; ring < rings; ++ring) {
        auto all = vertices_of<D>(result.rows);
        std::vector<GlobalNumber> front;
        std::ranges::set_difference(all, result.inner, std::back_inserter(front));
        const auto more = around_vertices<D>(parts, balls, front, ranks);
        if (!more) return fail(more.error());
        result.rows.insert(result.rows.end(), more->begin(), more->end());
        sort_rows(result.rows);
        result.inner = std::move(all);
    }
    return result;
}

/// A vertex or a place, and the place to which it belongs. A place is a connected set of elements, identified by its
/// lowest vertex.
struct PlaceMember {
    GlobalNumber number = 0, place = 0;
    auto operator<=>(const PlaceMember&) const = default;
};

template <int D>
std::vector<PlaceMember> places_on_rank(const std::vector<SimplexRow<D>>& rows) {
    const auto vertices = vertices_of<D>(rows);
    const auto at = [&](GlobalNumber v) {
        return static_cast<std::size_t>(std::ranges::lower_bound(vertices, v) - vertices.begin());
    };
    DisjointSets sets(vertices.size());
    for (const auto& row : rows)
        for (const GlobalNumber v : row.vertices) sets.unite(at(row.vertices[0]), at(v));
    std::vector<PlaceMember> places;
    places.reserve(vertices.size());
    for (std::size_t v = 0; v < vertices.size(); ++v) places.push_back({vertices[v], vertices[sets.lowest(v)]});
    return places;
}

Outcome<std::vector<PlaceMember>> touching_places(const std::vector<PlaceMember>& own, Ranks& ranks) {
    std::vector<std::vector<PlaceMember>> to(ranks.size());
    for (const PlaceMember& one : own) to[one.number % ranks.size()].push_back(one);
    auto all = exchanged_values<PlaceMember>(ranks, std::move(to));
    if (!all) return fail(all.error());
    std::ranges::sort(*all);
    std::vector<PlaceMember> pairs;
    for (std::size_t i = 1; i < all->size(); ++i)
        if ((*all)[i - 1].number == (*all)[i].number && (*all)[i - 1].place != (*all)[i].place)
            pairs.push_back({(*all)[i].place, (*all)[i - 1].place});
    std::ranges::sort(pairs);
    pairs.erase(std::ranges::unique(pairs).begin(), pairs.end());
    return gather_all(ranks, Outcome<std::vector<PlaceMember>>(std::move(pairs)));
}

class MergedPlaces {
  public:
    explicit MergedPlaces(const std::vector<PlaceMember>& pairs) {
        for (const PlaceMember& pair : pairs) {
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

/// Adds rings around the `elements` of all ranks. Each connected set of the resulting elements is a place.
template <int D>
Outcome<GrownElements<D>> grown_places(const RingedParts<D>& parts, std::span<const Incidence<ElementId>> balls,
                                       const std::vector<GlobalNumber>& elements, int rings, Ranks& ranks) {
    const auto seeds = own_seeds(parts, elements);
    auto alone = add_rings<D>(parts, balls, seeds, rings, ranks);
    if (!alone || ranks.size() == 1) return alone;
    const auto here = places_on_rank<D>(alone->rows);
    const auto pairs = touching_places(here, ranks);
    if (!pairs) return fail(pairs.error());
    const MergedPlaces together(*pairs);
    struct Seed {
        SimplexRow<D> element;
        GlobalNumber place = 0;
    };
    std::vector<Seed> own;
    own.reserve(seeds.size());
    for (const SimplexRow<D>& seed : seeds) {
        const auto at = std::ranges::lower_bound(here, seed.vertices[0], {}, &PlaceMember::number);
        own.push_back({seed, together.name_of(at->place)});
    }
    auto all = gather_all(ranks, Outcome<std::vector<Seed>>(std::move(own)));
    if (!all) return fail(all.error());
    std::ranges::sort(*all, {}, [](const Seed& s) { return std::pair(s.place, s.element.row); });
    std::vector<SimplexRow<D>> own_numbers;
    std::size_t owner = 0;
    for (std::size_t i = 0; i < all->size(); ++i) {
        const Seed& seed = (*all)[i];
        if (i == 0 || seed.place != (*all)[i - 1].place)
            owner = parts.layout.rank_of(parts.layout.part_with(std::ranges::min(seed.element.vertices)));
        if (owner == ranks.rank()) own_numbers.push_back(seed.element);
    }
    return add_rings<D>(parts, balls, std::move(own_numbers), rings, ranks);
}

template <int D>
struct VertexData {
    Vec<D> point;
    Reference reference = 0;
    LogMetric<D> log_metric;
};
template <int D>
struct EdgeData {
    LagrangeNode<D> node, extended, back_node;
    EdgeKind kind = EdgeKind::volume;
};

template <int D>
Outcome<Done> take_vertices(const RingedParts<D>& parts, const std::vector<PartState<D>>& states, Region<D>& region,
                            Ranks& ranks) {
    std::vector<ToPart<GlobalNumber>> questions;
    questions.reserve(region.vertices.size());
    for (const GlobalNumber v : region.vertices) questions.push_back({parts.layout.part_with(v), v});
    const auto data = query<VertexData<D>>(ranks, parts.layout, questions, [&](std::size_t b, GlobalNumber number) {
        const RingedPart<D>& part = parts.own[b];
        const VertexId v(std::ranges::lower_bound(part.vertices, number) - part.vertices.begin());
        return VertexData<D>{part.mesh.points[v], part.mesh.point_references[v],
                             states[b].log_metrics.empty() ? LogMetric<D>{} : states[b].log_metrics[v.index()]};
    });
    if (!data) return fail(data.error());
    Buffer<Vec<D>> points;
    Buffer<Reference> references;
    for (const auto& v : *data) {
        points.push_back(v.point);
        references.push_back(v.reference);
        region.log_metrics.push_back(v.log_metric);
    }
    region.mesh.linear.points = std::move(points);
    region.mesh.linear.point_references = std::move(references);
    return Done{};
}

template <int D>
Outcome<Done> take_edges(const RingedParts<D>& parts, const std::vector<PartState<D>>& states, bool has_extension,
                         bool has_back_nodes, Region<D>& region, Ranks& ranks) {
    using Ends = std::array<GlobalNumber, 2>;
    std::vector<ToPart<Ends>> questions;
    for (const auto& [a, b] : region.mesh.edges.vertices) {
        const Ends ends{region.vertices[a.index()], region.vertices[b.index()]};
        questions.push_back({parts.layout.part_with(ends[0]), ends});
    }
    const auto data = query<EdgeData<D>>(ranks, parts.layout, questions, [&](std::size_t b, const Ends& ends) {
        const RingedPart<D>& part = parts.own[b];
        const PartState<D>& state = states[b];
        const auto local = [&](GlobalNumber number) {
            return VertexId(std::ranges::lower_bound(part.vertices, number) - part.vertices.begin());
        };
        const std::size_t e = find_edge(state.mesh.edges, local(ends[0]), local(ends[1])).index();
        EdgeData<D> of{state.nodes[e], {}, {}, state.kinds[e]};
        if (state.extended.is_known()) of.extended = state.extended.at(state.mesh, EdgeId(e));
        if (state.back_nodes.is_known()) of.back_node = state.back_nodes.at(state.mesh, EdgeId(e));
        return of;
    });
    if (!data) return fail(data.error());
    Buffer<LagrangeNode<D>> nodes;
    Buffer<EdgeKind> kinds;
    for (const auto& edge : *data) {
        nodes.push_back(edge.node);
        kinds.push_back(edge.kind);
        if (has_extension) region.extended.push_back(edge.extended);
        if (has_back_nodes) region.back_nodes.push_back(edge.back_node);
    }
    region.mesh.mid_nodes = std::move(nodes);
    region.kinds = std::move(kinds);
    return Done{};
}

template <int D>
Outcome<Region<D>> region_of(const RingedParts<D>& parts, const std::vector<PartState<D>>& states,
                             const GrownElements<D>& add_rings, Ranks& ranks, const Execution& execution) {
    Region<D> region;
    region.vertices = vertices_of<D>(add_rings.rows);
    region.outer = Buffer<std::uint8_t>(region.vertices.size());
    for (std::size_t v = 0; v < region.vertices.size(); ++v)
        region.outer[v] = std::ranges::binary_search(add_rings.inner, region.vertices[v]) ? 0 : 1;
    Buffer<SimplexVertices<D>> simplices;
    Buffer<Reference> references;
    for (const auto& row : add_rings.rows) {
        SimplexVertices<D> simplex;
        for (int i = 0; i <= D; ++i)
            simplex[i] = VertexId(std::ranges::lower_bound(region.vertices, row.vertices[i]) - region.vertices.begin());
        simplices.push_back(simplex);
        references.push_back(row.reference);
        region.elements.push_back(row.row);
    }
    region.mesh.linear.elements = {std::move(simplices), std::move(references), {}};
    if (auto taken = take_vertices(parts, states, region, ranks); !taken) return fail(taken.error());
    auto elevated = elevate(std::move(region.mesh.linear), without_progress(execution));
    if (!elevated) return fail(elevated.error());
    region.mesh = std::move(*elevated);
    const auto have = [&](MovedNodes<D> PartState<D>::* rows_of) {
        std::vector<char> any{static_cast<char>(
            std::ranges::any_of(states, [&](const PartState<D>& s) { return (s.*rows_of).is_known(); }) ? 1 : 0)};
        return gather_all(ranks, Outcome<std::vector<char>>(std::move(any)));
    };
    const auto extended = have(&PartState<D>::extended), bent = have(&PartState<D>::back_nodes);
    if (!extended || !bent) return fail(extended ? bent.error() : extended.error());
    const auto any = [](const std::vector<char>& all) { return std::ranges::find(all, 1) != all.end(); };
    if (auto taken = take_edges(parts, states, any(*extended), any(*bent), region, ranks); !taken)
        return fail(taken.error());
    return region;
}

template <int D>
Outcome<Region<D>> place_of(const Region<D>& all, const std::vector<ElementId>& elements, const Execution& execution) {
    Region<D> place;
    std::vector<VertexId> vertices;
    for (const ElementId e : elements) {
        const auto& simplex = all.mesh.linear.elements.vertices[e];
        vertices.insert(vertices.end(), simplex.begin(), simplex.end());
    }
    std::ranges::sort(vertices);
    vertices.erase(std::ranges::unique(vertices).begin(), vertices.end());
    Buffer<Vec<D>> points;
    Buffer<Reference> point_references, references;
    for (const VertexId v : vertices) {
        place.vertices.push_back(all.vertices[v.index()]);
        place.outer.push_back(all.outer[v.index()]);
        place.log_metrics.push_back(all.log_metrics[v.index()]);
        points.push_back(all.mesh.linear.points[v]);
        point_references.push_back(all.mesh.linear.point_references[v]);
    }
    Buffer<SimplexVertices<D>> simplices;
    for (const ElementId e : elements) {
        SimplexVertices<D> simplex = all.mesh.linear.elements.vertices[e];
        for (VertexId& v : simplex) v = VertexId(std::ranges::lower_bound(vertices, v) - vertices.begin());
        simplices.push_back(simplex);
        references.push_back(all.mesh.linear.elements.references[e]);
        place.elements.push_back(all.elements[e.index()]);
    }
    LinearMesh<D> linear;
    linear.points = std::move(points);
    linear.point_references = std::move(point_references);
    linear.elements = {std::move(simplices), std::move(references), {}};
    auto elevated = elevate(std::move(linear), without_progress(execution));
    if (!elevated) return fail(elevated.error());
    place.mesh = std::move(*elevated);
    Buffer<LagrangeNode<D>> nodes;
    Buffer<EdgeKind> kinds;
    for (const auto& [a, b] : place.mesh.edges.vertices) {
        const EdgeId e = find_edge(all.mesh.edges, vertices[a.index()], vertices[b.index()]);
        nodes.push_back(all.mesh.mid_nodes[e]);
        kinds.push_back(all.kinds[e]);
        if (!all.extended.empty()) place.extended.push_back(all.extended[e.index()]);
        if (!all.back_nodes.empty()) place.back_nodes.push_back(all.back_nodes[e.index()]);
    }
    place.mesh.mid_nodes = std::move(nodes);
    place.kinds = std::move(kinds);
    return place;
}

template <int D>
Outcome<std::vector<Region<D>>> places_of(const Region<D>& all, const Execution& execution) {
    DisjointSets sets(all.vertices.size());
    const auto& simplices = all.mesh.linear.elements.vertices;
    for (const auto& simplex : simplices)
        for (const VertexId v : simplex) sets.unite(simplex[0].index(), v.index());
    std::map<std::size_t, std::vector<ElementId>> elements;  // elements of each place, by its lowest vertex
    for (std::size_t e = 0; e < simplices.size(); ++e)
        elements[sets.lowest(simplices[e][0].index())].push_back(ElementId(e));
    std::vector<Region<D>> places;
    for (const auto& [lowest, of_place] : elements) {
        auto place = place_of(all, of_place, execution);
        if (!place) return fail(place.error());
        places.push_back(std::move(*place));
    }
    return places;
}

}  // namespace

template <int D>
Outcome<std::vector<Region<D>>> regions_around(const RingedParts<D>& parts, const std::vector<PartState<D>>& states,
                                               const std::vector<GlobalNumber>& elements, int rings, Ranks& ranks,
                                               const Execution& execution) {
    std::vector<Incidence<ElementId>> around;
    for (const PartState<D>& state : states) {
        auto of = balls(state.mesh.linear, without_progress(execution));
        if (!of) return fail(of.error());
        around.push_back(std::move(*of));
    }
    const auto add_rings = grown_places<D>(parts, around, elements, rings, ranks);
    if (!add_rings) return fail(add_rings.error());
    const auto all = region_of(parts, states, *add_rings, ranks, execution);
    if (!all) return fail(all.error());
    return places_of(*all, execution);
}

#define CAMBER_INSTANTIATE(D)                                                                                   \
    template Outcome<std::vector<Region<D>>> regions_around<D>(                                                 \
        const RingedParts<D>&, const std::vector<PartState<D>>&, const std::vector<GlobalNumber>&, int, Ranks&, \
        const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
