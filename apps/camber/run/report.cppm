module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
export module camber.run:report;
import camber.core;
import camber.interpolation;
import camber.metric;
import camber.validity;
import camber.repair;
import camber.recipes;
import camber.distributed;
import :measurements;

/// What a run tells: plain numbers, printed as a table and written as report.json.
export namespace camber::run {

/// The number of the layout of report.json and of `check --json`: one more when a key goes, or means something else.
inline constexpr int report_format = 4;

/// What a run began with: known to the shell alone.
struct OriginReport {
    std::string version;            ///< of the program
    std::string mesh, metric;       ///< files; empty: generated, and no file
    int dimension = 3, degree = 1;  ///< of the mesh as it was read or generated, before `prepare`
    std::size_t vertices = 0, elements = 0, facets = 0;
    std::string config;    ///< the pipeline with every default, as JSON
    std::string geometry;  ///< "surrogate", "straight", "mesh", "analytic" or "cad"
};

/// Of the volume edges on the true field, by a 12-point rule: length reduction L_straight/L − 1 (paper eq. 8) and
/// curvature |P^l − M_11|/|P_20 − P_02|.
struct EdgeReport {
    double mean_length_reduction = 0, largest_length_reduction = 0;
    double mean_curvature = 0, largest_curvature = 0;
    std::size_t measured = 0;  ///< edges whose lengths are known: what reductions and `longer` are of
    std::size_t longer = 0;    ///< edges that are longer than their chords
};

/// The stages worked in an order of their own: how bad the mesh's is (ordering).
struct ReorderedReport {
    double scatter = 0;
};

struct MeshReport {
    int dimension = 3, degree = 1;
    std::size_t vertices = 0, nodes = 0, elements = 0, facets = 0, feature_edges = 0;

