// Remeshing by blocks: the rows of an adapted mesh, and functions that cut, join and output them.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <set>
#include <tuple>
#include <utility>
#include <vector>
export module camber.distributed:adaptation;
import camber.core;
import camber.cavity;
import camber.ordering;
import camber.metric;
import camber.io;
import camber.surface;
import camber.operation;
import camber.adapt;
import :parts;
import :ranks;

export namespace camber {

/// A vertex with its `number` in the whole mesh. The number is invalid for new vertices, and for vertices that only one
/// part has. Frozen vertices always have a number, because simplices outside all parts may share them.
template <int D>
struct AdaptedVertex {
    VertexId number;
    VertexId origin;  ///< number in the initial mesh, if the vertex has directions or associations
    Vec<D> point;
    Reference reference = 0;
    VertexState state;
    bool is_off_geometry = false;
    VertexMetric<D> metric;
    GeometryPosition place;
};

template <int K>
struct AdaptedSimplex {
    SimplexVertices<K> vertices;
    Reference reference = 0, entity = 0;
    Marks marks;
    std::uint8_t sides = 0;  ///< for a facet: number of its sides with elements in the whole mesh
};

/// Rows of a mesh or of a part. A facet between two parts is in both, marked as frozen. A line (feature edge, 3D) or a
/// vertex is in each part that has an element with it.
template <int D>
struct AdaptationRows {
    Buffer<AdaptedVertex<D>> vertices;
    Buffer<AdaptedSimplex<D>> elements;
    Buffer<AdaptedSimplex<D - 1>> facets;
    Buffer<AdaptedSimplex<1>> lines;

    static void each_kind(auto& all, auto&& f) { f(all.vertices), f(all.elements), f(all.facets), f(all.lines); }
};

/// Returns the rows of a whole linear mesh, with vertex numbers. Errors: memory.
template <int D>
[[nodiscard]] Outcome<AdaptationRows<D>> rows_of(const Adaptation<D>& whole);

template <int D>
struct AdaptedPart {
    Adaptation<D> state;
    Column<std::uint8_t> on_rim;  ///< true on the boundary to other parts; for initial vertices only
    std::size_t rim_lines = 0;    ///< temporary lines, stored after the lines of the rows
};

/// Makes a mutable mesh in which the boundary to other parts is fixed. Errors: those of make_dynamic_part.
template <int D>
[[nodiscard]] Outcome<AdaptedPart<D>> assembled(const AdaptationRows<D>& rows, const Execution& execution);

/// Returns the rows of a part. `before`: the initial rows of the part, which still describe its boundary to other
/// parts. Errors: memory.
template <int D>
[[nodiscard]] Outcome<AdaptationRows<D>> rows_of_part(const AdaptedPart<D>& part, const AdaptationRows<D>& before);

/// Expected number of new elements in place of each element, in units of 1/256, so that sums are exact in any order.
struct ElementWeights {
    static constexpr std::uint64_t one = 256;
    Buffer<std::uint64_t> weights;
    std::uint64_t sum = 0;

    [[nodiscard]] double elements() const { return static_cast<double>(sum) / static_cast<double>(one); }
};

/// Returns the volume of each element in the metric, in units of the volume of a unit simplex; at least one. The metric
/// sizes are multiplied by `coarser`. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<ElementWeights> expected_elements(const AdaptationRows<D>& rows, double coarser,
                                                        const Execution& execution);

/// A mesh shared among ranks between block iterations. Each element, facet and line is on one rank. Numbers of rows and
/// vertices increase from one rank to the next.
template <int D>
struct SharedRows {
    AdaptationRows<D> rows;       ///< the vertices of this rank precede those of other ranks in its simplices
    Buffer<std::uint8_t> on_rim;  ///< true for vertices that other ranks may use
    std::vector<std::size_t> first_vertices;  ///< number of the first vertex of each rank, and the total
    AdaptationRows<D> without_elements;  ///< last rank only: fixed entities without elements; vertices also in `rows`
                                         ///< have numbers

    [[nodiscard]] std::size_t vertices() const { return first_vertices.back(); }
    [[nodiscard]] std::size_t own_vertices(const Ranks& ranks) const {
        return first_vertices[ranks.rank() + 1] - first_vertices[ranks.rank()];
    }
};

[[nodiscard]] inline std::size_t rank_with(const std::vector<std::size_t>& firsts, std::size_t number) {
    return static_cast<std::size_t>(std::ranges::upper_bound(firsts, number) - firsts.begin()) - 1;
}

/// Returns this rank's share of a mesh that all ranks have. Errors: memory.
template <int D>
[[nodiscard]] Outcome<SharedRows<D>> share_of(const AdaptationRows<D>& whole, const Ranks& ranks);

