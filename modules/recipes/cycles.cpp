module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
module camber.recipes;
import camber.core;
import camber.solution_metric;
import camber.io;
import camber.stages;

namespace camber::run {

namespace {

bool uses_solver(const config::Pipeline& pipeline) { return !pipeline.adapt.solve.empty(); }

/// Path of the file `name` in the folder, with the extension of `output`; empty if `output` is empty.
std::string like(const std::string& folder, const char* name, const std::string& output) {
    return output.empty() ? output : folder + "/" + name + std::filesystem::path(output).extension().string();
}

config::Output output_of_cycle(const config::Pipeline& pipeline, const CycleFiles& files) {
    config::Output output = pipeline.output;
    output.mesh = files.mesh;
    output.format.clear();
    output.report = files.report;
    output.vtu = files.vtu;
    output.metric = files.metric;
    output.solution = uses_solver(pipeline) ? files.guess : files.carried;
    output.plots = files.plots;
    output.page = files.page;
    return output;
}

bool is_elevate(const config::Stage& stage) { return std::holds_alternative<config::Elevate>(stage); }

config::Pipeline without_field(config::Pipeline pipeline) {
    pipeline.adapt = {};
    pipeline.solution = {};
    pipeline.metric = config::NaturalMetric{};
    pipeline.metric_mesh.clear();
    pipeline.metric_operations.clear();
    return pipeline;
}

void set_complexity(config::Pipeline& pipeline, double complexity_target) {
    if (auto* outcome = std::get_if<config::SolutionMetric>(&pipeline.metric)) {
        outcome->vertices = outcome->elements = 0;
        outcome->complexity = complexity_target;
    } else {
        pipeline.metric_operations.emplace_back(config::Complexity{.target = complexity_target});
    }
}

double smaller_step(double complexity, std::size_t elements_before, std::size_t elements) {
    constexpr double least_change = 0.9;
    const double ratio =
        std::sqrt(static_cast<double>(std::max<std::size_t>(elements_before, 1)) / static_cast<double>(elements));
    return complexity * (ratio > least_change && ratio < 1 / least_change ? least_change : ratio);
}

std::string other_complexity(double complexity_target, double outcome) {
    return fmt::format(
        "the complexity of the mesh is {:.0f} instead of {:.0f}, since elements were not certified valid at that "
        "complexity; more cycles may reach it",
        outcome, complexity_target);
}

double target_complexity(const config::Adaptation& adapt, int cycle) {
    const auto& all = adapt.complexity;
    if (all.empty() || cycle < 1) return 0;
    return all[std::min(static_cast<std::size_t>(cycle), all.size()) - 1];
}

std::string problem_of(const config::Adaptation& adapt) {
    std::string text = adapt.exact;
    for (const std::string& word : adapt.solve) text += '\n' + word;
    return text;
}

/// True if the errors are comparable: the same requested complexity and problem.
bool is_like(const CycleRow& a, const CycleRow& b) {
    return a.cycle > 0 && b.cycle > 0 && a.complexity_target == b.complexity_target && a.problem == b.problem &&
           a.error_of == b.error_of;
}

bool is_better(const CycleRow& a, const CycleRow& b, const config::Adaptation& adapt) {
    const auto of_a = error_of_mesh(a, adapt), of_b = error_of_mesh(b, adapt);
    if (!of_a || !of_b) return false;
    return a.misses.empty() != b.misses.empty() ? a.misses.empty() : *of_a < *of_b;
}

/// Expected error, else the interpolation error. It bounds the boundary distance of the next mesh.
ExpectedError expected_of(const CycleRow& row, const std::vector<double>& weights) {
    if (row.expected) return {*row.expected, weights};
    return {row.interpolated ? row.interpolated->l2 : 0, {}};
}

void set_expected(config::Pipeline& pipeline, std::span<const CycleRow> rows) {
    auto* const outcome = std::get_if<config::SolutionMetric>(&pipeline.metric);
    if (outcome != nullptr && !rows.empty()) outcome->expected = expected_of(rows.back(), pipeline.solution.weights);
}

bool has_cycle(const std::string& word) { return word.find("{cycle}") != std::string::npos; }

bool returns_last(const config::Adaptation& adapt) {
    using enum config::ResultOfCycles;
    return adapt.result == last || (adapt.result == automatic && std::ranges::any_of(adapt.solve, has_cycle));
}

/// Compares the minimum error up to this cycle with that up to two cycles before, at the last complexity.
std::string settled_by_error(std::span<const CycleRow> rows, const config::Adaptation& adapt) {
    constexpr std::size_t cycles = 2;
    const std::size_t last = rows.size() - 1;
    if (last < cycles + 1 || !is_like(rows[last - cycles], rows[last])) return {};
    const auto least = [&](std::size_t at) {
        return error_of_mesh(rows[row_of_result(rows.first(at + 1), adapt)], adapt);
    };
    const auto now = least(last), before = least(last - cycles);
    if (!now || !before || *now < (1 - adapt.convergence_tolerance) * *before) return {};
    return fmt::format("converged: the minimum error is {:.2e} after cycle {} and was {:.2e} after cycle {}", *now,
                       rows[last].cycle, *before, rows[last - cycles].cycle);
}

std::string settled_by_edges(std::span<const CycleRow> rows, const config::Adaptation& adapt) {
    // With a smaller share of unit edges in the metric of the mesh's own solution, the cycles have not converged.
    constexpr double near_to_unit = 0.5, share = 0.2;
    const CycleRow &last = rows.back(), &before = rows[rows.size() - 2];
    // The input mesh of a cycle has the complexity of the previous cycle.
    if (before.cycle < 2 || static_cast<std::size_t>(before.cycle) <= adapt.complexity.size()) return {};
    if (last.unit_edges == 0 || last.unit_before > before.unit_before + share * adapt.convergence_tolerance) return {};
    if (last.unit_before < near_to_unit * last.unit_edges) return {};
    return fmt::format(
        "converged: measured in their own solution's metric, {:.1f} % of the edges of cycle {} have unit length, and "
        "{:.1f} % of the edges of cycle {}",
        100 * before.unit_before, before.cycle - 1, 100 * last.unit_before, last.cycle - 1);
}

void replace_all(std::string& text, std::string_view part, const std::string& by) {
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + by.size()))
        text.replace(at, part.size(), by);
}

