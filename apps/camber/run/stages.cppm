module;
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>
export module camber.run:stages;
import camber.core;
import camber.config;
import camber.curving;
import camber.distributed;
import camber.io;
import camber.metric;
import camber.operation;
import camber.ordering;
import camber.optimisation;
import camber.recipes;
import camber.surface;
import camber.cad;
import camber.validity;
import :geometry_source;
import :histogram;
import :parts;
import :report;
import :state;

/// What more than one stage takes or makes. A stage itself is in stages/NAME.cpp: a function from the values that it
/// needs to what it makes, with its part of the report, and its step, which takes them from the run's state and puts
/// them there (camber.run:steps). What must come before it is in camber.run:order.
export namespace camber::run {

/// Who has what a run makes: each rank all of it, or its rows.
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
    std::optional<MetricMesh> mesh = {};                 ///< none: the rows are at the vertices of the input
    std::optional<config::SolutionMetric> made_by = {};  ///< none: of a file
    std::vector<DistanceBound> bounds = {};              ///< of the boundary, by the error that the solution expects

    /// Whether that metric is meant.
    [[nodiscard]] bool is_of(const config::Metric& metric) const {
        if (const auto* file = std::get_if<config::FilePath>(&metric)) return !made_by && name == file->path;
        const auto* solution_metric = std::get_if<config::SolutionMetric>(&metric);
        return solution_metric != nullptr && made_by && *made_by == *solution_metric;
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
/// Of rows at all nodes of that mesh those at its vertices; others as they are.
[[nodiscard]] Solution rows_at_vertices(RowsByNodes rows, const AnyMesh& mesh);

}  // namespace camber::run

namespace camber::run {

/// A mesh, and rows of its vertices.
template <int D>
struct StageInputs {
    GivenMesh<D> mesh;
    std::vector<MetricFile> files;
    std::shared_ptr<Ranks> ranks = one_rank();  ///< who share what goes by blocks
    RunEnd end = RunEnd::whole;
};

/// The mesh made sound, or refused; notices of what was done. It is in the order to work in; none: the given one.
template <int D>
struct Sound {
    StageInputs<D> inputs;
    Notices notices;
    std::optional<BetterOrder> order;
};
template <int D>
[[nodiscard]] Outcome<Sound<D>> prepare_stage(StageInputs<D> given, std::span<const config::Stage> stages,
                                              const OrderingOptions& ordering, const Execution& execution);

/// What a field of log-metrics at the vertices of the straight mesh is made from.
template <int D>
struct MetricInput {
    const LinearMesh<D>& mesh;
    const EdgeSet<D>& edges;
    const Boundary<D>& boundary;
    const Column<Vec<D>>& given_points;  ///< where the rows of files speak
    std::span<const MetricFile> files;   ///< all that the config names
    Column<LogMetric<D>> natural;        ///< the mesh's own, with straight edges or with its curves
    const Inherited<D>* inherited;       ///< of a mesh that was remeshed: its metric is made; null of others
};

/// Of targets that were found; how fast is for the runner to say.
template <int D>
[[nodiscard]] CurveReport curve_report(const QuadraticMesh<D>& mesh, const Curved<D>& curved);

/// A config's geometry as a value; the surrogate is built from the mesh. `curves`: the nodes of its edges, where its
/// boundary's curves are the geometry; empty: smooth surfaces through its vertices. Error (usage, with the JSON path):
/// a vector of the wrong dimension, a surface that the dimension does not have, or that the mesh does not lie on. Of a
/// CAD model: errors of `associate`; of another mesh, whose ridges are found by `features_by`: those of
/// geometry_of_mesh.
template <int D>
struct MadeGeometry {
    Geometry<D> geometry;
    std::optional<CadReport> cad = {};
    std::vector<EdgeId> ridges = {};  ///< edges of the mesh on edges of the model, and vertices on its vertices, rising
    std::vector<VertexId> corners = {};
    std::optional<CurvedPatchesReport> curved_patches = {};
    std::optional<OffSurfacesReport> off_surfaces = {};  ///< of analytic surfaces
    std::optional<Error> misfit = {};                    ///< the mesh does not belong to the CAD model
};
template <int D>
[[nodiscard]] Outcome<MadeGeometry<D>> make_geometry(const config::Geometry& geometry, const GeometrySource& source,
                                                     const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                     const Features<D>& features, const FeatureOptions<D>& features_by,
                                                     std::span<const LagrangeNode<D>> curves,
                                                     const Execution& execution);
/// Policy for vertices that are far from the boundary of the geometry's mesh. Passes leave vertices off it where
/// elements would become invalid or walls would cross, so a mesh that an earlier cycle made is not refused.
enum class MisfitPolicy : std::uint8_t { refused, accepted };

/// The boundary of another mesh. Errors (usage): it is of another dimension, or lacks a reference of this one's
/// boundary; (input): more than few vertices of the boundary are farther from it than a tenth of their
/// edges, and not between its straight facets and the surfaces over them.
template <int D>
[[nodiscard]] Outcome<Geometry<D>> geometry_of_mesh(const AnyMesh& other, const FeatureOptions<D>& features_by,
                                                    const LinearMesh<D>& mesh, MisfitPolicy misfits,
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
/// Makes the CAD model alone, of the facets that are not of the references `elsewhere` (rising). A mesh with too many
/// vertices off the model has a misfit. Errors: those of `associate`.
template <int D>
[[nodiscard]] Outcome<MadeGeometry<D>> make_cad_geometry(const config::Cad& config, const CadModel& model,
                                                         const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                         std::span<const Reference> elsewhere,
                                                         const Execution& execution);

/// The source with its CAD model in the unit of the mesh (camber.cad: in_unit_of) where the config has the unit "auto".
/// Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<GeometrySource> in_unit_of_mesh(const config::Geometry& geometry, GeometrySource source,
                                                      const LinearMesh<D>& mesh, const Execution& execution);

/// Whether facets of a reference lie on the model.
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
[[nodiscard]] Outcome<MadeGeometry<D>> make_cad_mixture(const config::Cad& config, const CadModel& model,
                                                        const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                        const MakesSurrogate<D>& surrogate, const Execution& execution);

/// The largest distances that a config allows between the boundary and its geometry, by reference: those of chords in
/// its metric and its operations.
[[nodiscard]] std::vector<DistanceBound> required_distances(const config::Pipeline& pipeline);

/// The distances that a run bounds: those that its config requires, or else those that its metrics expect.
struct BoundedDistances {
    std::vector<DistanceBound> bounds;
    bool are_required = true;  ///< a result that exceeds them is not the one that was asked for
};
[[nodiscard]] BoundedDistances bounded_distances(const config::Pipeline& pipeline, std::span<const MetricFile> files);

/// Log-metrics at the vertices, and what the report says of where they are from.
template <int D>
struct SourcedMetric {
    Column<LogMetric<D>> log_metrics;
    MetricReport report;
    Notices notices;
};
/// Of a file: a tensor or a size a vertex. Errors (input): of another dimension or number of rows, values that are no
/// metric.
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
/// Where it is another mesh than `asked`, which is to take its metric, it must be in the same place: notices of
/// vertices that are outside. Errors: those of log_metrics_of_file; a mesh of another dimension, or in another place
/// (input).
template <int D>
[[nodiscard]] Outcome<FileField<D>> field_of_file(const MetricFile& file, const Column<Vec<D>>& asked,
                                                  const Execution& execution);
/// That field at points.
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

}  // namespace camber::run
