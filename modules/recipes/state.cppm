module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>
export module camber.recipes:state;
import camber.core;
import camber.bezier;
import camber.ordering;
import camber.metric;
import camber.transfer;
import camber.validity;
import camber.crossing;
import camber.optimisation;
import camber.io;
import camber.surface;
import camber.cad;
import camber.operation;
import camber.adapt;
import camber.curving;
import camber.stages;
import camber.distributed;
import :measurements;
import :report;
import :values;

export namespace camber::run {

/// Files are already read.
struct GeometrySource {
    std::optional<CadModel> cad = {};
    std::shared_ptr<const AnyMesh> mesh = {};
};

/// Origin of a plan that started from the nodes of the input.
template <int D>
struct OwnNodes {
    Features<D> features;
    std::optional<Boundary<D>> boundary = {};  ///< prescribed geometry, onto which boundary nodes were moved
};

/// Target nodes of `curve` or `reinsert`, and the data that define them.
template <int D>
struct CurvingTarget {
    Boundary<D> boundary;
    Incidence<ElementId> shells;
    Curved<D> curved;  ///< before any correction
    CurvingAim aim = CurvingAim::energy;
    Column<LagrangeNode<D>> extended = {};  ///< positions to relax towards, see CurveInput
};

template <int D>
struct CommittedPlaces {
    Proposal<D> proposal;
    Validation<D> validation;
};

template <int D>
struct Plan {
    std::variant<OwnNodes<D>, CurvingTarget<D>> origin;
    std::variant<Proposal<D>, JudgedProposal<D>, CommittedPlaces<D>> places;

    [[nodiscard]] const Features<D>& features() const;
    [[nodiscard]] const Proposal<D>& proposal() const;
    [[nodiscard]] const Validation<D>* validation() const;  ///< of the positions; null: not validated
    /// Null: the plan is not yet validated for the current mesh.
    [[nodiscard]] const JudgedProposal<D>* judged() const { return std::get_if<JudgedProposal<D>>(&places); }
    /// Null: the plan started from the nodes of the input.
    [[nodiscard]] const CurvingTarget<D>* target() const { return std::get_if<CurvingTarget<D>>(&origin); }
    /// Null: the boundary of the mesh, without a geometry.
    [[nodiscard]] const Boundary<D>* boundary() const {
        if (const auto* own = std::get_if<OwnNodes<D>>(&origin)) return own->boundary ? &*own->boundary : nullptr;
        return &std::get<CurvingTarget<D>>(origin).boundary;
    }
};

/// No plan; verdicts of the mesh's nodes, once validated.
template <int D>
struct Unplanned {
    std::optional<Validation<D>> validation;
};

template <int D>
struct Quadratic {
    QuadraticMesh<D> mesh;
    NodesOf nodes = NodesOf::elevation;
    std::variant<Unplanned<D>, Plan<D>> plan;

    [[nodiscard]] const Plan<D>* planned() const { return std::get_if<Plan<D>>(&plan); }
    /// Verdicts of the plan, or without a plan of the mesh; null: not validated.
    [[nodiscard]] const Validation<D>* validation() const;
    /// True if boundary nodes are from the input: they stay, unless analytic surfaces are prescribed.
    [[nodiscard]] bool is_boundary_from_input() const;
    [[nodiscard]] bool has_uncommitted() const;
};

/// No correction yet. `last`: latest verdicts.
template <int D>
struct Uncorrected {
    std::optional<Validation<D>> last;
};
/// After a correction. `before`: verdicts before it.
template <int D>
struct Corrected {
    Validation<D> before;
};
template <int D>
using History = std::variant<Uncorrected<D>, Corrected<D>>;

template <int D>
struct Changing {
    Adaptation<D> mesh;
    AdaptationGoal<D> goal;
    MetricReport metric;                ///< of the goal's field
    std::vector<Histogram> histograms;  ///< of the mesh before the passes, see UnitMesh
    /// Rows of this rank at the end of a run that ends in rows; `mesh` is then empty.
    std::optional<RemeshedRows<D>> shared = {};
};

/// Data for a remeshed mesh: its facets approximate the same geometry, and its vertices have a metric.
template <int D>
struct Inherited {
    Geometry<D> geometry;
    Column<LogMetric<D>> log_metrics;
    MetricReport metric;                    ///< of the field of the remeshing
    std::optional<BackMesh<D>> field = {};  ///< that field, if its file has its own mesh
    EmbeddedCurves<D> curves = {};          ///< of the mesh that was remeshed
};

template <int D>
struct KnownCrossings {
    Column<Vec<D>> points;
    Column<LagrangeNode<D>> mid_nodes;
    Crossings crossings;

