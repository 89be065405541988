module;
#include <cstdint>
#include <optional>
#include <span>
#include <string>
export module camber.run:stages;
import camber.core;
import camber.config;
import camber.io;
import camber.metric;
import camber.surface;
import :report;
import :state;

namespace camber::run {

/// A metric file's rows, read by the shell.
struct MetricFile {
    std::string name;
    Solution solution;
};

/// Each stage: the next state, and what it found added to the report.

/// The mesh made sound, or refused: `prepare`; what was done becomes notices.
template <int D>
Outcome<State<D>> prepare_stage(State<D> state, Report& report, const Execution& execution);

template <int D>
Outcome<State<D>> elevate_stage(State<D> state, Report& report, const Execution& execution);

/// The nodes of a mesh that was read with its curves become the proposal: its boundary's features tell what is given.
template <int D>
Outcome<State<D>> adopt_stage(State<D> state, const config::Features& features, Report& report,
                              const Execution& execution);

/// Features and geometry of the boundary.
template <int D>
Outcome<State<D>> surface_stage(State<D> state, const config::Features& features, const config::Geometry& geometry,
                                Report& report, const Execution& execution);

/// The back mesh: log-metrics at the vertices of the straight mesh, after the operations. `operands`: the files that
/// the operations intersect with, by name. Errors name the operation's JSON path.
template <int D>
Outcome<State<D>> metric_stage(State<D> state, const config::Metric& metric, const std::optional<MetricFile>& file,
                               std::span<const config::MetricOperation> operations,
                               std::span<const MetricFile> operands, Report& report, const Execution& execution);

template <int D>
Outcome<State<D>> curve_stage(State<D> state, const config::Curve& options, Report& report, const Execution& execution);

template <int D>
Outcome<State<D>> validate_stage(State<D> state, const config::Validate& options, Report& report,
                                 const Execution& execution);

template <int D>
Outcome<State<D>> relax_stage(State<D> state, const config::Relax& options, Report& report, const Execution& execution);

/// The proposal becomes the mesh's, valid or not: what is not is in the report, and the program's exit code.
template <int D>
Outcome<State<D>> commit_stage(State<D> state, Report& report, const Execution& execution);

/// The global algorithm of the cavity operator, in place of curve, validate, relax and commit.
template <int D>
Outcome<State<D>> reinsert_stage(State<D> state, const config::Reinsert& options, Report& report,
                                 const Execution& execution);

/// Gains after correction and distances of the boundary, for the report.
template <int D>
Outcome<State<D>> measure_stage(State<D> state, Report& report, const Execution& execution);

/// A config's geometry as a value; the surrogate is built from the mesh. Error (usage): a vector of the wrong
/// dimension, a surface that the dimension does not have.
template <int D>
Outcome<Geometry<D>> make_geometry(const config::Geometry& geometry, const State<D>& state, const Execution& execution);

template <int D>
Outcome<Column<LogMetric<D>>> make_log_metrics(const config::Metric& metric, const std::optional<MetricFile>& file,
                                               const State<D>& state, Report& report, const Execution& execution);

/// The metrics that are made, not read: of the boundary's normals (after the surface stage), of an analytic field, of
/// expressions. Errors (usage): what is of another dimension, values that are no sizes.
template <int D>
Outcome<Column<LogMetric<D>>> make_surface_metric(const config::SurfaceMetric& metric, const State<D>& state,
                                                  const Execution& execution);
template <int D>
Outcome<Column<LogMetric<D>>> make_field_metric(const config::FieldMetric& metric, const LinearMesh<D>& mesh,
                                                const Execution& execution);

/// A config's operations on a field, one after the other; figures go into the report's metric.
template <int D>
Outcome<Column<LogMetric<D>>> operated(Column<LogMetric<D>> field, std::span<const config::MetricOperation> operations,
                                       std::span<const MetricFile> operands, const State<D>& state, Report& report,
                                       const Execution& execution);

}  // namespace camber::run
