// Remeshing by blocks: rows of a mesh that changes, cutting, joining, finished rows.
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

/// A mesh that is brought to a metric as plain rows, the whole or a part: what is cut, moved between ranks and joined.
export namespace camber {

/// All that is known of a vertex. `number` is its own in the whole: none of one that is new, or is this part's alone
/// (but for frozen ones, on which there may be something that is of no part).
template <int D>
struct AdaptedVertex {
    VertexId number;
    VertexId origin;  ///< of one that directions or associations are given at: its number when all began
    Vec<D> point;
    Reference reference = 0;
    VertexState state;
    bool is_off_geometry = false;
    VertexMetric<D> metric;
    GeometryPlace place;
};

/// A K-simplex by rows of vertices.
template <int K>
struct AdaptedSimplex {
    SimplexVertices<K> vertices;
    Reference reference = 0, entity = 0;
    Marks marks;
    std::uint8_t sides = 0;  ///< of a facet: on how many of its sides there are elements, in the whole
};

/// Facets between two parts are in both, marked frozen; lines (3D) in each part that has an element there; vertices
/// likewise.
template <int D>
struct AdaptationRows {
    Buffer<AdaptedVertex<D>> vertices;
    Buffer<AdaptedSimplex<D>> elements;
    Buffer<AdaptedSimplex<D - 1>> facets;
    Buffer<AdaptedSimplex<1>> lines;

    /// f(rows) of each kind.
    static void each_kind(auto& all, auto&& f) { f(all.vertices), f(all.elements), f(all.facets), f(all.lines); }
};

/// The rows of a whole mesh of degree 1, in its order; vertices are numbered by it. Errors: memory.
template <int D>
[[nodiscard]] Outcome<AdaptationRows<D>> rows_of(const Adaptation<D>& whole);

/// A part between cutting and joining.
template <int D>
struct AdaptedPart {
    Adaptation<D> state;
    Column<std::uint8_t> on_rim;  ///< of each vertex that the rows had
    std::size_t rim_lines = 0;    ///< behind those of the rows, for the time being
};

/// The rows as a mesh to change, of which the rim stays (see make_dynamic_part). Errors: those of make_dynamic_part.
template <int D>
[[nodiscard]] Outcome<AdaptedPart<D>> assembled(const AdaptationRows<D>& rows, const Execution& execution);

/// The rows of a part that was changed; `before`: those that it was made of, as which its rim is still. Errors: memory.
template <int D>
[[nodiscard]] Outcome<AdaptationRows<D>> rows_of_part(const AdaptedPart<D>& part, const AdaptationRows<D>& before);

/// How many elements each is to become, in parts of 256 that add up in any order to the same.
struct ElementWeights {
    static constexpr std::uint64_t one = 256;
    Buffer<std::uint64_t> weights;  ///< one an element, at least `one`
    std::uint64_t sum = 0;

    [[nodiscard]] double elements() const { return static_cast<double>(sum) / static_cast<double>(one); }
};

/// By the volume of each element in the metric over that of a unit simplex, with all sizes `coarser` times as large;
/// elements that are to become fewer count as they are. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<ElementWeights> expected_elements(const AdaptationRows<D>& rows, double coarser,
                                                        const Execution& execution);

/// A mesh that is brought to a metric between two turns, shared among ranks. Each element, facet and line is on one of
/// them; what follows in its order goes over the ranks one after the other, as do the numbers of vertices.
template <int D>
struct SharedRows {
    AdaptationRows<D> rows;                   ///< vertices: this rank's in their order, then others that simplices name
    Buffer<std::uint8_t> on_rim;              ///< of each vertex: whether other ranks may name it
    std::vector<std::size_t> first_vertices;  ///< the first number of each rank's vertices; then how many there are
    AdaptationRows<D>
        aside;  ///< of the last rank: what is of no element, which stays; without number: of the rest none

    [[nodiscard]] std::size_t vertices() const { return first_vertices.back(); }
    [[nodiscard]] std::size_t own_vertices(const Ranks& ranks) const {
        return first_vertices[ranks.rank() + 1] - first_vertices[ranks.rank()];
    }
};

/// Which rank has a number, of those of which each begins with one of `firsts`; the last of these is the end.
[[nodiscard]] inline std::size_t rank_with(const std::vector<std::size_t>& firsts, std::size_t number) {
    return static_cast<std::size_t>(std::ranges::upper_bound(firsts, number) - firsts.begin()) - 1;
}

/// This rank's share of a mesh that all have as a whole: runs of its rows. Errors: memory.
template <int D>
[[nodiscard]] Outcome<SharedRows<D>> share_of(const AdaptationRows<D>& whole, const Ranks& ranks);

/// What is this rank's alone, simplices by the numbers of their vertices; of the last rank what is of no element, too.
template <int D>
[[nodiscard]] AdaptationRows<D> numbered_rows(SharedRows<D> shared, const Ranks& ranks);