bool is_of_files(const config::Metric& metric) {
    if (std::holds_alternative<config::FilePath>(metric)) return true;
    const auto* outcome = std::get_if<config::SolutionMetric>(&metric);
    return outcome != nullptr && !outcome->intersect.empty();
}

}  // namespace

std::string name_of_cycle(int cycle) { return fmt::format("cycle-{:03}", cycle); }

CycleFiles files_of_cycle(const config::Pipeline& pipeline, const std::string& folder) {
    const auto within = [&](const std::string& name) { return folder + "/" + name; };
    const config::Output& output = pipeline.output;
    const bool solves = uses_solver(pipeline);
    return {.folder = folder,
            .mesh = within(pipeline.adapt.mesh),
            .solution = within(pipeline.adapt.solution),
            .guess = within("guess.sol"),
            .said = within("solver.txt"),
            .report = within("report.json"),
            .view = within("view.vtu"),
            .vtu = output.vtu.empty() && solves ? "" : within(solves ? "run.vtu" : "view.vtu"),
            .metric = like(folder, "metric", output.metric),
            .carried = like(folder, "transferred", output.solution),
            .plots = output.plots.empty() ? "" : within("plots"),
            .page = output.page.empty() ? "" : within("page.html")};
}

config::Pipeline steps_of_cycles(int degree, const config::Metric& metric) {
    config::Pipeline pipeline;
    pipeline.metric = metric;
    config::Curve curve;
    if (std::holds_alternative<config::SolutionMetric>(metric)) curve.objective = Objective::solution;
    if (degree == 1)
        pipeline.stages = {config::Remesh{}};
    else
        pipeline.stages = {config::Elevate{},  config::Remesh{}, curve,
                           config::Validate{}, config::Relax{},  config::Commit{}};
    return pipeline;
}

config::Pipeline first_pipeline(const config::Pipeline& pipeline, const CycleFiles& into) {
    config::Pipeline first = without_field(pipeline);
    first.output = output_of_cycle(pipeline, into);
    first.output.metric.clear();
    first.output.solution.clear();
    first.output.plots.clear();
    first.output.page.clear();
    if (!uses_solver(pipeline)) first.stages.clear();
    std::erase_if(first.stages, [](const config::Stage& stage) {
        return std::visit([]<class S>(const S&) { return changes_topology<S>(); }, stage);
    });
    for (config::Stage& stage : first.stages)
        if (auto* curve = std::get_if<config::Curve>(&stage))
            if (curve->objective == Objective::solution) curve->objective = config::Curve{}.objective;
    return first;
}

Fit fit_of_cycle(int cycle, const InputDegree& required) {
    return [required, cycle](config::Pipeline pipeline, const AnyMesh& mesh) -> Outcome<config::Pipeline> {
        if (required.degree == 1 && plan_size(mesh).degree == 2)
            return fail(ErrorKind::input, "the mesh has degree 2, but degree 1 is required", {}, {},
                        fmt::format("give the straight mesh, or remove {}", required.option));
        if (!is_curved(mesh)) return pipeline;
        if (cycle == 0 && !pipeline.stages.empty()) pipeline.stages = {config::Validate{}};
        std::erase_if(pipeline.stages, is_elevate);
        return pipeline;
    };
}

