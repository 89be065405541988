module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.io;
import :dual_graph_rows;
import :finished_rows;
import :partition_rows;
import :parts_of_runs;
import :routing;
import :rows;
import :runs_of_rank;
import :shared_rows;

namespace camber {

namespace {

/// A simplex of a file, on its way to the rank whose run it is in.
template <int K>
struct FileRow {
    std::array<std::uint64_t, K + 1> nodes{};
    Reference reference = 0;
};

template <int K>
FileRow<K> file_row(const SimplexRun<K, 1>& run, std::size_t i) {
    return {run.nodes[i], run.references[i]};
}

template <int K>
SimplexRows<K> simplices_of(const std::vector<FileRow<K>>& rows) {
    SimplexRows<K> made;
    for (const FileRow<K>& row : rows) {
        SimplexVertices<K> vertices;
        for (std::size_t v = 0; v < vertices.size(); ++v) vertices[v] = VertexId(std::size_t{row.nodes[v]});
        made.vertices.push_back(vertices);
        made.references.push_back(row.reference);
    }
    return made;
}

/// Runs that follow each other over the ranks, cut anew so that each rank has as many.
template <int K>
Outcome<SimplexRows<K>> evened(const SimplexRun<K, 1>& run, std::size_t total, Ranks& ranks) {
    std::vector<std::vector<FileRow<K>>> to(ranks.size());
    for (std::size_t i = 0; i < run.nodes.size(); ++i)
        to[rank_of_row(run.first + i, total, ranks.size())].push_back(file_row<K>(run, i));
    // What lower ranks had comes before.
    const auto own = exchanged_values<FileRow<K>>(ranks, std::move(to));
    if (!own) return fail(own.error());
    return simplices_of<K>(*own);
}

template <int D>
Outcome<RunsOfRank<D>> runs_of(const FinishedRows<D>& rows, Ranks& ranks) {
    RunsOfRank<D> runs;
    runs.counts = {rows.totals.vertices, rows.totals.elements, rows.totals.facets, rows.totals.edges};
    auto elements = evened<D>(rows.part.elements, rows.totals.elements, ranks);
    if (!elements) return fail(elements.error());
    auto facets = evened<D - 1>(rows.part.facets, rows.totals.facets, ranks);
    if (!facets) return fail(facets.error());
    std::vector<FileRow<1>> own;
    own.reserve(rows.part.edges.nodes.size());
    for (std::size_t i = 0; i < rows.part.edges.nodes.size(); ++i) own.push_back(file_row<1>(rows.part.edges, i));
    const auto edges = gather_all(ranks, Outcome<std::vector<FileRow<1>>>(std::move(own)));
    if (!edges) return fail(edges.error());
    runs.elements = std::move(*elements);
    runs.facets = std::move(*facets);
    runs.edges = simplices_of<1>(*edges);
    runs.lists = rows.lists;
    return runs;
}

/// The vertices of these numbers, from the ranks that have them.
template <int D>
Outcome<PointRows<D>> points_of(const PointRun<D>& own, const std::vector<std::size_t>& firsts,
                                const std::vector<std::uint64_t>& vertices, Ranks& ranks) {
    std::vector<std::vector<std::uint64_t>> questions(ranks.size());
    for (const std::uint64_t v : vertices) questions[rank_with(firsts, v)].push_back(v);
    const auto asked = exchanged_lists(ranks, std::move(questions));
    if (!asked) return fail(asked.error());
    std::vector<std::vector<PointRow<D>>> answers(ranks.size());
    for (std::size_t r = 0; r < ranks.size(); ++r)
        for (const std::uint64_t v : (*asked)[r])
            answers[r].push_back({own.points[v - own.first], own.references[v - own.first]});
    // They rise, and so do the ranks that have them.
    const auto all = exchanged_values<PointRow<D>>(ranks, std::move(answers));
    if (!all) return fail(all.error());
    return point_rows(*all);
}

}  // namespace

template <int D>
Outcome<PartsOfRank<LinearMesh<D>>> parts_of_finished(FinishedRows<D> rows, std::size_t parts,
                                                      const GraphPartitioner& partition, Ranks& ranks) {
    return guarded([&]() -> Outcome<PartsOfRank<LinearMesh<D>>> {
        auto firsts = gather_all(ranks, Outcome<std::vector<std::size_t>>({rows.part.vertices.first}));
        if (!firsts) return fail(firsts.error());
        firsts->push_back(rows.totals.vertices);
        const auto runs = runs_of(rows, ranks);
        if (!runs) return fail(runs.error());
        rows.part.elements = {}, rows.part.facets = {}, rows.part.edges = {};
        const auto points_at = [&](const std::vector<std::uint64_t>& vertices) {
            return points_of<D>(rows.part.vertices, *firsts, vertices, ranks);
        };
        return parts_of_runs<D>(runs, points_at, parts, partition, ranks);
    });
}

#define CAMBER_INSTANTIATE(D)                                                                       \
    template Outcome<PartsOfRank<LinearMesh<D>>> parts_of_finished<D>(FinishedRows<D>, std::size_t, \
                                                                      const GraphPartitioner&, Ranks&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
