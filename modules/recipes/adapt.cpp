module;
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
module camber.recipes;
import camber.core;
import camber.transfer;
import camber.io;

namespace camber::run {

namespace {

class Loop {
  public:
    Loop(const config::Pipeline& pipeline, CycleStore& store, const CycleSolver& solver, const CycleListener& listener,
         const InputDegree& required, const StepWrapper& around)
        : pipeline_(pipeline),
          store_(store),
          solver_(solver),
          listener_(listener),
          required_(required),
          around_(around),
          rows_(store.rows()) {}

    Outcome<EndedCycles> run() && {
        const config::Adaptation& adapt = pipeline_.adapt;
        std::string reason;
        std::optional<std::size_t> delivered;
        for (int cycle = static_cast<int>(rows_.size()); cycle <= adapt.cycles && reason.empty(); ++cycle) {
            if (auto done = make(cycle); !done) return fail(done.error());
            const std::size_t result = row_of_result(rows_, adapt);
            if (delivered != result)
                if (auto done = store_.deliver(rows_[result].cycle); !done) return fail(done.error());
            delivered = result;
            if (listener_.row_added)
                if (auto done = listener_.row_added(rows_.back()); !done) return fail(done.error());
            reason = rows_.back().is_valid
                         ? reason_to_end(rows_, adapt)
                         : fmt::format("the mesh of cycle {} has elements that are not certified valid", cycle);
        }
        std::vector<std::string> notes;
        if (rows_.back().is_valid) notes = notes_on_result(rows_, adapt);
        const std::size_t result = row_of_result(rows_, adapt);
        return EndedCycles{std::move(rows_), result, std::move(reason), std::move(notes)};
    }

  private:
    Outcome<Done> make(int cycle) {
        const auto into = store_.begin(cycle);
        if (!into) return fail(into.error());
        auto outcome = mesh_of(cycle, *into);
        if (!outcome) return fail(outcome.error());
        Run& run = outcome->run;
        if (listener_.on_mesh) listener_.on_mesh(run);
        CycleRow row = row_of(cycle, pipeline_, *outcome);
        SolverResult solved{run.mesh, {}};
        if (solver_ && row.is_valid) {
            auto found = solver_({run.mesh, run.solution, cycle, *into});
            if (!found) return fail(found.error());
            solved = std::move(*found);
            run.solution = solved.fields;
            row.solve_seconds = solved.seconds;
        }
        const auto done = run_step(around_, "errors", [&](const Execution& e) {
            return add_errors(row, solved.mesh, solved.fields, pipeline_, e);
        });
        if (!done) return fail(done.error());
        rows_.push_back(std::move(row));
        return store_.add({cycle, *into, std::move(*outcome)}, rows_);
    }

    [[nodiscard]] Outcome<CycleRun> mesh_of(int cycle, const CycleFiles& into) const {
        const config::Pipeline pipeline =
            cycle == 0 ? first_pipeline(pipeline_, into)
                       : cycle_pipeline(pipeline_, cycle, store_.files(0), store_.files(cycle - 1), into);
        const bool is_input = cycle == 0 || pipeline.input == pipeline_.input;
        const Fit fit = is_input ? fit_of_cycle(cycle, required_) : Fit();
        return run_cycle(pipeline, rows_, [&](const config::Pipeline& tried) { return store_.run(tried, fit); });
    }

    const config::Pipeline& pipeline_;
    CycleStore& store_;
    const CycleSolver& solver_;
    const CycleListener& listener_;
    const InputDegree& required_;
    const StepWrapper& around_;
    std::vector<CycleRow> rows_;
};

}  // namespace

Outcome<EndedCycles> adapt(const config::Pipeline& pipeline, CycleStore& store, const CycleSolver& solver,
                           const CycleListener& listener, const InputDegree& required, const StepWrapper& around) {
    if (auto possible = check_cycles(pipeline); !possible) return fail(possible.error());
    return Loop(pipeline, store, solver, listener, required, around).run();
}

namespace {

class CyclesInMemory final : public CycleStore {
  public:
    CyclesInMemory(const config::Pipeline& pipeline, const RunOnValues& run) : pipeline_(pipeline), run_(run) {}

