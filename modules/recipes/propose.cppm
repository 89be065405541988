module;
#include <cstdint>
#include <optional>
#include <span>
#include <tuple>
export module camber.recipes:propose;
import camber.core;
import camber.bezier;
import camber.curving;
import camber.metric;
import camber.optimisation;
import camber.surface;
import :boundary;
import :curve_input;
import :known_solution;
import :metric_source;

export namespace camber {

/// What places volume nodes: `curve` of camber.curving by one of its aims, its `shape`, or its `solution_nodes`.
enum class Objective : std::uint8_t { accuracy, energy, length, shape, solution };
[[nodiscard]] constexpr auto words(Objective) {
    return words_of(Word{Objective::accuracy, "accuracy"}, Word{Objective::energy, word_of(EdgeObjectiveKind::energy)},
                    Word{Objective::length, word_of(EdgeObjectiveKind::length)}, Word{Objective::shape, "shape"},
                    Word{Objective::solution, "solution"});
}

/// Where the metric is read.
enum class BackMeshKind : std::uint8_t {
    curved,    ///< in a mesh of degree 2 that goes along with walls that sag, see back_mesh_nodes of camber.curving
    straight,  ///< in the straight mesh (paper §1.2)
};
[[nodiscard]] constexpr auto words(BackMeshKind) {
    return words_of(Word{BackMeshKind::curved, "curved"}, Word{BackMeshKind::straight, "straight"});
}

/// The options of `curve`, and what chooses between its aims and `shape`.
struct ProposeOptions : CurveOptions, PlacementOptions {
    Objective objective = Objective::accuracy;
    BackMeshKind back_mesh = BackMeshKind::curved;

    [[nodiscard]] static constexpr auto options() {
        using S = ProposeOptions;
        return std::tuple_cat(
            std::tuple(
                option(
                    "objective", &S::objective,
                    "what edges are curved for: accuracy, that what the metric belongs to is interpolated well; energy "
                    "or "
                    "length, that this is least in the metric (energy: smooth, evenly spaced); shape: no metric, the "
                    "Jacobians of elements are made as even as may be; solution: that the run's solution is "
                    "interpolated "
                    "well, no metric"),
                option("back_mesh", &S::back_mesh,
                       "where the metric is read: curved, in a mesh that goes along with walls that sag by more "
                       "than a little of its sizes, and nodes start from there; straight, at its point's place "
                       "in the straight mesh, as in the paper")),
            PlacementOptions::options(), CurveOptions::options());
    }
    friend bool operator==(const ProposeOptions&, const ProposeOptions&) = default;
};

/// Those for one edge: the aim is the objective's.
[[nodiscard]] CurveOptions edge_options(const ProposeOptions& options);

/// Whether edges follow a metric.
[[nodiscard]] constexpr bool has_field(Objective objective) {
    return objective != Objective::shape && objective != Objective::solution;
}

/// The expected error of a solution: of one field weight · L2 error in the user's unit, of several the root of
/// Σ (weight · L2 error)², each in a unit in which its range is about 1. With the nodes of the objective shape, and
/// with those that were found.
struct ExpectedErrors {
    double before = 0, after = 0;
    int rounds = 0;
};

/// Where the nodes of a mesh are wanted, before any correction, and what they were found from.
template <int D>
struct ProposedCurves {
    Curved<D> curved;
    CurveInput<D> input;
    std::optional<BackMesh<D>> field;                          ///< none: of the objectives shape and solution
    std::optional<Column<LogMetric<D>>> straight_log_metrics;  ///< at the vertices, of the straight mesh where the
                                                               ///< field is another
    CurveOptions edges = {};                                   ///< by which nodes were found: see accuracy_for
    std::optional<ExpectedErrors> expected = {};               ///< of the objective solution
};

/// Steps: extension, then metric where edges follow one, and curve. Errors (usage): the objectives
/// shape and solution with boundary nodes by length, solution without fields; those of the metric, of `known_solution`;
/// stopped; memory.
template <int D>
[[nodiscard]] Outcome<ProposedCurves<D>> propose_curves(const CurvedFrom<D>& from, const MetricSource<D>& metric,
                                                        const GivenSolution<D>& solution, const ProposeOptions& options,
                                                        const Around& around);

}  // namespace camber

namespace camber {

/// What a curving begins with: the input with its base where the field has nodes, and the field.
template <int D>
struct CurvingStart {
    CurveInput<D> input;
    std::optional<BackMesh<D>> field;
    std::optional<Column<LogMetric<D>>> straight_log_metrics;
    CurveOptions edges = {};  ///< for one edge, of this metric: see accuracy_for
};
/// The steps extension and, where edges follow one, metric.
template <int D>
[[nodiscard]] Outcome<CurvingStart<D>> begin_curving(const CurvedFrom<D>& from, const MetricSource<D>& metric,
                                                     const ProposeOptions& options, const Around& around);

/// Nodes of boundary edges where the options want them in the field: placed_input, slid_input.
template <int D>
[[nodiscard]] Outcome<CurveInput<D>> moved_input(const CurvedFrom<D>& from, CurveInput<D> input,
                                                 const BackMesh<D>& field, const CurveOptions& edges,
                                                 const PlacementOptions& options, const Execution& execution);

}  // namespace camber
