module;
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.config;
import camber.run;
import :cycles;
import :by_blocks;
import :ending;
import :execute;
import :formats;
import :given;
import :named_files;

namespace camber::app {

namespace {

std::string text_of(const run::Run& run, const config::Output& output, bool histogram) {
    std::string text = run::table(run.report);
    if (histogram)
        for (const run::Histogram& h : run.report.histograms) text += run::bars(h);
    text += "\n";
    const std::string metric = run.metric ? output.metric : std::string();
    const std::string solution = run.solution.empty() ? std::string() : output.solution;
    return text + wrote_rows({output.mesh, output.vtu, metric, solution, output.report, output.plots, output.page});
}

/// Prints why the result is not the requested one; returns the exit code 1.
int report_misses(const run::Report& report) {
    for (const std::string& miss : run::misses(report)) tell(miss);
    return 1;
}

int finish(const config::Pipeline& pipeline, bool histogram, Host host) {
    if (goes_by_blocks(pipeline, host)) return finish_by_blocks(pipeline, std::move(host));
    Written written;
    const auto run = execute(pipeline, written, {}, std::move(host));
    if (!run) return report_error(run.error());
    for (const std::string& notice : run->report.notices) tell_note(notice);
    if (const std::string note = run::recommended_bound_note(run->report); !note.empty()) tell_note(note);
    const int said = end_with(text_of(*run, pipeline.output, histogram), written);
    const int held = run->report.holds_what_was_asked() ? 0 : report_misses(run->report);
    return said != 0 ? said : held;
}

/// What became of the arguments of a verb: a pipeline, whose files are named so.
int run_or_plan(const config::Pipeline& pipeline, const std::vector<NamedFile>& files, bool dry_run, bool histogram,
                Host host = {}) {
    if (auto distinct = check_named_files(files); !distinct) return report_error(distinct.error());
    if (!dry_run) return finish(pipeline, histogram, std::move(host));
    const auto text = plan(pipeline);
    return text ? end_with(*text + "\n  nothing was done\n") : report_error(text.error());
}

}  // namespace

Outcome<config::Pipeline> pipeline_of(std::string_view base, const PipelineArguments& arguments) {
    // Settings are made on the default pipeline; the arguments of their own come after.
    for (const std::string& setting : arguments.settings)
        if (setting.starts_with("input") || setting.starts_with("output/mesh"))
            return fail(ErrorKind::usage, in_quotes(setting) + " is the verb's own argument", "--set", {},
                        "give the mesh, --flat and -o, or use camber run");
    auto pipeline = config::read_pipeline(base, "command line", arguments.settings);
    if (!pipeline) return pipeline;
    pipeline->input = {config::FilePath{arguments.input}, arguments.flat};
    if (arguments.min_scaled_jacobian) {
        for (config::Stage& stage : pipeline->stages) {
            if (auto* validate = std::get_if<config::Validate>(&stage))
                validate->min_scaled_jacobian = *arguments.min_scaled_jacobian;
            if (auto* relax = std::get_if<config::Relax>(&stage))
                relax->min_scaled_jacobian = *arguments.min_scaled_jacobian;
            if (auto* reinsert = std::get_if<config::Reinsert>(&stage))
                reinsert->relax.min_scaled_jacobian = *arguments.min_scaled_jacobian;
        }
    }
    if (arguments.threads) pipeline->threads = *arguments.threads;
    config::Output& output = pipeline->output;
    output.mesh = arguments.output;
    if (!arguments.format.empty()) output.format = arguments.format;
    if (!arguments.report.empty()) output.report = arguments.report;
    if (!arguments.vtu.empty()) output.vtu = arguments.vtu;
    if (!arguments.plots.empty()) output.plots = arguments.plots;
    if (!arguments.page.empty()) output.page = arguments.page;
    output.partition = arguments.partition.value_or(output.partition);
    const SolutionChoice& solution = arguments.solution;
    if (!solution.given.empty()) {
        const bool is_file = names_a_file(solution.given);
        pipeline->solution.file = is_file ? solution.given : "";
        pipeline->solution.expression = is_file ? "" : solution.given;
    }
    if (!solution.fields.empty()) pipeline->solution.fields = solution.fields;
    if (solution.method) pipeline->solution.method = *solution.method;
    if (!solution.output.empty()) output.solution = solution.output;
    return pipeline;
}

int run_verb(const Outcome<config::Pipeline>& pipeline, const PipelineArguments& arguments, Host host) {
    if (!pipeline) return report_error(pipeline.error());
    if (arguments.print_config) return end_with(config::write_pipeline(*pipeline));
    return run_or_plan(*pipeline, files_of(*pipeline, words_of_options), arguments.dry_run, arguments.histogram,
                       std::move(host));
}

int run_command(const RunArguments& arguments) {
    auto text = read_file(arguments.config);
    if (!text) {
        Error error = text.error();
        if (error.kind == ErrorKind::input) error.kind = ErrorKind::usage;
        return report_error(error);
    }
    auto pipeline = config::read_pipeline(as_text(*text), called_input(arguments.config), arguments.settings);
    if (!pipeline) return report_error(pipeline.error());
    if (arguments.threads) pipeline->threads = *arguments.threads;
    if (arguments.print_config) return end_with(config::write_pipeline(*pipeline));
    const config::Pipeline below =
        config::with_inputs_below(*pipeline, std::filesystem::path(arguments.config).parent_path().string());
    auto files = files_of(below, words_of_config);
    files.insert(files.begin(), NamedFile{arguments.config, "the config", Role::input});
    if (!below.adapt.is_asked() && arguments.from)
        return report_error({ErrorKind::usage, "the config has no cycles to go on from", "--from", {}, "leave it out"});
    if (!below.adapt.is_asked()) return run_or_plan(below, files, arguments.dry_run, arguments.histogram);
    if (!below.adapt.solve.empty() && !arguments.allow_commands)
        return report_error({ErrorKind::usage,
                             fmt::format("the config runs a command: {}", fmt::join(below.adapt.solve, " ")),
                             arguments.config + ": /adapt/solve",
                             {},
                             "--allow-commands lets it"});
    if (arguments.histogram)
        return report_error({ErrorKind::usage,
                             "is of a single run, and the config has cycles",
                             "--histogram",
                             {},
                             "give \"output\": {\"plots\": …}, or leave it out"});
    return run_or_plan_cycles(below, files, {.from = arguments.from}, arguments.dry_run);
}

int explain_command(const std::string& topic) {
    if (topic.empty()) return end_with(fmt::format("Topics: {}\n", fmt::join(config::topics(), ", ")));
    const auto text = config::explain(topic);
    return text ? end_with(*text) : report_error(text.error());
}

int schema_command() { return end_with(config::pipeline_schema()); }

}  // namespace camber::app
