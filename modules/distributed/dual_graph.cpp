// Builds the dual graph by rows, and the parts of a rank from the result of a partitioner.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;

namespace camber {

namespace {

template <int D>
struct FaceRow {
    SimplexVertices<D - 1> vertices{};
    std::uint32_t padding = 0;
    std::uint64_t element = 0;
};
struct Arc {
    std::uint64_t from = 0, to = 0;
    friend auto operator<=>(const Arc&, const Arc&) = default;
};

template <int K>
SimplexVertices<K> rising(SimplexVertices<K> vertices) {
    std::ranges::sort(vertices);
    return vertices;
}

template <int D>
Outcome<std::vector<FaceRow<D>>> faces_on_rank(std::span<const SimplexVertices<D>> elements, std::size_t first,
                                               std::size_t vertices, Ranks& ranks) {
    std::vector<std::vector<FaceRow<D>>> to(ranks.size());
    for (std::size_t e = 0; e < elements.size(); ++e)
        for (int opposite = 0; opposite <= D; ++opposite) {
            FaceRow<D> face{{}, 0, first + e};
            const auto local = face_opposite<D>(opposite);
            for (int i = 0; i < D; ++i) face.vertices[i] = elements[e][local[i]];
            face.vertices = rising<D - 1>(face.vertices);
            to[rank_of_row(face.vertices[0].index(), vertices, ranks.size())].push_back(face);
        }
    auto faces = exchanged_values<FaceRow<D>>(ranks, std::move(to));
    if (!faces) return faces;
    std::ranges::sort(*faces, {}, [](const FaceRow<D>& f) { return std::pair(f.vertices, f.element); });
    return faces;
}

template <int D>
Outcome<std::vector<std::vector<Arc>>> arcs_of(const std::vector<FaceRow<D>>& faces, std::size_t elements,
                                               std::size_t ranks) {
    std::vector<std::vector<Arc>> to(ranks);
    for (std::size_t i = 0; i + 1 < faces.size(); ++i) {
        if (faces[i].vertices != faces[i + 1].vertices) continue;
        if (i + 2 < faces.size() && faces[i + 2].vertices == faces[i].vertices)
            return fail(ErrorKind::input, "shares a face with two other elements", {},
                        Entity{simplex_name<D>, faces[i].element + 1});
        const std::uint64_t a = faces[i].element, b = faces[i + 1].element;
        to[rank_of_row(a, elements, ranks)].push_back({a, b});
        to[rank_of_row(b, elements, ranks)].push_back({b, a});
    }
    return to;
}

template <int D>
std::vector<std::vector<FacetRow<D>>> own_facets(const RunsOfRank<D>& runs, const Ranks& ranks) {
    const Run own = part_of({0, runs.counts.facets}, ranks.rank(), ranks.size());
    std::vector<std::vector<FacetRow<D>>> to(ranks.size());
    for (std::size_t f = 0; f < own.size(); ++f) {
        const auto& vertices = runs.facets.vertices[f];
        const std::size_t lowest = std::ranges::min(vertices).index();
        to[rank_of_row(lowest, runs.counts.points, ranks.size())].push_back(
            {own.begin + f, vertices, runs.facets.references[f], 0, no_element});
    }
    return to;
}

GraphRun graph_of(std::vector<Arc> arcs, std::size_t first, std::size_t rows) {
    std::ranges::sort(arcs);
    GraphRun graph;
    std::size_t at = 0;
    for (std::size_t e = first; e < first + rows; ++e) {
        for (; at < arcs.size() && arcs[at].from == e; ++at) graph.neighbours.push_back(arcs[at].to);
        graph.starts.push_back(graph.neighbours.size());
    }
    return graph;
}

}  // namespace

template <int D>
Outcome<DualRows<D>> dual_rows(const RunsOfRank<D>& runs, std::size_t first, Ranks& ranks) {
    const auto& elements = runs.elements.vertices;
    const auto faces = faces_on_rank<D>(elements, first, runs.counts.points, ranks);
    if (!faces) return fail(faces.error());
    auto arcs = exchanged_values(ranks, arcs_of<D>(*faces, runs.counts.elements, ranks.size()));
    if (!arcs) return fail(arcs.error());
    auto facets = exchanged_values<FacetRow<D>>(ranks, own_facets(runs, ranks));
    if (!facets) return fail(facets.error());
    for (FacetRow<D>& facet : *facets) {
        const auto vertices = rising<D - 1>(facet.vertices);
        const auto face = std::ranges::lower_bound(*faces, vertices, {}, &FaceRow<D>::vertices);
        if (face != faces->end() && face->vertices == vertices) facet.element = face->element;
    }
    return DualRows<D>{graph_of(std::move(*arcs), first, elements.size()), std::move(*facets)};
}

template Outcome<DualRows<2>> dual_rows<2>(const RunsOfRank<2>&, std::size_t, Ranks&);
template Outcome<DualRows<3>> dual_rows<3>(const RunsOfRank<3>&, std::size_t, Ranks&);

namespace {

template <int K>
struct RowOfPart {
    std::uint64_t row = 0;
    SimplexVertices<K> vertices{};
    Reference reference = 0;
    std::int32_t part = 0;
};

template <int K>
Outcome<std::vector<RowOfPart<K>>> to_parts(Ranks& ranks, std::size_t parts, const std::vector<RowOfPart<K>>& rows) {
    std::vector<std::vector<RowOfPart<K>>> to(ranks.size());
    for (const auto& row : rows)
        to[rank_of_row(static_cast<std::uint64_t>(row.part), parts, ranks.size())].push_back(row);
    auto own = exchanged_values<RowOfPart<K>>(ranks, std::move(to));
    if (!own) return own;
    std::ranges::sort(*own, {}, &RowOfPart<K>::row);
    return own;
}

template <int D>
Outcome<std::vector<RowOfPart<D - 1>>> facets_with_parts(const std::vector<FacetRow<D>>& facets,
                                                         const Buffer<std::int32_t>& part_of_own, Run own,
                                                         std::size_t elements, Ranks& ranks) {
    std::vector<std::vector<std::uint64_t>> questions(ranks.size());
    for (const FacetRow<D>& facet : facets)
        if (facet.element != no_element)
            questions[rank_of_row(facet.element, elements, ranks.size())].push_back(facet.element);
    const auto requests = exchanged_lists(ranks, std::move(questions));
    if (!requests) return fail(requests.error());
    std::vector<std::vector<std::int32_t>> answers(ranks.size());
    for (std::size_t r = 0; r < ranks.size(); ++r)
        for (const std::uint64_t e : (*requests)[r]) answers[r].push_back(part_of_own[e - own.begin]);
    const auto parts = exchanged_lists(ranks, std::move(answers));
    if (!parts) return fail(parts.error());
    std::vector<std::size_t> next(ranks.size(), 0);
    std::vector<RowOfPart<D - 1>> rows;
    for (const FacetRow<D>& facet : facets) {
        RowOfPart<D - 1> row{facet.row, facet.vertices, facet.reference, 0};
        if (facet.element != no_element) {
            const std::size_t r = rank_of_row(facet.element, elements, ranks.size());
            row.part = (*parts)[r][next[r]++];
        }
        rows.push_back(row);
    }
    return rows;
}

/// Returns, on rank 0, the feature edges with the parts of their lowest elements. All ranks have all feature edges,
/// because they are few.
template <int D>
Outcome<std::vector<RowOfPart<1>>> edges_with_parts(const RunsOfRank<D>& runs, Run own,
                                                    const Buffer<std::int32_t>& part_of_own, Ranks& ranks) {
    struct Lowest {
        std::uint64_t element = no_element;
        std::int64_t part = 0;
    };
    const RowCounts& counts = runs.counts;
    const SimplexRows<1>& edge_rows = runs.edges;
    const auto& elements = runs.elements.vertices;
    std::vector<Lowest> lowest(counts.edges);
    if (counts.edges > 0) {
        using Ends = std::pair<VertexId, VertexId>;
        std::vector<std::pair<Ends, std::size_t>> by_ends;
        std::vector<bool> has_edge(counts.points, false);
        for (std::size_t i = 0; i < counts.edges; ++i) {
            const auto [a, b] = edge_rows.vertices[i];
            by_ends.push_back({std::minmax(a, b), i});
            has_edge[a.index()] = has_edge[b.index()] = true;
        }
        std::ranges::sort(by_ends);
        for (std::size_t e = 0; e < elements.size(); ++e)
            for (const auto& [i, j] : local_edges<D>) {
                const VertexId a = elements[e][i], b = elements[e][j];
                if (!has_edge[a.index()] || !has_edge[b.index()]) continue;
                const auto same = std::ranges::equal_range(by_ends, Ends(std::minmax(a, b)), {},
                                                           [](const auto& edge) { return edge.first; });
                for (const auto& [ends, row] : same)
                    if (lowest[row].element == no_element) lowest[row] = {own.begin + e, part_of_own[e]};
            }
    }
    const auto all = gather_all(ranks, Outcome<std::vector<Lowest>>(std::move(lowest)));
    if (!all) return fail(all.error());
    std::vector<RowOfPart<1>> out;
    if (ranks.rank() > 0) return out;
    for (std::size_t i = 0; i < counts.edges; ++i) {
        Lowest least;
        for (std::size_t r = 0; r < ranks.size(); ++r)
            if (const Lowest& of_rank = (*all)[r * counts.edges + i]; of_rank.element < least.element) least = of_rank;
        out.push_back({i, edge_rows.vertices[i], edge_rows.references[i], static_cast<std::int32_t>(least.part)});
    }
    return out;
}

std::size_t place_of(const std::vector<std::uint64_t>& numbers, std::uint64_t number) {
    const auto at = std::ranges::lower_bound(numbers, number);
    return at != numbers.end() && *at == number ? static_cast<std::size_t>(at - numbers.begin()) : numbers.size();
}
Column<std::uint32_t> chosen(const Column<std::uint32_t>& list, const std::vector<std::uint64_t>& numbers) {
    Buffer<std::uint32_t> some;
    for (const std::uint32_t row : list)
        if (const std::size_t at = place_of(numbers, row); at < numbers.size())
            some.push_back(static_cast<std::uint32_t>(at));
    return some;
}
Column<VertexId> chosen(const Column<VertexId>& list, const std::vector<std::uint64_t>& numbers) {
    Buffer<VertexId> some;
    for (const VertexId v : list)
        if (const std::size_t at = place_of(numbers, v.index()); at < numbers.size()) some.push_back(VertexId(at));
    return some;
}

template <int K>
Simplices<K> simplices_of(const std::vector<RowOfPart<K>>& rows, const std::vector<std::uint64_t>& vertices,
                          std::vector<std::uint64_t>& numbers, Buffer<std::int32_t>& parts) {
    Buffer<SimplexVertices<K>> simplices;
    Buffer<Reference> references;
    for (const auto& row : rows) {
        auto& simplex = simplices.emplace_back(row.vertices);
        for (VertexId& v : simplex) v = VertexId(place_of(vertices, v.index()));
        references.push_back(row.reference);
        numbers.push_back(row.row);
        parts.push_back(row.part);
    }
    return {std::move(simplices), std::move(references), {}};
}

template <int K>
void add_vertices(const std::vector<RowOfPart<K>>& rows, std::vector<std::uint64_t>& vertices) {
    for (const auto& row : rows)
        for (const VertexId v : row.vertices) vertices.push_back(v.index());
}

template <int D>
PartsOfRank<LinearMesh<D>> assembled(const LinearMesh<D>& lists, PartsOfRank<LinearMesh<D>> own, PointRows<D> points,
                                     const std::vector<RowOfPart<D>>& elements,
                                     const std::vector<RowOfPart<D - 1>>& facets,
                                     const std::vector<RowOfPart<1>>& edges) {
    LinearMesh<D>& mesh = own.mesh;
    mesh.points = std::move(points.points);
    mesh.point_references = std::move(points.references);
    mesh.elements = simplices_of(elements, own.vertices, own.elements, own.part_of_element);
    mesh.facets = simplices_of(facets, own.vertices, own.facets, own.part_of_facet);
    mesh.edges = simplices_of(edges, own.vertices, own.edges, own.part_of_edge);
    mesh.corners = chosen(lists.corners, own.vertices);
    mesh.required_vertices = chosen(lists.required_vertices, own.vertices);
    mesh.elements.required = chosen(lists.elements.required, own.elements);
    mesh.facets.required = chosen(lists.facets.required, own.facets);
    mesh.edges.required = chosen(lists.edges.required, own.edges);
    mesh.ridges = chosen(lists.ridges, D == 3 ? own.edges : own.facets);
    mesh.groups = lists.groups;
    return own;
}

template <int D>
std::vector<RowOfPart<D>> elements_with_parts(const SimplexRows<D>& elements, Run own,
                                              const Buffer<std::int32_t>& part_of_own) {
    std::vector<RowOfPart<D>> rows;
    rows.reserve(own.size());
    for (std::size_t e = 0; e < own.size(); ++e)
        rows.push_back({own.begin + e, elements.vertices[e], elements.references[e], part_of_own[e]});
    return rows;
}

template <int D>
Outcome<PartsOfRank<LinearMesh<D>>> parts_among_ranks(const RunsOfRank<D>& runs, const PointsAt<D>& points_at,
                                                      std::size_t parts, const GraphPartitioner& partition,
                                                      Ranks& ranks) {
    const Run own = part_of({0, runs.counts.elements}, ranks.rank(), ranks.size());
    auto dual = dual_rows<D>(runs, own.begin, ranks);
    if (!dual) return fail(dual.error());
    const auto part_of_own = partition(ranks, dual->graph, parts);
    if (!part_of_own) return fail(part_of_own.error());
    dual->graph = {};
    const auto facets = facets_with_parts<D>(dual->facets, *part_of_own, own, runs.counts.elements, ranks);
    if (!facets) return fail(facets.error());
    const auto edges = edges_with_parts<D>(runs, own, *part_of_own, ranks);
    if (!edges) return fail(edges.error());
    const auto own_elements = to_parts<D>(ranks, parts, elements_with_parts<D>(runs.elements, own, *part_of_own));
    if (!own_elements) return fail(own_elements.error());
    const auto own_facets = to_parts<D - 1>(ranks, parts, *facets);
    if (!own_facets) return fail(own_facets.error());
    const auto own_edges = to_parts<1>(ranks, parts, *edges);
    if (!own_edges) return fail(own_edges.error());
    PartsOfRank<LinearMesh<D>> result;
    add_vertices(*own_elements, result.vertices);
    add_vertices(*own_facets, result.vertices);
    add_vertices(*own_edges, result.vertices);
    std::ranges::sort(result.vertices);
    result.vertices.erase(std::ranges::unique(result.vertices).begin(), result.vertices.end());
    result.first = parts * ranks.rank() / ranks.size();
    result.last = parts * (ranks.rank() + 1) / ranks.size();
    auto points = agreed(ranks, points_at(result.vertices));
    if (!points) return fail(points.error());
    return assembled<D>(runs.lists, std::move(result), std::move(*points), *own_elements, *own_facets, *own_edges);
}

}  // namespace

template <int D>
Outcome<RunsOfRank<D>> runs_of(const MeshRows<D>& rows, const Ranks& ranks) {
    const RowCounts counts = rows.counts();
    const auto own = [&](std::size_t n) { return part_of({0, n}, ranks.rank(), ranks.size()); };
    const Run of_elements = own(counts.elements), of_facets = own(counts.facets);
    auto elements = rows.elements(of_elements.begin, of_elements.end);
    if (!elements) return fail(elements.error());
    auto facets = rows.facets(of_facets.begin, of_facets.end);
    if (!facets) return fail(facets.error());
    auto edges = rows.edges(0, counts.edges);
    if (!edges) return fail(edges.error());
    auto lists = rows.lists();
    if (!lists) return fail(lists.error());
    return RunsOfRank<D>{counts, std::move(*elements), std::move(*facets), std::move(*edges), std::move(*lists)};
}

template <int D>
Outcome<PartsOfRank<LinearMesh<D>>> parts_of_runs(const Outcome<RunsOfRank<D>>& runs, const PointsAt<D>& points_at,
                                                  std::size_t parts, const GraphPartitioner& partition, Ranks& ranks) {
    return guarded([&]() -> Outcome<PartsOfRank<LinearMesh<D>>> {
        if (auto all = agreed(ranks, runs ? Outcome<Done>(Done{}) : fail(runs.error())); !all) return fail(all.error());
        if (parts == 0 || parts > runs->counts.elements)
            return fail(ErrorKind::usage, "the mesh cannot be divided into this number of parts", {}, {},
                        "request at least 1 part, and at most one per element");
        return parts_among_ranks(*runs, points_at, parts, partition, ranks);
    });
}

template <int D>
Outcome<PartsOfRank<LinearMesh<D>>> parts_of_rows(const MeshRows<D>& rows, std::size_t parts,
                                                  const GraphPartitioner& partition, Ranks& ranks) {
    const auto points_at = [&](const std::vector<std::uint64_t>& vertices) -> Outcome<PointRows<D>> {
        PointRows<D> points{Buffer<Vec<D>>(vertices.size()), Buffer<Reference>(vertices.size())};
        const auto read = [&](std::size_t begin, std::size_t end) { return rows.points(begin, end); };
        const auto done = read_some(vertices, read, [&](std::size_t i, const PointRows<D>& some, std::size_t at) {
            points.points[i] = some.points[at];
            points.references[i] = some.references[at];
        });
        if (!done) return fail(done.error());
        return points;
    };
    return parts_of_runs<D>(runs_of(rows, ranks), points_at, parts, partition, ranks);
}

#define CAMBER_INSTANTIATE(D)                                                                                        \
    template Outcome<RunsOfRank<D>> runs_of<D>(const MeshRows<D>&, const Ranks&);                                    \
    template Outcome<PartsOfRank<LinearMesh<D>>> parts_of_runs<D>(const Outcome<RunsOfRank<D>>&, const PointsAt<D>&, \
                                                                  std::size_t, const GraphPartitioner&, Ranks&);     \
    template Outcome<PartsOfRank<LinearMesh<D>>> parts_of_rows<D>(const MeshRows<D>&, std::size_t,                   \
                                                                  const GraphPartitioner&, Ranks&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
