module;
#include <optional>
#include <span>
module camber.run:steps;
import camber.core;
import camber.config;
import camber.curving;
import camber.io;
import camber.metric;
import camber.validity;
import :memory;
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

/// The boundary as the config describes it, before a stage that curves or changes topology; `curves`: see
/// make_geometry. Errors (usage): a geometry that is not the mesh's.
template <int D>
[[nodiscard]] Outcome<Boundary<D>> describe_boundary(Runner<D>& run, const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                     std::span<const LagrangeNode<D>> curves = {});

/// Nodes of boundary edges where the options want them in the field: placed_input, slid_input; told of.
template <int D>
[[nodiscard]] Outcome<CurveInput<D>> moved_input(Runner<D>& run, const Boundary<D>& boundary, CurveInput<D> input,
                                                 const BackMesh<D>& field, const config::Curve& options,
                                                 const Execution& execution);

/// The field of the config's metric on the mesh itself, straight or with its curves, and what was told of it. Errors:
/// as of make_field.
template <int D>
struct OwnField {
    BackMesh<D> back;
    MetricReport report;
};
template <int D>
[[nodiscard]] Outcome<OwnField<D>> make_own_field(Runner<D>& run, const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                  const Boundary<D>& boundary);
template <int D>
[[nodiscard]] Outcome<OwnField<D>> make_own_field(Runner<D>& run, const QuadraticMesh<D>& mesh,
                                                  const Boundary<D>& boundary);

/// Before any work of passes: what those of the config will make of the run's mesh; none where none of them splits.
/// Errors: those of describe_boundary and make_own_field; memory: more than there is room for.
template <int D>
[[nodiscard]] Outcome<std::optional<Growth>> asked_growth(Runner<D>& run);

/// A mesh that passes have changed becomes one as any other; nothing where none has.
template <int D>
[[nodiscard]] Outcome<Done> finish(Runner<D>& run);

/// What edges are curved from, before the field.
template <int D>
[[nodiscard]] Outcome<CurveInput<D>> begin_curving(Runner<D>& run, const Boundary<D>& boundary,
                                                   const config::Curve& options);

/// The field of the config's metric, before a stage that curves by it; volume edges then start where it has them.
/// Errors name the JSON path of the metric or the operation, or the file.
template <int D>
[[nodiscard]] Outcome<CurveInput<D>> make_field(Runner<D>& run, const Boundary<D>& boundary, CurveInput<D> input,
                                                CurvingAim aim);

/// A mesh that was read with its curves brings what else the stage `curve` proposes: its nodes become the plan where
/// there is none.
template <int D>
[[nodiscard]] Outcome<Done> adopt_own_nodes(Runner<D>& run);

/// Within a stage: the bound that it asks for, or that a stage before did, or the wish.
template <int D>
[[nodiscard]] JacobianBound bound_for(Runner<D>& run, const JacobianBound& of_stage);

/// Within a stage: the plan is judged to that bound, as the last stage judged it, or anew.
template <int D>
[[nodiscard]] Outcome<Done> judge_plan(Runner<D>& run, double bound, const Execution& execution);

/// The verdicts as they are now: told, and those of before as long as nothing was corrected.
template <int D>
void report_verdicts(Runner<D>& run, const Validation<D>& validation);

/// How fast edges found their nodes.
template <int D>
void report_curve(Runner<D>& run, CurveReport part, double seconds);

/// The last step: what the report says of the end, and the lengths after correction where they were measured.
template <int D>
[[nodiscard]] Outcome<std::optional<EdgeLengths>> measure(Runner<D>& run);

}  // namespace camber::run
