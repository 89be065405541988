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
import :moved_nodes;
import :part_state;
import :ringed_parts;
import :curve_blocks;
import :halo;
import :ranks;
import :rows;
import :whole_surface;

namespace camber {

/// What all parts are curved by.
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
    std::vector<PartState<D>> states = {};  ///< one a part here
    Halo edges = {}, vertices = {};
    std::optional<BetweenRingedParts<D>> between = {};
    std::optional<CurvingBy<D>> by = {};
    std::vector<GlobalNumber> not_valid = {};  ///< elements of this rank, rising
    bool is_displaced = false;                 ///< so that there is an extension, of whichever parts

    /// f of each part here: of what it makes the part's state is kept.
    Outcome<Done> each_part(const Execution& execution, const auto& f) {
        if (!options.blocks.memory.before) return each_part_keeping(execution, f);
        return each_part_keeping(execution, [&](PartState<D>& state, RingedPart<D>& part) -> Outcome<Done> {
            const std::vector<const void*> before = arrays_of(state);
            options.blocks.memory.before();
            auto done = f(state, part);
            options.blocks.memory.after();
            if (done) made_anew(state, before);
            return done;
        });
    }
    /// f of each part here, which makes what is kept beside the states.
    Outcome<Done> each_part_keeping(const Execution& execution, const auto& f) {
        for (std::size_t p = 0; p < states.size(); ++p) {
            auto done = f(states[p], out.parts.own[p]);
            if (!done) return fail(done.error());
            if (options.blocks.memory.leave) options.blocks.memory.leave();
            report_progress(execution, p + 1, states.size());
        }
        return Done{};
    }

    /// Rows of edges of the surface from the parts that own them: value_of(part, edge, edge of the surface), if any.
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

/// The surface, and what each part has of it.
template <int D>
[[nodiscard]] Outcome<Done> find_surface(BlockRun<D>& run, const MeshRows<D>& rows, const Execution& execution);

/// The boundary's displacement carried into the volume, see extend_boundary; in planes first.
template <int D>
[[nodiscard]] Outcome<Done> extend_blocks(BlockRun<D>& run, const Execution& execution);

/// The metric at the vertices, and the nodes of the mesh that it is read in.
template <int D>
[[nodiscard]] Outcome<Done> make_metric(BlockRun<D>& run, const Execution& execution);

/// Where edges start: those of the volume at these nodes, others where the surface has them.
template <int D>
[[nodiscard]] Buffer<LagrangeNode<D>> starting_at(const PartState<D>& state, const WholeSurface<D>& surface,
                                                  const MovedNodes<D>& nodes);

/// The field on a part of the mesh, of which some of its vertices and edges are; on a part.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> field_on(const QuadraticMesh<D>& mesh, Buffer<LagrangeNode<D>> back_nodes,
                                            const Buffer<LogMetric<D>>& log_metrics, KeptGradients kept,
                                            const Execution& execution);
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> field_of(const PartState<D>& state, KeptGradients kept, const Execution& execution);

/// Nodes of all edges.
template <int D>
[[nodiscard]] Outcome<Done> curve_nodes(BlockRun<D>& run, const Execution& execution);

/// Verdicts of all elements; those that are not valid are repaired.
template <int D>
[[nodiscard]] Outcome<Done> judge_blocks(BlockRun<D>& run, const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Done> relax_blocks(BlockRun<D>& run, const Execution& execution);

/// Moves nodes of the boundary back until no walls cross, as `uncross_walls` does; each rank looks at the whole
/// surface.
template <int D>
[[nodiscard]] Outcome<Done> uncross_blocks(BlockRun<D>& run, const Execution& execution);

/// Measures the deviation of the boundary from its geometry; each rank that of the whole surface.
template <int D>
[[nodiscard]] Outcome<Done> measure_blocks(BlockRun<D>& run, const Execution& execution);

}  // namespace camber
