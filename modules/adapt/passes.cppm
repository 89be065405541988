// Options and interfaces of the passes, of bring_to_metric and of reinsertion.
module;
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>
export module camber.adapt:passes;
import camber.core;
import camber.cavity;
import camber.metric;
import camber.validity;
import camber.surface;
import camber.operation;

export namespace camber {

/// What a step of remeshing gives: the mesh, and what was done.
template <int D>
struct Adapted {
    Adaptation<D> state;
    PassStatistics statistics;
};

/// Edges that are longer than `longest` are split, at the middle by length, the longest first.
struct SplitOptions {
    double longest = longest_unit_edge;
    /// No edge shorter than this is made; of an edge longer than 2 none shorter than (2/length)² of it: what is short a
    /// collapse mends, and what stands in the way of a split nothing.
    double shortest = 0.61;
    /// Of new elements, unless what they replace is worse; of an edge longer than 4 at most 0.02.
    double min_quality = 0.05;

    [[nodiscard]] static constexpr auto options() {
        using S = SplitOptions;
        return std::tuple(
            option("longest", &S::longest, "edges that are longer are split").unit("lengths in the metric").above(0),
            option("shortest", &S::shortest,
                   "no edge shorter than this is made; of an edge longer than 2 none shorter than (2/length)² of it")
                .unit("lengths in the metric")
                .at_least(0),
            option("min_quality", &S::min_quality,
                   "of new elements, unless what they replace is worse; of an edge longer than 4 at most 0.02")
                .at_least(0)
                .below(1));
    }
    friend bool operator==(const SplitOptions&, const SplitOptions&) = default;
};
template <int D>
[[nodiscard]] Outcome<Adapted<D>> split(Adaptation<D> state, const AdaptationGoal<D>& goal, const SplitOptions& options,
                                        const Execution& execution);

/// One end of each edge that is shorter than `shortest` goes into the other, the shortest first: somewhat longer ones
/// than unit edges may be short, so that what is left is of length 1 in the mean.
struct CollapseOptions {
    double shortest = 0.73;
    double longest = longest_unit_edge;  ///< no edge longer than this is made
    double min_quality = 0.1;            ///< of new elements, unless what they replace is worse
    double distance = 0.2;               ///< of new facets from the geometry, see is_near_geometry
    int bend_around = 0;                 ///< of degree 2, see PatchLimits

    [[nodiscard]] static constexpr auto options() {
        using S = CollapseOptions;
        return std::tuple(
            option("shortest", &S::shortest, "edges that are shorter are collapsed")
                .unit("lengths in the metric")
                .above(0),
            option("longest", &S::longest, "no edge longer than this is made").unit("lengths in the metric").above(0),
            option("min_quality", &S::min_quality, "of new elements, unless what they replace is worse")
                .at_least(0)
                .below(1),
            option("distance", &S::distance,
                   "no new facet is farther from the geometry than this share of its longest edge, unless one that it "
                   "replaces is")
                .above(0),
            option("neighbour_edges", &S::bend_around,
                   "of degree 2: where no nodes inside a cavity make its elements valid, those of so many edges around "
                   "it may follow; 0: none")
                .at_least(0)
                .at_most(64));
    }
    friend bool operator==(const CollapseOptions&, const CollapseOptions&) = default;
};
template <int D>
[[nodiscard]] Outcome<Adapted<D>> collapse(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                           const CollapseOptions& options, const Execution& execution);

/// Edges and faces of elements whose quality is below `wanted` are swapped where that makes the worst element better:
/// the one of their ends, or of the vertices around them, is joined to what they leave that wins most.
struct SwapOptions {
    double wanted = 0.7;
    double gain = 1.02;     ///< the worst quality, after by before
    double distance = 0.2;  ///< of new facets from the geometry, see is_near_geometry

    [[nodiscard]] static constexpr auto options() {
        using S = SwapOptions;
        return std::tuple(
            option("target_quality", &S::wanted, "elements of a better quality are left alone").above(0).at_most(1),
            option("gain", &S::gain, "the least gain: the worst quality after by that before").at_least(1),
            option("distance", &S::distance,
                   "no new facet is farther from the geometry than this share of its longest edge, unless one that it "
                   "replaces is")
                .above(0));
    }
    friend bool operator==(const SwapOptions&, const SwapOptions&) = default;
};
template <int D>
[[nodiscard]] Outcome<Adapted<D>> swap(Adaptation<D> state, const AdaptationGoal<D>& goal, const SwapOptions& options,
                                       const Execution& execution);

/// What nodes of inner edges of a mesh of degree 2 are smoothed by.
enum class SmoothedNodes : std::uint8_t {
    objective,   ///< they go along with vertices, to where the goal has the nodes of new edges
    distortion,  ///< and then to where elements are less distorted, see smooth_nodes
};
[[nodiscard]] constexpr auto words(SmoothedNodes) {
    return words_of(Word{SmoothedNodes::objective, "objective"}, Word{SmoothedNodes::distortion, "distortion"});
}

/// Vertices inside, and those of smooth surfaces where there is a geometry, go to where their edges are nearer to unit,
/// as far as the worst element around them becomes better. First those that are off the geometry go onto it.
struct SmoothOptions {
    double wanted = 0.8;
    double gain = 1.01;
    int sweeps = 2;
    SmoothedNodes nodes = SmoothedNodes::objective;