    [[nodiscard]] std::vector<CycleRow> rows() const override { return {}; }
    [[nodiscard]] CycleFiles files(int cycle) const override {
        return files_of_cycle(pipeline_, std::string(config::in_memory) + name_of_cycle(cycle));
    }
    Outcome<CycleFiles> begin(int cycle) override { return files(cycle); }
    Outcome<Run> run(const config::Pipeline& pipeline, const Fit& fit) override { return run_(pipeline, fit, values_); }
    Outcome<Done> add(FinishedCycle finished, std::span<const CycleRow> /*rows*/) override {
        // Later cycles start from the previous mesh; the first mesh is their geometry.
        if (finished.cycle > 1) {
            const CycleFiles before = files(finished.cycle - 1);
            values_.meshes.erase(before.mesh);
            values_.solutions.erase(before.solution);
        }
        values_.meshes[finished.files.mesh] = finished.cycle_run.run.mesh;
        values_.solutions[finished.files.solution] = finished.cycle_run.run.solution;
        last_ = std::move(finished);
        return Done{};
    }
    Outcome<Done> deliver(int cycle) override {
        if (last_.cycle == cycle) result = std::move(last_.cycle_run);
        return Done{};
    }

    CycleRun result;

  private:
    const config::Pipeline& pipeline_;
    const RunOnValues& run_;
    NamedValues values_;
    FinishedCycle last_;
};

}  // namespace

Outcome<AdaptedValues> adapt_values(const config::Pipeline& pipeline, const RunOnValues& run, const CycleSolver& solver,
                                    const InputDegree& required, const StepWrapper& around) {
    CyclesInMemory store(pipeline, run);
    auto cycles = adapt(pipeline, store, solver, {}, required, around);
    if (!cycles) return fail(cycles.error());
    return AdaptedValues{std::move(store.result), std::move(*cycles)};
}

namespace {

struct AdaptedInput {
    AnyMesh mesh;
    const GeometrySource& geometry;
};

Outcome<Inputs> inputs_of(const config::Pipeline& pipeline, const NamedValues& values, const AdaptedInput& specified,
                          const Execution& execution) {
    const auto stored = values.meshes.find(std::get<config::FilePath>(pipeline.input.source).path);
    Inputs inputs{{stored != values.meshes.end() ? stored->second : specified.mesh, {}}};
    inputs.geometry = specified.geometry;
    if (const auto* const file = std::get_if<config::FilePath>(&pipeline.geometry); file != nullptr)
        if (const auto found = values.meshes.find(file->path); found != values.meshes.end())
            inputs.geometry.mesh = std::make_shared<const AnyMesh>(found->second);
    if (!pipeline.solution.file.empty()) inputs.fields = values.solutions.at(pipeline.solution.file);
    if (!pipeline.solution.expression.empty()) {
        auto field = field_of_expression(inputs.mesh.mesh, pipeline.solution.expression, execution);
        if (!field) return fail(field.error());
        inputs.fields = {std::move(*field)};
    }
    if (const auto* const requested = std::get_if<config::SolutionMetric>(&pipeline.metric))
        inputs.solution_metrics.push_back({*requested, {}, "/metric/solution"});
    return inputs;
}

Outcome<Run> run_on_values(const config::Pipeline& pipeline, const Fit& fit, const NamedValues& values,
                           const AdaptedInput& specified, const StepWrapper& around) {
    const auto begin = std::chrono::steady_clock::now();
    auto inputs =
        run_step(around, "inputs", [&](const Execution& e) { return inputs_of(pipeline, values, specified, e); });
    if (!inputs) return fail(inputs.error());
    auto fitted = fit ? fit(pipeline, inputs->mesh.mesh) : pipeline;
    if (!fitted) return fail(fitted.error());
    auto run = run_pipeline(*fitted, std::move(*inputs), around);
    if (run)
        run->report.times.push_back(
            {"run", std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count()});
    return run;
}

/// Errors (input): a field with another number of values than the mesh has nodes.
Outcome<Done> check_sizes(const AnyMesh& mesh, std::span<const NamedField> fields, const Execution& execution) {
    const auto nodes = nodes_in_degree_2(mesh, execution);
    if (!nodes) return fail(nodes.error());
    for (const NamedField& f : fields) {
        const std::size_t at = f.field.degree == 2 ? *nodes : plan_size(mesh).vertices;
        if (f.field.values.size() != at * static_cast<std::size_t>(f.field.components))
            return fail(ErrorKind::input,
                        fmt::format("has {} values, but the mesh has {} nodes with {} components each",
                                    f.field.values.size(), at, f.field.components),
                        "field " + f.name);
    }
    return Done{};
}

template <int D>
CycleSolver solver_on(const MeshSolver<D>& solver, const StepWrapper& around) {
    return [&](const SolverCall& call) -> Outcome<SolverResult> {
        auto fields = solver(std::get<Mesh<D>>(call.mesh), call.guess, call.cycle);
        if (!fields) return fail(fields.error());
        const auto sound =
            run_step(around, "solution", [&](const Execution& e) { return check_sizes(call.mesh, *fields, e); });
        if (!sound) return fail(sound.error());
        return SolverResult{call.mesh, std::move(*fields)};
    };
}

config::Pipeline pipeline_of(const AdaptMeshOptions& options, const std::string* expression) {
    config::SolutionMetric metric = options.metric;
    if (expression != nullptr && options.degree == 1 && metric.degree == 0) metric.degree = 1;
    config::Pipeline pipeline = steps_of_cycles(options.degree, metric);
    pipeline.input.source = config::FilePath{std::string(config::in_memory) + "mesh"};
    pipeline.geometry = options.geometry;
    pipeline.adapt = options.cycles;
    pipeline.adapt.solve.clear();
    if (expression != nullptr)
        pipeline.solution.expression = *expression;
    else
        pipeline.adapt.solve = {std::string(config::in_memory) + "solver"};
    pipeline.output.solution = std::string(config::in_memory) + "carried.sol";
    return pipeline;
}

}  // namespace

}  // namespace camber::run

