module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
module camber.commands;
import camber.core;
import camber.solution_metric;
import camber.cad;
import camber.config;
import camber.io;
import camber.app_shell;
import camber.recipes;
import camber.reports;
import :execution;

namespace camber::app {

namespace {

template <class Stage>
void each_stage(config::Pipeline& pipeline, auto&& f) {
    for (config::Stage& stage : pipeline.stages)
        if (auto* const one = std::get_if<Stage>(&stage)) f(*one);
}

Outcome<config::Metric> metric_of(const std::string& text) {
    if (const auto size = number_in<double>(text)) {
        if (*size > 0) return config::Metric(config::ConstantMetric{.sizes = {*size}, .tensor = {}});
        return fail(ErrorKind::usage, text + " is not a size", "--metric", {}, "give a positive size");
    }
    std::string with_point = text;
    std::ranges::replace(with_point, ',', '.');
    if (with_point != text && number_in<double>(with_point))
        return fail(ErrorKind::usage, text + " is not a size", "--metric", {}, "use a decimal point: " + with_point);
    // An array is JSON and not a file name, but not a metric. The reader of configs reports it.
    const auto first = text.find_first_not_of(" \t\n");
    if (first != std::string::npos && text[first] == '[')
        if (auto array = config::read_pipeline(text, "--metric"); !array) return fail(array.error());
    return config::read_metric(text, "--metric");
}

bool bounds_geometry(const MetricChoice& choice) {
    return choice.geometry_error && std::isfinite(*choice.geometry_error);
}

/// Gradation is part of a solution's metric, since the search for the complexity includes it.
void put_into(const MetricChoice& choice, std::vector<ReferenceSize> sizes, config::SolutionMetric& metric) {
    if (choice.complexity) {
        metric.vertices = metric.elements = 0;
        metric.complexity = *choice.complexity;
    }
    metric.gradation = choice.gradation.value_or(metric.gradation);
    if (bounds_geometry(choice)) metric.geometry.chord_error = *choice.geometry_error;
    std::ranges::move(sizes, std::back_inserter(metric.sizes));
}

/// Rejects options of the metric if no stage uses one, and sizes if only curving uses a metric and none is specified.
Outcome<Done> check_metric_is_used(const MetricChoice& choice, const config::Pipeline& pipeline) {
    const char* const option = !choice.sizes.empty()     ? "--size"
                               : choice.complexity       ? "--complexity"
                               : choice.gradation        ? "--gradation"
                               : bounds_geometry(choice) ? "--geometry-error"
                                                         : nullptr;
    if (option == nullptr) return Done{};
    const config::Curve* curve = nullptr;
    for (const config::Stage& stage : pipeline.stages) {
        if (const auto* const specified = std::get_if<config::Curve>(&stage))
            curve = specified;
        else if (!std::holds_alternative<config::Elevate>(stage) && !std::holds_alternative<config::Validate>(stage) &&
                 !std::holds_alternative<config::Relax>(stage) && !std::holds_alternative<config::Commit>(stage))
            return Done{};
    }
    if (curve == nullptr) return Done{};
    if (curve->objective == Objective::shape || curve->objective == Objective::solution)
        return fail(
            ErrorKind::usage,
            "has no effect: curve does not use a metric with the objective " + std::string(word_of(curve->objective)),
            option, {}, "use camber remesh to change sizes, or another --objective");
    const bool changes_sizes = !choice.sizes.empty() || choice.complexity;
    if (changes_sizes && std::holds_alternative<config::NaturalMetric>(pipeline.metric))
        return fail(ErrorKind::usage, "has no effect on the sizes of elements: curve only moves nodes", option, {},
                    "use camber remesh, or give the --metric for curving");
    return Done{};
}

bool is_for_solution(const CurveArguments& arguments) {
    const auto says = [](const std::string& setting) {
        return setting.find("objective") != std::string::npos || setting.starts_with("metric");
    };
    return !arguments.solution.input_file.empty() && !arguments.objective && !arguments.metric.metric &&
           std::ranges::none_of(arguments.settings, says);
}

std::string text_of(const run::Run& run, const config::Output& output, bool histogram) {
    std::string text = voice() == Voice::verbose ? run::full_table(run.report) : run::summary(run.report);
    if (histogram)
        for (const run::Histogram& h : run.report.histograms) text += run::bars(h);
    text += "\n";
    const std::string metric = run.metric ? output.metric : std::string();
    const std::string solution = run.solution.empty() ? std::string() : output.solution;
    return text + wrote_rows({output.mesh, output.vtu, metric, solution, output.report, output.plots, output.page});
}

int report_misses(const run::Report& report) {
    for (const std::string& miss : run::misses(report)) print_line(miss);
    return 1;
}

Outcome<int> finish(const config::Pipeline& pipeline, bool histogram, Host host) {
    Written written;
    const auto run = runs_by_blocks(pipeline, host) ? execute_by_blocks(pipeline, written, std::move(host))
                                                    : execute(pipeline, written, {}, std::move(host));
    if (!run) return fail(run.error());
    for (const std::string& notice : run->report.notices)
        print_notice({notice, std::ranges::find(run->details, notice) != run->details.end()});
    if (const std::string note = run::recommended_bound_note(run->report); !note.empty()) print_note(note);
    const int said = end_with(text_of(*run, pipeline.output, histogram), written);
    const int code = run->report.meets_requirements() ? 0 : report_misses(run->report);
    return said != 0 ? said : code;
}

template <class Arguments>
Outcome<int> run_or_plan(const config::Pipeline& pipeline, const std::vector<NamedFile>& files,
                         const Arguments& arguments, Host host = {}) {
    if (auto distinct = check_named_files(files, arguments.force); !distinct) return fail(distinct.error());
    if (!arguments.dry_run) return finish(pipeline, arguments.histogram, std::move(host));
    return plan(pipeline).map([](const std::string& text) { return end_with(text + "\n  nothing was done\n"); });
}

Outcome<int> run_verb(const Outcome<config::Pipeline>& pipeline, const PipelineArguments& arguments, Host host = {}) {
    if (!pipeline) return fail(pipeline.error());
    // Option values have the same limits as values of a config.
    if (auto sound = config::with_values(*pipeline, {}, "command line"); !sound) return fail(sound.error());
    if (arguments.print_config) return end_with(config::write_pipeline(*pipeline));
    return run_or_plan(*pipeline, files_of(*pipeline, words_of_options), arguments, std::move(host));
}

config::Pipeline with_stages(std::vector<config::Stage> stages) {
    config::Pipeline pipeline;
    pipeline.stages = std::move(stages);
    return pipeline;
}

}  // namespace

Outcome<config::Pipeline> pipeline_of(const CurveArguments& arguments) {
    auto pipeline = pipeline_of(config::Pipeline{}, arguments);
    if (!pipeline) return pipeline;
    if (auto set = set_metric(arguments.metric, *pipeline); !set) return fail(set.error());
    if (auto set = set_geometry(arguments.geometry, *pipeline); !set) return fail(set.error());
    const auto objective = is_for_solution(arguments) ? Objective::solution : arguments.objective;
    each_stage<config::Curve>(*pipeline, [&](config::Curve& curve) {
        curve.objective = objective.value_or(curve.objective);
        curve.blocks = arguments.blocks.value_or(curve.blocks);
        if (arguments.memory) curve.memory = static_cast<double>(*arguments.memory);
    });
    if (auto used = check_metric_is_used(arguments.metric, *pipeline); !used) return fail(used.error());
    return pipeline;
}

Outcome<Done> set_metric(const MetricChoice& choice, config::Pipeline& pipeline) {
    if (choice.metric) {
        auto read = metric_of(*choice.metric);
        if (!read) return fail(read.error());
        pipeline.metric = std::move(*read);
    }
    if (choice.geometry_error && !bounds_geometry(choice)) pipeline.geometry_bound = config::GeometryBound::none;
    auto sizes = read_sizes(choice.sizes);
    if (!sizes) return fail(sizes.error());
    if (auto* result = std::get_if<config::SolutionMetric>(&pipeline.metric)) {
        put_into(choice, std::move(sizes->sizes), *result);
        return Done{};
    }
    auto& operations = pipeline.metric_operations;
    if (!sizes->sizes.empty()) operations.emplace_back(config::Intersect{std::move(*sizes)});
    if (bounds_geometry(choice))
        operations.emplace_back(config::Intersect{config::GeometryMetric{.chord_error = *choice.geometry_error}});
    if (choice.gradation && *choice.gradation > 0)
        operations.emplace_back(config::Gradation{.ratio = *choice.gradation});
    if (choice.complexity) operations.emplace_back(config::Complexity{.target = *choice.complexity});
    return Done{};
}

Outcome<Done> set_geometry(const GeometryArguments& arguments, config::Pipeline& pipeline) {
    const auto& [geometry, cad, unit, vertices, timeout, memory, tolerance] = arguments;
    if (tolerance) pipeline.geometry_tolerance.nodes = *tolerance;
    if (unit && !cad)
        return fail(ErrorKind::usage, "is the unit of a CAD model, but no model is specified", "--cad-unit", {},
                    "give --cad too");
    if (vertices && !cad)
        return fail(ErrorKind::usage, "moves vertices onto a CAD model, but no model is specified", "--cad-vertices",
                    {}, "give --cad too");
    config::Cad model;
    if (cad) {
        model.timeout = timeout;
        model.memory = memory;
        model.file = {*cad};
        model.unit = unit.value_or(model.unit);
        model.vertices = vertices.value_or(model.vertices);
        pipeline.geometry = model;
    }
    if (!geometry) return Done{};
    auto read = config::read_geometry(*geometry, "--geometry");
    if (!read) return fail(read.error());
    if (!cad) {
        pipeline.geometry = std::move(*read);
        return Done{};
    }
    // Analytic surfaces by reference complement the model. Any other geometry would describe the whole boundary too.
    auto* const beside = std::get_if<config::Analytic>(&*read);
    if (!beside)
        return fail(ErrorKind::usage, "cannot be combined with --cad", "--geometry", {},
                    "give one of them; only \"analytic\" surfaces can complement a model");
    model.analytic = std::move(beside->surfaces);
    pipeline.geometry = std::move(model);
    return Done{};
}

Outcome<int> curve_command(const CurveArguments& arguments, Host host) {
    return run_verb(pipeline_of(arguments), arguments, std::move(host));
}

Outcome<config::Pipeline> pipeline_of(const RemeshArguments& arguments) {
    auto pipeline = pipeline_of(with_stages({config::Remesh{}}), arguments);
    if (!pipeline) return pipeline;
    if (auto set = set_metric(arguments.metric, *pipeline); !set) return fail(set.error());
    if (auto set = set_geometry(arguments.geometry, *pipeline); !set) return fail(set.error());
    each_stage<config::Remesh>(*pipeline, [&](config::Remesh& remesh) {
        remesh.rounds = arguments.rounds.value_or(remesh.rounds);
        remesh.blocks = arguments.blocks.value_or(remesh.blocks);
        remesh.objective = arguments.objective.value_or(remesh.objective);
    });
    if (!arguments.output_metric.empty()) pipeline->output.metric = arguments.output_metric;
    return pipeline;
}

Outcome<int> remesh_command(const RemeshArguments& arguments, Host host) {
    return run_verb(pipeline_of(arguments), arguments, std::move(host));
}

Outcome<config::Pipeline> pipeline_of(const RepairArguments& arguments) {
    // The mesh has its own nodes: elevate and curve are not needed.
    auto pipeline = pipeline_of(with_stages({config::Validate{}, config::Relax{}, config::Commit{}}), arguments);
    if (!pipeline) return pipeline;
    if (auto set = set_geometry(arguments.geometry, *pipeline); !set) return fail(set.error());
    each_stage<config::Relax>(*pipeline, [&](config::Relax& relax) {
        relax.boundary_tolerance = arguments.boundary_tolerance.value_or(relax.boundary_tolerance);
    });
    return pipeline;
}

Outcome<int> repair_command(const RepairArguments& arguments) { return run_verb(pipeline_of(arguments), arguments); }

namespace {

/// Examples: "3=0.01", facets with reference 3; "elements:1,2=0.1", elements with two references.
Outcome<ReferenceSize> size_of(const std::string& text) {
    ReferenceSize out;
    const std::string_view whole = text;
    const auto equals = whole.find('='), colon = whole.find(':');
    const bool has_kind = colon < equals;
    const auto size = equals != std::string_view::npos ? number_in<double>(whole.substr(equals + 1)) : std::nullopt;
    const bool has_size = size && *size > 0;
    bool is_sound = has_size && !has_kind;
    out.size = size.value_or(0);
    for (const auto& word : words(out.of))
        if (has_size && has_kind && whole.substr(0, colon) == word.word) {
            out.of = word.value;
            is_sound = true;
        }
    for (std::size_t at = has_kind ? colon + 1 : 0; is_sound && at <= equals;) {
        const std::size_t end = std::min(whole.find(',', at), equals);
        const auto reference = number_in<Reference>(whole.substr(at, end - at));
        is_sound = reference.has_value();
        out.references.push_back(reference.value_or(0));
        at = end + 1;
    }
    if (is_sound) return out;
    return fail(ErrorKind::usage, "is not a size by reference", "--size " + shortened(text), {},
                fmt::format("write REFERENCE=SIZE, for example 3=0.01, or KIND:REFERENCE,REFERENCE=SIZE, where KIND is "
                            "one of {}",
                            fmt::join(all_words<ReferencedEntity>(), ", ")));
}

}  // namespace

Outcome<config::SizesMetric> read_sizes(const std::vector<std::string>& texts) {
    config::SizesMetric out;
    for (const std::string& text : texts) {
        auto size = size_of(text);
        if (!size) return fail(size.error());
        out.sizes.push_back(std::move(*size));
    }
    return out;
}

Outcome<config::Pipeline> pipeline_of(config::Pipeline base, const PipelineArguments& arguments) {
    // Settings apply to the default pipeline. The other arguments are applied after them.
    for (const std::string& setting : arguments.settings)
        if (setting.starts_with("input") || setting.starts_with("output/mesh"))
            return fail(ErrorKind::usage, in_quotes(setting) + " is set by an option of this verb", "--set", {},
                        "use the mesh argument, --flat and -o, or camber run");
    base.input = {config::FilePath{arguments.input}, arguments.flat};
    auto pipeline = config::with_values(base, arguments.settings, "command line");
    if (!pipeline) return pipeline;
    if (const auto& bound = arguments.min_scaled_jacobian) {
        each_stage<config::Validate>(*pipeline, [&](config::Validate& s) { s.min_scaled_jacobian = *bound; });
        each_stage<config::Relax>(*pipeline, [&](config::Relax& s) { s.min_scaled_jacobian = *bound; });
        each_stage<config::Reinsert>(*pipeline, [&](config::Reinsert& s) { s.relax.min_scaled_jacobian = *bound; });
    }
    if (arguments.threads) pipeline->threads = *arguments.threads;
    config::Output& output = pipeline->output;
    output.mesh = arguments.output;
    const SolutionChoice& solution = arguments.solution;
    const auto set = [](std::string& option, const std::string& argument) {
        if (!argument.empty()) option = argument;
    };
    set(output.format, arguments.format);
    set(output.report, arguments.report);
    set(output.vtu, arguments.vtu);
    set(output.plots, arguments.plots);
    set(output.page, arguments.page);
    set(output.solution, solution.output);
    output.partition = arguments.partition.value_or(output.partition);
    if (!solution.input_file.empty()) {
        const bool is_file = names_a_file(solution.input_file);
        pipeline->solution.file = is_file ? solution.input_file : "";
        pipeline->solution.expression = is_file ? "" : solution.input_file;
    }
    if (!solution.fields.empty()) pipeline->solution.fields = solution.fields;
    if (solution.method) pipeline->solution.method = *solution.method;
    return pipeline;
}

namespace {

Outcome<Done> check_is_config(const std::string& path, std::span<const std::byte> bytes) {
    if (as_text(bytes).starts_with('{')) return Done{};
    const bool is_mesh = format_with_content(mesh_formats(), bytes) || format_with_extension(mesh_formats(), path);
    const bool is_solution = format_with_content(solution_formats(), bytes) || is_solution_file(path);
    if (!is_mesh && !is_solution) return Done{};
    return fail(ErrorKind::usage,
                std::string(is_mesh ? "is a mesh" : "is a solution") + ", but run requires a config in JSON",
                called_input(path), {},
                is_mesh ? "for a mesh use camber curve, remesh, adapt, repair, check or convert"
                        : "for a solution use camber metric, transfer or convert");
}

}  // namespace

Outcome<int> run_command(const RunArguments& arguments) {
    auto text = read_file(arguments.config);
    if (!text) {
        Error error = text.error();
        if (error.kind == ErrorKind::input) error.kind = ErrorKind::usage;
        return fail(std::move(error));
    }
    if (auto is_config = check_is_config(arguments.config, *text); !is_config) return fail(is_config.error());
    auto pipeline = config::read_pipeline(as_text(*text), called_input(arguments.config), arguments.settings);
    if (!pipeline) return fail(pipeline.error());
    if (arguments.threads) pipeline->threads = *arguments.threads;
    if (arguments.print_config) return end_with(config::write_pipeline(*pipeline));
    const config::Pipeline below =
        config::with_inputs_below(*pipeline, std::filesystem::path(arguments.config).parent_path().string());
    auto files = files_of(below, words_of_config);
    files.insert(files.begin(), NamedFile{arguments.config, "the config", Role::input});
    if (!below.adapt.is_requested() && arguments.from)
        return fail(ErrorKind::usage, "the config has no cycles to continue", "--from", {}, "leave it out");
    if (!below.adapt.is_requested()) return run_or_plan(below, files, arguments);
    if (!below.adapt.solve.empty() && !arguments.allow_commands)
        return fail(ErrorKind::usage, fmt::format("the config runs a command: {}", fmt::join(below.adapt.solve, " ")),
                    arguments.config + ": /adapt/solve", {}, "allow it with --allow-commands");
    if (arguments.histogram)
        return fail(ErrorKind::usage, "is only available for single runs, but the config has cycles", "--histogram", {},
                    "use \"output\": {\"plots\": …}, or leave it out");
    return run_or_plan_cycles(below, files, {.from = arguments.from}, arguments.dry_run);
}

Outcome<int> schema_command(const std::string& of) {
    if (of.empty() || of == "config") return end_with(config::pipeline_schema());
    if (const auto schema = run::report_schema(of)) return end_with(*schema);
    return fail(ErrorKind::usage, "has no schema", of, {}, "use config, report, check or geometry");
}

}  // namespace camber::app
