module;
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>
export module camber.recipes:step_reports;
import camber.core;
import camber.operation;
import camber.curving;
import :fields;

/// Results of the steps of a run, as reports have them.
export namespace camber::run {

/// Volume edges on the true field, by a 12-point rule: length reduction L_straight/L − 1 (paper eq. 8) and curvature
/// |P^l − M_11|/|P_20 − P_02|.
struct EdgeReport {
    double mean_length_reduction = 0, largest_length_reduction = 0;
    double mean_curvature = 0, largest_curvature = 0;
    std::size_t measured = 0, longer = 0;

    static void fields(auto& s, auto& f) {
        f("mean_length_reduction", s.mean_length_reduction, "mean of L_straight/L − 1 over volume edges", unit("1"),
          of_volume);
        f("largest_length_reduction", s.largest_length_reduction, "largest L_straight/L − 1 of a volume edge",
          unit("1"), of_volume);
        f("mean_curvature", s.mean_curvature,
          "mean distance of an edge's node from the middle of its chord, divided by the chord's length", unit("1"));
        f("largest_curvature", s.largest_curvature, "largest such distance", unit("1"));
        f("measured_edges", s.measured,
          "number of edges whose lengths were measured: all volume edges, about 131 072 in a larger mesh, or all if "
          "the output shows fields",
          of_volume);
        f("longer_edges", s.longer,
          "number of edges that are longer than their chords in the metric; with the criterion accuracy this is no "
          "defect",
          of_volume);
    }
};

struct MeshReport {
    int dimension = 3, degree = 1;
    std::size_t vertices = 0, nodes = 0, elements = 0, facets = 0, feature_edges = 0;

    /// A surface in space without elements; its triangles are validated.
    [[nodiscard]] bool is_standalone_surface() const { return dimension == 3 && elements == 0 && facets > 0; }
    [[nodiscard]] std::size_t judged() const { return is_standalone_surface() ? facets : elements; }
    [[nodiscard]] int judged_dimension() const { return is_standalone_surface() ? 2 : dimension; }

    static void fields(auto& s, auto& f) {
        f("dimension", s.dimension, "2 or 3");
        f("degree", s.degree, "degree of the elements: 1 or 2");
        f("vertices", s.vertices, "number of vertices");
        f("nodes", s.nodes, "number of nodes: vertices and, in degree 2, one node per edge");
        f("elements", s.elements, "number of elements: triangles in 2D, tetrahedra in 3D");
        f("facets", s.facets, "number of edges (2D) or triangles (3D) of the boundary and of interfaces");
        f("feature_edges", s.feature_edges, "3D: number of edges that the file lists");
        f("standalone_surface", s.is_standalone_surface(), "true: a surface in space without elements", unless_empty);
    }
};

struct GradationReport {
    int sweeps = 0;
    std::size_t changed = 0;
    bool converged = true;

    static void fields(auto& s, auto& f) {
        f("sweeps", s.sweeps, "number of sweeps over all edges, of an operation `gradation`");
        f("changed_vertices", s.changed, "number of vertices whose metric was refined");
        f("converged", s.converged, "false: the limit of sweeps was reached before the gradation was satisfied");
    }
};

struct MetricReport {
    std::string source;
    double largest_anisotropy = 1;
    double complexity = 0;
    std::vector<GradationReport> gradations;
    std::size_t floored = 0;

    static void fields(auto& s, auto& f) {
        f("source", s.source, "`natural` (mesh-implied), or the source that the config names");
        f("largest_anisotropy", s.largest_anisotropy, "largest ratio of the longest to the shortest size at a vertex",
          unit("1"));
        f("complexity", s.complexity, "∫ √det M: proportional to the number of elements of unit size", unit("1"));
        f("corrected_tensors", s.floored,
          "number of tensors of the file that rounding had made indefinite; they were corrected");
        f("gradations", s.gradations, "one entry for each operation `gradation`", unless_empty);
    }
};

struct NodesByReport {
    std::string metric_kind;
    double size_share = 0;
    std::size_t walls = 0, metric = 0, loss_limited = 0;