namespace camber {

template <int D>
Outcome<AdaptedMesh<D>> adapt_mesh(Mesh<D> mesh, const std::variant<std::string, MeshSolver<D>>& solution,
                                   const AdaptMeshOptions& options, const StepWrapper& around) {
    if (auto within = check_limits(options.cycles); !within) return fail(within.error());
    if (auto within = check_limits(options.metric); !within) return fail(within.error());
    const auto* const solver = std::get_if<MeshSolver<D>>(&solution);
    const config::Pipeline pipeline = run::pipeline_of(options, std::get_if<std::string>(&solution));
    const run::AdaptedInput specified{std::move(mesh), options.geometry_source};
    const auto execute = [&](const config::Pipeline& tried, const run::Fit& fit, const run::NamedValues& values) {
        return run::run_on_values(tried, fit, values, specified, around);
    };
    auto outcome =
        run::adapt_values(pipeline, execute, solver ? run::solver_on<D>(*solver, around) : run::CycleSolver(),
                          {options.degree == 1 ? 1 : 0}, around);
    if (!outcome) return fail(outcome.error());
    run::Run& run = outcome->result.run;
    return AdaptedMesh<D>{std::get<Mesh<D>>(std::move(run.mesh)), std::move(run.solution), std::move(run.report),
                          std::move(outcome->cycles)};
}

#define CAMBER_INSTANTIATE(D)                                                                                \
    template Outcome<AdaptedMesh<D>> adapt_mesh<D>(Mesh<D>, const std::variant<std::string, MeshSolver<D>>&, \
                                                   const AdaptMeshOptions&, const StepWrapper&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
