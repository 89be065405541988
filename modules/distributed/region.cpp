module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.bezier;
import camber.metric;
import :grown_places;
import :moved_nodes;
import :part_state;
import :ringed_parts;
import :ranks;
import :region;
import :routing;
import :simplex_row;

namespace camber {

namespace {

/// A vertex and an edge of a part, as their owner has them.
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
    const auto data = ask<VertexData<D>>(ranks, parts.layout, questions, [&](std::size_t b, GlobalNumber number) {
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
    const auto data = ask<EdgeData<D>>(ranks, parts.layout, questions, [&](std::size_t b, const Ends& ends) {
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

/// What a rank has grown, with what the parts know of it.
template <int D>
Outcome<Region<D>> region_of(const RingedParts<D>& parts, const std::vector<PartState<D>>& states,
                             const GrownPlaces<D>& grown, Ranks& ranks, const Execution& execution) {
    Region<D> region;
    region.vertices = vertices_of<D>(grown.rows);
    region.outer = Buffer<std::uint8_t>(region.vertices.size());
    for (std::size_t v = 0; v < region.vertices.size(); ++v)
        region.outer[v] = std::ranges::binary_search(grown.inner, region.vertices[v]) ? 0 : 1;
    Buffer<SimplexVertices<D>> simplices;
    Buffer<Reference> references;
    for (const auto& row : grown.rows) {
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

/// One of the places of a region: its elements, rising, are all that hang together.
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
    std::map<std::size_t, std::vector<ElementId>> elements;  // by the lowest vertex
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
    const auto grown = grown_places<D>(parts, around, elements, rings, ranks);
    if (!grown) return fail(grown.error());
    const auto all = region_of(parts, states, *grown, ranks, execution);
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