    static void fields(auto& s, auto& f) {
        f("metric_kind", s.metric_kind, "kind of the metric that places nodes");
        f("size_share", s.size_share, "share σ of the metric’s sizes by which nodes may move", unit("1"));
        f("moved_by_walls", s.walls, "number of inner nodes that curved walls move by more than 1/1000 of the chord");
        f("moved_by_metric", s.metric, "number of inner nodes that the metric moves by more than 1/1000 of the chord");
        f("limited", s.loss_limited,
          "number of inner nodes that move by less than half of the way to their targets, since smooth functions would "
          "lose more than `max_smooth_error_increase`");
    }
};

struct ExpectedErrorsReport {
    double before = 0, after = 0;
    int rounds = 0;

    static void fields(auto& s, auto& f) {
        f("by_shape", s.before,
          "expected L2 error of the interpolated solution with nodes by the objective `shape`, for fields scaled to "
          "ranges of about 1");
        f("by_solution", s.after, "expected error with nodes by the objective `solution`");
        f("rounds", s.rounds, "number of rounds");
    }
};

struct CurveReport : CurveStatistics {
    std::size_t edges = 0;
    EdgeReport before = {};
    std::optional<NodesByReport> by = {};
    std::optional<ExpectedErrorsReport> expected = {};
    std::optional<EdgeReport> after = {};
    std::optional<EdgeReport> in_straight_field = {};
    double edges_per_second = 0;
    std::string objective = {};  ///< as in the config

    static void fields(auto& s, auto& f) {
        f("edges", s.edges, "number of edges");
        f("volume_edges", s.volume_edges, "number of edges inside the volume", of_volume);
        f("curved_edges", s.curved_edges, "number of edges whose node is not in the middle of the chord");
        f("pattern_searches", s.polished,
          "criteria energy and length: number of searches that stopped at a kink of the field and were completed by a "
          "pattern search",
          of_volume);
        f("not_converged", s.exhausted,
          "criteria energy and length: number of searches that reached the limit of iterations", of_volume);
        f("shortened", s.shortened,
          "criteria energy and length: number of edges whose offset was reduced, since the finer rule found them "
          "longer than their chords",
          of_volume);
        f("outside", s.outside, "number of edges with samples outside the back mesh", of_volume);
        f("not_located", s.lost, "number of edges with samples that were not located in the back mesh", of_volume);
        f("limited_nodes", s.relaxed,
          "criterion accuracy: number of nodes, in the volume or sliding within planes, that move only a part of the "
          "way, since an element would fall below `min_jacobian`",
          of_volume);
        f("edges_per_second", s.edges_per_second, "edges curved per second", unit("1/s"), of_volume);
        f("before_correction", s.before, "lengths and curvatures as `curve` proposed them");
        f("inner_nodes", s.by, "inner nodes for accuracy", of_volume);
        f("expected_error", s.expected, "expected error of the solution (objective `solution`)", of_volume);
        f("after_correction", s.after, "lengths and curvatures that `relax` left");
        f("in_straight_field", s.in_straight_field,
          "the same in the field of the straight back mesh, if the back mesh is curved", of_volume);
    }
};

struct ValidityReport {
    double bound = 0;
    bool is_explicit = false;
    std::size_t invalid = 0, undecided = 0, below_bound = 0, straight_inverted = 0;
    double smallest = 1;
    std::size_t worst = 0;
    std::uint64_t worst_tag = 0;

    static void fields(auto& s, auto& f) {
        f("bound", s.bound, "lower bound of the scaled Jacobian that is required or recommended", unit("1"));
        f("bound_is_required", s.is_explicit, "true: the bound is required; false: it is recommended");
        f("invalid", s.invalid, "number of elements where det J ≤ 0 at a point");
        f("undecided", s.undecided, "number of elements without a certified answer");
        f("below_bound", s.below_bound,
          "number of valid elements whose scaled Jacobian is not certified to reach the bound");
        f("straight_inverted", s.straight_inverted, "number of elements that are inverted or flat with straight edges");
        f("min_scaled_jacobian", s.smallest, "lower bound of the scaled Jacobian over all elements, to 10⁻³",
          unit("1"));
        f("worst_element", s.worst, "element with this bound, from 1; 0: no element");
        f("worst_element_tag", s.worst_tag, "its number in the input's file, if it differs", unless_empty);
    }
};

struct RelaxReport {
    std::string method;
    std::size_t corrected_elements = 0, raised_elements = 0;
    std::size_t relaxed_volume_edges = 0, relaxed_surface_edges = 0, slid_surface_edges = 0;
    std::size_t moved_vertices = 0, slid_vertices = 0;
    double work = 0;
    std::size_t unresolved = 0;

