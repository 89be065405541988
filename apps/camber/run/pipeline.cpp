module;
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
module camber.run;
import camber.core;
import camber.bezier;
import camber.config;
import camber.io;
import camber.shapes;
import camber.metric;
import camber.surface;
import camber.validity;
import camber.curving;
import :fields;
import :report;
import :order;
import :parts;
import :stages;
import :state;

namespace camber::run {

namespace {

/// Where an error of a stage happened, unless the stage itself says it.
Error at(Error error, const std::string& path) {
    if (error.where.empty() && error.kind == ErrorKind::usage) error.where = path;
    return error;
}

/// f(execution) → Outcome under the shell's wrapper, by that name.
template <class F>
std::invoke_result_t<F, const Execution&> step(const Around& around, std::string_view name, F&& f) {
    std::optional<std::invoke_result_t<F, const Execution&>> made;
    const auto done = around(name, [&](const Execution& execution) -> Outcome<Done> {
        made = guarded([&] { return f(execution); });
        if (!*made) return fail(made->error());
        return Done{};
    });
    if (!done) return fail(done.error());
    return std::move(*made);
}

double seconds_since(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

MeshReport mesh_report(const AnyMesh& mesh) {
    return std::visit(
        []<class Mesh>(const Mesh& m) {
            constexpr int degree = requires { m.linear; } ? 2 : 1;
            const auto& [linear, nodes] = [&] {
                if constexpr (degree == 2)
                    return std::pair(&m.linear, m.linear.points.size() + m.edges.size());
                else
                    return std::pair(&m, m.points.size());
            }();
            return MeshReport{Mesh::dimension,         degree,
                              linear->points.size(),   nodes,
                              linear->elements.size(), linear->facets.size(),
                              linear->edges.size()};
        },
        mesh);
}

/// One run in D dimensions: gives each stage what it needs of the state, and puts what it made there and into the
/// report. That the state has it, `check_order` has seen before.
template <int D>
class Runner {
  public:
    Runner(const config::Pipeline& pipeline, GivenMesh<D> mesh, std::span<const MetricFile> files, const Around& around)
        : pipeline_(pipeline), state_(beginning_with<D>(std::move(mesh))), files_(files), around_(around) {}

    Outcome<Run> run(const Notices& notices) {
        add(report_, notices);
        for (std::size_t i = 0; i < pipeline_.stages.size(); ++i) {
            auto done = std::visit([&](const auto& stage) { return apply(stage); }, pipeline_.stages[i]);
            if (!done) return fail(at(done.error(), "/stages/" + std::to_string(i)));
        }
        return ended();
    }

  private:
    template <class F>
    auto step(std::string_view name, F&& f) {
        return run::step(around_, name, std::forward<F>(f));
    }
    /// The step of a stage of that type.
    template <class Options, class F>
    auto step_of(F&& f) {
        return step(std::get<StageRow<Options>>(stage_rows).name, std::forward<F>(f));
    }

    Quadratic<D>& quadratic() { return std::get<Quadratic<D>>(state_.mesh); }
    Plan<D>& plan() { return std::get<Plan<D>>(quadratic().plan); }
    const BackMesh<D>* field() const { return state_.field ? &*state_.field : nullptr; }

    Outcome<Done> apply(const config::Elevate&) {
        auto mesh = step_of<config::Elevate>(
            [&](const Execution& e) { return elevate(std::get<LinearMesh<D>>(state_.mesh), e); });
        if (!mesh) return fail(mesh.error());
        state_.mesh = Quadratic<D>{std::move(*mesh), NodesOf::elevation, Unplanned<D>{}};
        return Done{};
    }

    Outcome<Boundary<D>> describe_boundary() {
        auto made = step("surface", [&](const Execution& e) {
            return surface_stage(quadratic().mesh, pipeline_.features, pipeline_.geometry, e);
        });
        if (!made) return fail(made.error());
        add(report_, made->report);
        return std::move(made->boundary);
    }
    Outcome<Done> make_field(const Boundary<D>& boundary) {
        auto made = step("metric", [&](const Execution& e) {
            const MetricInput<D> input{quadratic().mesh, boundary, state_.given_points, files_};
            return metric_stage(input, pipeline_.metric, pipeline_.metric_operations, e);
        });
        if (!made) return fail(made.error());
        add(report_, made->report);
        add(report_, made->notices);
        state_.field = std::move(made->back);
        return Done{};
    }
    Outcome<CurveInput<D>> curve_input(const Boundary<D>& boundary, const Execution& execution) {
        const auto input = quadratic().nodes == NodesOf::file ? input_of_read<D> : input_of_elevated<D>;
        auto made = input(quadratic().mesh, boundary, execution);
        if (made) add(report_, made->notices);
        return made;
    }

    Outcome<Done> apply(const config::Curve& options) {
        auto boundary = describe_boundary();
        if (!boundary) return fail(boundary.error());
        const bool by_metric = options.objective != config::Objective::shape;
        if (by_metric)
            if (auto made = make_field(*boundary); !made) return made;
        return step_of<config::Curve>([&](const Execution& e) -> Outcome<Done> {
            auto input = curve_input(*boundary, e);
            if (!input) return fail(input.error());
            const QuadraticMesh<D>& mesh = quadratic().mesh;
            const auto begin = std::chrono::steady_clock::now();
            auto made = by_metric ? curve_stage(mesh, *input, *state_.field, options, e) : shape_stage(mesh, *input, e);
            if (!made) return fail(made.error());
            enter(std::move(made->report), seconds_since(begin));
            if (by_metric && quadratic().nodes == NodesOf::file) add(report_, Notices{starts_from_file});
            Proposal<D> proposal = made->curved.proposal;
            quadratic().plan =
                Plan<D>{Wanted<D>{std::move(*boundary), std::move(input->shells), std::move(made->curved)},
                        std::move(proposal)};
            return Done{};
        });
    }

    Outcome<Done> apply(const config::Validate& options) {
        return step_of<config::Validate>([&](const Execution& e) { return judge(options.min_scaled_jacobian, e); });
    }

    /// A mesh that was read with its curves brings what else the stage "curve" proposes.
    Outcome<Done> adopt_own_nodes() {
        if (quadratic().planned()) return Done{};
        auto made =
            step("features", [&](const Execution& e) { return adopt_stage(quadratic().mesh, pipeline_.features, e); });
        if (!made) return fail(made.error());
        add(report_, made->report);
        quadratic().plan = Plan<D>{std::move(made->own), std::move(made->proposal)};
        return Done{};
    }

    Outcome<Done> apply(const config::Relax& options) {
        if (auto adopted = adopt_own_nodes(); !adopted) return adopted;
        return step_of<config::Relax>([&](const Execution& e) -> Outcome<Done> {
            if (auto done = judge_plan(options.min_scaled_jacobian, e); !done) return done;
            const JudgedProposal<D>& judged = *plan().judged();
            const auto models = models_of(plan(), judged, field(), options.repair, e);
            if (!models) return fail(models.error());
            const auto relax = quadratic().boundary_is_given() ? relax_within_stage<D> : relax_stage<D>;
            auto made = relax(judged, *models, options, e);
            if (!made) return fail(made.error());
            add(report_, made->report);
            close_history();
            plan().places = std::move(made->judged);
            enter(*plan().validation());
            return Done{};
        });
    }

    Outcome<Done> apply(const config::Commit&) {
        if (auto adopted = adopt_own_nodes(); !adopted) return adopted;
        return step_of<config::Commit>([&](const Execution& e) -> Outcome<Done> {
            if (!plan().judged())
                if (auto done = judge_plan(config::Validate{}.min_scaled_jacobian, e); !done) return done;
            const JudgedProposal<D> judged = *plan().judged();
            auto mesh = commit_stage(judged);
            if (!mesh) return fail(mesh.error());
            quadratic().mesh = std::move(*mesh);
            plan().places = Settled<D>{judged.proposal(), judged.validation()};
            report_.committed = true;
            return Done{};
        });
    }

    Outcome<Done> apply(const config::Reinsert& options) {
        auto boundary = describe_boundary();
        if (!boundary) return fail(boundary.error());
        if (auto made = make_field(*boundary); !made) return made;
        return step_of<config::Reinsert>([&](const Execution& e) -> Outcome<Done> {
            auto input = curve_input(*boundary, e);
            if (!input) return fail(input.error());
            const auto begin = std::chrono::steady_clock::now();
            auto made = reinsert_stage(quadratic().mesh, *input, *state_.field, options, e);
            if (!made) return fail(made.error());
            add(report_, made->report);
            add(report_, made->notices);
            enter(std::move(made->report.curve), seconds_since(begin));
            state_.history = Corrected<D>{std::move(made->wanted)};
            quadratic().mesh = std::move(made->done.mesh);
            quadratic().plan =
                Plan<D>{Wanted<D>{std::move(*boundary), std::move(input->shells), std::move(made->done.wanted)},
                        Settled<D>{std::move(made->done.proposal), std::move(made->validation)}};
            enter(*quadratic().validation());
            report_.committed = true;
            return Done{};
        });
    }

    /// The verdicts of what is planned, or of the mesh where nothing is.
    Outcome<Done> judge(double bound, const Execution& execution) {
        if (quadratic().planned()) return judge_plan(bound, execution);
        auto validation = validate(quadratic().mesh, bound, execution);
        if (!validation) return fail(validation.error());
        enter(*validation);
        quadratic().plan = Unplanned<D>{std::move(*validation)};
        return Done{};
    }
    /// As the last stage judged it, or anew.
    Outcome<Done> judge_plan(double bound, const Execution& execution) {
        const JudgedProposal<D>* const there = plan().judged();
        if (!there || there->validation().bound != bound) {
            auto judged = validate(quadratic().mesh, plan().proposal(), bound, execution);
            if (!judged) return fail(judged.error());
            plan().places = std::move(*judged);
        }
        enter(*plan().validation());
        return Done{};
    }

    void enter(CurveReport part, double seconds) {
        part.edges_per_second = static_cast<double>(part.volume_edges) / std::max(seconds, 1e-9);
        add(report_, part);
    }
    void enter(const Validation<D>& validation) {
        const VerdictsReport part = verdicts_report(validation);
        add(report_, part);
        auto* const open = std::get_if<Uncorrected<D>>(&state_.history);
        if (!open) return;
        open->last = validation;
        report_.validity_before = part.summary;
    }
    /// Before verdicts of what was corrected come.
    void close_history() {
        if (auto* open = std::get_if<Uncorrected<D>>(&state_.history)) {
            Validation<D> before = std::move(open->last).value();
            state_.history = Corrected<D>{std::move(before)};
        }
    }

    Outcome<Run> ended() {
        const auto* const end = std::get_if<Quadratic<D>>(&state_.mesh);
        if (end && end->planned() && (!report_.committed || end->has_uncommitted()))
            add(report_, Notices{not_committed});
        auto measured = step("measure", [&](const Execution& e) -> Outcome<Measured<D>> {
            if (!end) return Measured<D>{};
            return measure_stage(*end, field(), state_.history, e);
        });
        if (!measured) return fail(measured.error());
        add(report_, measured->report);
        MeshFields fields;
        if (shows_fields(pipeline_.output)) {
            auto made = step("fields", [&](const Execution& e) -> Outcome<MeshFields> {
                if (!end) return MeshFields{};
                return mesh_fields(*end, field(), measured->lengths, e);
            });
            if (!made) return fail(made.error());
            fields = std::move(*made);
        }
        AnyMesh mesh = end ? AnyMesh(std::move(quadratic().mesh)) : AnyMesh(std::get<LinearMesh<D>>(state_.mesh));
        report_.mesh = mesh_report(mesh);
        return Run{std::move(mesh), std::move(report_), std::move(fields)};
    }

    static constexpr const char* starts_from_file =
        "volume edges: the search begins at the node that the mesh was read with, where that is the better start";
    static constexpr const char* not_committed = "planned nodes were not committed: no stage \"commit\" after them";

    const config::Pipeline& pipeline_;
    State<D> state_;
    std::span<const MetricFile> files_;
    const Around& around_;
    Report report_;
};

/// The whole of a run.
template <int D>
Outcome<Run> run_on(GivenMesh<D> mesh, const config::Pipeline& pipeline, std::span<const MetricFile> files,
                    const Around& around) {
    const int degree = std::holds_alternative<LinearMesh<D>>(mesh) ? 1 : 2;
    if (auto order = check_order(pipeline.stages, degree); !order) return fail(order.error());
    auto sound = step(around, "prepare", [&](const Execution& e) { return prepare_stage<D>(std::move(mesh), e); });
    if (!sound) return fail(sound.error());
    return Runner<D>(pipeline, std::move(sound->mesh), files, around).run(sound->notices);
}

}  // namespace

bool shows_fields(const config::Output& output) {
    const MeshFormat* const format = format_with_ending(mesh_formats(), output.mesh);
    return !output.vtu.empty() || (format != nullptr && format->holds_fields);
}

Outcome<Run> run_pipeline(const config::Pipeline& pipeline, Inputs inputs, const Around& around) {
    std::vector<MetricFile> files = std::move(inputs.operands);
    if (inputs.metric) files.push_back({std::get<config::FilePath>(pipeline.metric).path, std::move(*inputs.metric)});
    auto run = std::visit(
        [&]<class Mesh>(Mesh mesh) { return run_on<Mesh::dimension>(std::move(mesh), pipeline, files, around); },
        std::move(inputs.mesh.mesh));
    if (!run) return run;
    for (Notice& notice : inputs.mesh.notices) run->report.notices.push_back(std::move(notice.what));
    return run;
}

Outcome<DecodedMesh> generate_shape(const config::Shape& shape) {
    return std::visit(
        [](const auto& options) -> Outcome<DecodedMesh> {
            auto mesh = generate(options);
            if (!mesh) return fail(mesh.error());
            return DecodedMesh{AnyMesh(std::move(*mesh)), {}};
        },
        shape);
}

}  // namespace camber::run
