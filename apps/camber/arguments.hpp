#pragma once
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
    std::string topic;
};

/// Options of several verbs.
void add_sizes(CLI::App* verb, std::vector<std::string>& sizes);
void add_solution_along(CLI::App* verb, SolutionChoice& solution);

void add_geometry(CLI::App* verb, GeometryArguments& arguments);
/// The bound of the verbs that judge curved elements.
void add_bound(CLI::App* verb, PipelineArguments& arguments);
/// What the verbs that are a pipeline have in common, but for the solution that goes along.
void add_pipeline(CLI::App* verb, PipelineArguments& arguments);

void add_adapt(CLI::App& app, Verb& verb);
void add_metric_of_solution(CLI::App& app, Verb& verb);
void add_transfer(CLI::App& app, Verb& verb);
void add_picture(CLI::App& app, Verb& verb);

/// --quiet of the verbs that say something beside the data that they are asked for.
void add_quiet(CLI::App& app);

/// The verbs and what they take.
void add_verbs(CLI::App& app, Verb& verb);

}  // namespace camber::app