    static void fields(auto& s, auto& f) {
        f("method", s.method,
          "method of the correction: `extension`, `cavity`, `edge`, `segment` or `backtracking` "
          "([repair.md](algorithms/repair.md))");
        f("corrected_elements", s.corrected_elements, "number of elements that the correction made valid");
        f("raised_elements", s.raised_elements,
          "number of elements, already valid, whose scaled Jacobian was raised to the target");
        f("relaxed_volume_edges", s.relaxed_volume_edges, "number of edges inside the volume whose node was moved");
        f("relaxed_surface_edges", s.relaxed_surface_edges,
          "number of boundary edges whose node was moved towards the chord");
        f("slid_surface_edges", s.slid_surface_edges,
          "number of other boundary edges whose node slid on the geometry ([cad.md](algorithms/cad.md))");
        f("moved_vertices", s.moved_vertices, "number of vertices that were moved");
        f("slid_vertices", s.slid_vertices, "number of these on the boundary; they slid on a prescribed geometry");
        f("work", s.work, "solved optimisation problems, in the unit of the option `effort`");
        f("unrepaired_elements", s.unresolved,
          "number of elements that are not repaired because the limit of work was "
          "reached");
    }
};

struct InputBoundaryReport {
    double tolerance = 0;
    std::optional<double> sufficient_tolerance = {};
    std::size_t moved_nodes = 0;
    double largest_shift = 0, largest_relative_shift = 0;

    static void fields(auto& s, auto& f) {
        f("tolerance", s.tolerance, "limit of the moves of boundary nodes, for a mesh that was read with its curves",
          unit("length"));
        f("sufficient_tolerance", s.sufficient_tolerance,
          "tolerance with which all remaining elements become valid, verified by a trial, if no geometry is "
          "prescribed; null: none is known",
          unit("length"), or_null);
        f("moved_nodes", s.moved_nodes, "number of boundary nodes that moved");
        f("largest_shift", s.largest_shift, "largest move of a node", unit("length"));
        f("largest_relative_shift", s.largest_relative_shift, "largest move divided by the chord's length", unit("1"));
    }
};

struct RemainingReport {
    std::size_t element = 0;
    std::string reason;
    std::size_t at = 0;          ///< vertex of the cause, from 1; 0: none, or the reason names it
    bool is_unresolved = false;  ///< the limit of work was reached; false if the reason names it
    std::uint64_t tag = 0;

    static void fields(auto& s, auto& f) {
        f("element", s.element, "element that could not be repaired, from 1");
        f("tag", s.tag, "its number in the input's file, if it differs", unless_empty);
        f("reason", s.reason, "reason, in words, with the vertex numbers of the input's file");
    }
};

struct ReinsertReport {
    std::size_t sweeps = 0, rounds = 0, patches = 0;
    std::size_t rejected_not_valid = 0, rejected_no_gain = 0;

    static void fields(auto& s, auto& f) {
        f("sweeps", s.sweeps, "number of sweeps of the stage `reinsert` over the vertices");
        f("rounds", s.rounds, "number of rounds of cavities that do not overlap");
        f("patches", s.patches, "number of cavities that were committed");
        f("rejected_not_valid", s.rejected_not_valid, "number of cavities rejected for invalid elements");
        f("rejected_no_gain", s.rejected_no_gain, "number of cavities rejected because nothing improves");
    }
};

/// Closeness of the straight mesh to a unit mesh (metric:unit_mesh).
struct UnitMeshNumbers {
    std::size_t edges = 0, unit_edges = 0, short_edges = 0, long_edges = 0;
    double shortest = 0, longest = 0, mean_length = 0;
    double worst_quality = 0, mean_quality = 0;
    std::size_t worst_element = 0;
};
struct UnitMeshReport : UnitMeshNumbers {
    std::string metric = {};