    [[nodiscard]] static constexpr auto options() {
        using S = SmoothOptions;
        return std::tuple(
            option("target_quality", &S::wanted, "elements of a better quality are left alone").above(0).at_most(1),
            option("gain", &S::gain, "the least gain: the worst quality after by that before").at_least(1),
            option("sweeps", &S::sweeps, "sweeps over the vertices, and over the nodes").at_least(0).at_most(100),
            option(
                "nodes", &S::nodes,
                "degree 2: nodes of inner edges go along with vertices to where their objective has them; distortion: "
                "and then to where the elements around them are less distorted"));
    }
    friend bool operator==(const SmoothOptions&, const SmoothOptions&) = default;
};
template <int D>
[[nodiscard]] Outcome<Adapted<D>> smooth(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                         const SmoothOptions& options, const Execution& execution);

/// Swaps and moves for bad elements alone, sweep after sweep, until there are none or no sweep finds anything to do.
struct MendOptions {
    double wanted = 0.5;
    int sweeps = 4;

    [[nodiscard]] static constexpr auto options() {
        using S = MendOptions;
        return std::tuple(
            option("target_quality", &S::wanted, "elements of a better quality are left alone").above(0).at_most(1),
            option("sweeps", &S::sweeps, "sweeps of swaps and moves").at_least(0).at_most(1000));
    }
    friend bool operator==(const MendOptions&, const MendOptions&) = default;
};
template <int D>
[[nodiscard]] Outcome<Adapted<D>> mend(Adaptation<D> state, const AdaptationGoal<D>& goal, const MendOptions& options,
                                       const Execution& execution);

/// Rounds of collapse, split, swap and smooth; bad elements are mended at last. In all rounds but the last a collapse
/// may make edges that are longer than its options say: the split behind halves them, and where none may be longer than
/// √2 most short edges would stay. And splits leave edges somewhat longer than their options say: of those in between
/// most come to be shorter by what goes on around them, and halves of them would make the mean length less than 1. Nor
/// do splits make edges there that a collapse would have to remove.
struct ToMetricOptions {
    double early_collapse_longest = 2;
    double early_split_longest = 1.55;
    double early_split_shortest = 0.7;
    CollapseOptions collapse = {};
    SplitOptions split = {};
    SwapOptions swap = {};
    SmoothOptions smooth = {};
    MendOptions mend = {};
    int rounds = 4;
    double min_change = 0.002;

    [[nodiscard]] static constexpr auto options() {
        using S = ToMetricOptions;
        return std::tuple(
            option("early_collapse_longest", &S::early_collapse_longest,
                   "the longest edges that collapses may make in all rounds but the last, if collapse/longest is less")
                .unit("lengths in the metric")
                .at_least(0),
            option("early_split_longest", &S::early_split_longest,
                   "the longest edges that splits leave in all rounds but the last, if split/longest is less")
                .unit("lengths in the metric")
                .at_least(0),
            option("early_split_shortest", &S::early_split_shortest,
                   "the shortest edges that splits make in all rounds but the last, if split/shortest is less")
                .unit("lengths in the metric")
                .at_least(0),
            option("collapse", &S::collapse, "the options of the stage collapse"),
            option("split", &S::split, "the options of the stage split"),
            option("swap", &S::swap, "the options of the stage swap"),
            option("smooth", &S::smooth, "the options of the stage smooth"),
            option("improve", &S::mend, "the options of the stage improve, which comes last"),
            option("rounds", &S::rounds, "rounds of collapse, split, swap and smooth").at_least(0).at_most(1000),
            option("min_change", &S::min_change,
                   "ends where a round raises the share of unit edges by less and makes or removes a smaller share of "
                   "vertices")
                .at_least(0)
                .at_most(1));
    }
    friend bool operator==(const ToMetricOptions&, const ToMetricOptions&) = default;
};

/// What each kind of pass did, in all rounds.
struct ToMetricStatistics {
    int rounds = 0;
    PassStatistics collapse, split, swap, smooth, mend;
    UnitMeshStatistics before, after;
};

template <int D>
struct BroughtToMetric {
    Adaptation<D> state;
    ToMetricStatistics statistics;
};

/// A mesh brought to a metric, of degree 1. Errors: options out of range, those of the passes.
template <int D>
[[nodiscard]] Outcome<BroughtToMetric<D>> bring_to_metric(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                                          const ToMetricOptions& options, const Around& around);
template <int D>
[[nodiscard]] Outcome<BroughtToMetric<D>> bring_to_metric(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                                          const ToMetricOptions& options, const Execution& execution) {
    return bring_to_metric(std::move(state), goal, options, plainly(execution));
}

/// Means by which bounds on distances are met: any; or as far as the mesh stays near to the metric, where edges are
/// halved once, and no element becomes worse than a fifth of the best quality.
enum class BoundaryEffort : std::uint8_t { any, near_metric };

/// Refines the boundary until every facet keeps the goal's `distance_bounds`, in rounds of splits and swaps of far
/// facets; swap, smooth and mend follow and keep the bounds. Ends early where a round changes nothing, or after
/// `max_bound_rounds`. `statistics` has no lengths. Errors: options out of range, those of the passes.
template <int D>
[[nodiscard]] Outcome<BroughtToMetric<D>> bring_within_bounds(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                                              const ToMetricOptions& options, BoundaryEffort effort,
                                                              const Around& around);
inline constexpr int max_bound_rounds = 8;

/// Number of facets that exceed the goal's bounds, by `bound_shares`. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<std::size_t> count_far_facets(const Adaptation<D>& r, const AdaptationGoal<D>& goal,
                                                    const Execution& execution);

