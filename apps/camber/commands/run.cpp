module;
#include <algorithm>
#include <cstddef>
#include <cstdio>
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
import :execute;

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

void print_histograms(const run::Report& report) {
    for (const run::Histogram& histogram : report.histograms) fmt::print("{}", run::bars(histogram));
}

void print_run(const run::Run& run, const config::Output& output, bool histogram) {
    for (const std::string& notice : run.report.notices) fmt::print(stderr, "camber: note: {}\n", notice);
    fmt::print("{}", run::table(run.report));
    if (histogram) print_histograms(run.report);
    fmt::print("\n");
    for (const std::string& path : {output.mesh, output.vtu, output.report, output.plots})
        if (!path.empty()) fmt::print("  wrote {}\n", path);
}

int print_plan(const config::Pipeline& pipeline) {
    auto text = plan(pipeline);
    if (!text) return report_error(text.error());
    fmt::print("{}\n  nothing was done\n", *text);
    return 0;
}

int finish(const config::Pipeline& pipeline, bool histogram) {
    auto run = execute(pipeline);
    if (!run) return report_error(run.error());
    print_run(*run, pipeline.output, histogram);
    if (run->report.holds_what_was_asked()) return 0;
    const run::Report& r = run->report;
    const std::size_t straight = r.validity->straight_inverted;
    fmt::print(stderr, "camber: {} elements are not certified valid above {:g}",
               r.invalid_elements.size() + r.undecided_elements.size(), r.validity->bound);
    if (!r.invalid_elements.empty()) fmt::print(stderr, "; invalid: {}", listed(r.invalid_elements));
    if (!r.undecided_elements.empty()) fmt::print(stderr, "; undecided: {}", listed(r.undecided_elements));
    if (straight > 0)
        fmt::print(stderr, " ({} flat or inverted before it was curved: mend the straight mesh)", straight);
    fmt::print(stderr, "\n");
    return 1;
}

}  // namespace

Outcome<config::Pipeline> pipeline_of(std::string_view base, const PipelineArguments& arguments) {
    // Settings are made on the default pipeline; the arguments of their own come after.
    for (const std::string& setting : arguments.settings)
        if (setting.starts_with("input") || setting.starts_with("output/mesh"))
            return fail(ErrorKind::usage, "\"" + setting + "\" is the verb's own argument", "--set", {},
                        "give the mesh and -o, or use camber run");
    auto pipeline = config::read_pipeline(base, "command line", arguments.settings);
    if (!pipeline) return pipeline;
    pipeline->input = config::FilePath{arguments.input};
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
    if (!arguments.report.empty()) output.report = arguments.report;
    if (!arguments.vtu.empty()) output.vtu = arguments.vtu;
    if (!arguments.plots.empty()) output.plots = arguments.plots;
    return pipeline;
}

int run_verb(const Outcome<config::Pipeline>& pipeline, const PipelineArguments& arguments) {
    if (!pipeline) return report_error(pipeline.error());
    if (arguments.print_config) {
        fmt::print("{}", config::write_pipeline(*pipeline));
        return 0;
    }
    return arguments.dry_run ? print_plan(*pipeline) : finish(*pipeline, arguments.histogram);
}

int run_command(const RunArguments& arguments) {
    auto text = read_file(arguments.config);
    if (!text) {
        Error error = text.error();
        error.kind = ErrorKind::usage;
        return report_error(error);
    }
    auto pipeline = config::read_pipeline(as_text(*text), arguments.config, arguments.settings);
    if (!pipeline) return report_error(pipeline.error());
    if (arguments.threads) pipeline->threads = *arguments.threads;
    if (arguments.print_config) {
        fmt::print("{}", config::write_pipeline(*pipeline));
        return 0;
    }
    const config::Pipeline below =
        config::with_inputs_below(*pipeline, std::filesystem::path(arguments.config).parent_path().string());
    return arguments.dry_run ? print_plan(below) : finish(below, arguments.histogram);
}

int explain_command(const std::string& topic) {
    if (topic.empty()) {
        fmt::print("Topics: {}\n", fmt::join(config::topics(), ", "));
        return 0;
    }
    auto text = config::explain(topic);
    if (!text) return report_error(text.error());
    fmt::print("{}", *text);
    return 0;
}

int schema_command() {
    fmt::print("{}", config::pipeline_schema());
    return 0;
}

}  // namespace camber::app
