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

std::string endings_of_input() { return listed(readable_extensions(mesh_formats()), ", "); }
std::string endings_of_output() { return listed(writable_extensions(mesh_formats()), ", "); }
std::string endings_of_solutions() { return listed(readable_extensions(solution_formats()), ", "); }

std::string mesh_or_solution() {
    return "A mesh of degree 1 or 2 (" + endings_of_input() + ") or a solution (" + endings_of_solutions() + ")";
}

namespace {

/// Joins error and remedy for the parser; `error_of` separates them.
std::string with_remedy(const std::string& what, const std::string& remedy) { return what + "\n" + remedy; }

}  // namespace

CLI::Validator within(const Limits& limits, bool is_whole) {
    const auto check = [limits, is_whole](const std::string& text) -> std::string {
        double x = 0;
        if (!CLI::detail::lexical_cast(text, x)) {
            std::string with_point = text;
            std::ranges::replace(with_point, ',', '.');
            const bool has_comma = with_point != text && CLI::detail::lexical_cast(with_point, x);
            return with_remedy(in_quotes(text) + " is not a number",
                               has_comma ? "use a decimal point: " + with_point : "write a number such as 0.5 or 1e-3");
        }
        if (is_whole && x != std::floor(x)) return "must be a whole number, got " + shortened(text);
        return limits.permit(x) ? std::string() : out_of_limits(limits, text);
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
    return {[text](std::string& argument_text) {
                if (argument_text == "none") argument_text = text;
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
            return with_remedy(in_quotes(text) + " is not an accepted value", suggestion(text, names));
        },
        "");
}

std::vector<std::string> mesh_format_names() {
    const auto names = writable_formats(mesh_formats());
    return {names.begin(), names.end()};
}

std::vector<std::string> field_format_names() {
    const auto of_solutions = writable_formats(solution_formats());
    std::vector<std::string> names(of_solutions.begin(), of_solutions.end());
    for (const MeshFormat& format : mesh_formats())
        if (format.encode && format.has_fields) names.emplace_back(format.name);
    return names;
}

std::string help_of(std::string_view text) {
    std::string sentence(text);
    sentence.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(sentence.front())));
    return sentence;
}

void add_words(CLI::App* verb, const std::string& name, const std::string& sentence,
               const std::vector<std::string>& words, const std::function<void(std::size_t)>& set) {
    const auto set_word = [words, set](const std::vector<std::string>& argument_text) {
        set(static_cast<std::size_t>(std::ranges::find(words, argument_text.front()) - words.begin()));
        return true;
    };
    add_option(verb, name, set_word, sentence)->transform(one_of(words))->option_text(joined(words, "|"));
}

void add_mesh(CLI::App* verb, std::string& input) {
    add_option(verb, "input", input, "The mesh (" + endings_of_input() + ")")->required();
}

void add_format(CLI::App* verb, std::string& format, const std::vector<std::string>& names) {
    add_option(verb, "--format", format,
               "Format of the output by name, independent of the file extension (" + joined(names) +
                   "). The output -, standard output, needs it")
        ->check(one_of(names))
        ->option_text("NAME");
}

void add_flat(CLI::App* verb, config::Flat& flat) {
    add_words(verb, "--flat", flat,
              "Interpretation of triangles at one z, without tetrahedra. plane: a 2D mesh, written with the same z; "
              "surface: a surface in space. Default: plane");
}

void add_read(CLI::App* verb, DecodeOptions& options) {
    add_option(verb, "--reference-array", options.reference_array,
               "Name of the cell array with the references (.vtu, .vtk). Default: reference, or the name that other "
               "programs use (material, region …)");
    add_option(verb, "--zone", options.zone,
               "Zone to read, by number or name (.su2, .cgns). Default: all zones, joined into one mesh");
}

void add_sizes(CLI::App* verb, std::vector<std::string>& sizes) {
    add_option(verb, "--size", sizes,
               "Size at boundary facets with a reference, such as 3=0.01, or KIND:REFERENCE,REFERENCE=SIZE. KIND is "
               "facets, edges, vertices or elements. Can be repeated")
        ->allow_extra_args(false);
}

void add_metric(CLI::App* verb, MetricChoice& a) {
    add_option(verb, "--metric", a.metric,
               "Metric. natural: sizes of the input mesh; solution: interpolates --solution best; otherwise a size "
               "such as 0.1, a file (" +
                   endings_of_solutions() +
                   ", or a mesh file with the field metric), or JSON such as '{\"field\": {\"polar-1\": {}}}'")
        ->default_str("natural");
    add_sizes(verb, a.sizes);
    add_option(
        verb, "--geometry-error", a.geometry_error,
        "Largest distance between the boundary and its geometry, in both directions, in model units. It bounds the "
        "sizes of the metric. remesh refines until the boundary meets it. If that fails: exit code 1. none: no limit. "
        "By "
        "default, remesh limits the distance of new facets to 0.01 times the size of their surface, and their turn to "
        "30 degrees (degree 2: 90)")
        ->check(above<double>(0))
        ->transform(none_as("inf"));
    add_gradation(verb, a.gradation);
    add_option(verb, "--complexity", a.complexity,
               "Complexity to which the graded metric is scaled: about 1/12 of the number of tetrahedra, or 1/2.6 of "
               "the number of triangles. Default: no scaling")
        ->check(above<double>(0));
}

