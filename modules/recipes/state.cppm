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

/// Files of a config's geometry, already read.
struct GeometrySource {
    std::optional<CadModel> cad = {};
    std::shared_ptr<const AnyMesh> mesh = {};
};

// ---------------------------------------------------------------- state of a run between two stages

/// A plan that began with the nodes that the mesh was read with.
template <int D>
struct OwnNodes {
    Features<D> features;
    std::optional<Boundary<D>> boundary = {};  ///< with a prescribed geometry, onto which the boundary's nodes went
};

/// A plan of `curve` or `reinsert`: where they want nodes, and by what.
template <int D>
struct CurvingTarget {
    Boundary<D> boundary;
    Incidence<ElementId> shells;
    Curved<D> curved;  ///< before any correction
    CurvingAim aim = CurvingAim::energy;
    Column<LagrangeNode<D>> extended = {};  ///< where nodes go back to, see CurveInput
};

/// Places that are the mesh's by now, and the verdicts that they became so with.
template <int D>
struct CommittedPlaces {
    Proposal<D> proposal;
    Validation<D> validation;
};

/// Places for nodes and vertices, committed or not.
template <int D>
struct Plan {
    std::variant<OwnNodes<D>, CurvingTarget<D>> origin;
    std::variant<Proposal<D>, JudgedProposal<D>, CommittedPlaces<D>> places;

    [[nodiscard]] const Features<D>& features() const;
    [[nodiscard]] const Proposal<D>& proposal() const;
    [[nodiscard]] const Validation<D>* validation() const;  ///< of the places; null until they were judged
    /// Null: to be judged for the mesh as it is now.
    [[nodiscard]] const JudgedProposal<D>* judged() const { return std::get_if<JudgedProposal<D>>(&places); }
    /// Null: began with the nodes that the mesh was read with.
    [[nodiscard]] const CurvingTarget<D>* target() const { return std::get_if<CurvingTarget<D>>(&origin); }
    /// Null: the mesh's own, without a geometry.
    [[nodiscard]] const Boundary<D>* boundary() const {
        if (const auto* own = std::get_if<OwnNodes<D>>(&origin)) return own->boundary ? &*own->boundary : nullptr;
        return &std::get<CurvingTarget<D>>(origin).boundary;
    }
};

/// Nothing is planned; verdicts of the mesh's own nodes, once asked for.
template <int D>
struct Unplanned {
    std::optional<Validation<D>> validation;
};

/// A mesh of degree 2, and what is planned for it.
template <int D>
struct Quadratic {
    QuadraticMesh<D> mesh;
    NodesOf nodes = NodesOf::elevation;
    std::variant<Unplanned<D>, Plan<D>> plan;

    [[nodiscard]] const Plan<D>* planned() const { return std::get_if<Plan<D>>(&plan); }
    /// Verdicts of the plan, or of the mesh where there is none; null when nothing was judged.
    [[nodiscard]] const Validation<D>* validation() const;
    /// True if the boundary's nodes are the file's: they stay, unless analytic surfaces are given.
    [[nodiscard]] bool is_boundary_from_input() const;
    [[nodiscard]] bool has_uncommitted() const;
};

/// Nothing was corrected yet: the last verdicts, if any.
template <int D>
struct Uncorrected {
    std::optional<Validation<D>> last;
};
/// Something was: the verdicts before.
template <int D>
struct Corrected {
    Validation<D> before;
};
template <int D>
using History = std::variant<Uncorrected<D>, Corrected<D>>;

/// A mesh between two passes that change it, and what it is brought to.
template <int D>
struct Changing {
    Adaptation<D> mesh;
    AdaptationGoal<D> goal;
    MetricReport metric;                ///< of the goal's field
    std::vector<Histogram> histograms;  ///< of the mesh before, see UnitMesh
    /// Shared among ranks, at the end of a run that ends in rows: the mesh is empty then.
    std::optional<RemeshedRows<D>> shared = {};
};

/// Inheritance of a remeshed mesh from the one before: its facets approximate the same geometry, and its vertices know
/// their metric.
template <int D>
struct Inherited {
    Geometry<D> geometry;
    Column<LogMetric<D>> log_metrics;
    MetricReport metric;                    ///< of the field that it was remeshed by
    std::optional<BackMesh<D>> field = {};  ///< itself, where that is of a file with a mesh of its own
    EmbeddedCurves<D> curves = {};          ///< of the mesh that was remeshed
};

