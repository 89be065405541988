module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.bezier;
import camber.metric;
import :moved_nodes;
import :part_state;
import :ringed_parts;
import :ranks;
import :region;
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

/// The given elements, from the parts that own them, on all ranks: they are few, and the lowest says who repairs.
template <int D>
Outcome<std::vector<SimplexRow<D>>> seeds_of(const RingedParts<D>& parts, const std::vector<GlobalNumber>& elements,
                                             Ranks& ranks) {
    std::vector<SimplexRow<D>> own;
    for (const RingedPart<D>& part : parts.own)
        for (std::size_t e = 0; e < part.elements.size(); ++e)
            if (part.owns(part.mesh.elements.vertices[e]) && std::ranges::binary_search(elements, part.elements[e]))
                own.push_back(row_of(part, ElementId(e)));
    auto all = gather_all(ranks, Outcome<std::vector<SimplexRow<D>>>(std::move(own)));
    if (all) std::ranges::sort(*all, {}, &SimplexRow<D>::row);
    return all;
}

/// What is around these vertices, of all parts, on the rank that asks: `mine` is empty on all others.
template <int D>
Outcome<std::vector<SimplexRow<D>>> around_vertices(const RingedParts<D>& parts,
                                                    std::span<const Incidence<ElementId>> balls,
                                                    const std::vector<GlobalNumber>& mine, std::size_t owner,
                                                    Ranks& ranks) {
    std::vector<std::vector<GlobalNumber>> of_ranks(ranks.size());
    for (const GlobalNumber v : mine) of_ranks[parts.layout.rank_of(parts.layout.part_with(v))].push_back(v);
    std::vector<Bytes> to;
    to.reserve(of_ranks.size());
    for (const auto& some : of_ranks) to.push_back(bytes_of<GlobalNumber>(some));
    const auto asked = ranks.exchange(std::move(to));
    if (!asked) return fail(asked.error());
    std::vector<GlobalNumber> vertices;
    append_values((*asked)[owner], vertices);
    std::vector<SimplexRow<D>> rows;
    for (const GlobalNumber v : vertices) {
        const std::size_t b = parts.layout.part_with(v) - parts.layout.begin_of(ranks.rank());
        const RingedPart<D>& part = parts.own[b];
        const VertexId local(std::ranges::lower_bound(part.vertices, v) - part.vertices.begin());
        for (const ElementId e : balls[b][local]) rows.push_back(row_of(part, e));
    }
    std::vector<Bytes> back(ranks.size());
    back[owner] = bytes_of<SimplexRow<D>>(rows);
    const auto answers = ranks.exchange(std::move(back));
    if (!answers) return fail(answers.error());
    std::vector<SimplexRow<D>> all;
    for (const Bytes& bytes : *answers) append_values(bytes, all);
    return all;
}

template <int D>
void sort_rows(std::vector<SimplexRow<D>>& rows) {
    std::ranges::sort(rows, {}, &SimplexRow<D>::row);
    const auto again = std::ranges::unique(rows, {}, &SimplexRow<D>::row);
    rows.erase(again.begin(), again.end());
}

template <int D>
std::vector<GlobalNumber> vertices_of(std::span<const SimplexRow<D>> rows) {
    std::vector<GlobalNumber> vertices;
    for (const auto& row : rows) vertices.insert(vertices.end(), row.vertices.begin(), row.vertices.end());
    std::ranges::sort(vertices);
    vertices.erase(std::ranges::unique(vertices).begin(), vertices.end());
    return vertices;
}

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

}  // namespace

template <int D>
Outcome<Region<D>> region_around(const RingedParts<D>& parts, const std::vector<PartState<D>>& states,
                                 const std::vector<GlobalNumber>& elements, int rings, Ranks& ranks,
                                 const Execution& execution) {
    auto rows = seeds_of(parts, elements, ranks);
    if (!rows) return fail(rows.error());
    if (rows->empty()) return Region<D>{};
    const std::size_t owner = parts.layout.rank_of(parts.layout.part_with(std::ranges::min(rows->front().vertices)));
    const bool is_here = owner == ranks.rank();
    if (!is_here) rows->clear();
    std::vector<Incidence<ElementId>> around;
    for (const PartState<D>& state : states) {
        auto of = balls(state.mesh.linear, without_progress(execution));
        if (!of) return fail(of.error());
        around.push_back(std::move(*of));
    }
    std::vector<GlobalNumber> asked;
    for (int ring = 0; ring < rings; ++ring) {
        const auto all = vertices_of<D>(*rows);
        std::vector<GlobalNumber> front;
        std::ranges::set_difference(all, asked, std::back_inserter(front));
        const auto more = around_vertices<D>(parts, around, front, owner, ranks);
        if (!more) return fail(more.error());
        rows->insert(rows->end(), more->begin(), more->end());
        sort_rows(*rows);
        asked = all;
    }
    Region<D> region;
    region.vertices = vertices_of<D>(*rows);
    region.outer = Buffer<std::uint8_t>(region.vertices.size());
    for (std::size_t v = 0; v < region.vertices.size(); ++v)
        region.outer[v] = std::ranges::binary_search(asked, region.vertices[v]) ? 0 : 1;
    Buffer<SimplexVertices<D>> simplices;
    Buffer<Reference> references;
    for (const auto& row : *rows) {
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

#define CAMBER_INSTANTIATE(D)                                                                             \
    template Outcome<Region<D>> region_around<D>(const RingedParts<D>&, const std::vector<PartState<D>>&, \
                                                 const std::vector<GlobalNumber>&, int, Ranks&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