    [[nodiscard]] bool is_of(const QuadraticMesh<D>& mesh) const {
        return points == mesh.linear.points && mid_nodes == mesh.mid_nodes;
    }
};

template <int D>
struct State {
    std::variant<LinearMesh<D>, Changing<D>, Quadratic<D>> mesh;
    Column<Vec<D>> input_points;               ///< vertices as read, to which rows of metric files refer
    Column<LagrangeNode<D>> input_nodes = {};  ///< nodes of a quadratic mesh as read
    std::optional<BackMesh<D>> field;
    /// Metric of the straight mesh at its vertices, if `field` is on a curved mesh.
    std::optional<Column<LogMetric<D>>> straight_log_metrics;
    std::optional<Inherited<D>> inherited;
    /// Boundary distance after `remesh`, compared with the bounds of the config; empty once a stage changes it.
    std::optional<ReachedDistance<D>> reached;
    std::optional<FinishedRows<D>> rows;  ///< final rows of this rank; the mesh is then empty
    std::optional<CadMovesReport> cad_moves;
    std::optional<std::size_t> crossings_of_input;    ///< pairs of facets that crossed before passes changed the mesh
    std::optional<RelaxedWallsReport> relaxed_walls;  ///< boundary nodes that were moved back because facets crossed
    std::optional<KnownCrossings<D>> crossings;       ///< of the positions after the stage `relax`
    History<D> history;
    JacobianBound bound = {};   ///< of the last stage that set one
    JacobianBound target = {};  ///< of repair, for the method that last placed nodes
    CurveOptions curving = {};  ///< of the last curving stage; passes place new nodes alike
};

/// Errors: unsupported (no simplices of degree 1 or 2).
template <int D>
[[nodiscard]] Outcome<State<D>> beginning_with(Mesh<D> mesh);

/// Each rank has the whole result, or its rows.
enum class RunEnd : std::uint8_t { whole, rows };

/// Mesh of a metric file whose rows are not at the input's vertices.
struct MetricMesh {
    enum class Of { input, another };
    AnyMesh mesh;
    Of of = Of::another;  ///< `input`: rows at all nodes of the input as read
};

/// Rows of a metric: read from a file, or made for the run's solution.
struct MetricFile {
    std::string name;
    Solution solution;
    std::optional<MetricMesh> mesh = {};                       ///< none: the rows are at the vertices of the input
    std::optional<config::SolutionMetric> metric_config = {};  ///< none: of a file
    std::vector<DistanceBound> bounds = {};  ///< of the boundary, by the expected error of the solution