/// Returns the rows of this rank. Their simplices refer to vertices by number in the whole mesh. The last rank also
/// returns the rows without elements.
template <int D>
[[nodiscard]] AdaptationRows<D> numbered_rows(SharedRows<D> shared, const Ranks& ranks);

template <int D>
[[nodiscard]] Outcome<AdaptationRows<D>> gathered(SharedRows<D> shared, Ranks& ranks);

/// Sums of a number over all ranks, and over all lower ranks.
struct Counted {
    std::size_t all = 0, before = 0;
};
[[nodiscard]] Outcome<Counted> counted(Ranks& ranks, std::size_t own);

}  // namespace camber

namespace camber {

using PartNumber = std::uint32_t;

template <int K>
struct SentSimplex {
    std::uint64_t number = 0;
    PartNumber part = 0;
    AdaptedSimplex<K> simplex;
};

/// Rows sent to another rank when a mesh is cut. Simplices refer to vertices by their index in `vertices`. Simplices in
/// `…_by_number` refer to them by number instead: other ranks send these vertices with their elements, and the part may
/// have no element at the simplex.
template <int D>
struct SentRows {
    Buffer<AdaptedVertex<D>> vertices;
    Buffer<SentSimplex<D>> elements;
    Buffer<SentSimplex<D - 1>> facets;
    Buffer<SentSimplex<1>> lines;
    Buffer<SentSimplex<D - 1>> facets_by_number;
    Buffer<SentSimplex<1>> lines_by_number;

    static void each_kind(auto& all, auto&& f) {
        f(all.vertices), f(all.elements), f(all.facets), f(all.lines);
        f(all.facets_by_number), f(all.lines_by_number);
    }
};

/// Makes parts [first, last) from the rows sent by all ranks. Vertices are in Morton order in `grid`, elements in the
/// order of their first vertices, other rows in the order of the whole mesh. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<std::vector<AdaptationRows<D>>> parts_of_sent(std::vector<SentRows<D>> sent,
                                                                    const PointBox<D>& grid, PartNumber first,
                                                                    PartNumber last, const Execution& execution);

template <int D>
[[nodiscard]] Outcome<Incidence<ElementId>> elements_around(const AdaptationRows<D>& rows, const Execution& execution);

}  // namespace camber

export namespace camber {

/// A mesh that was cut into parts. Part numbers increase from one rank to the next.
template <int D>
struct CutMesh {
    std::vector<AdaptationRows<D>> parts;
    AdaptationRows<D> without_elements;
    std::vector<std::size_t> first_vertices;  ///< as in SharedRows, before the cut
};

/// Cuts a mesh into parts of about `elements` expected elements: runs of elements in Morton order of their first
/// vertices. Vertices of a part are in Morton order. The grid starts `shift` times the mesh extent before the mesh.
/// Grids with shifts that differ by thirds (2D) or fifths (3D) have no common cell walls (T. M. Chan, 1998). Facets
/// between parts are frozen. Parts do not depend on the distribution of the mesh. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<CutMesh<D>> cut_into_parts(SharedRows<D> shared, const ElementWeights& weights,
                                                 std::size_t elements, double shift, Ranks& ranks,
                                                 const Execution& execution);

/// Joins parts to a shared mesh. If several parts have a row, it stays in the first of them, on the rank of that part.
/// New vertices are numbered part after part. Errors: memory.
template <int D>
[[nodiscard]] Outcome<SharedRows<D>> joined(CutMesh<D> cut, Ranks& ranks);

}  // namespace camber

namespace camber {

/// For each simplex, returns 1 if this is the first rank that has it, else 0. `simplices` have ascending vertex
/// numbers.
template <std::size_t N>
[[nodiscard]] Outcome<std::vector<std::uint8_t>> are_first(const std::vector<std::array<VertexId, N>>& simplices,
                                                           const std::vector<std::size_t>& first_vertices,
                                                           Ranks& ranks) {
    using Numbers = std::array<VertexId, N>;
    const auto rank_of = [&](const Numbers& one) { return rank_with(first_vertices, one.front().index()); };
    std::vector<std::vector<Numbers>> to(ranks.size());
    for (const Numbers& one : simplices) to[rank_of(one)].push_back(one);
    const auto requests = exchanged_lists(ranks, std::move(to));
    if (!requests) return fail(requests.error());
    std::set<Numbers> listed;
    std::vector<std::vector<std::uint8_t>> answers(ranks.size());
    for (std::size_t r = 0; r < requests->size(); ++r)
        for (const Numbers& one : (*requests)[r]) answers[r].push_back(listed.insert(one).second ? 1 : 0);
    const auto replies = exchanged_lists(ranks, std::move(answers));
    if (!replies) return fail(replies.error());
    std::vector<std::size_t> next(ranks.size(), 0);
    std::vector<std::uint8_t> first;
    first.reserve(simplices.size());
    for (const Numbers& one : simplices) first.push_back((*replies)[rank_of(one)][next[rank_of(one)]++]);
    return first;
}

}  // namespace camber

