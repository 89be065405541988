#pragma once
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
import camber.commands;

namespace camber::app {

/// Subcommands store what is to be done; main does it.
struct Verb {
    RunArguments run;
    CurveArguments curve;
    RemeshArguments remesh;
    AdaptArguments adapt;
    RepairArguments repair;
    ConvertArguments convert;
    GenerateArguments generate;
    PlotArguments plot;
    PictureArguments picture;
    CheckArguments check;
    ReportArguments report;
    GeometryCommandArguments geometry;
    MetricArguments metric;
    TransferArguments transfer;
    InfoArguments info;
    std::string topic, help_of, schema;
};

/// Options of several verbs.
void add_sizes(CLI::App* verb, std::vector<std::string>& sizes);
void add_metric(CLI::App* verb, MetricChoice& arguments);
void add_solution_along(CLI::App* verb, SolutionChoice& solution);
void add_histogram(CLI::App* verb, bool& histogram);
/// What steers a run of a config, from whichever verb.
void add_settings(CLI::App* verb, std::vector<std::string>& settings, std::optional<int>& threads, bool& print_config,
                  bool& dry_run);

void add_geometry(CLI::App* verb, GeometryArguments& arguments);
/// How far nodes of the boundary may be from it.
void add_geometry_tolerance(CLI::App* verb, GeometryArguments& arguments);
/// The bound of the verbs that judge curved elements.
void add_bound(CLI::App* verb, PipelineArguments& arguments);
/// What the verbs that are a pipeline have in common, but for the solution that goes along.
void add_pipeline(CLI::App* verb, PipelineArguments& arguments);

void add_run(CLI::App& app, Verb& verb);
void add_curve(CLI::App& app, Verb& verb);
void add_repair(CLI::App& app, Verb& verb);
void add_remesh(CLI::App& app, Verb& verb);
void add_adapt(CLI::App& app, Verb& verb);
void add_metric_of_solution(CLI::App& app, Verb& verb);
void add_transfer(CLI::App& app, Verb& verb);
void add_convert(CLI::App& app, Verb& verb);
void add_generate(CLI::App& app, Verb& verb);
void add_check(CLI::App& app, Verb& verb);
void add_report(CLI::App& app, Verb& verb);
void add_inspection(CLI::App& app, Verb& verb);
void add_picture(CLI::App& app, Verb& verb);
void add_plot(CLI::App& app, Verb& verb);
/// info, explain, schema.
void add_others(CLI::App& app, Verb& verb);

/// --quiet and --verbose of the verbs that print something beside the data that is their result.
void add_voice(CLI::App& app);
void add_force(CLI::App* verb, bool& force);

/// The verbs and what they take.
void add_verbs(CLI::App& app, Verb& verb);

}  // namespace camber::app