    [[nodiscard]] bool is_of(const config::Metric& metric) const {
        if (const auto* file = std::get_if<config::FilePath>(&metric)) return !metric_config && name == file->path;
        const auto* solution_metric = std::get_if<config::SolutionMetric>(&metric);
        return solution_metric != nullptr && metric_config && *metric_config == *solution_metric;
    }
};

/// Rows of a metric file in the order of a mesh's vertices. With one row per node of a curved mesh, rows of its edges
/// follow. The file's numbers decide. Other rows are unchanged; an edge without a node in the file has the mean of its
/// ends. Errors: memory, stopped.
struct RowsByNodes {
    Solution solution;
    bool is_at_nodes = false;
};
[[nodiscard]] Outcome<RowsByNodes> rows_by_nodes(Solution solution, const DecodedMesh& mesh,
                                                 const Execution& execution);
/// Selects the rows of the vertices from rows at all nodes; other rows are unchanged.
[[nodiscard]] Solution rows_at_vertices(RowsByNodes rows, const AnyMesh& mesh);

/// A mesh, and metric files with one row per vertex; a better order renumbers both.
template <int D>
struct StageInputs {
    Mesh<D> mesh;
    std::vector<MetricFile> files = {};
};

/// Prepared mesh, notices of its changes, and the order to work in (none: that of the input).
template <int D>
struct Sound {
    StageInputs<D> inputs;
    Notices notices;
    std::optional<BetterOrder> order;
};
template <int D>
[[nodiscard]] Outcome<Sound<D>> prepare_stage(StageInputs<D> specified, std::span<const config::Stage> stages,
                                              const OrderingOptions& ordering, const Execution& execution);

template <int D>
struct MetricInput {
    const LinearMesh<D>& mesh;
    const EdgeSet<D>& edges;
    const Boundary<D>& boundary;
    const Column<Vec<D>>& input_points;  ///< vertices as read, to which rows of files refer
    std::span<const MetricFile> files;
    Column<LogMetric<D>> natural;   ///< mesh-implied metric, straight or curved
    const Inherited<D>* inherited;  ///< of a remeshed mesh, whose metric exists; else null
};

/// A surrogate passes through the nodes of `boundary` if there are any, else through the vertices. Errors (usage, with
/// the JSON path): a vector of the wrong dimension; a surface that does not exist in this dimension or that the mesh is
/// not on; those of `associate`, or of geometry_of_mesh with ridges by `features_by`.
template <int D>
struct BuiltGeometry {
    Geometry<D> geometry;
    std::optional<CadReport> cad = {};
    std::vector<EdgeId> ridges = {};  ///< mesh edges on model edges, and mesh vertices on model vertices, ascending
    std::vector<VertexId> corners = {};
    std::optional<CurvedPatchesReport> curved_patches = {};
    std::optional<OffSurfacesReport> off_surfaces = {};  ///< of analytic surfaces
    std::optional<Error> fit_error = {};                 ///< the mesh does not fit the CAD model
};
template <int D>
[[nodiscard]] Outcome<BuiltGeometry<D>> make_geometry(const config::Geometry& geometry, const GeometrySource& source,
                                                      const BoundaryCurves<D>& boundary,
                                                      const FeatureOptions<D>& features_by, const Execution& execution);
/// Policy for vertices far from the boundary of the geometry's mesh. Passes leave vertices off it if elements would
/// become invalid or facets would cross, so meshes of earlier cycles are accepted.
enum class FitErrorPolicy : std::uint8_t { refused, accepted };

/// Errors: usage (another dimension, or a reference of this boundary is missing); input (several boundary vertices are
/// farther away than a tenth of their edges, and not between straight facets and the surfaces above them).
template <int D>
[[nodiscard]] Outcome<Geometry<D>> geometry_of_mesh(const AnyMesh& other, const FeatureOptions<D>& features_by,
                                                    const LinearMesh<D>& mesh, FitErrorPolicy policy,
                                                    const Execution& execution);
/// Analytic surfaces of a config. Errors (usage) have the JSON path: `where` and the item's number.
template <int D>
[[nodiscard]] Outcome<AnalyticGeometry<D>> make_analytic(const std::vector<config::AnalyticSurface>& surfaces,
                                                         const std::string& where, const LinearMesh<D>& mesh,
                                                         const Execution& execution);
/// Vertices that are farther from their surface than rounding explains. `check_fit` accepts a tenth of the edges, since
/// meshes may be made on slightly different surfaces.
template <int D>
[[nodiscard]] OffSurfacesReport off_surfaces(const LinearMesh<D>& mesh, const AnalyticGeometry<D>& geometry);
/// Geometry of facets on the CAD model, without those of the references `excluded` (ascending). `fit_error`: too many
/// vertices are off the model. Errors: those of `associate`.
template <int D>
[[nodiscard]] Outcome<BuiltGeometry<D>> make_cad_geometry(const config::Cad& config, const CadModel& model,
                                                          const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                          std::span<const Reference> excluded,
                                                          const Execution& execution);

/// Converts the CAD model to the mesh's unit (camber.cad: in_unit_of) if the config has "auto". Errors: stopped,
/// memory.
template <int D>
[[nodiscard]] Outcome<GeometrySource> in_unit_of_mesh(const config::Geometry& geometry, GeometrySource source,
                                                      const LinearMesh<D>& mesh, const Execution& execution);

[[nodiscard]] bool lies_on_model(const config::Cad& cad, Reference reference);
/// Vertices moved onto the CAD model, or onto its intersections with analytic surfaces. Errors: see make_cad_mixture.
template <int D>
struct MovedVertices {
    Column<Vec<D>> points;
    CadMovesReport report;
};
template <int D>
[[nodiscard]] Outcome<MovedVertices<D>> moved_vertices(const config::Cad& config, const CadModel& model,
                                                       const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                       const Execution& execution);
/// Geometry of the CAD model, of analytic surfaces, and of a surrogate for other facets, if there are any. Errors
/// (usage): references that are named twice or that no facet has.
template <int D>
[[nodiscard]] Outcome<BuiltGeometry<D>> make_cad_mixture(const config::Cad& config, const CadModel& model,
                                                         const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                         const SurrogateFactory<D>& surrogate,
                                                         const Execution& execution);

/// Largest allowed distances of the boundary from its geometry, by reference: chord errors of metric and operations.
[[nodiscard]] std::vector<DistanceBound> required_distances(const config::Pipeline& pipeline);

/// Bounds on boundary distances of a run: those that the config requires, or else those that its metrics expect.
struct BoundedDistances {
    std::vector<DistanceBound> bounds;
    bool are_required = true;  ///< a result that exceeds required bounds is not the requested one
};

template <int D>
struct SourcedMetric {
    Column<LogMetric<D>> log_metrics;
    MetricReport report;
    Notices notices;
};
/// Metric of a file: a tensor or a size per vertex. Errors (input): another dimension or number of rows, values that
/// are no metric.
template <int D>
[[nodiscard]] Outcome<SourcedMetric<D>> log_metrics_of_file(const MetricFile& file, std::size_t vertices,
                                                            const Execution& execution);

/// Field of a metric file on its own mesh; of form (4) on a curved one.
template <int D>
struct FileField {
    BackMesh<D> back;
    MetricReport report;
    Notices notices;
};
/// The mesh of the file must be in the place of the points `requested`; notices report points outside it. Errors: those
/// of log_metrics_of_file; a mesh of another dimension or place (input).
template <int D>
[[nodiscard]] Outcome<FileField<D>> field_of_file(const MetricFile& file, const Column<Vec<D>>& requested,
                                                  const Execution& execution);
template <int D>
[[nodiscard]] Outcome<SourcedMetric<D>> sampled_file(const MetricFile& file, const Column<Vec<D>>& points,
                                                     const Execution& execution);
/// File of the config's metric, if it has its own mesh; else null.
[[nodiscard]] const MetricFile* file_with_mesh(const config::Pipeline& config, std::span<const MetricFile> files);

template <int D>
[[nodiscard]] Outcome<SourcedMetric<D>> make_log_metrics(const MetricInput<D>& input, const config::Metric& metric,
                                                         const Execution& execution);

/// Computed metrics: of normals, and of an analytic field. Errors (usage): a wrong dimension, values that are no sizes.
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> make_surface_metric(const config::SurfaceMetric& metric,
                                                                const MetricInput<D>& input,
                                                                const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> make_field_metric(const config::FieldMetric& metric,
                                                              const LinearMesh<D>& mesh, const Execution& execution);

template <int D>
[[nodiscard]] Outcome<SourcedMetric<D>> apply_operations(SourcedMetric<D> field, const MetricInput<D>& input,
                                                         std::span<const config::MetricOperation> operations,
                                                         const Execution& execution);

struct NamedField {
    std::string name;
    FieldKind kind = FieldKind::scalar;
    TransferField field;
};

[[nodiscard]] std::vector<Column<double>> scalars_of(std::span<const NamedField> fields);

/// Selects fields by name, each once; no names: all. Errors: an unknown name (usage, with `where`).
[[nodiscard]] Outcome<std::vector<NamedField>> named(std::vector<NamedField> fields,
                                                     const std::vector<std::string>& names, const std::string& where);

/// Elevates a straight mesh. Errors: another dimension (internal), memory, stopped.
template <int D>
[[nodiscard]] Outcome<QuadraticMesh<D>> of_degree_2(const AnyMesh& mesh, const Execution& execution);

/// Number of nodes in degree 2: vertices and one per edge, also for a straight mesh. Errors: those of `unique_edges`.
[[nodiscard]] Outcome<std::size_t> nodes_in_degree_2(const AnyMesh& mesh, const Execution& execution);

[[nodiscard]] std::vector<NamedField> at_vertices(const AnyMesh& mesh, std::vector<NamedField> fields);

/// Metric for fields: at the vertices of a straight mesh, at all nodes of a curved one. Each component of each field is
/// one function. `specified`: metrics to intersect with, rows at the vertices. Errors: those of `metric_of_solution`
/// and of metric files; fields at different nodes, or unknown names (usage).
struct SolutionMetricResult {
    NamedField metric;
    SolutionMetricReport report;
    std::vector<DistanceBound> bounds = {};  ///< of the boundary, by the expected error (MetricOfSolution)
};
[[nodiscard]] Outcome<SolutionMetricResult> metric_of_fields(const AnyMesh& mesh, std::span<const NamedField> fields,
                                                             const config::SolutionMetric& requested,
                                                             std::span<const Solution> specified, double ridge_angle,
                                                             const StepWrapper& around);

/// Second derivatives of a scalar field at the vertices; where materials meet, the mean of both sides. Errors: those of
/// `recover_derivatives`; no scalar field (usage).
[[nodiscard]] Outcome<Solution> hessians_of(const AnyMesh& mesh, const NamedField& field, const Execution& execution);

/// Errors: those of `transfer`; meshes of different dimensions (input).
struct TransferredFields {
    std::vector<NamedField> fields;
    TransferReport report;
};
[[nodiscard]] Outcome<TransferredFields> transfer_fields(const AnyMesh& new_mesh, const AnyMesh& old_mesh,
                                                         std::vector<NamedField> fields, const TransferOptions& options,
                                                         const StepWrapper& around);

/// Fields at the vertices and, for degree 2, at edge nodes, where a field of degree 1 has the mean of the ends.
[[nodiscard]] MeshFields as_mesh_fields(const AnyMesh& mesh, std::span<const NamedField> fields);

/// Values of an expression at the nodes of a mesh; on a straight one also at the middles of its edges. Errors: usage
/// (cannot be parsed, not finite at a node), stopped, memory.
[[nodiscard]] Outcome<NamedField> field_of_expression(const AnyMesh& mesh, const std::string& expression,
                                                      const Execution& execution);

struct SolutionSource {
    AnyMesh mesh;
    std::vector<NamedField> fields;
    std::string expression;       ///< empty: none
    std::vector<double> weights;  ///< one per field; none: 1 each
};

/// Components of all fields at the nodes of a mesh made from the input, where unchanged nodes keep their values; or the
/// expression. Step: transfer. Errors: those of `transfer_fields`; usage (an expression that cannot be parsed, a wrong
/// number of weights).
template <int D>
[[nodiscard]] Outcome<SolutionInput<D>> solution_on(const SolutionSource& source, const QuadraticMesh<D>& mesh,
                                                    const StepWrapper& around);

/// Fields that a VTU file can show on the final mesh, as far as stages computed them. `field`: null if none was made.
///
/// Cells (on facets and feature edges NaN and −1):
/// - `scaled_jacobian`: certified lower bound of min det J / |det straight|; `verdict`: 0 valid, 1 invalid,
///   2 undecided.
///
/// Nodes (vertices and nodes of edges):
/// - `node_kind`: 0 volume, 1 surface, 2 ridge, 3 corner;
/// - `edge_change`: −1 at vertices, else 0 straight, 1 projected, 2 optimised, 3 relaxed, 4 straightened;
/// - `curvature`: |P^l − M_11|/|P_20 − P_02| of the node's edge; at a vertex the mean of its edges;
/// - `length_reduction`: L_straight/L − 1 of the node's edge, 0 on boundary edges; at a vertex the mean of its volume
///   edges;
/// - `distance_to_geometry` (model units): of boundary nodes; NaN in the volume;
/// - `metric` (1/length²): M; at edge nodes log-Euclidean between the back mesh's vertices.
///
/// Errors: stopped.
template <int D>
[[nodiscard]] Outcome<MeshFields> mesh_fields(const Quadratic<D>& end, const BackMesh<D>* field,
                                              const std::optional<EdgeLengths>& lengths, const Execution& execution);

/// Metrics (1/length²) from logs, one per vertex; or those at the vertices of the back mesh. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Solution> metric_solution(const Column<LogMetric<D>>& log_metrics, const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Solution> metric_solution(const BackMesh<D>& field, const Execution& execution);
/// The same at all nodes of a curved mesh: vertices, then edges.
template <int D>
[[nodiscard]] Outcome<Solution> metric_solution(const BackMesh<D>& field, const QuadraticMesh<D>& mesh,
                                                const Execution& execution);

/// Fields of a solution at the nodes of its mesh. Rows are at the vertices; edge nodes get the mean of the ends,
/// log-Euclidean if both tensors are positive definite. A single tensor is named `metric`, a single size `size`, others
/// `field_1` … Errors: input (rows or dimension differ from the mesh; `name` is the file's), stopped.
[[nodiscard]] Outcome<MeshFields> solution_fields(const Solution& solution, const std::string& name,
                                                  const AnyMesh& mesh, const Execution& execution);

/// L_straight/L − 1 (paper eq. 8) of each edge; 0: no length.
[[nodiscard]] std::vector<double> length_reductions(const Column<double>& straight, const Column<double>& lengths);

/// |P^l − M_11|/|P_20 − P_02| of each edge with these nodes; 0: no chord length.
template <int D>
[[nodiscard]] std::vector<double> curvatures(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> mid_nodes);

/// Edges whose lengths are measured: all where the output shows them.
[[nodiscard]] MeasuredEdges reported_lengths(const config::Output& output);

template <int D>
[[nodiscard]] std::size_t bent_edges(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal);

/// Length reductions of the volume edges that have lengths, and curvatures of all.
template <int D>
[[nodiscard]] EdgeReport edge_report(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal,
                                     const Column<double>& straight, const Column<double>& lengths);

/// Histograms of a run's result. Volume edges: length reductions, lengths (also "straight") and curvatures, after
/// correction if there are `lengths`. Elements: scaled Jacobians "before" (proposed by `curve`) and "after"; without
/// `curve` only these, as "count". Quantities that were not measured have no entry. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<std::vector<Histogram>> run_histograms(const Quadratic<D>& end,
                                                             const std::optional<EdgeLengths>& lengths,
                                                             const History<D>& history, const Execution& execution);

/// Deviation of nodes or vertices from the geometry. `vertices`: the worst vertex, or the ends of the worst edge, from
/// 1 (0: none); `at`: its position.
template <class Id, int D>
[[nodiscard]] DeviationReport deviation_report(const OffGeometry<Id>& of, double tolerance,
                                               const std::array<std::size_t, 2>& vertices, const Vec<D>& at) {
    DeviationReport report{
        .measured = of.measured, .off = of.off, .largest = of.largest, .share = of.share, .tolerance = tolerance};
    if (!of.worst.valid()) return report;
    report.vertices = vertices;
    report.at.assign(at.c.begin(), at.c.end());
    return report;
}

/// `box_of(facet)` locates the first crossing.
template <int D, class BoxOf>
[[nodiscard]] WallsReport walls_report(const Crossings& found, const BoxOf& box_of) {
    WallsReport report{.crossing = found.crossing, .touching = found.touching, .undecided = found.undecided};
    const auto first = std::ranges::find(found.found, Crossing::crossing, &FacetCrossing::verdict);
    if (first == found.found.end()) return report;
    report.first = first->first.index() + 1;
    report.other = first->second.index() + 1;
    const Box<D> a = box_of(first->first), b = box_of(first->second);
    for (int c = 0; c < D; ++c)
        report.first_at.push_back((std::max(a.low[c], b.low[c]) + std::min(a.high[c], b.high[c])) / 2);
    return report;
}

/// Geometry over the facets of a mesh as small straight facets, for viewers. Each facet has its own lattice, so that
/// normals may jump between facets. Fields: `normal` of points; of cells `facet`, the number of the mesh's facet, and
/// `patch`.
struct SurfaceMesh {
    AnyMesh mesh;
    MeshFields fields;
};
/// Splits each facet into 36 (2D: 6). A facet without a surface stays plane. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<SurfaceMesh> surface_mesh(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                const Geometry<D>& geometry, const Execution& execution);

}  // namespace camber::run