export namespace camber {

/// Initial geometry and groups. Vertices have their initial numbers.
template <int D>
struct InitialGeometry {
    std::size_t vertices = 0;
    InputGeometry<D> geometry;
    Column<Group> groups;
};

/// The rows of this rank for the output file of a remeshed mesh. Together, the rows of all ranks equal the result of
/// `finished` for the whole mesh.
template <int D>
struct FinishedRows {
    FilePart<D, 1> part;
    PartTotals totals;
    LinearMesh<D> lists;  ///< the same on all ranks
};
/// Errors: memory.
template <int D>
[[nodiscard]] Outcome<FinishedRows<D>> finished_rows(SharedRows<D> shared, const InitialGeometry<D>& original,
                                                     Ranks& ranks);

/// Metric edge lengths, each edge on one rank, and qualities of this rank's elements.
struct MeasuredRows {
    std::vector<double> lengths, qualities;
};
template <int D>
[[nodiscard]] Outcome<MeasuredRows> measured_rows(const SharedRows<D>& shared, Ranks& ranks,
                                                  const Execution& execution);

/// Remeshing by blocks. Block boundaries are fixed in an iteration; the next iteration uses other blocks. Each rank has
/// some of the blocks, and the whole field and geometry.
struct RemeshBlocksOptions {
    int blocks = 0;

    [[nodiscard]] static constexpr auto options() {
        using S = RemeshBlocksOptions;
        return std::tuple(
            option("blocks", &S::blocks,
                   "straight meshes only: number of elements in a block. Each block is remeshed separately with a "
                   "fixed interface to other blocks; then the mesh is divided into other blocks and remeshed again. "
                   "0: the mesh is remeshed as a whole")
                .at_least(0));
    }
    friend bool operator==(const RemeshBlocksOptions&, const RemeshBlocksOptions&) = default;
};

/// One iteration: cut the mesh, remesh the blocks and join them.
struct BlockIteration {
    double shift = 0;  ///< see cut_into_parts
    int rounds = 1;    ///< maximum number of rounds (collapse, split, swap and smooth), before the pass mend
    /// `loose`: all rounds use the limits ToMetricOptions::early_collapse_longest, early_split_longest and
    /// early_split_shortest.
    enum class Lengths : std::uint8_t { loose, strict } lengths = Lengths::strict;
    double coarser = 1;  ///< all metric sizes are multiplied by this when edges are split
};

/// Iterations of a run. The block boundaries of one iteration are inside the blocks of the next.
template <int D>
[[nodiscard]] std::vector<BlockIteration> block_iterations(const ToMetricOptions& options);

/// `elements` is the expected number of elements of a block.
struct BlockRemeshing {
    std::size_t elements = 0;
    Ranks& ranks;
};

template <int D>
struct RemeshedRows {
    SharedRows<D> shared;
    InitialGeometry<D> original = {};
    ToMetricStatistics statistics = {};  ///< of the iterations so far, without `after`
};

/// Runs one iteration, and adds to the statistics of passes and rounds. Errors: those of remesh_to_metric.
template <int D>
[[nodiscard]] Outcome<RemeshedRows<D>> run_block_iteration(RemeshedRows<D> rows, const AdaptationGoal<D>& goal,
                                                           const ToMetricOptions& options, const BlockRemeshing& by,
                                                           const BlockIteration& turn, const StepWrapper& around);

/// Remeshes a linear mesh that all ranks have. The result is shared among ranks, and depends only on the mesh and the
/// block size. Errors: those of remesh_to_metric; degree 2 and surface meshes (unsupported).
template <int D>
[[nodiscard]] Outcome<RemeshedRows<D>> remesh_shared_rows(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                                          const ToMetricOptions& options, const BlockRemeshing& by,
                                                          const std::vector<BlockIteration>& turns,
                                                          const StepWrapper& around);

/// Like remesh_shared_rows, with the whole result on all ranks.
template <int D>
[[nodiscard]] Outcome<RemeshResult<D>> remesh_by_blocks(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                                        const ToMetricOptions& options, const BlockRemeshing& by,
                                                        const std::vector<BlockIteration>& turns,
                                                        const StepWrapper& around);

}  // namespace camber