    /// Then what is said of elements is said of its triangles.
    [[nodiscard]] bool is_surface_alone() const { return dimension == 3 && elements == 0 && facets > 0; }
    [[nodiscard]] std::size_t judged() const { return is_surface_alone() ? facets : elements; }
};

struct GradationReport {
    int sweeps = 0;
    std::size_t changed = 0;  ///< vertices whose metric it made smaller
    bool converged = true;    ///< false: out of sweeps
};

struct MetricReport {
    std::string source;
    double largest_anisotropy = 1;
    double complexity = 0;                    ///< ∫ sqrt(det M), after the operations
    std::vector<GradationReport> gradations;  ///< one a gradation, in the config's order
    std::size_t floored = 0;                  ///< tensors of the file that rounding had made indefinite
};

/// A position on the boundary; an invalid one has no coordinates.
using ReportedPlace = std::vector<double>;

/// Number of boundary nodes that `curve` moved back towards their chords until no walls crossed (repair:method).
struct RelaxedWallsReport {
    std::size_t nodes = 0;
    double largest = 0;             ///< distance of a node from its target (model units)
    ReportedPlace largest_at = {};  ///< position of that node
};

/// Pairs of facets that cross, curved as they are in the end (crossing:crossings).
struct WallsReport {
    std::size_t crossing = 0, touching = 0, undecided = 0;
    std::size_t first = 0, other = 0;                ///< the first pair that crosses, from 1; 0: none
    ReportedPlace first_at = {};                     ///< centre of the overlap of their boxes
    std::size_t crossing_before = 0;                 ///< pairs that crossed in the input already
    std::optional<RelaxedWallsReport> relaxed = {};  ///< where nodes were moved back
};

/// Elements that overlap in the end (crossing:crossings).
struct OverlappingReport {
    std::size_t overlapping = 0;  ///< places where they do; 0: none
    std::vector<double> point;    ///< one of them (model units)
};

/// Vertices that were brought onto a CAD model before all else.
struct CadMovesReport {
    std::size_t moved = 0, held = 0;  ///< held: short of their places, since elements do not allow them
    double largest = 0;               ///< of the moves (model units)
};

/// Faces of a CAD model (in 2D edges) that meet smoothly and that a mesh treats as one, by their numbers from 1.
struct JoinedFacesReport {
    bool are_edges = false;
    std::vector<std::vector<std::size_t>> lists = {};
};

/// Facets of a mesh that span ridges of a CAD model.
struct AcrossRidgesReport {
    std::size_t count = 0;
    std::size_t first = 0;           ///< from 1; 0: none
    std::vector<double> place = {};  ///< of the ridge that this one spans
};

/// What a mesh's boundary met of a CAD model.
struct CadReport {
    std::string unit, file_unit;  ///< of the mesh's coordinates; as the file calls its own, empty: it says none
    bool is_in_file_unit = true;
    bool is_unit_found = false;                      ///< by the mesh's boundary, another one than the file's
    std::size_t faces = 0, edges = 0, vertices = 0;  ///< of the model
    std::size_t faces_met = 0, edges_met = 0, vertices_met = 0;         ///< those with something of the mesh on them
    std::size_t facets = 0, analytic_facets = 0, surrogate_facets = 0;  ///< of the mesh, by what they lie on
    std::vector<Reference> within_materials = {};  ///< of facets off the model, with one material on both sides
    std::size_t coincident_facets = 0;             ///< another face is at the same place
    std::size_t doubtful_facets = 0, settled_facets = 0, doubtful_edges = 0, doubtful_vertices = 0;
    double largest_vertex_distance = 0;           ///< (model units)
    std::optional<double> largest_node_distance;  ///< of boundary edges, in the end (model units)
    std::optional<CadMovesReport> moves = {};
    std::size_t lost_faces = 0, failed_entities = 0, open_shells = 0;  ///< of the file, and not in the model
    JoinedFacesReport joined = {};
    AcrossRidgesReport across = {};
};

/// Vertices that are not on the analytic surface of their facets' reference, and stay where they are.
struct OffSurfacesReport {
    std::size_t vertices = 0;
    double largest = 0;  ///< distance (model units)
};

/// Deviation of the boundary's nodes, or of its vertices, from the geometry (surface:boundary_deviation).
struct DeviationReport {
    std::size_t measured = 0, off = 0;  ///< off: farther than the tolerance
    double largest = 0;                 ///< largest distance (model units)
    double share = 0;                   ///< largest distance as a share of the local edge length
    double tolerance = 0;               ///< limit of that share
    /// Place of the largest share: the vertex or the ends of the edge, from 1 (0: none), and its coordinates.
    std::array<std::size_t, 2> vertices{};
    ReportedPlace at = {};
};

/// What became of nodes of boundary edges that were to go elsewhere than to the projected middle.
struct BoundaryNodesReport {
    std::string by;  ///< the aim's word
    std::size_t edges = 0, placed = 0, best = 0, off = 0, far = 0, elements = 0, walked = 0, limited = 0;
    double mean_reduction = 0, largest_reduction = 0;
};

/// Of a mesh that was read with curves, the patches that have curves of their own.
struct CurvedPatchesReport {
    std::size_t smooth = 0, as_read = 0;  ///< with one surface through vertices and nodes; as they are in the file
    double mean_angle = 0,
           largest_angle = 0;  ///< between pieces of the smooth ones: root mean square, largest (degrees)
};

/// Largest distance between the boundary in the end and its geometry, by the bound that the run requires
/// (recipes:remesh_mesh).
struct GeometryErrorReport {
    double required = 0, reached = 0;  ///< of the facet that is farthest by its bound (model units)
    std::size_t far_facets = 0;        ///< number of facets that exceed their bounds
    std::size_t facet = 0;             ///< that facet, from 1; 0: no facet has a bound
    std::vector<double> at;            ///< where it is
    bool is_required = true;           ///< by the config; else the bound is that of the expected error