/// Crossings of a proposal, and its places.
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
    Column<Vec<D>> input_points;  ///< of the vertices as they were read: where the rows of metric files speak
    Column<LagrangeNode<D>> input_nodes = {};  ///< of a mesh of degree 2 its nodes, likewise: what came is told beside
    std::optional<BackMesh<D>> field;          ///< the last that was made
    /// If that is on a curved back mesh: the metric of the straight mesh at its vertices.
    std::optional<Column<LogMetric<D>>> straight_log_metrics;
    std::optional<Inherited<D>> inherited;
    /// Boundary that the stage `remesh` left, against the bounds of the config; empty once a stage changes it.
    std::optional<ReachedDistance<D>> reached;
    std::optional<FinishedRows<D>> rows;              ///< what this rank has in the end: the mesh is empty then
    std::optional<CadMovesReport> cad_moves;          ///< of vertices, before the first stage
    std::optional<std::size_t> crossings_of_input;    ///< pairs of facets that crossed before passes changed the mesh
    std::optional<RelaxedWallsReport> relaxed_walls;  ///< boundary nodes that were moved back because walls crossed
    std::optional<KnownCrossings<D>> crossings;       ///< of the places that the stage `relax` left
    History<D> history;
    JacobianBound bound = {};   ///< what the last stage asked for that did
    JacobianBound target = {};  ///< of repair, for how the last stage placed nodes
    CurveOptions curving = {};  ///< of the last stage that curved: passes have new edges find their nodes alike
};

/// State of a run before its first stage. Errors: unsupported (no simplices of degree 1 or 2).
template <int D>
[[nodiscard]] Outcome<State<D>> beginning_with(Mesh<D> mesh);

// ---------------------------------------------------------------- values that several stages take or make

/// Distribution of a run's result: each rank has all of it, or its rows.
enum class RunEnd : std::uint8_t { whole, rows };

/// The mesh that a metric file speaks of, where its rows are not at the input's vertices.
struct MetricMesh {
    enum class Of { input, another };
    AnyMesh mesh;
    Of of = Of::another;  ///< input: with rows at all nodes of it, as it was read
};

/// A metric's rows: of a file, read by the shell, or made for the run's solution.
struct MetricFile {
    std::string name;
    Solution solution;
    std::optional<MetricMesh> mesh = {};                       ///< none: the rows are at the vertices of the input
    std::optional<config::SolutionMetric> metric_config = {};  ///< none: of a file
    std::vector<DistanceBound> bounds = {};  ///< of the boundary, by the error that the solution expects

    [[nodiscard]] bool is_of(const config::Metric& metric) const {
        if (const auto* file = std::get_if<config::FilePath>(&metric)) return !metric_config && name == file->path;
        const auto* solution_metric = std::get_if<config::SolutionMetric>(&metric);
        return solution_metric != nullptr && metric_config && *metric_config == *solution_metric;
    }
};

/// A metric file's rows in the order of a mesh's vertices and, where there are as many as nodes of a curved one, of its
/// edges: the file's numbers decide. Other rows are left as they are. An edge without a node in the file has the mean
/// of its ends. Errors: memory, stopped.
struct RowsByNodes {
    Solution solution;
    bool is_at_nodes = false;
};
[[nodiscard]] Outcome<RowsByNodes> rows_by_nodes(Solution solution, const DecodedMesh& mesh,
                                                 const Execution& execution);
/// Rows at the vertices, of rows at all nodes of that mesh; others as they are.
[[nodiscard]] Solution rows_at_vertices(RowsByNodes rows, const AnyMesh& mesh);

/// Input of a run that its order of work renumbers: a mesh, and metric files with one row per vertex.
template <int D>
struct StageInputs {
    Mesh<D> mesh;
    std::vector<MetricFile> files = {};
};

/// The mesh made sound, or refused; notices of what was done. It is in the order to work in; none: the given one.
template <int D>
struct Sound {
    StageInputs<D> inputs;
    Notices notices;
    std::optional<BetterOrder> order;
};
template <int D>
[[nodiscard]] Outcome<Sound<D>> prepare_stage(StageInputs<D> specified, std::span<const config::Stage> stages,
                                              const OrderingOptions& ordering, const Execution& execution);

