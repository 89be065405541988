// Options and interfaces of passes, `remesh_to_metric` and reinsertion.
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

template <int D>
struct Adapted {
    Adaptation<D> state;
    PassStatistics statistics;
};

/// Splits edges longer than `longest` in halves of equal metric length. The longest edge is first.
struct SplitOptions {
    double longest = longest_unit_edge;
    /// Minimum length of new edges. If the split edge has a length l above 2, it is multiplied by (2/l)², because
    /// collapses repair short edges, but only splits repair long ones.
    double shortest = 0.61;
    /// Minimum quality of new elements, unless removed ones are worse. If the split edge is longer than 4, the minimum
    /// is at most 0.02.
    double min_quality = 0.05;

    [[nodiscard]] static constexpr auto options() {
        using S = SplitOptions;
        return std::tuple(
            option("longest", &S::longest, "edges longer than this are split").unit("lengths in the metric").above(0),
            option("shortest", &S::shortest,
                   "smallest length of new edges; reduced by the factor (2/length)² when an edge longer than 2 is "
                   "split")
                .unit("lengths in the metric")
                .at_least(0),
            option("min_quality", &S::min_quality,
                   "smallest quality of new elements, unless the replaced elements are worse; at most 0.02 when an "
                   "edge longer than 4 is split")
                .at_least(0)
                .below(1));
    }
    friend bool operator==(const SplitOptions&, const SplitOptions&) = default;
};
template <int D>
[[nodiscard]] Outcome<Adapted<D>> split(Adaptation<D> state, const AdaptationGoal<D>& goal, const SplitOptions& options,
                                        const Execution& execution);

/// Collapses edges shorter than `shortest`. The shortest edge is first. The default gives a mean length of about 1,
/// because edges slightly longer than 1 also remain.
struct CollapseOptions {
    double shortest = 0.73;
    double longest = longest_unit_edge;
    double min_quality = 0.1;  ///< minimum quality of new elements, unless removed ones are worse
    double distance = 0.2;     ///< limit of `distance_from_geometry` for new facets
    int bend_around = 0;       ///< degree 2, see `PatchLimits::bend_around`

    [[nodiscard]] static constexpr auto options() {
        using S = CollapseOptions;
        return std::tuple(
            option("shortest", &S::shortest, "edges shorter than this are collapsed")
                .unit("lengths in the metric")
                .above(0),
            option("longest", &S::longest, "largest length of new edges").unit("lengths in the metric").above(0),
            option("min_quality", &S::min_quality,
                   "smallest quality of new elements, unless the replaced elements "
                   "are worse")
                .at_least(0)
                .below(1),
            option("distance", &S::distance,
                   "largest distance of a new facet from the geometry, as a share of its longest edge, unless a "
                   "replaced facet is farther")
                .above(0),
            option("neighbour_edges", &S::bend_around,
                   "degree 2 only: number of edges around a cavity whose nodes may also move if nodes inside do not "
                   "make its elements valid. 0: none")
                .at_least(0)
                .at_most(64));
    }
    friend bool operator==(const CollapseOptions&, const CollapseOptions&) = default;
};
template <int D>
[[nodiscard]] Outcome<Adapted<D>> collapse(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                           const CollapseOptions& options, const Execution& execution);

/// Swaps edges and faces of elements below the target quality: joins the elements at the edge or face to the vertex for
/// which the worst element becomes best.
struct SwapOptions {
    double target_quality = 0.7;
    double gain = 1.02;     ///< minimum ratio of the worst quality after a swap to that before
    double distance = 0.2;  ///< limit of `distance_from_geometry` for new facets

    [[nodiscard]] static constexpr auto options() {
        using S = SwapOptions;
        return std::tuple(
            option("target_quality", &S::target_quality, "elements of a better quality are not changed")
                .above(0)
                .at_most(1),
            option("gain", &S::gain, "smallest ratio of the worst quality after an operation to that before")
                .at_least(1),
            option("distance", &S::distance,
                   "largest distance of a new facet from the geometry, as a share of its longest edge, unless a "
                   "replaced facet is farther")
                .above(0));
    }
    friend bool operator==(const SwapOptions&, const SwapOptions&) = default;
};
template <int D>
[[nodiscard]] Outcome<Adapted<D>> swap(Adaptation<D> state, const AdaptationGoal<D>& goal, const SwapOptions& options,
                                       const Execution& execution);

enum class SmoothedNodes : std::uint8_t {
    objective,   ///< nodes of edges at a moved vertex get the positions that the goal gives to new edges
    distortion,  ///< nodes also move to reduce distortion, see `smooth_nodes`
};
[[nodiscard]] constexpr auto words(SmoothedNodes) {
    return words_of(Word{SmoothedNodes::objective, "objective"}, Word{SmoothedNodes::distortion, "distortion"});
}