    [[nodiscard]] bool is_met() const { return !(reached > required); }
};

struct BoundaryReport {
    std::size_t surface_edges = 0, ridge_edges = 0, corners = 0, patches = 0;
    std::optional<double> straight_distance, curved_distance;  ///< largest, to the geometry (model units)
    std::optional<WallsReport> walls = {};
    std::optional<CadReport> cad = {};
    std::optional<DistancesReport> distances = {};  ///< both ways, by entity, where that is asked for
    std::optional<BoundaryNodesReport> nodes = {};
    std::optional<CurvedPatchesReport> curved_patches = {};
    std::optional<OffSurfacesReport> off_surfaces = {};      ///< where analytic surfaces are given
    std::optional<GeometryErrorReport> geometry_error = {};  ///< where the run has a bound
    std::optional<DeviationReport> node_deviation = {}, vertex_deviation = {};
};

/// What inner nodes for accuracy go by.
struct NodesByReport {
    std::string metric_kind;
    double size_share = 0;
    std::size_t walls = 0, metric = 0;  ///< nodes that they move, by more than 1/1000 of the chord
    std::size_t held_back = 0;          ///< that go less than half of their way, for smooth functions
};

struct CurveReport {
    std::size_t edges = 0, volume_edges = 0, curved_edges = 0;
    std::size_t polished = 0, exhausted = 0, shortened = 0, outside = 0, lost = 0;
    std::size_t drawn_back = 0;  ///< nodes inside or in planes that go a part of their way, for `min_jacobian`
    EdgeReport before;           ///< correction
    std::optional<NodesByReport> by = {};         ///< of accuracy
    std::optional<ExpectedErrors> expected = {};  ///< of the objective solution
    std::optional<EdgeReport> after;
    std::optional<EdgeReport> in_straight_field;  ///< after correction, where the back mesh is curved
    double edges_per_second = 0;
    std::string objective = {};  ///< word of the configuration
};

struct ValidityReport {
    double bound = 0;
    bool is_asked = false;                   ///< the bound; else it is recommended
    std::size_t invalid = 0, undecided = 0;  ///< whether det J > 0: it is not; it is not certain
    std::size_t below_bound = 0;             ///< it is, but the scaled Jacobian is not certain to hold the bound
    std::size_t straight_inverted = 0;
    double smallest = 1;    ///< min_scaled_jacobian
    std::size_t worst = 0;  ///< its element, from 1; 0 when there is none
};

struct RelaxReport {
    std::string repair;
    std::size_t corrected_elements = 0;
    std::size_t raised_elements = 0;  ///< valid before, at the target of repair now
    std::size_t relaxed_volume_edges = 0, relaxed_surface_edges = 0, moved_vertices = 0;
    std::size_t slid_surface_edges = 0;  ///< not among the relaxed ones: their nodes are on the geometry still
    std::size_t slid_vertices = 0;       ///< of the moved ones those of the boundary
    double work = 0;                     ///< of programmes, as the option `effort` counts it
    std::size_t given_up = 0;            ///< elements that were not repaired when that was spent
};

/// What became of the boundary of a mesh that was read with its curves.
struct KeptBoundaryReport {
    double tolerance = 0;
    std::optional<double> would_do = {};  ///< a tolerance by which every element becomes valid, tried (model units)
    std::size_t moved_nodes = 0;
    double largest_shift = 0;           ///< of a node (model units)
    double largest_relative_shift = 0;  ///< the same by the length of its edge's chord
};

/// An element of such a mesh that could not be repaired.
struct RemainingReport {
    std::size_t element = 0;  ///< from 1
    std::string reason;
    std::size_t at = 0;        ///< the vertex where it is, from 1; 0: nowhere in particular, or the reason has its name
    bool is_given_up = false;  ///< the work was spent; likewise
    std::uint64_t tag = 0;     ///< of the element in the input's file, where that is another number
};

struct ReinsertReport {
    std::size_t sweeps = 0, rounds = 0, patches = 0;
    std::size_t rejected_not_valid = 0, rejected_no_gain = 0;
};

/// How near to unit the straight form of a mesh is in a metric. Lengths and qualities: metric:unit_mesh.
struct UnitMeshReport {
    std::string metric;  ///< a file's name, or what the metric is
    std::size_t edges = 0;
    std::size_t unit_edges = 0, short_edges = 0, long_edges = 0;  ///< within 1/√2 and √2, below, above
    double shortest = 0, longest = 0, mean_length = 0;
    double worst_quality = 0, mean_quality = 0;
    std::size_t worst_element = 0;  ///< from 1; 0: no element
};

/// What all passes of one kind did to a mesh.
struct PassReport {
    std::string pass;
    std::size_t rounds = 0, proposals = 0, planned = 0, accepted = 0, corrections = 0, shortened = 0;
    std::size_t drawn_back = 0, bent_around = 0, programmes = 0, straight_inverted = 0,
                straight_positive = 0;  ///< of degree 2
    double farthest_facet = 0;          ///< of what swaps and collapses made, from the geometry, by its longest edge
    std::size_t moved_nodes = 0;        ///< of degree 2, by distortion
    std::vector<std::pair<std::string, std::size_t>> rejected;  ///< by reason, those that there were
    double seconds = 0;
};
/// What the nodes of inner edges of a remeshed mesh of degree 2 are for.
struct RemeshedNodesReport {
    std::string objective;
};

/// Boundary facets where the default bound on the distance from the geometry acts.
struct BoundedFacetsReport {
    std::size_t limited = 0;  ///< finer than the metric requests
    std::size_t far = 0;      ///< farther than the bound, as in the mesh before
};

struct RemeshReport {
    UnitMeshReport before, after;
    std::vector<PassReport> passes;
    std::optional<RemeshedNodesReport> nodes = {};
    std::optional<BoundedFacetsReport> bounded_facets = {};  ///< where it acts
};

struct StageTime {
    std::string stage;
    double seconds = 0;
    std::size_t peak_bytes = 0;
};

struct Report {
    std::optional<OriginReport> origin;
    std::optional<ReorderedReport> reordered;
    MeshReport mesh;
    std::optional<SolutionMetricReport> solution_metric;
    std::optional<MetricReport> metric;
    std::optional<RemeshReport> remesh;
    std::optional<BoundaryReport> boundary;
    std::optional<CurveReport> curve;
    std::optional<ValidityReport> validity_before, validity;
    std::optional<RelaxReport> relax;
    std::optional<KeptBoundaryReport> kept_boundary;
    std::vector<RemainingReport> remaining;
    std::optional<ReinsertReport> reinsert;
    std::optional<TransferReport> transfer;
    OverlappingReport overlaps;
    bool committed = false;
    /// Elements, from 1, that are not certified valid in the end (all of them).
    std::vector<std::size_t> invalid_elements, undecided_elements, elements_below_bound;
    std::vector<Histogram> histograms;
    std::vector<std::string> notices;
    std::vector<StageTime> times;
    int threads = 0;  ///< that were really used

