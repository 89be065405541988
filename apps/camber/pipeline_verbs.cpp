#include "arguments.hpp"

#include <string>
#include <vector>
#include <CLI/CLI.hpp>

import camber.core;
import camber.commands;
import camber.config;
import camber.recipes;
import camber.solution_metric;
import camber.transfer;

namespace camber::app {

Work declare_run(CLI::App* verb, Arguments& all) {
    RunArguments& a = all.run;
    add_option(verb, "config", a.config, "Config file of the pipeline. Input paths are relative to its folder")
        ->required();
    add_flag(verb, "--allow-commands", a.allow_commands,
             "Allow the config to run the command of its adapt/solve. Use it only for configs that you trust");
    add_option(verb, "--from", a.from, "For a config with cycles: continue after this cycle of an earlier run")
        ->check(at_least<int>(0));
    add_settings(verb, a.settings, a.threads, a.print_config, a.dry_run);
    add_force(verb, a.force);
    add_histogram(verb, a.histogram);
    return {[&a](const Host&) { return run_command(a); }};
}

Work declare_curve(CLI::App* verb, Arguments& all) {
    CurveArguments& a = all.curve;
    add_mesh(verb, a.input);
    add_option(verb, "-o,--output", a.output, "Output file of the curved mesh (" + endings_of_output() + ")")
        ->required();
    add_metric(verb, a.metric);
    add_geometry(verb, a.geometry);
    add_geometry_tolerance(verb, a.geometry);
    add_words(verb, "--objective", a.objective,
              help_of(option_of(&config::Curve::objective)) +
                  ". Default: solution if there is --solution and no --metric, otherwise " +
                  std::string(word_of(config::Curve{}.objective)));
    const auto blocks = option_of(&config::Curve::blocks);
    add_option(verb, "--blocks", a.blocks, help_of(blocks))->check(within<int>(blocks.limits));
    add_option(verb, "--memory", a.memory, help_of(option_of(&config::Curve::memory)) + ". 2G: 2 gibibytes")
        ->transform(CLI::AsSizeValue(false));
    add_bound(verb, a);
    add_fields(verb, a.solution);
    add_partition(verb, a);
    add_pipeline(verb, a);
    add_force(verb, a.force);
    add_histogram(verb, a.histogram);
    return {[&a](const Host& host) { return curve_command(a, host); }, [&a] { return pipeline_of(a); }};
}

Work declare_repair(CLI::App* verb, Arguments& all) {
    add_details(
        verb,
        "  camber repair broken.meshb -o valid.meshb\n"
        "  camber repair broken.meshb -o valid.meshb --boundary-tolerance 1e-3\n\n"
        "The boundary and interfaces between materials stay unchanged. Nodes of the volume move, and its vertices if "
        "necessary. With --cad, or analytic surfaces, boundary nodes are first projected onto these. They slide on "
        "them only if other moves fail. With --boundary-tolerance T, nodes of boundary edges may move by at most T if "
        "other moves fail. Between nodes, the surface then moves by at most 4/3 T. Boundary vertices never move. "
        "Elements that cannot be repaired are listed with the reason. The mesh is written with them, and the exit code "
        "is 1. Algorithm: docs/algorithms/repair.md");
    RepairArguments& a = all.repair;
    add_option(verb, "input", a.input, "The curved mesh (" + endings_of_input() + ")")->required();
    add_option(verb, "-o,--output", a.output, "Output file of the repaired mesh (" + endings_of_output() + ")")
        ->required();
    add_option(verb, "--boundary-tolerance", a.boundary_tolerance,
               "Largest distance by which the node of a boundary edge may move, in model units; 0 (the default): it "
               "does not move")
        ->check(at_least<double>(0));
    add_geometry(verb, a.geometry);
    add_geometry_tolerance(verb, a.geometry);
    add_bound(verb, a);
    add_fields(verb, a.solution);
    add_pipeline(verb, a);
    add_force(verb, a.force);
    add_histogram(verb, a.histogram);
    return {[&a](const Host&) { return repair_command(a); }, [&a] { return pipeline_of(a); }};
}

Work declare_remesh(CLI::App* verb, Arguments& all) {
    add_details(verb,
                "  camber remesh wing.meshb --metric wing.solb -o finer.meshb\n"
                "  camber remesh wing.meshb --metric 0.1 -o even.meshb\n"
                "  camber remesh wing.meshb --metric wing.solb -o finer.meshb --output-metric finer.solb\n"
                "  camber remesh two.meshb -o three.meshb --geometry '{\"mesh\": \"one.meshb\"}'\n\n"
                "References, materials, interfaces, ridges, listed curves, corners and required entities are "
                "preserved. New boundary vertices lie on the geometry: by default a smooth surface through the "
                "boundary's vertices, and through its nodes if it is curved. If a mesh is remeshed repeatedly, specify "
                "the first mesh or the CAD model as the geometry, so that the boundary does not drift. A mesh of "
                "degree 2 keeps its degree: edges are measured along their curves, and every new element is valid. To "
                "curve a remeshed straight mesh onto the same geometry, put \"remesh\" before \"elevate\" in a config "
                "(configs/remesh.json). Algorithm: docs/algorithms/cavity-operator.md");
    RemeshArguments& a = all.remesh;
    add_mesh(verb, a.input);
    add_option(verb, "-o,--output", a.output, "Output file of the new mesh (" + endings_of_output() + ")")->required();
    add_metric(verb, a.metric);
    add_geometry(verb, a.geometry);
    add_geometry_tolerance(verb, a.geometry);
    const auto rounds = option_of(&config::Remesh::rounds);
    add_option(verb, "--rounds", a.rounds,
               "The " + std::string(rounds.sentence) + ". Fewer are done if few operations remain")
        ->check(within<int>(rounds.limits));
    const auto blocks = option_of(&config::Remesh::blocks);
    add_option(verb, "--blocks", a.blocks, help_of(blocks))->check(within<int>(blocks.limits));
    add_words(verb, "--objective", a.objective,
              help_of(option_of(&config::Remesh::objective)) +
                  ". Default: " + std::string(word_of(config::Remesh{}.objective)));
    add_option(verb, "--output-metric", a.output_metric,
               "Also write the metric at the new vertices (" + endings_of_solutions() + ")");
    add_fields(verb, a.solution);
    add_partition(verb, a);
    add_pipeline(verb, a);
    add_force(verb, a.force);
    add_histogram(verb, a.histogram);
    return {[&a](const Host& host) { return remesh_command(a, host); }, [&a] { return pipeline_of(a); }};
}

namespace {

void add_aims(CLI::App* verb, AdaptArguments& a) {
    add_option(verb, "--solution", a.solution.input_file,
               "Solution on MESH: a file of rows at its vertices or nodes (" + endings_of_solutions() +
                   "), or a file of the same mesh with fields. It allows one cycle, because it is unknown on the next "
                   "mesh. An expression such as 'tanh((x-y)/0.05)' allows any number of cycles");
    add_option(verb, "--fields", a.solution.fields, "Names of the fields to use, separated by commas. Default: all")
        ->delimiter(',');
    add_option(
        verb, "--solve",
        [&a](const std::vector<std::string>& argument_text) {
            a.adapt.solve = CLI::detail::split_up(argument_text.front());
            return !a.adapt.solve.empty();
        },
        "Command of the solver, run without a shell on the first mesh and on every new mesh. Its words contain {mesh}, "
        "the file to read, and {solution}, the file to write. Optional: {guess}, the previous solution, transferred to "
        "the new mesh; {cycle}, the number of the cycle; {folder}, its folder")
        ->type_name("COMMAND");
    add_option(verb, "--metric", a.metric.metric,
               "Metric to use instead of a solution: a size, a file (" + endings_of_solutions() +
                   ", or a mesh file with the field metric), or JSON such as '{\"field\": {\"polar-1\": {}}}'");
    add_option(verb, "--field", a.adapt.exact,
               "Exact solution as an expression. Its errors are reported for each cycle. Without another target, the "
               "mesh is adapted to it")
        ->type_name("EXPRESSION");
}

/// H1 means the L2 norm of gradients.
void add_norm(CLI::App* verb, config::SolutionMetric& metric) {
    const auto norm = option_of(&config::SolutionMetric::norm);
    add_option(verb, "--norm", metric.norm, help_of(norm) + "; H1: the same as --norm 2 --error-of gradients")
        ->check(within<double>(norm.limits))
        ->transform(CLI::Validator(
            [&metric, verb](std::string& argument_text) -> std::string {
                if (argument_text == "H1") {
                    const CLI::Option* const other = verb->get_option("--error-of");
                    if (other->count() > 0 && other->results().back() == "values")
                        return "H1 is the norm of gradients: remove --error-of values";
                    metric.error_of = ErrorQuantity::gradients;
                    argument_text = "2";
                }
                return std::string();
            },
            ""))
        ->capture_default_str();
}

void add_metric_of_solution_options(CLI::App* verb, AdaptArguments& a) {
    using S = config::SolutionMetric;
    add_option(verb, "--complexity", a.adapt.complexity,
               "Complexity of the metric in each cycle, separated by commas; the last value applies to all later "
               "cycles. A mesh has about 12 times as many tetrahedra, or 2.6 times as many triangles. Default: the "
               "number of elements of the mesh")
        ->delimiter(',')
        ->check(above<double>(0));
    add_norm(verb, a.of_solution);
    add_words(verb, "--error-of", a.of_solution.error_of, help_of(option_of(&S::error_of)));
    add_described<double>(verb, a.of_solution, option_of(&S::min_size));
    add_described<double>(verb, a.of_solution, option_of(&S::max_size));
    add_described<double>(verb, a.of_solution, option_of(&S::max_anisotropy));
    add_sizes(verb, a.metric.sizes);
    add_option(verb, "--geometry-error", a.metric.geometry_error,
               "Largest distance between the boundary and its geometry, in both directions, in model units. A larger "
               "distance in the result: exit code 1. none: no limit. The default is set by the expected error of the "
               "solution, and a larger distance causes a note; new facets are limited as with remesh")
        ->check(above<double>(0))
        ->transform(none_as("inf"));
    add_gradation(verb, a.metric.gradation);
}

void add_cycles(CLI::App* verb, AdaptArguments& a) {
    using S = config::Adaptation;
    add_option(verb, "--cycles", a.cycles,
               "Maximum number of cycles. They end earlier if the error has converged. Default: 8, or 1 with a "
               "solution file")
        ->check(between<int>(1, 1000));
    add_option(verb, "--degree", a.degree, "Degree of the new meshes. 1: straight; 2: curved")
        ->check(between<int>(1, 2))
        ->capture_default_str();
    add_described<double>(verb, a.adapt, option_of(&S::convergence_tolerance));
    add_words(verb, "--result", a.adapt.result, help_of(option_of(&S::result)));
    add_option(verb, "--timeout", a.adapt.timeout, "Time limit for each run of the solver, in s. Default: no limit")
        ->check(at_least<double>(0));
    add_option(verb, "--folder", a.adapt.folder,
               "Folder for the cycles, with a folder for each of them, series.pvd for ParaView, and cycles.json. "
               "Default: with --solve, the name of OUTPUT with .cycles; otherwise cycles are not stored");
    add_option(verb, "--from", a.from, "Continue after this cycle of an earlier run; later cycles are replaced")
        ->check(at_least<double>(0));
    add_option(verb, "--mesh-file", a.adapt.mesh,
               "File name of each cycle's mesh, with the extension of the format that the solver reads (" +
                   endings_of_output() + ")")
        ->capture_default_str();
    add_option(verb, "--solution-file", a.adapt.solution,
               "Name of the file that the solver writes: rows at the vertices or nodes of the mesh, in the order of "
               "the mesh file (" +
                   endings_of_solutions() + "), or a mesh file with fields at its nodes")
        ->capture_default_str();
}

}  // namespace

Work declare_adapt(CLI::App* verb, Arguments& all) {
    add_details(
        verb,
        "  camber adapt wing.meshb --solve 'python3 flow.py {mesh} {solution}' --complexity 2000,4000,8000 -o "
        "new.meshb\n"
        "  camber adapt wing.meshb --field 'tanh((sqrt(x^2+y^2+z^2)-1.2)/0.02)' --complexity 5000 -o new.meshb\n"
        "  camber adapt wing.meshb --solution u.solb --complexity 5000 -o new.meshb --output-solution v.solb\n"
        "  camber adapt wing.meshb --metric wing.solb --degree 1 -o new.meshb\n"
        "  camber adapt wing.meshb --solve 'flow {mesh} {solution}' -o new.meshb --from 3 --cycles 12\n\n"
        "Each cycle reads a mesh and its solution. It computes the metric that interpolates the solution best with the "
        "specified complexity, remeshes, and curves the edges for the solution. Then it transfers the solution to the "
        "new mesh. Every mesh is valid. The boundary stays on the geometry: that of --geometry or --cad, otherwise "
        "that of the first mesh. Cycles end if the error has converged (--convergence-tolerance), at the limit of "
        "--cycles, or by Ctrl-C. OUTPUT is the mesh with the smallest error (see --result). Algorithm: "
        "docs/algorithms/adaptation.md");
    AdaptArguments& a = all.adapt;
    add_mesh(verb, a.input);
    add_option(verb, "-o,--output", a.output, "Output file of the result (" + endings_of_output() + ")")->required();
    add_aims(verb, a);
    add_metric_of_solution_options(verb, a);
    add_cycles(verb, a);
    add_geometry(verb, a.geometry);
    add_geometry_tolerance(verb, a.geometry);
    add_option(verb, "--output-solution", a.solution.output,
               "Output file of the last solution (" + endings_of_solutions() + "). Default: in the mesh file");
    add_words(verb, "--transfer", a.solution.method, help_of(option_of(&TransferOptions::method)));
    add_bound(verb, a);
    add_pipeline(verb, a);
    return {[&a](const Host&) { return adapt_command(a); }, [&a] { return pipeline_of(a); }};
}

}  // namespace camber::app
