// Kinds of arguments, and options that several verbs have.
#include "arguments.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>
#include <CLI/CLI.hpp>

import camber.core;
import camber.cad;
import camber.commands;
import camber.config;
import camber.recipes;
import camber.io;
import camber.surface;
import camber.transfer;

namespace camber::app {

void add_details(CLI::App* verb, const std::string& text) {
    verb->description(verb->get_description() + "\n\n" + text);
}

template <class T>
CLI::Option* add_option(CLI::App* verb, const std::string& name, T& value, const std::string& text) {
    return verb->add_option(name, value, text);
}
#define CAMBER_ARGUMENT(...) \
    template CLI::Option* add_option(CLI::App*, const std::string&, __VA_ARGS__&, const std::string&);
CAMBER_ARGUMENT(int)
CAMBER_ARGUMENT(std::size_t)
CAMBER_ARGUMENT(double)
CAMBER_ARGUMENT(std::string)
CAMBER_ARGUMENT(std::optional<int>)
CAMBER_ARGUMENT(std::optional<std::size_t>)
CAMBER_ARGUMENT(std::optional<double>)
CAMBER_ARGUMENT(std::optional<std::string>)
CAMBER_ARGUMENT(std::vector<std::string>)
CAMBER_ARGUMENT(std::vector<double>)
#undef CAMBER_ARGUMENT

CLI::Option* add_option(CLI::App* verb, const std::string& name, const CLI::callback_t& take, const std::string& text) {
    return verb->add_option(name, take, text);
}

CLI::Option* add_flag(CLI::App* verb, const std::string& name, bool& value, const std::string& text) {
    return verb->add_flag(name, value, text);
}

std::string long_name(const CLI::Option& option) {
    return option.get_lnames().empty() ? option.get_name() : option.get_lnames().front();
}

std::string joined(const std::vector<std::string>& words, std::string_view separator) {
    std::string text;
    for (const std::string& word : words) text.append(text.empty() ? std::string_view() : separator).append(word);
    return text;
}

std::string endings_of_input() { return listed(endings_read(mesh_formats()), ", "); }
std::string endings_of_output() { return listed(endings_written(mesh_formats()), ", "); }
std::string endings_of_solutions() { return listed(endings_read(solution_formats()), ", "); }

std::string mesh_or_solution() {
    return "A mesh of degree 1 or 2 (" + endings_of_input() + ") or a solution (" + endings_of_solutions() + ")";
}

namespace {

/// The error of an option's value and its remedy as one text for the parser; `error_of` separates them again.
std::string with_remedy(const std::string& what, const std::string& remedy) { return what + "\n" + remedy; }

}  // namespace

CLI::Validator within(const Limits& limits, bool is_whole) {
    const auto check = [limits, is_whole](const std::string& text) -> std::string {
        double x = 0;
        if (!CLI::detail::lexical_cast(text, x)) {
            std::string with_point = text;
            std::ranges::replace(with_point, ',', '.');
            const bool has_comma = with_point != text && CLI::detail::lexical_cast(with_point, x);
            return with_remedy(in_quotes(text) + " is no number", has_comma
                                                                      ? "write it with a point: " + with_point
                                                                      : "give one in digits, such as 0.5 or 1e-3");
        }
        if (is_whole && x != std::floor(x)) return "must be a whole number, got " + shortened(text);
        return limits.hold(x) ? std::string() : out_of_limits(limits, text);
    };
    return CLI::Validator(check, limits.interval());
}

CLI::Validator zero_or(const Limits& limits) {
    const auto check = [inner = within(limits, false)](const std::string& text) -> std::string {
        double x = 1;
        return CLI::detail::lexical_cast(text, x) && x == 0 ? std::string() : inner(text);
    };
    return CLI::Validator(check, "0 or " + limits.interval());
}
CLI::Validator none_as(const std::string& text) {
    return {[text](std::string& given) {
                if (given == "none") given = text;
                return std::string();
            },
            ""};
}

CLI::Validator one_of(const std::vector<std::string>& names) {
    return CLI::Validator(
        [names](const std::string& text) -> std::string {
            if (std::ranges::find(names, text) != names.end()) return {};
            if (const std::string now = config::new_name(config::NameKind::value, text, names); !now.empty())
                return with_remedy(in_quotes(text) + " was renamed to " + in_quotes(now), "write " + now);
            return with_remedy(in_quotes(text) + " is none of its words", suggestion(text, names));
        },
        "");
}

std::vector<std::string> mesh_format_names() {
    const auto names = names_written(mesh_formats());
    return {names.begin(), names.end()};
}

std::vector<std::string> field_format_names() {
    const auto of_solutions = names_written(solution_formats());
    std::vector<std::string> names(of_solutions.begin(), of_solutions.end());
    for (const MeshFormat& format : mesh_formats())
        if (format.encode && format.holds_fields) names.emplace_back(format.name);
    return names;
}

std::string help_of(std::string_view text) {
    std::string sentence(text);
    sentence.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(sentence.front())));
    return sentence;
}