/// Input of a field of log-metrics at the vertices of the straight mesh.
template <int D>
struct MetricInput {
    const LinearMesh<D>& mesh;
    const EdgeSet<D>& edges;
    const Boundary<D>& boundary;
    const Column<Vec<D>>& input_points;  ///< where the rows of files speak
    std::span<const MetricFile> files;   ///< all that the config names
    Column<LogMetric<D>> natural;        ///< the mesh's own, with straight edges or with its curves
    const Inherited<D>* inherited;       ///< of a mesh that was remeshed: its metric is made; null of others
};

/// A config's geometry as a value; the surrogate is built from the mesh, through the nodes of `boundary` if there are
/// any, else through its vertices. Error (usage, with the JSON path):
/// a vector of the wrong dimension, a surface that the dimension does not have, or that the mesh does not lie on. Of a
/// CAD model: errors of `associate`; of another mesh, whose ridges are found by `features_by`: those of
/// geometry_of_mesh.
template <int D>
struct BuiltGeometry {
    Geometry<D> geometry;
    std::optional<CadReport> cad = {};
    std::vector<EdgeId> ridges = {};  ///< edges of the mesh on edges of the model, and vertices on its vertices, rising
    std::vector<VertexId> corners = {};
    std::optional<CurvedPatchesReport> curved_patches = {};
    std::optional<OffSurfacesReport> off_surfaces = {};  ///< of analytic surfaces
    std::optional<Error> fit_error = {};                 ///< the mesh does not belong to the CAD model
};
template <int D>
[[nodiscard]] Outcome<BuiltGeometry<D>> make_geometry(const config::Geometry& geometry, const GeometrySource& source,
                                                      const BoundaryCurves<D>& boundary,
                                                      const FeatureOptions<D>& features_by, const Execution& execution);
/// Policy for vertices that are far from the boundary of the geometry's mesh. Passes leave vertices off it where
/// elements would become invalid or walls would cross, so a mesh that an earlier cycle made is not refused.
enum class FitErrorPolicy : std::uint8_t { refused, accepted };

/// The boundary of another mesh. Errors (usage): it is of another dimension, or lacks a reference of this one's
/// boundary; (input): more than few vertices of the boundary are farther from it than a tenth of their
/// edges, and not between its straight facets and the surfaces over them.
template <int D>
[[nodiscard]] Outcome<Geometry<D>> geometry_of_mesh(const AnyMesh& other, const FeatureOptions<D>& features_by,
                                                    const LinearMesh<D>& mesh, FitErrorPolicy policy,
                                                    const Execution& execution);
/// The analytic surfaces of a config. Errors (usage) with the JSON path, `where` and the item's number.
template <int D>
[[nodiscard]] Outcome<AnalyticGeometry<D>> make_analytic(const std::vector<config::AnalyticSurface>& surfaces,
                                                         const std::string& where, const LinearMesh<D>& mesh,
                                                         const Execution& execution);
/// Vertices that are farther from the surface of a facet than rounding explains: `check_fit` lets pass a tenth of the
/// edges, since meshes are made on surfaces that are not quite those of the model.
template <int D>
[[nodiscard]] OffSurfacesReport off_surfaces(const LinearMesh<D>& mesh, const AnalyticGeometry<D>& geometry);
/// Makes the CAD model alone, of the facets that are not of the references `excluded` (rising). A mesh with too many
/// vertices off the model has a misfit. Errors: those of `associate`.
template <int D>
[[nodiscard]] Outcome<BuiltGeometry<D>> make_cad_geometry(const config::Cad& config, const CadModel& model,
                                                          const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                          std::span<const Reference> excluded,
                                                          const Execution& execution);

/// The source with its CAD model in the unit of the mesh (camber.cad: in_unit_of) where the config has the unit "auto".
/// Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<GeometrySource> in_unit_of_mesh(const config::Geometry& geometry, GeometrySource source,
                                                      const LinearMesh<D>& mesh, const Execution& execution);

