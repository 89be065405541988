// Options that several verbs take from the command line, and all verbs.
#include "arguments.hpp"
#include "argument_kinds.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>
#include <CLI/CLI.hpp>

import camber.core;
import camber.app_shell;
import camber.cad;
import camber.commands;
import camber.config;
import camber.io;
import camber.surface;

namespace camber::app {

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
    add_option(verb, "--gradation", a.gradation,
               "Largest ratio of the metric's sizes at adjacent edges; 0: not limited. Default: 2.5 for the metric of "
               "a solution, others as they are")
        ->check(zero_or(camber::option_of(&camber::config::Gradation::ratio).limits));
    add_option(verb, "--complexity", a.complexity,
               "Scale the metric, once it is graded, to this complexity: about 12 times as many tetrahedra, 2.6 "
               "times as many triangles. Default: as the metric is")
        ->check(above<double>(0));
}

void add_geometry(CLI::App* verb, GeometryArguments& a) {
    add_option(verb, "--geometry", a.geometry,
               "surrogate (from the mesh), straight, or JSON such as "
               "'{\"analytic\": [{\"references\": [1], \"sphere\": {\"radius\": 5}}]}' or "
               "'{\"mesh\": \"first.meshb\"}': the boundary of another mesh of the body")
        ->default_str("surrogate");
    add_option(verb, "--cad", a.cad,
               "The CAD model that the boundary is put onto (" + std::string(camber::cad_endings) +
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
    const auto nodes = camber::option_of(&camber::BoundaryTolerance::nodes);
    add_option(verb, "--geometry-tolerance", a.tolerance,
               help_of(nodes) + "; nodes beyond it: exit code 1. Default: 1e-5")
        ->check(within<double>(nodes.limits));
}

void add_bound(CLI::App* verb, PipelineArguments& a) {
    add_option(verb, "--min-scaled-jacobian", a.min_scaled_jacobian,
               "Every element's scaled Jacobian must be at least this, from 0 and below 1; what is not: exit code "
               "1. Without it 0.1 is recommended: what is below is a note")
        ->check(within<double>(camber::option_of(&camber::config::Validate::min_scaled_jacobian).limits));
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

void add_force(CLI::App* verb, bool& force) {
    add_flag(verb, "--force", force, "Replace the input if the output is the same file");
}

void add_voice(CLI::App& app) {
    const std::vector<std::string> give_data{"info", "explain", "help", "schema"};
    for (CLI::App* verb : app.get_subcommands({}))
        if (std::ranges::find(give_data, verb->get_name()) == give_data.end()) {
            CLI::Option* const quiet = verb->add_flag_callback(
                "--quiet", [] { set_voice(Voice::quiet); },
                "Print errors, and why the result is not the requested one, only: no table, no notes, no progress");
            verb->add_flag_callback(
                    "--verbose", [] { set_voice(Voice::verbose); },
                    "Also print details: data other than names and fields that the output's format cannot store")
                ->excludes(quiet);
        }
}

void add_verbs(CLI::App& app, Verb& verb) {
    add_run(app, verb);
    add_curve(app, verb);
    add_remesh(app, verb);
    add_adapt(app, verb);
    add_repair(app, verb);
    add_metric_of_solution(app, verb);
    add_transfer(app, verb);
    add_convert(app, verb);
    add_generate(app, verb);
    add_plot(app, verb);
    add_picture(app, verb);
    add_check(app, verb);
    add_report(app, verb);
    add_inspection(app, verb);
    add_others(app, verb);
}

}  // namespace camber::app