/// The whole mesh on all ranks. Errors: of any rank.
template <int D>
[[nodiscard]] Outcome<AdaptationRows<D>> gathered(SharedRows<D> shared, Ranks& ranks);

/// A number of each rank added up, and where this rank's begins if they are counted on from rank to rank. Errors: of
/// any rank.
struct Counted {
    std::size_t all = 0, before = 0;
};
[[nodiscard]] Outcome<Counted> counted(Ranks& ranks, std::size_t own);

}  // namespace camber

namespace camber {

using PartNumber = std::uint32_t;

/// A simplex on its way into a part.
template <int K>
struct SentSimplex {
    std::uint64_t number = 0;  ///< in the order of the whole
    PartNumber part = 0;
    AdaptedSimplex<K> simplex;
};

/// What goes from a rank to another when a mesh is cut: simplices by rows of `vertices`, those of `by_number` by the
/// numbers of their vertices, which go along with the elements of others. The latter may be of the part or not.
template <int D>
struct SentRows {
    Buffer<AdaptedVertex<D>> vertices;
    Buffer<SentSimplex<D>> elements;
    Buffer<SentSimplex<D - 1>> facets;
    Buffer<SentSimplex<1>> lines;
    Buffer<SentSimplex<D - 1>> facets_by_number;
    Buffer<SentSimplex<1>> lines_by_number;

    /// f(rows) of each kind.
    static void each_kind(auto& all, auto&& f) {
        f(all.vertices), f(all.elements), f(all.facets), f(all.lines);
        f(all.facets_by_number), f(all.lines_by_number);
    }
};

/// Parts [first, last) made of what all ranks sent: vertices follow the curve in `grid`, elements that of their first
/// vertices, facets and lines the whole. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<std::vector<AdaptationRows<D>>> parts_of_sent(std::vector<SentRows<D>> sent,
                                                                    const PointBox<D>& grid, PartNumber first,
                                                                    PartNumber last, const Execution& execution);

/// The elements around each vertex. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<Incidence<ElementId>> elements_around(const AdaptationRows<D>& rows, const Execution& execution);

}  // namespace camber

export namespace camber {

/// A mesh cut into parts, of which each rank has a run.
template <int D>
struct CutMesh {
    std::vector<AdaptationRows<D>> parts;     ///< this rank's
    AdaptationRows<D> aside;                  ///< of the last rank: what is of no element, which is nobody's work
    std::vector<std::size_t> first_vertices;  ///< of the mesh that was cut (SharedRows)
};

/// Into parts that are to become about `elements` each, by their weights: runs of the elements along the Morton curve
/// of their first vertices there, in a grid that begins `shift` of the mesh's extent before it. Vertices of a part
/// follow that curve, too. Two grids whose shifts differ by thirds (2D) or fifths (3D) have no wall in common (T. M.
/// Chan, 1998), which two runs of one curve would: however far they are shifted along it, both end at the first plane
/// that halves the mesh. Facets are frozen where they are between two parts. All ranks call it, with their shares: the
/// parts, in their order over the ranks, are the same whoever has what. Errors: stopped, memory; of any rank.
template <int D>
[[nodiscard]] Outcome<CutMesh<D>> cut_into_parts(SharedRows<D> shared, const ElementWeights& weights,
                                                 std::size_t elements, double shift, Ranks& ranks,
                                                 const Execution& execution);

/// The whole again: vertices, elements, facets and lines of one part after the other, each in the first that has it,
/// and on its rank; new numbers are counted on from part to part. Errors: memory, of any rank.
template <int D>
[[nodiscard]] Outcome<SharedRows<D>> joined(CutMesh<D> cut, Ranks& ranks);

}  // namespace camber

namespace camber {

/// Of simplices that several ranks may have, by the rising numbers of their vertices: whether this is the first of
/// them.
template <std::size_t N>
[[nodiscard]] Outcome<std::vector<std::uint8_t>> are_first(const std::vector<std::array<VertexId, N>>& simplices,
                                                           const std::vector<std::size_t>& first_vertices,
                                                           Ranks& ranks) {
    using Numbers = std::array<VertexId, N>;
    const auto rank_of = [&](const Numbers& one) { return rank_with(first_vertices, one.front().index()); };
    std::vector<std::vector<Numbers>> to(ranks.size());
    for (const Numbers& one : simplices) to[rank_of(one)].push_back(one);
    const auto asked = exchanged_lists(ranks, std::move(to));
    if (!asked) return fail(asked.error());
    std::set<Numbers> told;
    std::vector<std::vector<std::uint8_t>> answers(ranks.size());
    for (std::size_t r = 0; r < asked->size(); ++r)
        for (const Numbers& one : (*asked)[r]) answers[r].push_back(told.insert(one).second ? 1 : 0);
    const auto heard = exchanged_lists(ranks, std::move(answers));
    if (!heard) return fail(heard.error());
    std::vector<std::size_t> next(ranks.size(), 0);
    std::vector<std::uint8_t> first;
    first.reserve(simplices.size());
    for (const Numbers& one : simplices) first.push_back((*heard)[rank_of(one)][next[rank_of(one)]++]);
    return first;
}

}  // namespace camber