void add_words(CLI::App* verb, const std::string& name, const std::string& sentence,
               const std::vector<std::string>& words, const std::function<void(std::size_t)>& set) {
    const auto set_word = [words, set](const std::vector<std::string>& given) {
        set(static_cast<std::size_t>(std::ranges::find(words, given.front()) - words.begin()));
        return true;
    };
    add_option(verb, name, set_word, sentence)->transform(one_of(words))->option_text(joined(words, "|"));
}

void add_mesh(CLI::App* verb, std::string& input) {
    add_option(verb, "input", input, "The mesh (" + endings_of_input() + ")")->required();
}

void add_format(CLI::App* verb, std::string& format, const std::vector<std::string>& names) {
    add_option(verb, "--format", format,
               "The output's format by its name, whatever its ending (" + joined(names) +
                   "); - as the output, standard output, needs it")
        ->check(one_of(names))
        ->option_text("NAME");
}

void add_flat(CLI::App* verb, config::Flat& flat) {
    add_words(verb, "--flat", flat,
              "What triangles without tetrahedra and of one z are: plane (the default), a 2D mesh, written with its z "
              "again; or surface, one in space");
}

void add_read(CLI::App* verb, DecodeOptions& options) {
    add_option(verb, "--reference-array", options.reference_array,
               "The array of cells that has their references (.vtu, .vtk). Default: reference, or one that other "
               "programs have for that (material, region …)");
    add_option(verb, "--zone", options.zone,
               "The zone to read, by its number or name (.su2, .cgns). Default: all, joined into one mesh");
}

void add_sizes(CLI::App* verb, std::vector<std::string>& sizes) {
    add_option(verb, "--size", sizes,
               "A size at boundary facets by their reference, as 3=0.01, or KIND:REFERENCE,REFERENCE=SIZE with "
               "facets, edges, vertices or elements; again for more")
        ->allow_extra_args(false);
}

void add_metric(CLI::App* verb, MetricChoice& a) {
    add_option(verb, "--metric", a.metric,
               "natural, a size such as 0.1, solution (what interpolates --solution best), a file (" +
                   endings_of_solutions() +
                   ", or a mesh file with its field metric), or JSON such as '{\"field\": {\"polar-1\": {}}}'")
        ->default_str("natural");
    add_sizes(verb, a.sizes);
    add_option(
        verb, "--geometry-error", a.geometry_error,
        "Largest distance of the boundary from its geometry, both ways. The metric gets the sizes for it; remesh "
        "refines until it is met, or ends with exit code 1. Default: remesh makes no facet that is farther than a "
        "hundredth of the size of its surface, or that turns by more than 30 degrees, with degree 2 by 90; none: any")
        ->check(above<double>(0))
        ->transform(none_as("inf"));
    add_gradation(verb, a.gradation);
    add_option(verb, "--complexity", a.complexity,
               "Scale the metric, once it is graded, to this complexity: about 12 times as many tetrahedra, 2.6 "
               "times as many triangles. Default: as the metric is")
        ->check(above<double>(0));
}

void add_gradation(CLI::App* verb, std::optional<double>& gradation) {
    add_option(verb, "--gradation", gradation,
               "Largest ratio of the metric's sizes at adjacent edges; 0: not limited. Default: 2.5 for the metric of "
               "a solution, others as they are")
        ->check(zero_or(option_of(&config::Gradation::ratio).limits));
}

