// Makes parts for solvers from quadratic rows, curved blocks and remeshed meshes.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.io;

namespace camber {

namespace {

constexpr std::uint64_t no_node = std::numeric_limits<std::uint64_t>::max();

template <int D>
class NodesOfEdges {
  public:
    NodesOfEdges(const QuadraticRows<D>& rows, const PartsOfRank<LinearMesh<D>>& of, const EdgeSet<D>& edges)
        : rows_(rows), of_(of), edges_(edges), nodes_(edges.size(), no_node) {}

    Outcome<std::vector<std::uint64_t>> find() {
        auto done = take<D>(of_.elements, [&](std::size_t e) { return edges_.of_elements[e]; });
        if (done) done = take<D - 1>(of_.facets, [&](std::size_t f) { return edges_.of_facets[f]; });
        if constexpr (D == 3)
            if (done) done = take<1>(of_.edges, [&](std::size_t e) { return std::array{edges_.of_edges[e]}; });
        if (!done) return fail(done.error());
        auto sorted = nodes_;
        std::ranges::sort(sorted);
        if (const auto twice = std::ranges::adjacent_find(sorted); twice != sorted.end())
            return fail(ErrorKind::input, "mid node " + number_of(*twice) + " belongs to two edges", {}, {},
                        "the file is damaged, or was joined from two files");
        return std::move(nodes_);
    }

  private:
    [[nodiscard]] std::string number_of(std::uint64_t node) const {
        return std::to_string(rows_.counts().points + node + 1);
    }
    template <int K>
    Outcome<Done> take(const std::vector<std::uint64_t>& numbers, const auto& edges_of) {
        const auto read = [&](std::size_t begin, std::size_t end) { return rows_.template nodes_of<K>(begin, end); };
        std::uint64_t defective = no_node;
        std::array<std::uint64_t, 2> two{};
        auto done = read_some(numbers, read, [&](std::size_t i, const EdgeNodeRows<K>& some, std::size_t at) {
            for (std::size_t k = 0; k < some[at].size(); ++k) {
                std::uint64_t& node = nodes_[edges_of(i)[k].index()];
                if (node != no_node && node != some[at][k] && defective == no_node)
                    defective = numbers[i], two = {some[at][k], node};
                node = some[at][k];
            }
        });
        if (!done || defective == no_node) return done;
        return fail(ErrorKind::input,
                    "an edge has mid node " + number_of(two[0]) + " here and " + number_of(two[1]) + " elsewhere", {},
                    Entity{simplex_name<K>, defective + 1}, "the file is damaged, or was joined from two files");
    }

