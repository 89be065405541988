module;
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.distributed:block_run;
import camber.core;
import camber.curving;
import camber.metric;
import camber.recipes;
import :block_state;
import :blocks;
import :curve_blocks;
import :halo;
import :ranks;
import :rows;
import :whole_surface;

namespace camber {

/// What all blocks are curved by.
template <int D>
struct CurvingBy {
    WholeSurface<D> surface;
    CurveOptions edges;
};

/// What a rank knows between two steps of curve_blocks.
template <int D>
struct BlockRun {
    const BlocksGoal<D>& goal;
    const CurveBlocksOptions& options;
    Ranks& ranks;
    CurvedBlocks<D> out = {};
    std::vector<BlockState<D>> states = {};  ///< one a block here
    Halo edges = {}, vertices = {};
    std::optional<BetweenBlocks<D>> between = {};
    std::optional<CurvingBy<D>> by = {};
    std::vector<GlobalNumber> not_valid = {};  ///< elements of this rank, rising
    bool is_displaced = false;                 ///< so that there is an extension, of whichever blocks

    /// f of each block here.
    Outcome<Done> each_block(const Execution& execution, const auto& f) {
        for (std::size_t b = 0; b < states.size(); ++b) {
            auto done = f(states[b], out.blocks.own[b]);
            if (!done) return fail(done.error());
            if (options.after_block) options.after_block();
            report_progress(execution, b + 1, states.size());
        }
        return Done{};
    }

    /// Rows of edges of the surface from the blocks that own them: value_of(block, edge, edge of the surface), if any.
    Outcome<Done> gather_on_surface(std::span<Vec<D>> rows, const auto& value_of) {
        struct Found {
            std::uint64_t at = 0;
            Vec<D> value;
        };
        std::vector<Found> found;
        for (std::size_t b = 0; b < states.size(); ++b)
            for (EdgeId e = states[b].first_edge; e < states[b].last_edge; e = EdgeId(e.index() + 1)) {
                const EdgeId at = states[b].on_surface[e];
                if (!at.valid()) continue;
                if (const std::optional<Vec<D>> value = value_of(b, e, at)) found.push_back({at.index(), *value});
            }
        const auto all = gather_all(ranks, Outcome<std::vector<Found>>(std::move(found)));
        if (!all) return fail(all.error());
        for (const Found& f : *all) rows[f.at] = f.value;
        return Done{};
    }
};

/// The surface, and what each block has of it.
template <int D>
[[nodiscard]] Outcome<Done> find_surface(BlockRun<D>& run, const MeshRows<D>& rows, const Execution& execution);

/// The boundary's displacement carried into the volume, see extend_boundary; in planes first.
template <int D>
[[nodiscard]] Outcome<Done> extend_blocks(BlockRun<D>& run, const Execution& execution);

/// The metric at the vertices, and the nodes of the mesh that it is read in.
template <int D>
[[nodiscard]] Outcome<Done> make_metric(BlockRun<D>& run, const Execution& execution);

/// The field on a part of the mesh, of which some of its vertices and edges are; on a block.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> field_on(const QuadraticMesh<D>& mesh, const Buffer<LagrangeNode<D>>& back_nodes,
                                            const Buffer<LogMetric<D>>& log_metrics, KeptGradients kept,
                                            const Execution& execution);
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> field_of(const BlockState<D>& state, KeptGradients kept, const Execution& execution);

/// Nodes of all edges.
template <int D>
[[nodiscard]] Outcome<Done> curve_nodes(BlockRun<D>& run, const Execution& execution);

/// Verdicts of all elements; those that are not valid are repaired.
template <int D>
[[nodiscard]] Outcome<Done> judge_blocks(BlockRun<D>& run, const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Done> relax_blocks(BlockRun<D>& run, const Execution& execution);

}  // namespace camber
