module;
#include <optional>
#include <span>
#include <string>
#include <vector>
export module camber.run:stages;
import camber.core;
import camber.cavity;
import camber.config;
import camber.curving;
import camber.io;
import camber.metric;
import camber.programmes;
import camber.surface;
import camber.validity;
import :histogram;
import :parts;
import :report;
import :state;

/// The stages and the steps before them: from the values that each needs to what it makes, with its part of the report.
/// `elevate` and `validate` are the verbs of the modules as they are. What must come before a stage is in
/// camber.run:order; clocks, progress and the run's state are the runner's (pipeline.cpp).
export namespace camber::run {

/// A metric file's rows, read by the shell.
struct MetricFile {
    std::string name;
    Solution solution;
};

}  // namespace camber::run

namespace camber::run {

/// The mesh made sound, or refused; notices of what was done.
template <int D>
struct Sound {
    GivenMesh<D> mesh;
    Notices notices;
};
template <int D>
[[nodiscard]] Outcome<Sound<D>> prepare_stage(GivenMesh<D> mesh, const Execution& execution);

/// Features and geometry of the boundary. Errors (usage): those of a geometry that is not the mesh's.
template <int D>
struct Described {
    Boundary<D> boundary;
    BoundaryReport report;
};
template <int D>
[[nodiscard]] Outcome<Described<D>> surface_stage(const QuadraticMesh<D>& mesh, const config::Features& features,
                                                  const config::Geometry& geometry, const Execution& execution);

/// A field of log-metrics at the vertices of the straight mesh, after the config's operations. Errors name the JSON
/// path of the metric or the operation, or the file.
template <int D>
struct MetricInput {
    const QuadraticMesh<D>& mesh;
    const Boundary<D>& boundary;
    const Column<Vec<D>>& given_points;  ///< where the rows of files speak
    std::span<const MetricFile> files;   ///< all that the config names
};
template <int D>
struct Field {
    BackMesh<D> back;
    MetricReport report;
    Notices notices;
};
template <int D>
[[nodiscard]] Outcome<Field<D>> metric_stage(const MetricInput<D>& input, const config::Metric& metric,
                                             std::span<const config::MetricOperation> operations,
                                             const Execution& execution);

/// What the edges of a mesh are curved from: where boundary nodes are wanted, one row an edge, and which nodes stay.
template <int D>
struct CurveInput {
    Column<EdgeKind> kinds;
    Column<LagrangeNode<D>> boundary_nodes;
    Incidence<ElementId> shells;
    Notices notices;
};
/// Boundary nodes on the geometry.
template <int D>
[[nodiscard]] Outcome<CurveInput<D>> input_of_elevated(const QuadraticMesh<D>& mesh, const Boundary<D>& boundary,
                                                       const Execution& execution);
/// The same of a mesh that was read with its curves: boundary nodes where they are, but for edges on analytic surfaces.
template <int D>
[[nodiscard]] Outcome<CurveInput<D>> input_of_read(const QuadraticMesh<D>& mesh, const Boundary<D>& boundary,
                                                   const Execution& execution);

/// Where nodes are wanted: those of the volume by the field, or without one by `shape`.
template <int D>
struct CurveOutput {
    Curved<D> curved;
    CurveReport report;
};
template <int D>
[[nodiscard]] Outcome<CurveOutput<D>> curve_stage(const QuadraticMesh<D>& mesh, const CurveInput<D>& input,
                                                  const BackMesh<D>& field, const config::Curve& options,
                                                  const Execution& execution);
template <int D>
[[nodiscard]] Outcome<CurveOutput<D>> shape_stage(const QuadraticMesh<D>& mesh, const CurveInput<D>& input,
                                                  const Execution& execution);

/// The nodes of a mesh that was read with its curves as a plan: its boundary's features tell what is given.
template <int D>
struct Adopted {
    OwnNodes<D> own;
    Proposal<D> proposal;
    BoundaryReport report;
};
template <int D>
[[nodiscard]] Outcome<Adopted<D>> adopt_stage(const QuadraticMesh<D>& mesh, const config::Features& features,
                                              const Execution& execution);

/// Models of what a node off its wanted place costs: in the field, or in the mesh's own metric where there is none
/// (null). None for repairs that take none.
template <int D>
[[nodiscard]] Outcome<Column<QuadraticModel<D>>> models_of(const Plan<D>& plan, const JudgedProposal<D>& judged,
                                                           const BackMesh<D>* field, config::Repair repair,
                                                           const Execution& execution);

/// What is not valid mended; boundary nodes may go back to their chords.
template <int D>
struct Relaxed {
    JudgedProposal<D> judged;
    CorrectionReport report;
};
template <int D>
[[nodiscard]] Outcome<Relaxed<D>> relax_stage(const JudgedProposal<D>& judged, const Column<QuadraticModel<D>>& models,
                                              const config::Relax& options, const Execution& execution);
/// The same where the boundary is given: it stays, but for the options' tolerance.
template <int D>
[[nodiscard]] Outcome<Relaxed<D>> relax_within_stage(const JudgedProposal<D>& judged,
                                                     const Column<QuadraticModel<D>>& models,
                                                     const config::Relax& options, const Execution& execution);

/// The proposal becomes the mesh's, valid or not: what is not is in the report, and the program's exit code.
template <int D>
[[nodiscard]] Outcome<QuadraticMesh<D>> commit_stage(const JudgedProposal<D>& judged);

/// The global algorithm of the cavity operator, in place of curve, validate, relax and commit.
template <int D>
struct Walked {
    Reinserted<D> done;
    Validation<D> wanted, validation;  ///< of the targets, and in the end
    CavitiesReport report;
    Notices notices;
};
template <int D>
[[nodiscard]] Outcome<Walked<D>> reinsert_stage(const QuadraticMesh<D>& mesh, const CurveInput<D>& input,
                                                const BackMesh<D>& field, const config::Reinsert& options,
                                                const Execution& execution);

/// Lengths after correction, against the chords as they are then, for the fields; the rest for the report.
template <int D>
struct Measured {
    std::optional<EdgeLengths> lengths;
    MeasuresReport report;
};
template <int D>
[[nodiscard]] Outcome<Measured<D>> measure_stage(const Quadratic<D>& end, const BackMesh<D>* field,
                                                 const History<D>& history, const Execution& execution);

/// The options of a curving for one edge.
[[nodiscard]] EdgeMinimiserOptions edge_options(const config::Curve& options);

/// Of targets that were found; how fast is for the runner to say.
template <int D>
[[nodiscard]] CurveReport curve_report(const QuadraticMesh<D>& mesh, const Curved<D>& curved);

/// A config's geometry as a value; the surrogate is built from the mesh. Error (usage, with the JSON path): a vector of
/// the wrong dimension, a surface that the dimension does not have, or that the mesh does not lie on.
template <int D>
[[nodiscard]] Outcome<Geometry<D>> make_geometry(const config::Geometry& geometry, const QuadraticMesh<D>& mesh,
                                                 const Features<D>& features, const Execution& execution);

/// Log-metrics at the vertices, and what the report says of where they are from.
template <int D>
struct SourcedMetric {
    Column<LogMetric<D>> log_metrics;
    MetricReport report;
    Notices notices;
};
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
[[nodiscard]] Outcome<SourcedMetric<D>> operated(SourcedMetric<D> field, const MetricInput<D>& input,
                                                 std::span<const config::MetricOperation> operations,
                                                 const Execution& execution);

}  // namespace camber::run