[[nodiscard]] bool lies_on_model(const config::Cad& cad, Reference reference);
/// Vertices that are off the model brought onto it, and beside the analytic surfaces onto the curve of both. Errors: as
/// of make_cad_mixture.
template <int D>
struct MovedVertices {
    Column<Vec<D>> points;
    CadMovesReport report;
};
template <int D>
[[nodiscard]] Outcome<MovedVertices<D>> moved_vertices(const config::Cad& config, const CadModel& model,
                                                       const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                       const Execution& execution);
/// The CAD model with what lies beside it: analytic surfaces, and the surrogate of all else, which is made only where
/// there is something. Errors (usage): references that are named twice or that no facet has.
template <int D>
[[nodiscard]] Outcome<BuiltGeometry<D>> make_cad_mixture(const config::Cad& config, const CadModel& model,
                                                         const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                         const SurrogateFactory<D>& surrogate,
                                                         const Execution& execution);

/// The largest distances that a config allows between the boundary and its geometry, by reference: those of chords in
/// its metric and its operations.
[[nodiscard]] std::vector<DistanceBound> required_distances(const config::Pipeline& pipeline);

/// The distances that a run bounds: those that its config requires, or else those that its metrics expect.
struct BoundedDistances {
    std::vector<DistanceBound> bounds;
    bool are_required = true;  ///< a result that exceeds them is not the one that was asked for
};

/// Log-metrics at the vertices, and what the report says of where they are from.
template <int D>
struct SourcedMetric {
    Column<LogMetric<D>> log_metrics;
    MetricReport report;
    Notices notices;
};
/// Metric of a file: a tensor or a size a vertex. Errors (input): of another dimension or number of rows, values that
/// are no metric.
template <int D>
[[nodiscard]] Outcome<SourcedMetric<D>> log_metrics_of_file(const MetricFile& file, std::size_t vertices,
                                                            const Execution& execution);

/// The field of a metric file on the mesh that it speaks of: of form (4) on a curved one.
template <int D>
struct FileField {
    BackMesh<D> back;
    MetricReport report;
    Notices notices;
};
/// Another mesh than that of `requested` must be in the same place: notices of vertices that are outside. Errors: those
/// of log_metrics_of_file; a mesh of another dimension, or in another place (input).
template <int D>
[[nodiscard]] Outcome<FileField<D>> field_of_file(const MetricFile& file, const Column<Vec<D>>& requested,
                                                  const Execution& execution);
template <int D>
[[nodiscard]] Outcome<SourcedMetric<D>> sampled_file(const MetricFile& file, const Column<Vec<D>>& points,
                                                     const Execution& execution);
/// The file of the config's metric, where that has a mesh of its own; else null.
[[nodiscard]] const MetricFile* file_with_mesh(const config::Pipeline& config, std::span<const MetricFile> files);

template <int D>
[[nodiscard]] Outcome<SourcedMetric<D>> make_log_metrics(const MetricInput<D>& input, const config::Metric& metric,
                                                         const Execution& execution);