    /// True if every element is certified valid, above the bound where one is requested.
    [[nodiscard]] bool has_valid_elements() const {
        return !validity || (validity->invalid == 0 && validity->undecided == 0 &&
                             (validity->below_bound == 0 || !validity->is_asked));
    }
    /// Number of elements that are not certified valid, above the bound where one is requested.
    [[nodiscard]] std::size_t not_valid() const {
        const bool has_bound = validity && validity->is_asked;
        return invalid_elements.size() + undecided_elements.size() + (has_bound ? elements_below_bound.size() : 0);
    }
    /// True if no boundary node or vertex is off its geometry by more than the tolerance.
    [[nodiscard]] bool boundary_holds() const {
        const auto holds = [](const std::optional<DeviationReport>& d) { return !d || d->off == 0; };
        return !boundary || (holds(boundary->node_deviation) && holds(boundary->vertex_deviation));
    }
    /// True if no walls pass through each other.
    [[nodiscard]] bool walls_hold() const { return !boundary || !boundary->walls || boundary->walls->crossing == 0; }
    /// True if the boundary is as near to its geometry as `--geometry-error` requires.
    [[nodiscard]] bool keeps_geometry_error() const {
        return !boundary || !boundary->geometry_error || !boundary->geometry_error->is_required ||
               boundary->geometry_error->is_met();
    }
    /// True if the result is the requested one: the exit code is 0.
    [[nodiscard]] bool holds_what_was_asked() const {
        return has_valid_elements() && boundary_holds() && keeps_geometry_error() && walls_hold() &&
               overlaps.overlapping == 0;
    }
};

/// One sentence for each cause for which a result is not the requested one, with its place; empty if it is.
[[nodiscard]] std::vector<std::string> misses(const Report& report);
/// Elements that are valid, but below the recommended bound; empty if there are none or the bound is requested.
[[nodiscard]] std::string recommended_bound_note(const Report& report);
/// "16 pairs of boundary triangles pass through each other …"; empty where no walls cross.
[[nodiscard]] std::string crossing_message(const WallsReport& walls, int dimension);
/// "elements overlap in 3 places …"; empty where none do.
[[nodiscard]] std::string overlap_message(const Report& report);
/// The distance that is required and not reached, and where.
[[nodiscard]] std::string sentence_of(const GeometryErrorReport& missed);

/// Lines for a terminal, without colours.
[[nodiscard]] std::string table(const Report& report);

/// report.json: the same numbers. What each key means: docs/report.md.
[[nodiscard]] std::string to_json(const Report& report);

}  // namespace camber::run

