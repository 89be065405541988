module;
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.config;
import :cycles;
import :ending;
import :formats;
import :named_files;

namespace camber::app {

namespace {

constexpr const char* by_the_solution =
    R"({"input": {"mesh": "-"}, "metric": {"solution": {}}, "stages": ["elevate", "remesh",
        {"curve": {"objective": "solution"}}, "validate", "relax", "commit"]})";
constexpr const char* by_the_metric =
    R"({"input": {"mesh": "-"}, "stages": ["elevate", "remesh", "curve", "validate", "relax", "commit"]})";
constexpr const char* straight = R"({"input": {"mesh": "-"}, "metric": {"solution": {}}, "stages": ["remesh"]})";
/// An expression has values at all nodes: its degree says nothing of the elements that it is for.
constexpr const char* straight_by_expression =
    R"({"input": {"mesh": "-"}, "metric": {"solution": {"degree": 1}}, "stages": ["remesh"]})";
constexpr int usual_cycles = 8;

Outcome<Done> check_given(const AdaptArguments& a) {
    for (const std::string& setting : a.settings)
        if (setting.starts_with("adapt"))
            return fail(ErrorKind::usage, in_quotes(setting) + " is the verb's own argument", "--set", {},
                        "give --cycles and the like, or use camber run");
    const config::Adaptation& adapt = a.adapt;
    if (a.solution.given.empty() && !a.metric.metric && adapt.solve.empty() && adapt.exact.empty())
        return fail(ErrorKind::usage, "what is the mesh to be adapted to?", {}, {},
                    "give --solution, --metric, --solve or --field");
    if (!a.solution.given.empty() && !adapt.solve.empty())
        return fail(ErrorKind::usage, "and --solve are two solutions", "--solution", {}, "leave one of them out");
    return Done{};
}

/// What arguments say other than by default.
void put_given(const config::SolutionMetric& given, config::SolutionMetric& metric) {
    const config::SolutionMetric by_default;
    const auto put = [&](auto member) {
        if (given.*member != by_default.*member) metric.*member = given.*member;
    };
    put(&config::SolutionMetric::norm);
    put(&config::SolutionMetric::error_of);
    put(&config::SolutionMetric::min_size);
    put(&config::SolutionMetric::max_size);
    put(&config::SolutionMetric::max_anisotropy);
}

/// The pipeline of a cycle: nodes are placed by the solution where the metric is made of it, too.
const char* cycle_of(const AdaptArguments& a) {
    const std::string& given = a.solution.given;
    const bool is_expression = a.adapt.solve.empty() && (given.empty() || !names_a_file(given));
    if (a.degree == 1) return is_expression ? straight_by_expression : straight;
    return a.metric.metric ? by_the_metric : by_the_solution;
}

}  // namespace

Outcome<config::Pipeline> pipeline_of(const AdaptArguments& a) {
    if (auto given = check_given(a); !given) return fail(given.error());
    auto pipeline = pipeline_of(cycle_of(a), a);
    if (!pipeline) return pipeline;
    if (auto* made = std::get_if<config::SolutionMetric>(&pipeline->metric)) put_given(a.of_solution, *made);
    if (auto set = set_metric(a.metric, *pipeline); !set) return fail(set.error());
    if (auto set = set_geometry(a.geometry, *pipeline); !set) return fail(set.error());
    pipeline->adapt = a.adapt;
    const bool is_of_first_mesh = a.adapt.solve.empty() && !pipeline->solution.file.empty();
    pipeline->adapt.cycles = a.cycles.value_or(is_of_first_mesh ? 1 : usual_cycles);
    if (a.adapt.solve.empty() && a.solution.given.empty() && !a.metric.metric)
        pipeline->solution.expression = a.adapt.exact;
    return pipeline;
}

int adapt_command(const AdaptArguments& arguments) {
    const auto pipeline = pipeline_of(arguments);
    if (!pipeline) return report_error(pipeline.error());
    if (arguments.print_config) return end_with(config::write_pipeline(*pipeline));
    // What arguments gave is as sound as what a config says.
    if (auto read = config::read_pipeline(config::write_pipeline(*pipeline), "command line"); !read)
        return report_error(read.error());
    return run_or_plan_cycles(*pipeline, files_of(*pipeline, words_of_options),
                              {.from = arguments.from, .degree = arguments.degree == 1 ? 1 : 0}, arguments.dry_run);
}

int run_or_plan_cycles(const config::Pipeline& pipeline, const std::vector<NamedFile>& files,
                       const CyclesChoice& choice, bool dry_run) {
    // Every cycle's mesh takes the place of the output: the input would be lost while it is still needed.
    std::vector<NamedFile> named = files;
    for (NamedFile& file : named) {
        if (file.role == Role::input_mesh) file.role = Role::input;
        if (file.path == standard_stream)
            return report_error({ErrorKind::usage,
                                 "cycles read and write their files again and again, which a stream cannot",
                                 file.word + " -",
                                 {},
                                 "give a file"});
    }
    if (auto distinct = check_named_files(named); !distinct) return report_error(distinct.error());
    if (!dry_run) return run_cycles(pipeline, choice);
    const auto text = plan_cycles(pipeline, choice);
    return text ? end_with(*text + "\n  nothing was done\n") : report_error(text.error());
}

}  // namespace camber::app