/// The metrics that are made, not read: of the boundary's normals, of an analytic field. Errors (usage): what is of
/// another dimension, values that are no sizes.
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> make_surface_metric(const config::SurfaceMetric& metric,
                                                                const MetricInput<D>& input,
                                                                const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> make_field_metric(const config::FieldMetric& metric,
                                                              const LinearMesh<D>& mesh, const Execution& execution);

/// A config's operations on a field, one after the other.
template <int D>
[[nodiscard]] Outcome<SourcedMetric<D>> apply_operations(SourcedMetric<D> field, const MetricInput<D>& input,
                                                         std::span<const config::MetricOperation> operations,
                                                         const Execution& execution);

// ---------------------------------------------------------------- fields on a mesh

/// A field at the vertices, or at all nodes, of a mesh.
struct NamedField {
    std::string name;
    FieldKind kind = FieldKind::scalar;
    TransferField field;
};

/// Each component of each field, a value a node.
[[nodiscard]] std::vector<Column<double>> scalars_of(std::span<const NamedField> fields);

/// The fields of these names, each once; no names: all. Errors: a name that there is not (usage), with `where`.
[[nodiscard]] Outcome<std::vector<NamedField>> named(std::vector<NamedField> fields,
                                                     const std::vector<std::string>& names, const std::string& where);

/// The mesh as one of degree 2: a straight one elevated. Errors: of another dimension (internal), memory, stopped.
template <int D>
[[nodiscard]] Outcome<QuadraticMesh<D>> of_degree_2(const AnyMesh& mesh, const Execution& execution);

/// Number of nodes of the mesh in degree 2: its vertices, and one an edge. The nodes of a straight mesh are those of
/// the elevated one. Errors: those of `unique_edges`.
[[nodiscard]] Outcome<std::size_t> nodes_in_degree_2(const AnyMesh& mesh, const Execution& execution);

/// The fields with their values at the vertices alone, as fields of degree 1.
[[nodiscard]] std::vector<NamedField> at_vertices(const AnyMesh& mesh, std::vector<NamedField> fields);

/// The metric that fields ask for: at the vertices of a straight mesh, at all nodes of a curved one. `specified`: those
/// that it is intersected with, rows at the vertices. Each component of each field is a function by itself. Errors:
/// those of `metric_of_solution` and of metric files; fields that are not known alike, none of the names (usage).
struct SolutionMetricResult {
    NamedField metric;
    SolutionMetricReport report;
    std::vector<DistanceBound> bounds = {};  ///< of the boundary, by the expected error (MetricOfSolution)
};
[[nodiscard]] Outcome<SolutionMetricResult> metric_of_fields(const AnyMesh& mesh, std::span<const NamedField> fields,
                                                             const config::SolutionMetric& requested,
                                                             std::span<const Solution> specified, double ridge_angle,
                                                             const StepWrapper& around);

/// The second derivatives of a field of numbers at the vertices, where materials meet the mean of their sides. Errors:
/// those of `recover_derivatives`; no field of numbers (usage).
[[nodiscard]] Outcome<Solution> hessians_of(const AnyMesh& mesh, const NamedField& field, const Execution& execution);

/// The fields of a mesh on another one. Errors: those of `transfer`; meshes of two dimensions (input).
struct TransferredFields {
    std::vector<NamedField> fields;
    TransferReport report;
};
[[nodiscard]] Outcome<TransferredFields> transfer_fields(const AnyMesh& new_mesh, const AnyMesh& old_mesh,
                                                         std::vector<NamedField> fields, const TransferOptions& options,
                                                         const StepWrapper& around);

/// As fields of a mesh file: at the vertices and, of a mesh of degree 2, at the edges' nodes, where a field of degree 1
/// has the means of their ends.
[[nodiscard]] MeshFields as_mesh_fields(const AnyMesh& mesh, std::span<const NamedField> fields);

/// An expression's values at the nodes of a mesh; a straight one has them in the middles of its edges. Errors (usage):
/// one that cannot be read, or has no number at a node; stopped, memory.
[[nodiscard]] Outcome<NamedField> field_of_expression(const AnyMesh& mesh, const std::string& expression,
                                                      const Execution& execution);

/// Fields on the mesh that was read, or an expression.
struct SolutionSource {
    AnyMesh mesh;
    std::vector<NamedField> fields;
    std::string expression;       ///< empty: none
    std::vector<double> weights;  ///< a field each; none: 1 of all
};

/// Each component of each field at the nodes of a mesh that came of that one: those that stayed keep their values; or
/// the expression itself. Step: transfer. Errors: those of `transfer_fields`; an expression that cannot be read;
/// as many weights as fields (usage).
template <int D>
[[nodiscard]] Outcome<SolutionInput<D>> solution_on(const SolutionSource& source, const QuadraticMesh<D>& mesh,
                                                    const StepWrapper& around);

/// The fields that a run's end can show on its mesh, for a VTU file; only those that its stages made known. `field`:
/// null where none was made.
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
/// edges;
/// - `distance_to_geometry` (model units): of boundary nodes from the nearest point of the geometry; NaN in the volume;
/// - `metric` (1/length²): M; at nodes of edges log-Euclidean between the back mesh's vertices.
/// Errors: stopped.
template <int D>
[[nodiscard]] Outcome<MeshFields> mesh_fields(const Quadratic<D>& end, const BackMesh<D>* field,
                                              const std::optional<EdgeLengths>& lengths, const Execution& execution);

/// Metrics (1/length²) by their logs, one a vertex; those at the vertices of the back mesh. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Solution> metric_solution(const Column<LogMetric<D>>& log_metrics, const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Solution> metric_solution(const BackMesh<D>& field, const Execution& execution);
/// The same at all nodes of a curved mesh, those of the edges after the vertices.
template <int D>
[[nodiscard]] Outcome<Solution> metric_solution(const BackMesh<D>& field, const QuadraticMesh<D>& mesh,
                                                const Execution& execution);

/// A solution's fields at the nodes of its mesh: rows are those of the vertices; the nodes of edges get the mean of the
/// edge's ends, log-Euclidean where both tensors are positive definite. A lone symmetric tensor is called `metric`, a
/// lone size `size`, others `field_1` … Errors: input (rows or dimension are not those of the mesh; `name` is the
/// file's), stopped.
[[nodiscard]] Outcome<MeshFields> solution_fields(const Solution& solution, const std::string& name,
                                                  const AnyMesh& mesh, const Execution& execution);

/// L_straight/L − 1 (paper eq. 8) of each edge; 0 where there are no lengths.
[[nodiscard]] std::vector<double> length_reductions(const Column<double>& straight, const Column<double>& lengths);

/// |P^l − M_11|/|P_20 − P_02| of each edge with these nodes; 0 for an edge of no length.
template <int D>
[[nodiscard]] std::vector<double> curvatures(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> mid_nodes);

/// Edges whose lengths are measured: all where the output shows them.
[[nodiscard]] MeasuredEdges reported_lengths(const config::Output& output);

/// Edges whose node is not in the middle of their chord.
template <int D>
[[nodiscard]] std::size_t bent_edges(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal);

/// Length reductions of the volume edges that have lengths, and curvatures of all.
template <int D>
[[nodiscard]] EdgeReport edge_report(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal,
                                     const Column<double>& straight, const Column<double>& lengths);

/// Histograms of a run's end: length reductions, lengths and curvatures of the volume edges (where there are `lengths`,
/// after correction), scaled Jacobians of the elements, "before" (as `curve` left them) and "after" (in the end);
/// lengths also "straight". Without `curve` the Jacobians alone, as "count". Only what is known: no entry for a
/// quantity that was not measured. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<std::vector<Histogram>> run_histograms(const Quadratic<D>& end,
                                                             const std::optional<EdgeLengths>& lengths,
                                                             const History<D>& history, const Execution& execution);