namespace camber::run {

/// Rows of both tables about walls that cross.
[[nodiscard]] std::string walls_rows(const WallsReport& walls);
/// Keys of both objects about them.
[[nodiscard]] std::string walls_json(const WallsReport& walls);

/// Row of both tables about nodes or vertices off the geometry; empty where none are.
[[nodiscard]] std::string deviation_row(const char* name, const DeviationReport& deviation);
[[nodiscard]] std::string deviation_json(const DeviationReport& deviation);

/// What both tables and both objects say of a CAD model.
[[nodiscard]] std::string cad_rows(const CadReport& cad);
[[nodiscard]] std::string cad_json(const CadReport& cad);

}  // namespace camber::run

/// How well the mesh carries a function: `camber check --field`.
export namespace camber::run {

/// Elements of one kind, with their shares of the squared L2 error over the mesh.
struct ErrorBin {
    std::string range;  ///< "0.01 to 0.1"
    std::size_t elements = 0;
    double straight = 0, same_boundary = 0, curved = 0;
};
/// One way to tell elements apart.
struct ErrorPlace {
    std::string_view key;  ///< in JSON
    std::string_view title;
    std::vector<ErrorBin> bins;  ///< those without elements included
};

/// Errors of the interpolants of one field; lengths^(D/2) times the field's unit (L2), that by a length (H1).
struct FieldErrors {
    std::string expression;
    InterpolationError errors;
    std::vector<ErrorPlace> places;
};

/// One number an element, by which errors are told apart.
struct ElementKinds {
    Buffer<double> curvature;        ///< the largest of its edges: |node − middle|/|chord|
    Buffer<double> scaled_jacobian;  ///< the smallest
    Buffer<double> hops;             ///< edges from its nearest vertex to the boundary; 8 stands for all above, too
};
template <int D>
[[nodiscard]] Outcome<ElementKinds> element_kinds(const QuadraticMesh<D>& mesh,
                                                  const Column<float>& min_scaled_jacobian, const Execution& execution);

/// The errors of an expression, and where they sit. Errors: those of the expression and of `interpolation_error`.
template <int D>
[[nodiscard]] Outcome<FieldErrors> field_errors(const QuadraticMesh<D>& mesh, const std::string& expression,
                                                const ElementKinds& kinds, const Execution& execution);

/// Lines for a terminal; of degree 1 nothing is curved.
[[nodiscard]] std::string field_table(const FieldErrors& field, const MeshReport& mesh);
/// A JSON object.
[[nodiscard]] std::string field_json(const FieldErrors& field);

}  // namespace camber::run