void add_geometry(CLI::App* verb, GeometryArguments& a) {
    add_option(
        verb, "--geometry", a.geometry,
        "surrogate (from the mesh), straight, or JSON such as '{\"analytic\": [{\"references\": [1], \"sphere\": "
        "{\"radius\": 5}}]}' or '{\"mesh\": \"first.meshb\"}': the boundary of another mesh of the body")
        ->default_str("surrogate");
    add_option(verb, "--cad", a.cad,
               "The CAD model that the boundary is put onto (" + std::string(cad_endings) +
                   "); --geometry may have analytic surfaces beside it, by reference");
    add_words(verb, "--cad-unit", a.cad_unit,
              "The unit of the mesh's coordinates, to which the CAD model is converted. Default: auto, that of the "
              "model's file if the mesh's boundary lies on the model in it, else the only unit in which it does");
    add_words(verb, "--cad-vertices", a.cad_vertices,
              "Vertices of the boundary that are off the CAD model: keep, or move them onto it first. Default: keep, "
              "and too many of them are an error");
    add_option(verb, "--cad-timeout", a.cad_timeout,
               "How long reading the CAD model may take (s). Default: 10, and 1 for each megabyte of its file")
        ->check(at_least<double>(0));
    add_option(verb, "--cad-memory", a.cad_memory,
               "How much memory reading the CAD model may take (MB). Default: 1000, and 50 times its file")
        ->check(at_least<double>(0));
}

void add_geometry_tolerance(CLI::App* verb, GeometryArguments& a) {
    const auto nodes = option_of(&BoundaryTolerance::nodes);
    add_option(verb, "--geometry-tolerance", a.tolerance,
               help_of(nodes) + "; nodes beyond it: exit code 1. Default: 1e-5")
        ->check(within<double>(nodes.limits));
}

void add_bound(CLI::App* verb, PipelineArguments& a) {
    add_option(verb, "--min-scaled-jacobian", a.min_scaled_jacobian,
               "Every element's scaled Jacobian must be at least this, from 0 and below 1; what is not: exit code 1. "
               "Without it 0.1 is recommended: what is below is a note")
        ->check(within<double>(option_of(&config::Validate::min_scaled_jacobian).limits));
}

void add_fields(CLI::App* verb, SolutionChoice& a) {
    add_option(verb, "--solution", a.given,
               "Fields on the input that go along: rows at its vertices or nodes (" + endings_of_solutions() +
                   "), a file of the same mesh with fields, or an expression such as 'tanh((x-y)/0.05)' of its "
                   "nodes. curve places inner nodes where these are interpolated best, but for a --metric or an "
                   "--objective. Default: the fields of the input's own file");
    add_option(verb, "--fields", a.fields, "Names of the fields to take, with commas. Default: all")->delimiter(',');
    add_option(verb, "--output-solution", a.output,
               "Where they go (" + endings_of_solutions() +
                   ", or with the mesh). Default: with the mesh, where its format has fields");
    add_words(verb, "--transfer", a.method, help_of(option_of(&TransferOptions::method)));
}

void add_partition(CLI::App* verb, PipelineArguments& a) {
    const auto partition = option_of(&config::Output::partition);
    add_option(verb, "--partition", a.partition,
               "The mesh in so many parts for a solver, as convert has it: -o OUT.pvtu, which names its pieces")
        ->check(within<int>(partition.limits));
}

void add_force(CLI::App* verb, bool& force) {
    add_flag(verb, "--force", force, "Replace the input if the output is the same file");
}

void add_histogram(CLI::App* verb, bool& histogram) {
    add_flag(
        verb, "--histogram", histogram,
        "Also print how length reductions, lengths, curvatures and Jacobians are spread, before and after correction");
}

void add_settings(CLI::App* verb, std::vector<std::string>& settings, std::optional<int>& threads, bool& print_config,
                  bool& dry_run) {
    add_option(verb, "--set", settings,
               "Override one option of the config: path=value, e.g. stages/curve/objective=length")
        ->type_name("PATH=VALUE");
    add_threads(verb, threads);
    add_flag(verb, "--print-config", print_config, "Print the pipeline with every default, and stop");
    add_flag(verb, "--dry-run", dry_run,
             "Read the input and tell what would be done, with memory and time expected; write nothing");
}

void add_pipeline(CLI::App* verb, PipelineArguments& a) {
    add_format(verb, a.format, mesh_format_names());
    add_flat(verb, a.flat);
    add_option(verb, "--report", a.report, "Also write the figures as JSON");
    add_option(verb, "--vtu", a.vtu, "Also write the mesh with the run's fields for ParaView (.vtu)");
    add_option(verb, "--plots", a.plots, "Also write histograms as SVG files into this folder");
    add_option(verb, "--page", a.page, "Also write the mesh and the figures as a page for a browser (.html)");
    add_settings(verb, a.settings, a.threads, a.print_config, a.dry_run);
}

}  // namespace camber::app
