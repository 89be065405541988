module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
#include <tbb/info.h>
module camber.commands;
import camber.core;
import camber.io;
import camber.distributed;
import camber.app_shell;
import camber.config;
import camber.recipes;
import camber.reports;
import :execution;

namespace camber::app {

namespace {

Outcome<Done> check_memory(const AnyMesh& mesh) {
    const run::PlanSize size = run::plan_size(mesh);
    const std::size_t needed = run::estimated_peak_bytes(size.vertices, size.elements, size.dimension);
    const MemoryLimit limit = memory_limit();
    if (needed <= limit.bytes) return Done{};
    return fail(ErrorKind::memory,
                "the run needs about " + readable(needed) + " of memory, and " + limit.source + " gives " +
                    readable(limit.bytes),
                {}, {}, "provide more memory, or use a smaller mesh");
}

std::vector<std::string> named_outputs(const config::Output& output) {
    std::vector<std::string> files;
    for (const std::string& path :
         {output.mesh, output.vtu, output.metric, output.solution, output.report, output.page})
        if (!path.empty()) files.push_back(path);
    return files;
}

bool is_for_viewers(const MeshFormat& format) { return format.for_viewers; }
bool can_store_metrics(const MeshFormat& format) {
    return format.has_fields &&
           (!format.can_store || format.can_store({"metric", Centring::node, FieldKind::symmetric_tensor, {}}));
}

Outcome<Done> check_mesh_output(const config::Output& output) {
    if (output.mesh.empty() && output.partition > 0)
        return fail(ErrorKind::usage, "requires a mesh file to write in parts", "/output/partition", {},
                    "name one in \"mesh\", or leave it out");
    if (output.mesh.empty()) return Done{};
    if (output.partition == 0 && names_its_pieces(output.mesh)) return missing_partition_error(output.mesh);
    const auto known =
        output.partition > 0 ? format_of_parts(output.mesh, output.format) : format_of_mesh(output.mesh, output.format);
    if (!known) return fail(known.error());
    return Done{};
}

Outcome<Done> check_endings(const config::Output& output) {
    if (auto known = check_mesh_output(output); !known) return known;
    if (!output.page.empty())
        if (auto possible = check_page(output.page); !possible) return possible;
    const auto ends_in = [](const std::string& path, const std::vector<std::string_view>& endings) {
        return std::any_of(endings.begin(), endings.end(), [&](std::string_view end) { return path.ends_with(end); });
    };
    const auto wrong_ending = [](const char* what, const std::vector<std::string_view>& endings,
                                 const std::string& path) {
        return fail(ErrorKind::usage, std::string("the file of \"") + what + "\" must end in " + listed(endings), path);
    };
    if (const auto viewers = writable_extensions(mesh_formats(), is_for_viewers);
        !output.vtu.empty() && !ends_in(output.vtu, viewers))
        return wrong_ending("vtu", viewers, output.vtu);
    auto endings = writable_extensions(solution_formats());
    for (const std::string_view ending : writable_extensions(mesh_formats(), can_store_metrics))
        endings.push_back(ending);
    if (!output.metric.empty() && !ends_in(output.metric, endings))
        return wrong_ending("metric", endings, output.metric);
    return output.solution.empty() ? Done{} : check_fields_output(output.solution, {});
}

int threads_used(const config::Pipeline& pipeline) {
    const int there = tbb::info::default_concurrency();
    return pipeline.threads > 0 ? std::min(pipeline.threads, there) : there;
}

std::string writable(const std::string& path) {
    const auto checked = check_writable(path);
    return checked ? "writable" : checked.error().what;
}

Outcome<config::Pipeline> fitted_to(const AnyMesh& mesh, const config::Pipeline& specified, const Fit& fit) {
    if (!fit) return specified;
    auto fitted = fit(specified, mesh);
    if (!fitted) return fail(of_input(fitted.error(), specified));
    return fitted;
}

bool is_remeshing_pass(const config::Pipeline& pipeline, std::string_view step) {
    constexpr std::array<std::string_view, 7> passes{"blocks", "lengths", "collapse", "split",
                                                     "swap",   "smooth",  "improve"};
    const auto is_remesh = [](const config::Stage& s) { return std::holds_alternative<config::Remesh>(s); };
    return std::ranges::find(passes, step) != passes.end() && std::ranges::any_of(pipeline.stages, is_remesh);
}

struct Forecast {
    std::optional<run::Growth> growth = {};
    std::optional<double> seconds = {};
};
Outcome<Forecast> forecast(const config::Pipeline& pipeline, run::Inputs inputs, const run::PlanSize& size,
                           const Meter& meter, const Execution& execution) {
    const StepWrapper quietly = [&](std::string_view, const auto& body) { return body(execution); };
    const int threads = threads_used(pipeline);
    const auto probe = run::requested_blocks(pipeline) ? std::nullopt : run::probe_of(pipeline, size, threads);
    if (!probe)
        return run::planned_growth(pipeline, std::move(inputs), quietly)
            .map([](const std::optional<run::Growth>& growth) { return Forecast{.growth = growth}; });
    return run::run_pipeline(*probe, std::move(inputs), quietly).map([&](const run::Run& run_result) {
        return Forecast{.seconds = run::expected_seconds(pipeline, run_result.report, meter.read().seconds, threads)};
    });
}

}  // namespace

run::OriginReport origin_of(const config::Pipeline& pipeline, const run::PlanSize& size) {
    const auto* file = std::get_if<config::FilePath>(&pipeline.input.source);
    const auto* metric = std::get_if<config::FilePath>(&pipeline.metric);
    constexpr std::array<const char*, std::variant_size_v<config::Geometry>> geometries{"surrogate", "straight", "mesh",
                                                                                        "analytic", "cad"};
    return {.version = CAMBER_VERSION,
            .mesh = file != nullptr ? file->path : std::string(),
            .metric = metric != nullptr ? metric->path : std::string(),
            .dimension = size.dimension,
            .degree = size.degree,
            .vertices = size.vertices,
            .elements = size.elements,
            .facets = size.facets,
            .config = config::write_pipeline(pipeline),
            .geometry = geometries[pipeline.geometry.index()]};
}

Error of_input(Error error, const config::Pipeline& pipeline) {
    const auto* file = std::get_if<config::FilePath>(&pipeline.input.source);
    return of_file(std::move(error), file != nullptr ? file->path : "the generated mesh");
}

StepWrapper TimedSteps::around() {
    return [this](std::string_view stage, const std::function<Outcome<Done>(const Execution&)>& body) {
        if (is_remeshing_pass(pipeline_, stage))
            progress_.begin_in_rounds("remesh", std::string(stage));
        else
            progress_.begin(std::string(stage));
        const Meter meter;
        auto done = guarded([&] {
            return body(Execution{.threads = pipeline_.threads, .stop = host_.stop, .progress = progress_.ticks()});
        });
        if (!done && done.error().kind == ErrorKind::memory && done.error().where.empty()) done.error().where = stage;
        const Usage usage = meter.read();
        const auto same = std::ranges::find(times_, stage, &run::StageTime::stage);
        run::StageTime& time = same == times_.end() ? times_.emplace_back(std::string(stage)) : *same;
        time.seconds += usage.seconds;
        time.peak_bytes = std::max(time.peak_bytes, usage.peak_bytes);
        return done;
    };
}

void TimedSteps::add_to(run::Report& report, run::OriginReport origin) {
    progress_.wipe();
    const auto seconds_of = [&](std::string_view step) {
        const auto time = std::ranges::find(times_, step, &run::StageTime::stage);
        return time == times_.end() ? 0.0 : time->seconds;
    };
    if (report.curve)
        report.curve->edges_per_second = static_cast<double>(report.curve->volume_edges) /
                                         std::max(seconds_of(report.reinsert ? "reinsert" : "curve"), 1e-9);
    if (report.remesh)
        for (run::PassReport& pass : report.remesh->passes) pass.seconds = seconds_of(pass.pass);
    report.times = std::move(times_);
    report.threads = threads_used(pipeline_);
    if (report.boundary) report.boundary->geometry = origin.geometry;
    report.origin = std::move(origin);
}

Outcome<Done> write_report(const run::Report& report, const config::Output& files, const Host& host, Written& written) {
    if (files.report.empty() || host.ranks->rank() != 0) return Done{};
    return written.add(files.report, write_text(files.report, run::to_json(report)));
}

config::Output files_of(config::Output output) {
    for (std::string* const name :
         {&output.mesh, &output.vtu, &output.metric, &output.solution, &output.report, &output.plots, &output.page})
        if (config::is_in_memory(*name)) name->clear();
    return output;
}

Outcome<Done> check_outputs(const config::Output& output) {
    if (auto endings = check_endings(output); !endings) return endings;
    for (const std::string& path : named_outputs(output))
        if (auto writable = check_writable(path); !writable) return writable;
    if (output.plots.empty()) return Done{};
    std::error_code none;
    if (!std::filesystem::is_directory(output.plots, none)) return check_folder(output.plots);
    for (const std::string& path : plot_files(output.plots))
        if (auto writable = check_writable(path); !writable) return writable;
    return Done{};
}

Outcome<std::string> plan(const config::Pipeline& specified, const Fit& fit) {
    if (auto endings = check_endings(specified.output); !endings) return fail(endings.error());
    const Execution execution{.threads = specified.threads, .stop = stop_on_signals()};
    const Meter meter;
    auto inputs = read_inputs(specified, {}, execution);
    if (!inputs) return fail(inputs.error());
    auto fitted = fitted_to(inputs->mesh.mesh, specified, fit);
    if (!fitted) return fail(fitted.error());
    const config::Pipeline pipeline = std::move(*fitted);
    if (auto enough = check_memory(inputs->mesh.mesh); !enough) return fail(enough.error());
    const run::PlanSize size = run::plan_size(inputs->mesh.mesh);
    const auto found = forecast(pipeline, std::move(*inputs), size, meter, execution);
    if (!found) return fail(of_input(found.error(), pipeline));
    std::string text = run::plan_text(pipeline, config::parts_of(pipeline), size, found->growth, found->seconds,
                                      threads_used(pipeline));
    for (const std::string& path : named_outputs(pipeline.output))
        text += "  " + called_output(path) + ": " + writable(path) + "\n";
    if (const std::string& plots = pipeline.output.plots; !plots.empty()) {
        const auto checked = check_folder(plots);
        text += "  " + plots + ": " + (checked ? "writable" : checked.error().what) + "\n";
    }
    return text;
}

namespace {

Outcome<run::Inputs> inputs_of(const config::Pipeline& pipeline, Host& host, const Execution& execution) {
    auto inputs = read_inputs(pipeline, host.memory_inputs, execution);
    if (!inputs) return inputs;
    inputs->ranks = host.ranks;
    if (host.ranks->size() > 1 && run::may_end_in_rows(pipeline) && !inputs->mesh.lift) inputs->end = run::RunEnd::rows;
    host.memory_inputs = {};  // the run has its own copy
    if (auto enough = check_memory(inputs->mesh.mesh); !enough) return fail(enough.error());
    return inputs;
}

}  // namespace

Outcome<run::Run> execute(const config::Pipeline& specified, Written& written, const Fit& fit, Host host) {
    if (run::requested_blocks(specified))
        return fail(ErrorKind::usage, "curving by blocks is only available in single runs from file to file", "/stages",
                    {}, "leave out blocks and memory of the stage curve");
    if (auto outputs = check_outputs(files_of(specified.output)); !outputs) return fail(outputs.error());
    TimedSteps steps(specified, host);
    const StepWrapper around = steps.around();
    auto inputs =
        run_step(around, std::holds_alternative<config::FilePath>(specified.input.source) ? "read" : "generate",
                 [&](const Execution& e) { return inputs_of(specified, host, e); });
    if (!inputs) return fail(inputs.error());
    auto fitted = fitted_to(inputs->mesh.mesh, specified, fit);
    if (!fitted) return fail(fitted.error());
    const config::Pipeline pipeline = std::move(*fitted);
    const InputForm form{inputs->mesh.format, inputs->mesh.is_always_3d, inputs->mesh.lift};
    const run::PlanSize size = run::plan_size(inputs->mesh.mesh);
    if (run::preserves_elements(pipeline)) steps.progress().of_mesh(size.elements);
    auto run = run::run_pipeline(pipeline, std::move(*inputs), around);
    if (!run) return fail(of_input(run.error(), pipeline));
    const config::Output files = files_of(pipeline.output);
    if (auto done = write_outputs(*run, files, form, around, written, host); !done) return fail(done.error());
    steps.add_to(run->report, origin_of(pipeline, size));
    if (auto done = write_report(run->report, files, host, written); !done) return fail(done.error());
    return run;
}

namespace {

int exit_code(ErrorKind kind) {
    switch (kind) {
        case ErrorKind::usage: return 2;
        case ErrorKind::input:
        case ErrorKind::unsupported:
        case ErrorKind::write: return 3;
        case ErrorKind::stopped: return 130;
        case ErrorKind::memory:
        case ErrorKind::internal: return 4;
    }
    return 4;
}

std::optional<Error>& not_said() {
    static std::optional<Error> error;
    return error;
}

}  // namespace

void print_line(const std::string& line) {
    if (voice() != Voice::none) std::fputs(("camber: " + line + "\n").c_str(), stderr);
}

void print_note(const std::string& note) {
    if (prints_notes()) print_line("note: " + note);
}

void print_notice(const Notice& notice) {
    if (!notice.is_detail || voice() == Voice::verbose) print_note(notice.what);
}

std::optional<Error> unreported_error() { return not_said(); }

int report_error(const Error& error) {
    if (voice() == Voice::none) not_said() = error;
    print_line(describe(error));
    return exit_code(error.kind);
}

std::string wrote_rows(const std::vector<std::string>& paths) {
    std::string text;
    for (const std::string& path : paths)
        if (!path.empty()) text += "  wrote " + called_output(path) + "\n";
    return text;
}

int end_with(std::string_view text) {
    StandardOutput out;
    out.print(text);
    const auto said = out.finish();
    return said ? 0 : report_error(said.error());
}

int end_with(std::string_view text, const Written& written) {
    if (!prints_notes()) return 0;
    StandardOutput out = written.takes_standard_output() ? StandardOutput::beside_a_file() : StandardOutput();
    out.print(text);
    const auto said = out.finish();
    return said ? 0 : report_error(written.error_with_files(said.error()));
}

bool Written::takes_standard_output() const { return std::ranges::find(paths_, standard_stream) != paths_.end(); }

Outcome<Done> Written::add(const std::string& path, Outcome<Done> outcome) {
    if (!outcome) return fail(error_with_files(std::move(outcome.error())));
    paths_.push_back(path);
    return Done{};
}

Error Written::error_with_files(Error error) const {
    if (!paths_.empty()) error.what += fmt::format("; written before: {}", fmt::join(paths_, ", "));
    return error;
}

}  // namespace camber::app
