module;
#include <cstddef>
#include <cstdint>
#include <tuple>
export module camber.adapt:passes;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.operation;
import camber.surface;

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
            option("bend_around", &S::bend_around,
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
            option("wanted", &S::wanted, "elements of a better quality are left alone").above(0).at_most(1),
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
            option("wanted", &S::wanted, "elements of a better quality are left alone").above(0).at_most(1),
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
            option("wanted", &S::wanted, "elements of a better quality are left alone").above(0).at_most(1),
            option("sweeps", &S::sweeps, "sweeps of swaps and moves").at_least(0).at_most(1000));
    }
    friend bool operator==(const MendOptions&, const MendOptions&) = default;
};
template <int D>
[[nodiscard]] Outcome<Adapted<D>> mend(Adaptation<D> state, const AdaptationGoal<D>& goal, const MendOptions& options,
                                       const Execution& execution);

}  // namespace camber