export namespace camber {

/// What a mesh had of its maker, beside its rows: at vertices, by their numbers when all began.
template <int D>
struct GivenOfMesh {
    std::size_t vertices = 0;
    GivenGeometry<D> geometry;
    Column<Group> groups;
};

/// A mesh that was remeshed, shared among ranks, as the rows of its file: as `finished` has them of a mesh as a whole.
template <int D>
struct FinishedRows {
    FilePart<D, 1> part;  ///< this rank's rows
    PartTotals totals;
    LinearMesh<D> lists;  ///< what is said beside the rows: on all ranks
};
/// Errors: memory, of any rank.
template <int D>
[[nodiscard]] Outcome<FinishedRows<D>> finished_rows(SharedRows<D> shared, const GivenOfMesh<D>& given, Ranks& ranks);

/// Of a shared mesh the lengths of edges in the metric, each on one rank, and the qualities of elements there. Errors:
/// memory, stopped, of any rank.
struct MeasuredRows {
    std::vector<double> lengths, qualities;
};
template <int D>
[[nodiscard]] Outcome<MeasuredRows> measured_rows(const SharedRows<D>& shared, Ranks& ranks,
                                                  const Execution& execution);

/// A mesh that is brought to a metric block by block: each by itself while its rim stays, then cut anew elsewhere.
/// Ranks share the work and the mesh, each some of its blocks; its field and its geometry are on all of them.
struct RemeshBlocksOptions {
    int blocks = 0;

    [[nodiscard]] static constexpr auto options() {
        using S = RemeshBlocksOptions;
        return std::tuple(
            option("blocks", &S::blocks,
                   "of a straight mesh: elements in a block, each of which is brought to the metric by itself while "
                   "what it shares with others stays, then again in other blocks; 0: the mesh as a whole")
                .at_least(0));
    }
    friend bool operator==(const RemeshBlocksOptions&, const RemeshBlocksOptions&) = default;
};

/// What the blocks of one cut go through.
struct BlockTurn {
    double shift = 0;  ///< of the grid, see cut_into_parts
    int rounds = 1;    ///< at most, of collapse, split, swap and smooth; then mend
    /// Whether even its last round leaves edges that a later one will see to (ToMetricOptions::early_collapse_longest,
    /// early_split_longest, early_split_shortest).
    enum class Lengths : std::uint8_t { loose, strict } lengths = Lengths::strict;
    double coarser = 1;  ///< all sizes that splits mind are so many times those of the metric
};

/// In each of the later turns what was a rim before is inside.
template <int D>
[[nodiscard]] std::vector<BlockTurn> block_turns(const ToMetricOptions& options);

/// How: in blocks that are to become of about so many elements each, by these ranks.
struct InBlocks {
    std::size_t elements = 0;
    Ranks& ranks;
};

/// A mesh that turns bring to a metric, shared by the ranks.
template <int D>
struct BroughtRows {
    SharedRows<D> shared;
    GivenOfMesh<D> given = {};
    ToMetricStatistics statistics = {};  ///< of the turns so far, without `after`
};

/// One turn: the mesh cut, its blocks brought to the metric, and joined. Adds to the statistics of passes and rounds.
/// Errors: those of bring_to_metric, of any rank.
template <int D>
[[nodiscard]] Outcome<BroughtRows<D>> turn_by_blocks(BroughtRows<D> rows, const AdaptationGoal<D>& goal,
                                                     const ToMetricOptions& options, const InBlocks& by,
                                                     const BlockTurn& turn, const Around& around);

/// A mesh of degree 1, the same on all ranks, brought to a metric in these turns, and still shared: the result depends
/// on the mesh and the size of the blocks, and on nothing else. Errors: those of bring_to_metric; degree 2 and surfaces
/// alone (unsupported).
template <int D>
[[nodiscard]] Outcome<BroughtRows<D>> bring_rows_to_metric(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                                           const ToMetricOptions& options, const InBlocks& by,
                                                           const std::vector<BlockTurn>& turns, const Around& around);

/// The same as a whole, on all ranks.
template <int D>
[[nodiscard]] Outcome<BroughtToMetric<D>> bring_to_metric_by_blocks(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                                                    const ToMetricOptions& options, const InBlocks& by,
                                                                    const std::vector<BlockTurn>& turns,
                                                                    const Around& around);

}  // namespace camber