    const QuadraticRows<D>& rows_;
    const PartsOfRank<LinearMesh<D>>& of_;
    const EdgeSet<D>& edges_;
    std::vector<std::uint64_t> nodes_;
};

template <int D>
Outcome<Buffer<LagrangeNode<D>>> nodes_at(const QuadraticRows<D>& rows, const std::vector<std::uint64_t>& numbers) {
    auto rising = numbers;
    std::ranges::sort(rising);
    Buffer<LagrangeNode<D>> sorted(numbers.size()), nodes(numbers.size());
    const auto read = [&](std::size_t begin, std::size_t end) { return rows.mid_nodes(begin, end); };
    const auto done = read_some(
        rising, read, [&](std::size_t i, const PointRows<D>& some, std::size_t at) { sorted[i] = {some.points[at]}; });
    if (!done) return fail(done.error());
    for (std::size_t e = 0; e < numbers.size(); ++e)
        nodes[e] = sorted[static_cast<std::size_t>(std::ranges::lower_bound(rising, numbers[e]) - rising.begin())];
    return nodes;
}

template <int D>
PartsOfRank<QuadraticMesh<D>> with_nodes(PartsOfRank<LinearMesh<D>> own, EdgeSet<D> edges,
                                         Buffer<LagrangeNode<D>> nodes, std::vector<std::uint64_t> numbers) {
    return {own.first,
            own.last,
            {std::move(own.mesh), std::move(edges), std::move(nodes)},
            std::move(own.vertices),
            std::move(own.elements),
            std::move(own.facets),
            std::move(own.edges),
            std::move(numbers),
            std::move(own.part_of_element),
            std::move(own.part_of_facet),
            std::move(own.part_of_edge)};
}

template <int D>
Outcome<PartsOfRank<QuadraticMesh<D>>> with_nodes_of(const QuadraticRows<D>& rows, PartsOfRank<LinearMesh<D>> own,
                                                     const Execution& execution) {
    auto edges = unique_edges(own.mesh, execution);
    if (!edges) return fail(edges.error());
    auto numbers = NodesOfEdges<D>(rows, own, *edges).find();
    if (!numbers) return fail(numbers.error());
    auto nodes = nodes_at(rows, *numbers);
    if (!nodes) return fail(nodes.error());
    return with_nodes(std::move(own), std::move(*edges), std::move(*nodes), std::move(*numbers));
}

template <int D>
Outcome<PointRows<D>> points_of(const CurvedBlocks<D>& mesh, const std::vector<std::uint64_t>& vertices, Ranks& ranks) {
    const PartLayout& layout = mesh.parts.layout;
    std::vector<ToPart<std::uint64_t>> questions;
    questions.reserve(vertices.size());
    for (const std::uint64_t v : vertices) questions.push_back({layout.part_with(v), v});
    const auto answers = query<PointRow<D>>(ranks, layout, questions, [&](std::size_t p, std::uint64_t number) {
        const RingedPart<D>& part = mesh.parts.own[p];
        const VertexId v(part.first.index() + (number - part.vertices[part.first]));
        return PointRow<D>{mesh.curved[p].mesh.linear.points[v], part.mesh.point_references[v]};
    });
    if (!answers) return fail(answers.error());
    return point_rows(*answers);
}

template <int D>
struct NumberedNode {
    LagrangeNode<D> node;
    std::uint64_t number = 0;
};
template <int D>
Outcome<std::vector<NumberedNode<D>>> nodes_of(const CurvedBlocks<D>& mesh, const EdgeSet<D>& edges,
                                               const std::vector<std::uint64_t>& vertices, Ranks& ranks) {
    using Ends = std::array<GlobalNumber, 2>;
    const PartLayout& layout = mesh.parts.layout;
    std::vector<ToPart<Ends>> questions;
    questions.reserve(edges.size());
    for (const auto& [a, b] : edges.vertices) {
        const Ends ends{vertices[a.index()], vertices[b.index()]};  // the lower number is first, because local ids have
                                                                    // the same order
        questions.push_back({layout.part_with(ends[0]), ends});
    }
    return query<NumberedNode<D>>(ranks, layout, questions, [&](std::size_t p, const Ends& ends) {
        const RingedPart<D>& part = mesh.parts.own[p];
        const CurvedPart<D>& curved = mesh.curved[p];
        const auto local = [&](GlobalNumber number) {
            return VertexId(std::ranges::lower_bound(part.vertices, number) - part.vertices.begin());
        };
        const EdgeId e = find_edge(curved.mesh.edges, local(ends[0]), local(ends[1]));
        return NumberedNode<D>{curved.mesh.mid_nodes[e], mesh.first_edges[layout.begin_of(ranks.rank()) + p] +
                                                             (e.index() - curved.first_edge.index())};
    });
}

}  // namespace

template <int D>
Outcome<PartsOfRank<QuadraticMesh<D>>> parts_of_quadratic_rows(const QuadraticRows<D>& rows, std::size_t parts,
                                                               const GraphPartitioner& partition, Ranks& ranks,
                                                               const Execution& execution) {
    return guarded([&]() -> Outcome<PartsOfRank<QuadraticMesh<D>>> {
        auto own = parts_of_rows<D>(rows, parts, partition, ranks);
        if (!own) return fail(own.error());
        return agreed(ranks, with_nodes_of(rows, std::move(*own), execution));
    });
}

template <int D>
Outcome<PartsOfRank<QuadraticMesh<D>>> parts_of_blocks(const MeshRows<D>& rows, const CurvedBlocks<D>& mesh,
                                                       std::size_t parts, const GraphPartitioner& partition,
                                                       Ranks& ranks, const Execution& execution) {
    return guarded([&]() -> Outcome<PartsOfRank<QuadraticMesh<D>>> {
        const auto points_at = [&](const std::vector<std::uint64_t>& vertices) {
            return points_of(mesh, vertices, ranks);
        };
        auto own = parts_of_runs<D>(runs_of(rows, ranks), points_at, parts, partition, ranks);
        if (!own) return fail(own.error());
        auto edges = agreed(ranks, unique_edges(own->mesh, execution));
        if (!edges) return fail(edges.error());
        const auto found = nodes_of(mesh, *edges, own->vertices, ranks);
        if (!found) return fail(found.error());
        Buffer<LagrangeNode<D>> nodes;
        std::vector<std::uint64_t> numbers;
        for (const NumberedNode<D>& one : *found) {
            nodes.push_back(one.node);
            numbers.push_back(one.number);
        }
        return with_nodes(std::move(*own), std::move(*edges), std::move(nodes), std::move(numbers));
    });
}

namespace {

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
    SimplexRows<K> result;
    for (const FileRow<K>& row : rows) {
        SimplexVertices<K> vertices;
        for (std::size_t v = 0; v < vertices.size(); ++v) vertices[v] = VertexId(std::size_t{row.nodes[v]});
        result.vertices.push_back(vertices);
        result.references.push_back(row.reference);
    }
    return result;
}

template <int K>
Outcome<SimplexRows<K>> evened(const SimplexRun<K, 1>& run, std::size_t total, Ranks& ranks) {
    std::vector<std::vector<FileRow<K>>> to(ranks.size());
    for (std::size_t i = 0; i < run.nodes.size(); ++i)
        to[rank_of_row(run.first + i, total, ranks.size())].push_back(file_row<K>(run, i));
    // The result is in file order, because rows of lower ranks come first.
    const auto own = exchanged_values<FileRow<K>>(ranks, std::move(to));
    if (!own) return fail(own.error());
    return simplices_of<K>(*own);
}

template <int D>
Outcome<RunsOfRank<D>> runs_of_finished(const FinishedRows<D>& rows, Ranks& ranks) {
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

template <int D>
Outcome<PointRows<D>> points_of_run(const PointRun<D>& own, const std::vector<std::size_t>& firsts,
                                    const std::vector<std::uint64_t>& vertices, Ranks& ranks) {
    std::vector<std::vector<std::uint64_t>> questions(ranks.size());
    for (const std::uint64_t v : vertices) questions[rank_with(firsts, v)].push_back(v);
    const auto requests = exchanged_lists(ranks, std::move(questions));
    if (!requests) return fail(requests.error());
    std::vector<std::vector<PointRow<D>>> answers(ranks.size());
    for (std::size_t r = 0; r < ranks.size(); ++r)
        for (const std::uint64_t v : (*requests)[r])
            answers[r].push_back({own.points[v - own.first], own.references[v - own.first]});
    // The answers are in order, because vertices are ascending and so are their ranks.
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
        const auto runs = runs_of_finished(rows, ranks);
        if (!runs) return fail(runs.error());
        rows.part.elements = {}, rows.part.facets = {}, rows.part.edges = {};
        const auto points_at = [&](const std::vector<std::uint64_t>& vertices) {
            return points_of_run<D>(rows.part.vertices, *firsts, vertices, ranks);
        };
        return parts_of_runs<D>(runs, points_at, parts, partition, ranks);
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                        \
    template Outcome<PartsOfRank<QuadraticMesh<D>>> parts_of_quadratic_rows<D>(                                      \
        const QuadraticRows<D>&, std::size_t, const GraphPartitioner&, Ranks&, const Execution&);                    \
    template Outcome<PartsOfRank<QuadraticMesh<D>>> parts_of_blocks<D>(                                              \
        const MeshRows<D>&, const CurvedBlocks<D>&, std::size_t, const GraphPartitioner&, Ranks&, const Execution&); \
    template Outcome<PartsOfRank<LinearMesh<D>>> parts_of_finished<D>(FinishedRows<D>, std::size_t,                  \
                                                                      const GraphPartitioner&, Ranks&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