config::Pipeline cycle_pipeline(const config::Pipeline& pipeline, int cycle, const CycleFiles& first,
                                const CycleFiles& before, const CycleFiles& into) {
    config::Pipeline next = pipeline;
    next.adapt = {};
    next.output = output_of_cycle(pipeline, into);
    const bool is_first_run = cycle == 1 && !uses_solver(pipeline);
    if (!is_first_run) {
        if (std::holds_alternative<config::FilePath>(pipeline.metric) && pipeline.metric_mesh.empty())
            if (const auto* file = std::get_if<config::FilePath>(&pipeline.input.source)) next.metric_mesh = file->path;
        next.input = {config::FilePath{before.mesh}, pipeline.input.flat};
        if (std::holds_alternative<config::Surrogate>(pipeline.geometry)) next.geometry = config::FilePath{first.mesh};
        // An earlier cycle made this mesh for the same geometry.
        if (auto* const of_mesh = std::get_if<config::FilePath>(&next.geometry)) of_mesh->is_of_cycle = true;
        std::erase_if(next.stages, is_elevate);
    }
    if (uses_solver(pipeline)) {
        next.solution.file = before.solution;
        next.solution.expression.clear();
    }
    if (const double complexity_target = target_complexity(pipeline.adapt, cycle); complexity_target > 0)
        set_complexity(next, complexity_target);
    return next;
}

Outcome<CycleRun> run_cycle(config::Pipeline pipeline, std::span<const CycleRow> rows,
                            const std::function<Outcome<Run>(const config::Pipeline&)>& execute) {
    constexpr int most_steps = 3;
    set_expected(pipeline, rows);
    std::vector<std::string> notices;
    std::vector<StageTime> times;
    double complexity_target = 0;
    for (int step = 0;; ++step) {
        auto outcome = execute(pipeline);
        if (!outcome) return fail(outcome.error());
        Report& report = outcome->report;
        const double complexity = report.metric ? report.metric->complexity : 0;
        if (step == 0) complexity_target = complexity;
        const bool continues = !report.has_valid_elements() && step < most_steps && !rows.empty() && complexity > 0;
        if (!continues) {
            report.notices.insert(report.notices.end(), notices.begin(), notices.end());
            report.times.insert(report.times.end(), times.begin(), times.end());
            const bool is_smaller = step > 0 && report.has_valid_elements();
            return CycleRun{std::move(*outcome),
                            is_smaller ? other_complexity(complexity_target, complexity) : std::string()};
        }
        const double smaller = smaller_step(complexity, rows.back().elements, report.mesh.judged());
        set_complexity(pipeline, smaller);
        times.insert(times.end(), report.times.begin(), report.times.end());
        notices.push_back(
            fmt::format("cycle {}: at complexity {:.0f}, {} elements are not certified valid; the cycle is repeated at "
                        "{:.0f}",
                        rows.size(), complexity, report.not_valid(), smaller));
    }
}

std::vector<std::string> solver_command(const config::Adaptation& adapt, int cycle, const CycleFiles& files) {
    std::vector<std::string> words = adapt.solve;
    for (std::string& word : words) {
        replace_all(word, "{mesh}", files.mesh);
        replace_all(word, "{solution}", files.solution);
        replace_all(word, "{guess}", files.guess);
        replace_all(word, "{cycle}", std::to_string(cycle));
        replace_all(word, "{folder}", files.folder);
    }
    return words;
}

Outcome<Done> check_cycles(const config::Pipeline& pipeline) {
    const auto refuse = [](const char* what, const char* where, const char* remedy) {
        return fail(ErrorKind::usage, what, where, {}, remedy);
    };
    const bool is_once = pipeline.adapt.cycles == 1;
    if (pipeline.output.partition > 0)
        return refuse("several cycles do not write a mesh in parts", "/output/partition",
                      "split the final mesh with camber convert --partition");
    if (!uses_solver(pipeline) && !pipeline.solution.file.empty() && !is_once)
        return refuse("is a solution on the first mesh only", "/solution/file",
                      "set \"adapt\": {\"cycles\": 1}, or give \"solve\", a command that computes the solution on each "
                      "mesh");
    for (const config::MetricOperation& operation : pipeline.metric_operations) {
        const auto* intersect = std::get_if<config::Intersect>(&operation);
        if (intersect != nullptr && is_of_files(intersect->metric) && !is_once)
            return refuse("a metric file is known on the first mesh only", "/metric_operations",
                          "set \"adapt\": {\"cycles\": 1}, or use a metric that is known everywhere");
    }
    const auto* outcome = std::get_if<config::SolutionMetric>(&pipeline.metric);
    if (outcome != nullptr && !outcome->intersect.empty() && !is_once)
        return refuse("metric files are known on the first mesh only", "/metric/solution/intersect",
                      "set \"adapt\": {\"cycles\": 1}, or use sizes by reference");
    return Done{};
}