/// Reports the deviation of entities of one kind from the geometry. `vertices`: the worst of them as a vertex or the
/// ends of an edge, from 1; 0: none. `at`: its position.
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

/// Reports pairs of facets; `box_of(facet)` locates the first one that crosses.
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

/// Geometry over the facets of a mesh as a surface of small straight facets, for viewers. Each facet has its own
/// lattice, so that normals may break between them. Fields: `normal` of points; of cells `facet`,
/// the number of the mesh's facet, and `patch`.
struct SurfaceMesh {
    AnyMesh mesh;
    MeshFields fields;
};
/// Each facet in 36 (2D: 6). A facet without a surface is its own plane. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<SurfaceMesh> surface_mesh(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                const Geometry<D>& geometry, const Execution& execution);

}  // namespace camber::run

/// Functions that several files of the module use.
namespace camber::run {

/// Numbers of a config as a vector. Errors (usage): they are not D; `what` names them.
template <int D>
[[nodiscard]] Outcome<Vec<D>> vec(const std::vector<double>& numbers, const char* what) {
    if (numbers.size() != D)
        return fail(ErrorKind::usage, std::string(what) + " has " + std::to_string(numbers.size()) +
                                          " coordinates, the mesh " + std::to_string(D));
    Vec<D> v;
    std::ranges::copy(numbers, v.c.begin());
    return v;
}

/// `nodes`: their number in the mesh's degree.
template <int D>
[[nodiscard]] MeshReport mesh_report(const LinearMesh<D>& mesh, int degree, std::size_t nodes) {
    return {D, degree, mesh.points.size(), nodes, mesh.elements.size(), mesh.facets.size(), mesh.edges.size()};
}

/// A field on cells: the values from the cell `first` on, and `none` on the other cells.
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

/// Tensors of a metric in rows, by its logs `log_at(row)`. Errors: stopped.
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

/// Log-metrics of a field at the points `point_at(row)`. Errors: memory, stopped.
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