namespace camber::run {

/// Errors (usage): not D numbers; `what` names them.
template <int D>
[[nodiscard]] Outcome<Vec<D>> vec(const std::vector<double>& numbers, const char* what) {
    if (numbers.size() != D)
        return fail(ErrorKind::usage, std::string(what) + " has " + std::to_string(numbers.size()) +
                                          " coordinates, the mesh " + std::to_string(D));
    Vec<D> v;
    std::ranges::copy(numbers, v.c.begin());
    return v;
}

/// `nodes`: number of nodes in degree `degree`.
template <int D>
[[nodiscard]] MeshReport mesh_report(const LinearMesh<D>& mesh, int degree, std::size_t nodes) {
    return {D, degree, mesh.points.size(), nodes, mesh.elements.size(), mesh.facets.size(), mesh.edges.size()};
}

/// Field on cells: `values` from cell `first` on, `none` on other cells.
template <int D, class T>
[[nodiscard]] MeshField cell_field(const LinearMesh<D>& mesh, std::string name, std::size_t first, const auto& values,
                                   T none) {
    Buffer<T> column(mesh.elements.size() + mesh.facets.size() + mesh.edges.size(), none);
    for (std::size_t i = 0; i < values.size(); ++i) column[first + i] = static_cast<T>(values[i]);
    return {std::move(name), Centring::cell, FieldKind::scalar, Column<T>(std::move(column))};
}

template <int D>
[[nodiscard]] MeshField node_kinds(const QuadraticMesh<D>& mesh, const Features<D>& features) {
    const std::size_t vertices = mesh.linear.points.size();
    Buffer<std::int32_t> column(vertices + mesh.edges.size());
    for (std::size_t n = 0; n < column.size(); ++n)
        column[n] = n < vertices ? static_cast<std::int32_t>(features.vertex_kinds[n])
                                 : static_cast<std::int32_t>(features.edge_kinds[n - vertices]);
    return {"node_kind", Centring::node, FieldKind::scalar, Column<std::int32_t>(std::move(column))};
}

/// Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Column<double>> tensor_rows(std::size_t rows, const auto& log_at, const Execution& execution) {
    Buffer<double> values(rows * sym_size<D>);
    auto done = each(execution, rows, [&](std::size_t n) {
        const Sym<D> m = exp(log_at(n)).m;
        std::ranges::copy(m.c, values.begin() + static_cast<std::ptrdiff_t>(n * sym_size<D>));
    });
    if (!done) return fail(std::move(done.error()));
    return Column<double>(std::move(values));
}

/// Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> sampled_logs(const BackMesh<D>& field, std::size_t rows,
                                                         const auto& point_at, const Execution& execution) {
    return guarded([&]() -> Outcome<Column<LogMetric<D>>> {
        Buffer<LogMetric<D>> logs(rows);
        auto done = each_chunk(execution, rows, [&](std::size_t begin, std::size_t end) {
            ElementId hint;
            for (std::size_t n = begin; n < end; ++n) {
                const FieldSample<D> sample = sample_value(field, point_at(n), hint);
                hint = sample.location.element;
                logs[n] = sample.log_metric;
            }
        });
        if (!done) return fail(std::move(done.error()));
        return Column<LogMetric<D>>(std::move(logs));
    });
}

}  // namespace camber::run