CycleRow row_of(int cycle, const config::Pipeline& pipeline, const CycleRun& outcome) {
    const config::Adaptation& adapt = pipeline.adapt;
    const Report& report = outcome.run.report;
    CycleRow row{.cycle = cycle,
                 .unknowns = report.mesh.nodes,
                 .elements = report.mesh.judged(),
                 .problem = problem_of(adapt),
                 .complexity_target = target_complexity(adapt, cycle)};
    if (report.metric && cycle > 0) row.complexity = report.metric->complexity;
    if (report.remesh) {
        const auto share = [](const UnitMeshReport& r) {
            return r.edges == 0 ? 1 : static_cast<double>(r.unit_edges) / static_cast<double>(r.edges);
        };
        row.unit_before = share(report.remesh->before);
        row.unit_edges = share(report.remesh->after);
        row.worst_quality = report.remesh->after.worst_quality;
        row.mean_quality = report.remesh->after.mean_quality;
    }
    if (report.validity) row.smallest_jacobian = report.validity->smallest;
    if (report.curve && report.curve->expected) row.expected = report.curve->expected->after;
    if (report.boundary && report.boundary->geometry_error) {
        const GeometryErrorReport& g = *report.boundary->geometry_error;
        row.boundary = {g.required, g.reached,
                        g.is_required ? DistanceBoundBy::config : DistanceBoundBy::expected_error};
    }
    row.is_valid = report.has_valid_elements();
    row.misses = misses(report);
    if (!outcome.miss.empty()) row.misses.push_back(outcome.miss);
    for (const StageTime& time : report.times) row.seconds += time.seconds;
    if (const auto* const of_solution = std::get_if<config::SolutionMetric>(&pipeline.metric))
        row.error_of = of_solution->error_of;
    return row;
}

std::optional<double> error_of_mesh(const CycleRow& row, const config::Adaptation& adapt) {
    if (adapt.solve.empty() && row.interpolated)
        return row.error_of == ErrorQuantity::gradients ? row.interpolated->h1 : row.interpolated->l2;
    return row.expected;
}

std::size_t row_of_result(std::span<const CycleRow> rows, const config::Adaptation& adapt) {
    std::size_t last = rows.size() - 1;
    if (last > 0 && !rows[last].is_valid) --last;  // no cycle follows one that is not valid
    if (returns_last(adapt)) return last;
    std::size_t best = last;
    for (std::size_t i = last; i > 0 && is_like(rows[i], rows[last]); --i)
        if (is_better(rows[i], rows[best], adapt)) best = i;
    return best;
}

std::string reason_to_end(std::span<const CycleRow> rows, const config::Adaptation& adapt) {
    if (adapt.convergence_tolerance == 0 || rows.size() < 2) return {};
    return error_of_mesh(rows.back(), adapt) && !returns_last(adapt) ? settled_by_error(rows, adapt)
                                                                     : settled_by_edges(rows, adapt);
}

std::vector<std::string> notes_on_result(std::span<const CycleRow> rows, const config::Adaptation& adapt) {
    const std::size_t at = row_of_result(rows, adapt);
    const CycleRow& row = rows[at];
    std::vector<std::string> notes;
    if (at + 1 < rows.size())
        notes.push_back(fmt::format(
            "the result is the mesh of cycle {}: its error {:.2e} is the smallest of the meshes that {}", row.cycle,
            *error_of_mesh(row, adapt), row.misses.empty() ? "satisfy all requirements" : "were made"));
    if (row.boundary && row.boundary->by == DistanceBoundBy::expected_error &&
        row.boundary->reached > row.boundary->bound)
        notes.push_back(
            fmt::format("the boundary of cycle {} is up to {:.2e} from its geometry; up to {:.2e} changes the solution "
                        "by no more than its expected error. Use --geometry-error or a larger complexity",
                        row.cycle, row.boundary->reached, row.boundary->bound));
    if (at == 0 || !is_like(rows[at - 1], row)) return notes;
    const CycleRow& before = rows[at - 1];
    constexpr double least_fall_of_edges = 0.05, least_fall_of_quality = 0.5;
    if (row.unit_edges < before.unit_edges - least_fall_of_edges)
        notes.push_back(fmt::format("unit edges fell from {:.1f} % in cycle {} to {:.1f} % in cycle {}",
                                    100 * before.unit_edges, before.cycle, 100 * row.unit_edges, row.cycle));
    if (row.worst_quality < least_fall_of_quality * before.worst_quality)
        notes.push_back(fmt::format("the minimum quality fell from {:.3f} in cycle {} to {:.3f} in cycle {}",
                                    before.worst_quality, before.cycle, row.worst_quality, row.cycle));
    return notes;
}

}  // namespace camber::run