/// What each stage tells, and how it becomes part of the report.
namespace camber::run {

using Notices = std::vector<std::string>;

/// Of all elements, at the bound asked for.
struct VerdictsReport {
    ValidityReport summary;
    std::vector<std::size_t> invalid, undecided, below_bound;  ///< elements, from 1
};
/// `is_asked`: whether somebody did for the bound.
template <int D>
[[nodiscard]] VerdictsReport verdicts_report(const Validation<D>& validation, bool is_asked);

/// Of the same, before anything was corrected.
struct BeforeReport {
    ValidityReport summary;
};

/// What a repair came to; `given_up`: elements on which the work was spent in vain.
[[nodiscard]] RelaxReport relax_report(const RepairStatistics& statistics, std::size_t given_up, RepairMethod method);

/// Reports nodes that were moved back because walls crossed.
template <int D>
[[nodiscard]] RelaxedWallsReport relaxed_walls_report(const MovedBack<D>& moved) {
    return {moved.nodes, moved.largest, {moved.largest_at.c.begin(), moved.largest_at.c.end()}};
}

/// Of a correction.
struct CorrectionReport {
    RelaxReport relax;
    std::optional<KeptBoundaryReport> kept_boundary;
    std::vector<RemainingReport> remaining;
};

/// Of the stage that goes from vertex to vertex, but for its targets.
struct CavitiesReport {
    ValidityReport wanted;  ///< of the targets, before the cavities corrected them
    RelaxReport relax;
    ReinsertReport reinsert;
};

/// Planned places became the mesh's.
struct CommitReport {};

/// Of a plan at a run's end: whether its places are the mesh's.
struct PlanReport {
    bool is_mesh = false;
};

/// A mesh that passes are to change, and what they left.
struct BeginsChangingReport {
    UnitMeshReport unit_mesh;
};
struct FinishedNodesReport {
    RemeshedNodesReport nodes;
};
struct FinishedReport {
    UnitMeshReport unit_mesh;
    std::vector<Histogram> histograms;
    std::optional<BoundedFacetsReport> bounded_facets = {};
};

/// Of a run's end.
struct MeasuresReport {
    std::optional<EdgeReport> edges;  ///< after correction
    std::optional<EdgeReport>
        edges_in_straight_field;  ///< the same in the straight field, where the back mesh is curved
    std::optional<double> straight_distance, curved_distance;  ///< see BoundaryReport
    std::optional<WallsReport> walls = {};
    std::optional<DeviationReport> node_deviation = {}, vertex_deviation = {};
    std::optional<DistancesReport> distances = {};
    std::optional<GeometryErrorReport> geometry_error = {};
    bool is_remeshed = false;  ///< what the report has of the boundary's vertices is of the mesh before
    std::vector<Histogram> histograms;
};

void add(Report& report, const Notices& notices);
void add(Report& report, const OverlappingReport& part);
void add(Report& report, const MetricReport& part);
void add(Report& report, const BoundaryReport& part);
void add(Report& report, const BoundaryNodesReport& part);
void add(Report& report, const CurveReport& part);
void add(Report& report, const VerdictsReport& part);
void add(Report& report, const BeforeReport& part);
/// Corrections add up: of the cavities' own, and of a stage `relax` after them.
void add(Report& report, const CorrectionReport& part);
void add(Report& report, const CavitiesReport& part);
void add(Report& report, const CommitReport&);
void add(Report& report, const PlanReport& part);
void add(Report& report, const MeshReport& part);
void add(Report& report, const BeginsChangingReport& part);
/// Passes of one kind add up.
void add(Report& report, const PassReport& part);
void add(Report& report, const FinishedReport& part);
void add(Report& report, const FinishedNodesReport& part);
void add(Report& report, const MeasuresReport& part);

}  // namespace camber::run

