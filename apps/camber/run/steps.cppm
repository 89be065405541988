module;
#include <optional>
#include <span>
module camber.run:steps;
import camber.core;
import camber.config;
import camber.curving;
import camber.io;
import camber.metric;
import camber.recipes;
import camber.surface;
import camber.validity;
import :geometry_source;
import :memory;
import :parts;
import :report;
import :runner;
import :stages;
import :state;

/// The steps of a run: each takes what its stage needs from the run's state, and puts there and tells what it made.
namespace camber::run {

/// One for each row of `stage_rows`, in stages/NAME.cpp. Errors: those of its verb, and stopped.
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Elevate& options);
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Curve& options);
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Validate& options);
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Relax& options);
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Commit& options);
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Reinsert& options);
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Collapse& options);
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Split& options);
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Swap& options);
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Smooth& options);
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Mend& options);
template <int D>
[[nodiscard]] Outcome<Done> apply(Runner<D>& run, const config::Remesh& options);

/// Vertices of the boundary brought onto the CAD model, where the config wants that; before the first stage.
template <int D>
[[nodiscard]] Outcome<Done> move_vertices(Runner<D>& run);

/// Features and geometry as a config describes them, of a mesh that nothing has changed.
template <int D>
struct DescribedBoundary {
    Boundary<D> boundary;
    BoundaryReport report;
};
/// Errors (usage): a geometry that is not the mesh's.
template <int D>
[[nodiscard]] Outcome<DescribedBoundary<D>> boundary_by_config(const config::Pipeline& pipeline,
                                                               const GeometrySource& source, const LinearMesh<D>& mesh,
                                                               const EdgeSet<D>& edges, const Execution& execution);

/// The boundary as the config describes it, before a stage that curves or changes topology; `curves`: see
/// make_geometry. Errors (usage): a geometry that is not the mesh's.
template <int D>
[[nodiscard]] Outcome<Boundary<D>> describe_boundary(Runner<D>& run, const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                     std::span<const LagrangeNode<D>> curves = {});

/// What was told of the config's metric when it was made.
struct MetricTold {
    std::optional<MetricReport> report;
    Notices notices;
};
/// The config's metric as recipes take it. Errors, when it is made, name the JSON path of the metric or the operation,
/// or the file. All arguments are asked then.
template <int D>
[[nodiscard]] MetricSource<D> metric_for_curving(const Runner<D>& run, const QuadraticMesh<D>& mesh,
                                                 const Boundary<D>& boundary, MetricTold& told);
/// The same as a field on the mesh itself, straight or with its curves, and what was told of it.
template <int D>
struct OwnField {
    BackMesh<D> back;
    MetricReport report;
    MetricOrigin origin = MetricOrigin::natural;
};
template <int D>
[[nodiscard]] Outcome<OwnField<D>> make_own_field(Runner<D>& run, const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                  const Boundary<D>& boundary);
template <int D>
[[nodiscard]] Outcome<OwnField<D>> make_own_field(Runner<D>& run, const QuadraticMesh<D>& mesh,
                                                  const Boundary<D>& boundary);
template <int D>
void report_metric(Runner<D>& run, MetricTold told);

/// Before any work of passes: what those of the config will make of the run's mesh; none where none of them splits.
/// Errors: those of describe_boundary and make_own_field; memory: more than there is room for.
template <int D>
[[nodiscard]] Outcome<std::optional<Growth>> asked_growth(Runner<D>& run);

/// The field that passes of the config would go by, on the run's mesh as it is. Errors: those of describe_boundary and
/// make_own_field.
template <int D>
[[nodiscard]] Outcome<OwnField<D>> asked_field(Runner<D>& run);

/// A mesh that passes have changed becomes one as any other; nothing where none has.
template <int D>
[[nodiscard]] Outcome<Done> finish(Runner<D>& run);

/// A mesh that was read with its curves brings what else the stage `curve` proposes: its nodes become the plan where
/// there is none.
template <int D>
[[nodiscard]] Outcome<Done> adopt_own_nodes(Runner<D>& run);

/// Within a stage: the bound that it asks for, or that a stage before did, or the recommended one.
template <int D>
[[nodiscard]] JacobianBound bound_for(Runner<D>& run, const JacobianBound& of_stage);

/// Within a stage: the plan is judged to that bound, as the last stage judged it, or anew.
template <int D>
[[nodiscard]] Outcome<Done> judge_plan(Runner<D>& run, double bound, const Execution& execution);

/// The verdicts as they are now: told, and those of before as long as nothing was corrected.
template <int D>
void report_verdicts(Runner<D>& run, const Validation<D>& validation);

/// What was proposed, in those seconds; and how nodes of a mesh with curves of its own fared.
template <int D>
void report_curves(Runner<D>& run, const ProposedCurves<D>& made, const ProposeOptions& options, double seconds);

/// The field goes to the run's state, the rest to a plan.
template <int D>
[[nodiscard]] Wanted<D> keep_field(Runner<D>& run, Boundary<D> boundary, ProposedCurves<D> made, CurvingAim aim);

/// The last step: what the report says of the end, and the lengths after correction where they were measured.
template <int D>
[[nodiscard]] Outcome<std::optional<EdgeLengths>> measure(Runner<D>& run);

}  // namespace camber::run
