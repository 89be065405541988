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
import :dual_graph_rows;
import :routing;
import :row_runs;
import :runs_of_rank;

namespace camber {

namespace {

/// An element's face, its vertices rising.
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

/// The faces of all elements whose lowest vertex is of this rank's run, in order.
template <int D>
Outcome<std::vector<FaceRow<D>>> faces_here(std::span<const SimplexVertices<D>> elements, std::size_t first,
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

/// Both ways between the elements of each inner face, to the ranks that have them.
template <int D>
Outcome<std::vector<std::vector<Arc>>> arcs_of(const std::vector<FaceRow<D>>& faces, std::size_t elements,
                                               std::size_t ranks) {
    std::vector<std::vector<Arc>> to(ranks);
    for (std::size_t i = 0; i + 1 < faces.size(); ++i) {
        if (faces[i].vertices != faces[i + 1].vertices) continue;
        if (i + 2 < faces.size() && faces[i + 2].vertices == faces[i].vertices)
            return fail(ErrorKind::input, "shares a face with two others", {},
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
    const auto faces = faces_here<D>(elements, first, runs.counts.points, ranks);
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

}  // namespace camber