void add_gradation(CLI::App* verb, std::optional<double>& gradation) {
    add_option(verb, "--gradation", gradation,
               "Largest ratio of the metric's sizes at adjacent edges; 0: no limit. Default: 2.5 for the metric of a "
               "solution, no limit for others")
        ->check(zero_or(option_of(&config::Gradation::ratio).limits));
}

void add_geometry(CLI::App* verb, GeometryArguments& a) {
    add_option(
        verb, "--geometry", a.geometry,
        "Geometry of the boundary. surrogate: smooth surface through the mesh; straight: flat facets; or JSON such as "
        "'{\"analytic\": [{\"references\": [1], \"sphere\": {\"radius\": 5}}]}' or '{\"mesh\": \"first.meshb\"}', the "
        "boundary of another mesh of the body")
        ->default_str("surrogate");
    add_option(verb, "--cad", a.cad,
               "CAD model onto which the boundary is projected (" + std::string(cad_endings) +
                   "). --geometry can add analytic surfaces by reference");
    add_words(verb, "--cad-unit", a.cad_unit,
              "Unit of the mesh's coordinates. The CAD model is converted to it. Default: auto, the unit of the "
              "model's file if the boundary of the mesh lies on the model in it, otherwise the only unit in which it "
              "does");
    add_words(verb, "--cad-vertices", a.cad_vertices,
              "Treatment of boundary vertices that are off the CAD model. keep: they stay; too many of them are an "
              "error; move: they move onto the model first. Default: keep");
    add_option(verb, "--cad-timeout", a.cad_timeout,
               "Time limit for reading the CAD model, in s. Default: 10 s, and 1 s for each megabyte of its file")
        ->check(at_least<double>(0));
    add_option(verb, "--cad-memory", a.cad_memory,
               "Memory limit for reading the CAD model, in MB. Default: 1000, and 50 times the size of its file")
        ->check(at_least<double>(0));
}

void add_geometry_tolerance(CLI::App* verb, GeometryArguments& a) {
    const auto nodes = option_of(&BoundaryTolerance::nodes);
    add_option(verb, "--geometry-tolerance", a.tolerance,
               help_of(nodes) + ". Farther nodes: exit code 1. Default: 1e-5")
        ->check(within<double>(nodes.limits));
}

void add_bound(CLI::App* verb, PipelineArguments& a) {
    add_option(verb, "--min-scaled-jacobian", a.min_scaled_jacobian,
               "Smallest scaled Jacobian that every element must have, from 0 to below 1. Elements below it: exit code "
               "1. By default, elements below 0.1 are reported in a note")
        ->check(within<double>(option_of(&config::Validate::min_scaled_jacobian).limits));
}

void add_fields(CLI::App* verb, SolutionChoice& a) {
    add_option(verb, "--solution", a.input_file,
               "Fields on the input that are transferred: rows at its vertices or nodes (" + endings_of_solutions() +
                   "), a mesh file of the same mesh with fields, or an expression at its nodes such as "
                   "'tanh((x-y)/0.05)'. curve places inner nodes to interpolate them best, unless there is a --metric "
                   "or an --objective. Default: the fields of the input file");
    add_option(verb, "--fields", a.fields, "Names of the fields to read, separated by commas. Default: all")
        ->delimiter(',');
    add_option(verb, "--output-solution", a.output,
               "Output file of the fields (" + endings_of_solutions() +
                   "). Default: in the mesh file, if its format stores fields");
    add_words(verb, "--transfer", a.method, help_of(option_of(&TransferOptions::method)));
}

void add_partition(CLI::App* verb, PipelineArguments& a) {
    const auto partition = option_of(&config::Output::partition);
    add_option(verb, "--partition", a.partition,
               "Number of parts of the mesh for a parallel solver, as in convert: -o OUT.pvtu, which lists its pieces")
        ->check(within<int>(partition.limits));
}

void add_force(CLI::App* verb, bool& force) {
    add_flag(verb, "--force", force, "Replace the input if the output is the same file");
}

void add_histogram(CLI::App* verb, bool& histogram) {
    add_flag(
        verb, "--histogram", histogram,
        "Also print histograms of length reductions, lengths, curvatures and Jacobians, before and after correction");
}

void add_settings(CLI::App* verb, std::vector<std::string>& settings, std::optional<int>& threads, bool& print_config,
                  bool& dry_run) {
    add_option(verb, "--set", settings,
               "Override one option of the config: path=value, e.g. stages/curve/objective=length")
        ->type_name("PATH=VALUE");
    add_threads(verb, threads);
    add_flag(verb, "--print-config", print_config, "Print the pipeline with all defaults, and stop");
    add_flag(verb, "--dry-run", dry_run,
             "Read the input, print the steps and the estimated memory and time, and write nothing");
}

void add_pipeline(CLI::App* verb, PipelineArguments& a) {
    add_format(verb, a.format, mesh_format_names());
    add_flat(verb, a.flat);
    add_option(verb, "--report", a.report, "Also write the report as JSON");
    add_option(verb, "--vtu", a.vtu, "Also write the mesh with the run's fields for ParaView (.vtu)");
    add_option(verb, "--plots", a.plots, "Also write histograms as SVG files into this folder");
    add_option(verb, "--page", a.page, "Also write the mesh and the report as a page for a browser (.html)");
    add_settings(verb, a.settings, a.threads, a.print_config, a.dry_run);
}

}  // namespace camber::app