    static void fields(auto& s, auto& f) {
        f("metric", s.metric, "metric: a file, or its source");
        f("edges", s.edges, "number of edges");
        f("unit_edges", s.unit_edges, "number of edges of a length from 1/√2 to √2 in the metric");
        f("short_edges", s.short_edges, "number of edges shorter than 1/√2");
        f("long_edges", s.long_edges, "number of edges longer than √2");
        f("shortest", s.shortest,
          "length of the shortest edge in the metric: (a − b)/ln(a/b) of its lengths a, b by the metrics of both ends; "
          "degree 2: along the curves",
          unit("1"));
        f("longest", s.longest, "length of the longest edge in the metric", unit("1"));
        f("mean_length", s.mean_length, "mean length of edges in the metric", unit("1"));
        f("min_quality", s.worst_quality,
          "minimum mean ratio of an element in the metric: 1 unit, 0 flat. Degree 2: by the [mean "
          "distortion](algorithms/distortion.md), 0: not valid",
          unit("1"));
        f("mean_quality", s.mean_quality, "mean of these ratios", unit("1"));
        f("worst_element", s.worst_element, "element with the minimum quality, from 1; 0: no element");
    }
};

struct PassReport : PassStatistics {
    std::string pass = {};
    double seconds = 0;

    [[nodiscard]] std::vector<std::pair<std::string, std::size_t>> rejected_by_reason() const;
    static void fields(auto& s, auto& f) {
        f("pass", s.pass,
          "`collapse`, `split`, `swap`, `smooth` or `improve`; all passes of the kind are counted "
          "together");
        f("rounds", s.rounds, "number of commits");
        f("proposals", s.proposals, "number of proposed operations");
        f("planned", s.planned,
          "number of proposed operations that satisfy the pass's own criteria of length and shape");
        f("accepted", s.accepted, "number of operations that were carried out");
        f("rejected", s.rejected_by_reason(),
          "number of operations that were rejected, by reason: `empty`, `required`, `surface`, `line`, `ball` and "
          "`exists` (topology), `volume`, `quality`, `length`, `height`, `geometry`, `wall`, `crossing`, `gain` (no "
          "noticeable change), `deferred` (counted again later) ([cavity-operator.md](algorithms/cavity-operator.md))");
        f("corrections", s.corrections, "number of times that elements joined or left a cavity");
        f("shortened", s.shortened, "number of trials in which a point moved only a part of the way to the geometry");
        f("off_target", s.relaxed, "degree 2: number of operations whose nodes are off the targets of the metric");
        f("neighbour_moves", s.bent_around, "degree 2: number of operations that also move nodes around their cavity");
        f("optimisation_problems", s.optimisation_problems,
          "degree 2: number of optimisation problems solved for nodes");
        f("moved_nodes", s.moved_nodes, "degree 2: number of nodes of inner edges that `smooth` moved by distortion");
        f("straight_inverted", s.straight_inverted,
          "degree 2: number of accepted operations that a test of straight elements would reject");
        f("straight_positive", s.straight_positive,
          "degree 2: number of operations rejected as `volume` that this test would accept");
        f("farthest_facet", s.farthest_facet,
          "largest distance from the geometry of a facet made by a swap or a collapse, divided by its longest edge",
          unit("1"));
        f("seconds", s.seconds, "elapsed time", unit("s"));
    }
};

struct RemeshedNodesReport {
    std::string objective;

    static void fields(auto& s, auto& f) {
        f("objective", s.objective, "degree 2: objective of the nodes of inner edges");
    }
};

struct BoundedFacetsReport {
    std::size_t limited = 0, far = 0;

    static void fields(auto& s, auto& f) {
        f("limited_facets", s.limited,
          "number of facets that the [default bound](algorithms/cavity-operator.md#the-default-bound) makes finer than "
          "the metric requests: edges below 0.73, and a facet of twice the size would exceed the bound. Only for a "
          "mesh on one process");
        f("facets_beyond_bound", s.far, "number of facets that exceed the bound, as did facets of the mesh before");
    }
};

struct RemeshReport {
    UnitMeshReport before, after;
    std::vector<PassReport> passes;
    std::optional<RemeshedNodesReport> nodes = {};
    std::optional<BoundedFacetsReport> bounded_facets = {};

    static void fields(auto& s, auto& f) {
        f("before", s.before, "the mesh before the passes, measured in the metric");
        f("after", s.after, "the mesh after the passes, measured in the metric");
        f("passes", s.passes, "one entry for each kind of pass");
        f("nodes", s.nodes, "nodes of inner edges");
        f("geometry_bound", s.bounded_facets, "facets where the default distance bound acts");
    }
};

}  // namespace camber::run