/// How near to unit a straight mesh is in a metric: `camber check --metric`, and before and after passes that change
/// it.
namespace camber::run {

/// The report, and what it counts, one a unique edge and one an element.
struct UnitMesh {
    UnitMeshReport report;
    std::vector<double> lengths, qualities;
};

/// Of lengths, one an edge, and qualities, one an element.
[[nodiscard]] UnitMeshReport unit_mesh_report(std::string metric, const std::vector<double>& lengths,
                                              const std::vector<double>& qualities);

/// `metric`: the name of what the logs, one a vertex, are.
template <int D>
[[nodiscard]] Outcome<UnitMesh> measure_unit_mesh(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                  const Column<LogMetric<D>>& log_metrics, std::string metric,
                                                  const Execution& execution);

/// Of a mesh of degree 2: along its curves, and by the mean distortion of its elements.
template <int D>
[[nodiscard]] Outcome<UnitMesh> measure_unit_mesh(const QuadraticMesh<D>& mesh, const Column<LogMetric<D>>& log_metrics,
                                                  std::string metric, const Execution& execution);

/// Its histograms, by one series of that name each.
[[nodiscard]] std::vector<Histogram> histograms_of(const UnitMesh& measured, const std::string& series);

/// Lines for a terminal; a JSON object.
[[nodiscard]] std::string unit_mesh_rows(const UnitMeshReport& report);
[[nodiscard]] std::string unit_mesh_json(const UnitMeshReport& report);

}  // namespace camber::run

/// How near to unit a mesh of degree 2 is in a metric, along its curves: `camber check --metric`.
namespace camber::run {

struct CurvedUnitMeshReport {
    /// An element's quality, from 1: its mean, the least that was attained at a point, and what it is above everywhere.
    struct Element {
        std::size_t number = 0;
        double quality = 0, least = 0, bound = 0;
    };
    UnitMeshReport unit_mesh;    ///< lengths along the curves, mean qualities
    Element lowest;              ///< of the lowest quality at a point; its number 0: no element
    double bound = 0;            ///< above which the quality is at every point of the mesh
    std::vector<Element> worst;  ///< of the lowest mean qualities, the worst first
};

/// The report, and what it counts, one a unique edge and one an element.
struct CurvedUnitMesh {
    CurvedUnitMeshReport report;
    std::vector<double> lengths, qualities;
};

/// `metric`: the name of what the logs, one a vertex, are; `worst`: how many elements to name.
template <int D>
[[nodiscard]] Outcome<CurvedUnitMesh> measure_curved_unit_mesh(const QuadraticMesh<D>& mesh,
                                                               const Column<LogMetric<D>>& log_metrics,
                                                               std::string metric, std::size_t worst,
                                                               const Execution& execution);

[[nodiscard]] std::vector<Histogram> histograms_of(const CurvedUnitMesh& measured, const std::string& series);

/// Lines for a terminal; a JSON object.
[[nodiscard]] std::string curved_unit_mesh_rows(const CurvedUnitMeshReport& report);
[[nodiscard]] std::string curved_unit_mesh_json(const CurvedUnitMeshReport& report);

/// Of a mesh that ranks share: as of one as a whole, but for the last digits of means, which are summed rank by rank.
struct UnitMeshOfRanks {
    UnitMeshReport report;
    std::vector<Histogram> histograms;
};
/// Errors: of any rank.
[[nodiscard]] Outcome<UnitMeshOfRanks> unit_mesh_of_ranks(std::string metric, const MeasuredRows& own, Ranks& ranks);

}  // namespace camber::run
