module;
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <vector>
export module camber.distributed:remesh_blocks;
import camber.core;
import camber.metric;
import camber.operation;
import camber.adapt;
import :adaptation_rows;
import :finished_rows;
import :ranks;
import :shared_rows;

export namespace camber {

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
    /// Whether even its last round leaves edges that a later one will see to (ToMetricOptions::loose_longest,
    /// loose_split, loose_shortest).
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

/// One turn: the mesh cut, its blocks brought to the metric, and joined. Adds to the statistics of passes and rounds.
/// Errors: those of bring_to_metric, of any rank.
template <int D>
[[nodiscard]] Outcome<SharedRows<D>> turn_by_blocks(SharedRows<D> shared, const AdaptationGoal<D>& goal,
                                                    const ToMetricOptions& options, const InBlocks& by,
                                                    const BlockTurn& turn, ToMetricStatistics& statistics,
                                                    const Around& around);

/// A mesh of degree 1, the same on all ranks, brought to a metric in these turns, and still shared: the result depends
/// on the mesh and the size of the blocks, and on nothing else. Of `statistics` there is no `after`. Errors: those of
/// bring_to_metric; degree 2 and surfaces alone (unsupported).
template <int D>
struct BroughtRows {
    SharedRows<D> shared;
    GivenOfMesh<D> given;
    ToMetricStatistics statistics;
};
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
