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

/// "3, 17, 18 and 240 more".
std::string listed(const std::vector<std::size_t>& elements) {
    constexpr std::size_t shown = 10;
    std::string text;
    for (std::size_t i = 0; i < std::min(shown, elements.size()); ++i)
        text += (i > 0 ? ", " : "") + std::to_string(elements[i]);
    if (elements.size() > shown) text += fmt::format(" and {} more", elements.size() - shown);
    return text;
}

std::string text_of(const run::Run& run, const config::Output& output, bool histogram) {
    std::string text = run::table(run.report);
    if (histogram)
        for (const run::Histogram& h : run.report.histograms) text += run::bars(h);
    text += "\n";
    const std::string metric = run.metric ? output.metric : std::string();
    const std::string solution = run.solution.empty() ? std::string() : output.solution;
    return text + wrote_rows({output.mesh, output.vtu, metric, solution, output.report, output.plots, output.page});
}

/// What would make the elements valid that repair left; empty where nothing is known of it.
std::string what_would_help(const run::Report& r) {
    if (!r.kept_boundary || r.remaining.empty()) return {};
    std::vector<std::string> ways;
    if (const auto& tolerance = r.kept_boundary->would_do)
        ways.push_back(fmt::format("--boundary-tolerance {:g} (tried: every element is valid then)", *tolerance));
    if (r.origin && (r.origin->geometry == "surrogate" || r.origin->geometry == "straight"))
        ways.emplace_back("--cad MODEL, or --geometry, on which the boundary's nodes may slide");
    return fmt::format("{}", fmt::join(ways, ", or "));
}

/// "camber: 3 elements are not certified valid …": what the run misses, and the exit code 1.
int report_misses(const run::Report& r) {
    const std::size_t straight = r.validity->straight_inverted;
    const std::size_t below = r.validity->is_asked ? r.elements_below_bound.size() : 0;
    std::string line = fmt::format("{} elements are not certified valid",
                                   r.invalid_elements.size() + r.undecided_elements.size() + below);
    if (below > 0) line += fmt::format(" above {:g}", r.validity->bound);
    if (!r.invalid_elements.empty()) line += "; invalid: " + listed(r.invalid_elements);
    if (!r.undecided_elements.empty()) line += "; undecided: " + listed(r.undecided_elements);
    if (below > 0) line += fmt::format("; below {:g}: ", r.validity->bound) + listed(r.elements_below_bound);
    if (const std::string help = what_would_help(r); !help.empty()) line += "; what would help: " + help;
    if (straight > 0 && !r.remesh)  // what passes leave inverted when straight is no fault
        line += fmt::format(" ({} flat or inverted before it was curved: mend the straight mesh)", straight);
    tell(line);
    return 1;
}

/// What is below a bound that nobody asked for; empty when nothing is.
std::string note_of_wish(const run::Report& r) {
    if (!r.validity || r.validity->is_asked || r.elements_below_bound.empty()) return {};
    const char* raise = "";
    if (r.kept_boundary)
        raise = "; --boundary-tolerance or --cad gives it room to raise them";
    else if (r.curve)
        raise = "; --objective shape, or smaller elements there, raises them";
    return fmt::format(
        "{} elements are valid, but below the recommended scaled Jacobian {:g}: {} (no failure: "
        "--min-scaled-jacobian {:g} would make it one{})",
        r.elements_below_bound.size(), r.validity->bound, listed(r.elements_below_bound), r.validity->bound, raise);
}

int finish(const config::Pipeline& pipeline, bool histogram, Host host) {
    if (goes_by_blocks(pipeline, host)) return finish_by_blocks(pipeline, std::move(host));
    Written written;
    const auto run = execute(pipeline, written, {}, std::move(host));
    if (!run) return report_error(run.error());
    for (const std::string& notice : run->report.notices) tell_note(notice);
    if (const std::string note = note_of_wish(run->report); !note.empty()) tell_note(note);
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
            return fail(ErrorKind::usage, "\"" + setting + "\" is the verb's own argument", "--set", {},
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