/// Moves vertices so that edge lengths approach 1 and the worst element improves. Boundary vertices move along the
/// geometry or, without one, along planes and straight lines. First, `snap_to_geometry` moves vertices onto the
/// geometry.
struct SmoothOptions {
    double target_quality = 0.8;
    double gain = 1.01;
    int sweeps = 2;
    SmoothedNodes nodes = SmoothedNodes::objective;

    [[nodiscard]] static constexpr auto options() {
        using S = SmoothOptions;
        return std::tuple(
            option("target_quality", &S::target_quality, "elements of a better quality are not changed")
                .above(0)
                .at_most(1),
            option("gain", &S::gain, "smallest ratio of the worst quality after an operation to that before")
                .at_least(1),
            option("sweeps", &S::sweeps, "number of sweeps over the vertices, and of sweeps over the nodes")
                .at_least(0)
                .at_most(100),
            option("nodes", &S::nodes,
                   "degree 2 only. objective: nodes of inner edges follow the vertices to the positions of their "
                   "objective; distortion: nodes then also move to reduce the distortion of the elements around them"));
    }
    friend bool operator==(const SmoothOptions&, const SmoothOptions&) = default;
};
template <int D>
[[nodiscard]] Outcome<Adapted<D>> smooth(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                         const SmoothOptions& options, const Execution& execution);

/// Sweeps over elements below the target quality. A sweep swaps edges and faces, and moves and removes vertices.
struct MendOptions {
    double target_quality = 0.5;
    int sweeps = 4;

    [[nodiscard]] static constexpr auto options() {
        using S = MendOptions;
        return std::tuple(
            option("target_quality", &S::target_quality, "elements of a better quality are not changed")
                .above(0)
                .at_most(1),
            option("sweeps", &S::sweeps, "number of sweeps of swaps and moves").at_least(0).at_most(1000));
    }
    friend bool operator==(const MendOptions&, const MendOptions&) = default;
};
template <int D>
[[nodiscard]] Outcome<Adapted<D>> mend(Adaptation<D> state, const AdaptationGoal<D>& goal, const MendOptions& options,
                                       const Execution& execution);

/// Rounds of collapse, split, swap and smooth, then mending of bad elements. All rounds except the last use wider
/// length limits:
/// - Collapses may create longer edges, which splits then halve. With a limit of √2, most short edges would stay.
/// - Splits do not halve slightly long edges. Most get shorter anyway, and their halves would lower the mean length
///   below 1.
/// - Splits do not create edges that a collapse would remove.
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
                   "largest length of edges that collapses create in all rounds except the last, if collapse/longest "
                   "is smaller")
                .unit("lengths in the metric")
                .at_least(0),
            option("early_split_longest", &S::early_split_longest,
                   "edges longer than this are split in all rounds except the last, if split/longest is smaller")
                .unit("lengths in the metric")
                .at_least(0),
            option("early_split_shortest", &S::early_split_shortest,
                   "smallest length of edges that splits create in all rounds except the last, if split/shortest is "
                   "smaller")
                .unit("lengths in the metric")
                .at_least(0),
            option("collapse", &S::collapse, "options of the stage collapse"),
            option("split", &S::split, "options of the stage split"),
            option("swap", &S::swap, "options of the stage swap"),
            option("smooth", &S::smooth, "options of the stage smooth"),
            option("improve", &S::mend, "options of the stage improve, which runs last"),
            option("rounds", &S::rounds, "largest number of rounds of collapse, split, swap and smooth")
                .at_least(0)
                .at_most(1000),
            option("min_change", &S::min_change,
                   "rounds end when one raises the share of unit edges by less than this, and adds or removes a "
                   "smaller share of vertices")
                .at_least(0)
                .at_most(1));
    }
    friend bool operator==(const ToMetricOptions&, const ToMetricOptions&) = default;
};

struct ToMetricStatistics {
    int rounds = 0;
    PassStatistics collapse, split, swap, smooth, mend;
    UnitMeshStatistics before, after;
};

template <int D>
struct RemeshResult {
    Adaptation<D> state;
    ToMetricStatistics statistics;
};

/// Errors: options out of range, those of the passes.
template <int D>
[[nodiscard]] Outcome<RemeshResult<D>> remesh_to_metric(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                                        const ToMetricOptions& options, const StepWrapper& around);
template <int D>
[[nodiscard]] Outcome<RemeshResult<D>> remesh_to_metric(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                                        const ToMetricOptions& options, const Execution& execution) {
    return remesh_to_metric(std::move(state), goal, options, without_wrapper(execution));
}

