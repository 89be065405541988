module;
#include <algorithm>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
#include "viewer.hpp"
module camber.commands;
import camber.core;
import camber.transfer;
import camber.validity;
import camber.io;
import camber.config;
import camber.recipes;
import camber.reports;
import :execution;

namespace camber::app {

namespace {

void store_all_outputs(config::Output& output) {
    if (output.metric.empty()) output.metric = std::string(config::in_memory) + "metric";
    if (output.solution.empty()) output.solution = std::string(config::in_memory) + "solution";
}

DecodedMesh with_place_of(AnyMesh outcome, const DecodedMesh& input) {
    DecodedMesh mesh{std::move(outcome), {}};
    mesh.lift = input.lift;
    mesh.is_always_3d = input.is_always_3d;
    mesh.format = input.format;
    return mesh;
}

DecodedMesh input_of(const config::Pipeline& pipeline, const MemoryInputs& specified) {
    const auto* const file = std::get_if<config::FilePath>(&pipeline.input.source);
    const auto found = file != nullptr ? specified.meshes.find(file->path) : specified.meshes.end();
    return found != specified.meshes.end() ? found->second : DecodedMesh();
}

MemoryResult memory_result_of(run::Run run, const DecodedMesh& input) {
    return {with_place_of(std::move(run.mesh), input),
            run::to_json(run.report),
            std::move(run.metric),
            std::move(run.solution),
            run.report.notices,
            run.report.meets_requirements(),
            run.report.has_valid_elements()};
}

}  // namespace

Outcome<MemoryResult> run_in_memory(config::Pipeline pipeline, Host host) {
    store_all_outputs(pipeline.output);
    const DecodedMesh input = input_of(pipeline, host.memory_inputs);
    Written written;
    auto run = execute(pipeline, written, run::fit_of_cycle(1), std::move(host));
    if (!run) return fail(run.error());
    return memory_result_of(std::move(*run), input);
}

Outcome<MetricInMemory> metric_in_memory(const config::Pipeline& pipeline, Host host) {
    ShownSteps steps(pipeline.threads, host);
    auto inputs = steps.run("read", [&](const Execution& e) { return read_inputs(pipeline, host.memory_inputs, e); });
    if (!inputs) return fail(inputs.error());
    auto outcome = run::compute_metric(pipeline, std::move(*inputs), steps.around);
    if (!outcome) return fail(outcome.error());
    return MetricInMemory{std::move(outcome->metric), outcome->report.complexity, outcome->report.largest_anisotropy,
                          std::move(outcome->notices)};
}

Outcome<Solution> hessians_in_memory(const DecodedMesh& mesh, const run::NamedField& field, Host host) {
    return ShownSteps(0, host).run("recover",
                                   [&](const Execution& e) { return run::hessians_of(mesh.mesh, field, e); });
}

Outcome<std::vector<run::NamedField>> transfer_in_memory(const DecodedMesh& old_mesh, const DecodedMesh& new_mesh,
                                                         std::vector<run::NamedField> fields,
                                                         const TransferOptions& options, Host host) {
    ShownSteps steps(0, host);
    return run::transfer_fields(new_mesh.mesh, old_mesh.mesh, std::move(fields), options, steps.around)
        .map([](run::TransferredFields outcome) { return std::move(outcome.fields); });
}

Outcome<DecodedMesh> read_into_memory(const std::string& path, config::Flat flat, const DecodeOptions& options,
                                      Host host) {
    return ShownSteps(0, host).run("read", [&](const Execution& e) { return read_mesh(path, flat, options, e); });
}

Outcome<std::vector<std::string>> write_from_memory(const DecodedMesh& mesh, const std::vector<run::NamedField>& fields,
                                                    const std::string& path, const std::string& name, Host host) {
    const auto format = format_of_mesh(path, name, mesh.format);
    if (!format) return fail(format.error());
    std::vector<std::string> losses;
    std::vector<run::NamedField> supported;
    for (const run::NamedField& field : fields)
        if ((*format)->has_fields && check_place_for(path, name, field.kind))
            supported.push_back(field);
        else
            losses.push_back("the format cannot store the field " + field.name);
    auto done = ShownSteps(0, host).run(
        "write", [&](const Execution& e) { return write_with_mesh(mesh, supported, **format, path, e); });
    if (!done) return fail(done.error());
    for (Notice& notice : (*format)->losses(mesh.mesh)) losses.push_back(std::move(notice.what));
    return losses;
}

std::vector<run::NamedField> nodal_fields_of(const DecodedMesh& mesh) {
    std::vector<Notice> ignored;
    return fields_at_nodes(mesh, ignored);
}

namespace {

/// Checks the outputs that are files. Cycles in memory only write the last mesh and its report. Errors: usage.
Outcome<Done> check_files(const config::Output& files) {
    for (const std::string& path : {files.vtu, files.metric, files.solution, files.plots, files.page})
        if (!path.empty())
            return fail(ErrorKind::usage, "is not available for cycles in memory", path, {},
                        "leave it out, or use camber run");
    return check_outputs(files);
}

Outcome<Done> write_files(const config::Output& files, const MemoryResult& outcome, const Host& host) {
    if (!files.report.empty())
        if (auto done = write_text(files.report, outcome.report); !done) return done;
    if (files.mesh.empty()) return Done{};
    return write_from_memory(outcome.mesh, outcome.solution, files.mesh, files.format, host).map([](const auto&) {
        return Done{};
    });
}

}  // namespace

Outcome<AdaptedInMemory> adapt_in_memory(config::Pipeline pipeline, int degree, const Solver& solver, Host host) {
    const config::Output files = files_of(pipeline.output);
    if (auto possible = check_files(files); !possible) return fail(possible.error());
    if (solver) pipeline.adapt.solve = {std::string(config::in_memory) + "solver"};
    pipeline.output.metric = std::string(config::in_memory) + "metric.sol";
    pipeline.output.solution = std::string(config::in_memory) + "carried.sol";
    const DecodedMesh input = input_of(pipeline, host.memory_inputs);
    const auto run_on_values = [&](const config::Pipeline& tried, const Fit& fit, const run::NamedValues& cycles) {
        Host with_cycles = host;
        for (const auto& [name, mesh] : cycles.meshes)
            with_cycles.memory_inputs.meshes.insert_or_assign(name, with_place_of(mesh, input));
        for (const auto& [name, fields] : cycles.solutions)
            with_cycles.memory_inputs.solutions.insert_or_assign(name, fields);
        Written none;
        return execute(tried, none, fit, std::move(with_cycles));
    };
    const auto solve = [&](const run::SolverCall& call) -> Outcome<run::SolverResult> {
        return solver(with_place_of(call.mesh, input), call.guess, call.cycle)
            .map([&](std::vector<run::NamedField> fields) { return run::SolverResult{call.mesh, std::move(fields)}; });
    };
    const Execution execution{.threads = pipeline.threads, .stop = host.stop};
    auto outcome = run::adapt_values(pipeline, run_on_values, solver ? solve : run::CycleSolver(), {degree},
                                     without_wrapper(execution));
    if (!outcome) return fail(outcome.error());
    auto& [of_result, cycles] = *outcome;
    MemoryResult result = memory_result_of(std::move(of_result.run), input);
    result.meets_requirements = result.meets_requirements && of_result.miss.empty() && cycles.is_valid();
    if (!of_result.miss.empty()) result.notices.push_back(std::move(of_result.miss));
    std::ranges::move(cycles.notes, std::back_inserter(result.notices));
    if (auto done = write_files(files, result, host); !done) return fail(done.error());
    return AdaptedInMemory{std::move(result), run::cycles_json(cycles.rows), std::move(cycles.reason)};
}

namespace {

std::vector<ElementColumn> columns_of(const run::CheckReport& report) {
    std::vector<ElementColumn> all;
    run::each_shown_field(report.elements, run::Reported::volume, [&](const auto& field, const auto& column) {
        ElementColumn& out = all.emplace_back(std::string(field.key), std::vector<double>());
        out.values.reserve(column.size());
        std::ranges::transform(column, std::back_inserter(out.values), [](auto x) { return static_cast<double>(x); });
    });
    return all;
}

}  // namespace

Outcome<CheckedInMemory> check_in_memory(const DecodedMesh& mesh, const std::optional<Solution>& metric,
                                         const run::CheckOptions& options, Host host) {
    ShownSteps steps(0, host);
    std::optional<run::MetricFile> rows;
    if (metric) {
        auto sorted = run::rows_by_nodes(*metric, mesh, {.stop = host.stop});
        if (!sorted) return fail(sorted.error());
        rows = run::MetricFile{std::string(config::in_memory) + "metric",
                               run::rows_at_vertices(std::move(*sorted), mesh.mesh)};
    }
    const auto report = run::check_mesh(mesh, rows, options, steps.around);
    if (!report) return fail(report.error());
    return CheckedInMemory{
        run::check_json_head(*report, std::string(config::in_memory) + "mesh", CAMBER_VERSION) + "\n}\n",
        report->answer() + "\n" + run::check_table(*report), columns_of(*report), report->all_good()};
}

Outcome<std::string> page_in_memory(const DecodedMesh& mesh, const std::vector<run::NamedField>& fields,
                                    const std::string& title, const run::PageOptions& options, Host host) {
    Viewer parts = viewer();
    ShownSteps steps(0, host);
    auto report = run::check_mesh(mesh, std::nullopt, {}, steps.around);
    if (!report) return fail(report.error());
    run::PageSource source;
    source.mesh = mesh.mesh;
    source.fields = fields;
    source.title = title;
    source.version = CAMBER_VERSION;
    source.histograms = report->histograms;
    source.numbers = run::check_table(*report);
    source.report = std::move(*report);
    return steps.run("page", [&](const Execution& e) {
        return run::page(source, {std::move(parts.frame), std::move(parts.style), std::move(parts.script)}, options, e);
    });
}

Outcome<std::string> geometry_in_memory(const DecodedMesh& mesh, const config::Geometry& geometry,
                                        const run::InspectOptions& options, Host host) {
    ShownSteps steps(0, host);
    auto source = steps.run("read", [&](const Execution& e) { return read_geometry(geometry, e, host.memory_inputs); });
    if (!source) return fail(source.error());
    auto found = run::inspect_geometry(mesh, {geometry, std::move(*source)}, options, steps.around);
    if (!found) return fail(found.error());
    return run::inspect_json(found->report, std::string(config::in_memory) + "mesh", CAMBER_VERSION);
}

}  // namespace camber::app
