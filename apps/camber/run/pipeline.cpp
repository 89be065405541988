module;
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
module camber.run;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.config;
import camber.io;
import camber.shapes;
import camber.surface;
import camber.validity;
import camber.soundness;
import camber.curving;
import :fields;
import :report;
import :measures;
import :stages;
import :state;

namespace camber::run {

namespace {

/// Where an error of a stage happened, unless the stage itself says it.
Error at(Error error, const std::string& path) {
    if (error.where.empty() && error.kind == ErrorKind::usage) error.where = path;
    return error;
}

/// One run in D dimensions: applies stages under the shell's wrapper.
template <int D>
class Runner {
  public:
    Runner(const config::Pipeline& pipeline, State<D> state, std::optional<MetricFile> metric,
           std::vector<MetricFile> operands, const Around& around)
        : pipeline_(pipeline),
          state_(std::move(state)),
          metric_(std::move(metric)),
          operands_(std::move(operands)),
          around_(around) {
        measure_mesh();
        state_.read_curved = state_.quadratic() != nullptr;
    }

    Outcome<Run> run() {
        auto prepared =
            step("prepare", [&](State<D> s, const Execution& e) { return prepare_stage(std::move(s), report_, e); });
        if (!prepared) return fail(prepared.error());
        measure_mesh();
        for (std::size_t i = 0; i < pipeline_.stages.size(); ++i) {
            const std::string path = "/stages/" + std::to_string(i);
            auto done = std::visit([&](const auto& stage) { return apply(stage); }, pipeline_.stages[i]);
            if (!done) return fail(at(done.error(), path));
        }
        if (state_.proposal && !report_.committed)
            report_.notices.emplace_back("planned nodes were not committed: no stage \"commit\"");
        auto measured =
            step("measure", [&](State<D> s, const Execution& e) { return measure_stage(std::move(s), report_, e); });
        if (!measured) return fail(measured.error());
        MeshFields fields;
        if (shows_fields(pipeline_.output)) {
            auto made = step("fields", [&](State<D> s, const Execution& e) -> Outcome<State<D>> {
                auto found = mesh_fields(s, e);
                if (!found) return fail(found.error());
                fields = std::move(*found);
                return s;
            });
            if (!made) return fail(made.error());
        }
        auto mesh = std::visit([](auto& m) { return AnyMesh(std::move(m)); }, state_.mesh);
        return Run{std::move(mesh), std::move(report_), std::move(fields)};
    }

  private:
    void measure_mesh() {
        const LinearMesh<D>& mesh = state_.linear();
        const QuadraticMesh<D>* curves = state_.quadratic();
        report_.mesh = {D,
                        curves ? 2 : 1,
                        mesh.points.size(),
                        mesh.points.size() + (curves ? curves->edges.size() : 0),
                        mesh.elements.size(),
                        mesh.facets.size(),
                        mesh.edges.size()};
    }

    template <class F>
    Outcome<Done> step(std::string_view name, F&& f) {
        return around_(name, [&](const Execution& execution) {
            return guarded([&]() -> Outcome<Done> {
                auto next = f(std::move(state_), execution);
                if (!next) return fail(next.error());
                state_ = std::move(*next);
                return Done{};
            });
        });
    }

    Outcome<Done> apply(const config::Elevate&) {
        if (state_.quadratic() && !state_.read_curved)
            return fail(ErrorKind::usage, "the mesh is quadratic already, by an \"elevate\" before", {}, {},
                        "leave one of them out");
        return step("elevate", [&](State<D> s, const Execution& e) { return elevate_stage(std::move(s), report_, e); });
    }
    Outcome<Done> prepare_surface() {
        return step("surface", [&](State<D> s, const Execution& e) {
            return surface_stage(std::move(s), pipeline_.features, pipeline_.geometry, report_, e);
        });
    }
    /// What curving by a metric needs.
    Outcome<Done> prepare_curving() {
        if (auto surface = prepare_surface(); !surface) return surface;
        return step("metric", [&](State<D> s, const Execution& e) {
            return metric_stage(std::move(s), pipeline_.metric, metric_, pipeline_.metric_operations, operands_,
                                report_, e);
        });
    }
    Outcome<Done> apply(const config::Curve& options) {
        const bool by_metric = options.objective != config::Objective::shape;
        if (auto prepared = by_metric ? prepare_curving() : prepare_surface(); !prepared) return prepared;
        return step("curve",
                    [&](State<D> s, const Execution& e) { return curve_stage(std::move(s), options, report_, e); });
    }
    Outcome<Done> apply(const config::Validate& options) {
        return step("validate",
                    [&](State<D> s, const Execution& e) { return validate_stage(std::move(s), options, report_, e); });
    }
    /// A mesh that was read with its curves brings what else the stage "curve" proposes.
    Outcome<Done> adopt_own_nodes() {
        if (state_.proposal || !state_.read_curved) return Done{};
        return step("features", [&](State<D> s, const Execution& e) {
            return adopt_stage(std::move(s), pipeline_.features, report_, e);
        });
    }
    Outcome<Done> apply(const config::Relax& options) {
        if (auto adopted = adopt_own_nodes(); !adopted) return adopted;
        return step("relax",
                    [&](State<D> s, const Execution& e) { return relax_stage(std::move(s), options, report_, e); });
    }
    Outcome<Done> apply(const config::Commit&) {
        if (auto adopted = adopt_own_nodes(); !adopted) return adopted;
        return step("commit", [&](State<D> s, const Execution& e) { return commit_stage(std::move(s), report_, e); });
    }

    Outcome<Done> apply(const config::Reinsert& options) {
        if (auto prepared = prepare_curving(); !prepared) return prepared;
        return step("reinsert",
                    [&](State<D> s, const Execution& e) { return reinsert_stage(std::move(s), options, report_, e); });
    }

    const config::Pipeline& pipeline_;
    State<D> state_;
    std::optional<MetricFile> metric_;
    std::vector<MetricFile> operands_;
    const Around& around_;
    Report report_;
};

template <class Mesh>
State<Mesh::dimension> beginning_with(Mesh mesh) {
    State<Mesh::dimension> state;
    state.mesh = std::move(mesh);
    return state;
}

}  // namespace

bool shows_fields(const config::Output& output) {
    const MeshFormat* const format = format_with_ending(mesh_formats(), output.mesh);
    return !output.vtu.empty() || (format != nullptr && format->holds_fields);
}

Outcome<Run> run_pipeline(const config::Pipeline& pipeline, Inputs inputs, const Around& around) {
    std::optional<MetricFile> metric;
    if (inputs.metric) metric = MetricFile{std::get<config::FilePath>(pipeline.metric).path, std::move(*inputs.metric)};
    auto run = std::visit(
        [&]<class Mesh>(Mesh mesh) {
            return Runner<Mesh::dimension>(pipeline, beginning_with(std::move(mesh)), std::move(metric),
                                           std::move(inputs.operands), around)
                .run();
        },
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