/// Operations allowed to meet distance bounds. `any`: no restriction. `near_metric`: splits halve an edge at most once,
/// and no element gets worse than quality 0.2.
enum class BoundaryEffort : std::uint8_t { any, near_metric };

/// Refines the boundary until every facet meets the goal's `distance_bounds`. Each round splits and swaps facets beyond
/// their bounds. It then swaps, smooths and mends all elements, and keeps facets within their bounds. Ends early
/// without progress, or after `max_bound_rounds`. Does not set the lengths in `statistics`. Errors: options out of
/// range, those of the passes.
template <int D>
[[nodiscard]] Outcome<RemeshResult<D>> refine_to_bounds(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                                        const ToMetricOptions& options, BoundaryEffort effort,
                                                        const StepWrapper& around);
inline constexpr int max_bound_rounds = 8;

/// Number of facets beyond the goal's bounds (`bound_shares`). Errors: stopped.
template <int D>
[[nodiscard]] Outcome<std::size_t> count_far_facets(const Adaptation<D>& r, const AdaptationGoal<D>& goal,
                                                    const Execution& execution);

struct NodeMoves {
    std::size_t tried = 0, moved = 0;
};

/// Degree 2: moves nodes of inner edges to reduce the distortion of elements in the metric of their vertices
/// (camber.metric:unit_mesh). The worst element at a node never gets worse. Skips edges whose elements all reach the
/// target quality, and edges of interfaces and of required or invalid elements. Certificates prove that det J of
/// changed elements is above 0.1 times the straight determinant, or above 0 if it was lower before. The result is the
/// same as if the edges were processed one after another, in the order of `spread_rank`. Errors: options out of range,
/// stopped, memory.
template <int D>
[[nodiscard]] Outcome<NodeMoves> smooth_nodes(Adaptation<D>& r, const SmoothOptions& options,
                                              const Execution& execution);

struct ReinsertionOptions {
    double min_scaled_jacobian = min_bound;
    double target = 0.01;
    /// Maximum number of sweeps over vertices. The first sweep visits all vertices with an edge whose node is off its
    /// target, inner vertices first. Later sweeps visit only those at elements that have changed.
    int max_sweeps = 100;

    [[nodiscard]] static constexpr auto options() {
        using S = ReinsertionOptions;
        return std::tuple(
            option("min_scaled_jacobian", &S::min_scaled_jacobian,
                   "smallest scaled Jacobian of new elements, unless "
                   "the elements before were not valid")
                .at_least(0)
                .below(1),
            option("target", &S::target,
                   "scaled Jacobian that new elements should reach, unless an element before is "
                   "worse")
                .at_least(0)
                .below(1),
            option("max_sweeps", &S::max_sweeps,
                   "largest number of sweeps over the vertices. Sweeps after the first visit only vertices with nodes "
                   "that did not reach their targets")
                .at_least(1)
                .at_most(1000));
    }
    friend bool operator==(const ReinsertionOptions&, const ReinsertionOptions&) = default;
};

template <int D>
struct ReinsertionResult {
    Proposal<D> proposal;  ///< nodes after all operations
    PassStatistics statistics;
    std::size_t sweeps = 0;
    std::size_t left = 0;  ///< vertices that another sweep would visit
};

/// The paper's global algorithm (§4): reinserts every vertex at its position, with all elements around it as the cavity
/// (§3.2). Edge nodes move to their targets or, if elements would become invalid, half or none of the way. No element
/// becomes invalid. An element may get worse than the worst one of its cavity only if its quality stays sufficient.
///
/// `target`: result of `curve`, one row for each edge (kind `fixed` does not change). `breaks`: as in `make_dynamic`.
/// `field`: metric for qualities. Nodes of edges without elements move directly to their targets. The result does not
/// depend on the number of threads. Errors: options out of range, a proposal of another mesh, those of `make_dynamic`;
/// stopped, memory.
template <int D>
[[nodiscard]] Outcome<ReinsertionResult<D>> reinsert(const QuadraticMesh<D>& mesh, const Proposal<D>& target,
                                                     const BreaksOfMesh& breaks, const BackMesh<D>& field,
                                                     const ReinsertionOptions& options, const Execution& execution);

}  // namespace camber

namespace camber {

/// Moves vertices of surfaces and lines onto the geometry, as far as their elements allow. Vertices that do not reach
/// the geometry stay in `off_geometry`. Errors: those of `run_pass`.
template <int D>
[[nodiscard]] Outcome<PassStatistics> snap_to_geometry(Adaptation<D>& r, const AdaptationGoal<D>& goal,
                                                       const Execution& execution);

}  // namespace camber