/// What sweeps over the nodes of inner edges did.
struct NodeMoves {
    std::size_t tried = 0, moved = 0;
};

/// Of a mesh of degree 2: nodes of inner edges go to where the elements around are less distorted in the metric of
/// their vertices (see camber.metric:unit_mesh), the worst of them never more so. Vertices and the boundary stay.
/// Edges around which all elements are as good as `wanted` are left alone, and those of required elements, of elements
/// that are not valid, and of interfaces. Every element that changes is certified: to 0.1 of its straight one's
/// determinant, or det J > 0 where it was below that. As if one edge after the other, in an order by their numbers.
/// Errors: options out of range, stopped, memory.
template <int D>
[[nodiscard]] Outcome<NodeMoves> smooth_nodes(Adaptation<D>& r, const SmoothOptions& options,
                                              const Execution& execution);

/// How vertices are put in again.
struct ReinsertionOptions {
    double min_scaled_jacobian = min_bound;
    double target = 0.01;
    /// Through a stack of layers nodes come one layer a turn. Turns over the vertices that have a node short of its
    /// target next to something that changed; the first turn is over all of them: those of the volume, then those of
    /// the boundary.
    int max_sweeps = 100;

    [[nodiscard]] static constexpr auto options() {
        using S = ReinsertionOptions;
        return std::tuple(
            option("min_scaled_jacobian", &S::min_scaled_jacobian, "of new elements, unless they were not valid before")
                .at_least(0)
                .below(1),
            option("target", &S::target, "of new elements the scaled Jacobian, unless one before is worse")
                .at_least(0)
                .below(1),
            option("max_sweeps", &S::max_sweeps,
                   "sweeps over the vertices; after the first only those with nodes that neighbours kept from their "
                   "places")
                .at_least(1)
                .at_most(1000));
    }
    friend bool operator==(const ReinsertionOptions&, const ReinsertionOptions&) = default;
};

/// What the walk over the vertices made.
template <int D>
struct Reinserted {
    Proposal<D> proposal;  ///< what the cavities made of the wanted nodes
    PassStatistics statistics;
    std::size_t sweeps = 0;
    std::size_t left = 0;  ///< vertices that had reason for another sweep when max_sweeps ended it
};

/// The paper's global algorithm (§4): every vertex is put in again where it is, with its ball as the cavity (§3.2), and
/// the nodes of its edges go to where `wanted` has them, as far as elements stay valid: all of the way, or by halves of
/// it. Those that other nodes keep back have another sweep once these have moved. No element is worse for it than the
/// worst of its cavity, unless it is good, and none is invalid that was not. `wanted`: of `curve`, a row an edge; the
/// kind `fixed` stays. `breaks`: see make_dynamic. `field`: by which elements are judged. Edges that no element holds
/// go to their places straight away. Threads have no say. Errors: options out of range, a proposal that is not the
/// mesh's, those of make_dynamic; stopped, memory.
template <int D>
[[nodiscard]] Outcome<Reinserted<D>> reinsert(const QuadraticMesh<D>& mesh, const Proposal<D>& wanted,
                                              const BreaksOfMesh& breaks, const BackMesh<D>& field,
                                              const ReinsertionOptions& options, const Execution& execution);

}  // namespace camber

namespace camber {

/// Vertices of surfaces and lines that are off the geometry go onto it, as far as elements around them bear it: their
/// cavities grow where that helps. Those that cannot go all of the way yet stay `off_geometry`. Errors: of run_pass.
template <int D>
[[nodiscard]] Outcome<PassStatistics> snap_to_geometry(Adaptation<D>& r, const AdaptationGoal<D>& goal,
                                                       const Execution& execution);

}  // namespace camber
