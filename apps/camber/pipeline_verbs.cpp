// Arguments of the verbs that run a pipeline: run, curve, remesh, repair, adapt.
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
    add_option(verb, "config", a.config, "The pipeline; paths of inputs are relative to its folder")->required();
    add_flag(verb, "--allow-commands", a.allow_commands,
             "Let the config run the command of its adapt/solve: only of configs that you trust");
    add_option(verb, "--from", a.from, "Of a config with cycles: go on from this one of an earlier run")
        ->check(at_least<int>(0));
    add_settings(verb, a.settings, a.threads, a.print_config, a.dry_run);
    add_force(verb, a.force);
    add_histogram(verb, a.histogram);
    return {[&a](const Host&) { return run_command(a); }};
}

Work declare_curve(CLI::App* verb, Arguments& all) {
    CurveArguments& a = all.curve;
    add_mesh(verb, a.input);
    add_option(verb, "-o,--output", a.output, "Where the curved mesh goes (" + endings_of_output() + ")")->required();
    add_metric(verb, a.metric);
    add_geometry(verb, a.geometry);
    add_geometry_tolerance(verb, a.geometry);
    add_words(verb, "--objective", a.objective,
              help_of(option_of(&config::Curve::objective)) +
                  ". Default: solution where there is --solution and no --metric, else " +
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
        "The boundary stays as it is, bit for bit, interfaces between materials too: nodes of the volume move, and, if "
        "need be, its vertices. With --cad, or analytic surfaces, the boundary's nodes are first put onto these, and "
        "slide on them where nothing else helps. With --boundary-tolerance T the nodes of boundary edges may move too "
        "where nothing else helps, each by T at most (between them the surface then moves by 4/3 T at most); boundary "
        "vertices never do. Elements that cannot be repaired are listed with the reason, the mesh is written with "
        "them, and the exit code is 1. How it is done: docs/algorithms/repair.md");
    RepairArguments& a = all.repair;
    add_option(verb, "input", a.input, "The curved mesh (" + endings_of_input() + ")")->required();
    add_option(verb, "-o,--output", a.output, "Where the repaired mesh goes (" + endings_of_output() + ")")->required();
    add_option(verb, "--boundary-tolerance", a.boundary_tolerance,
               "How far the node of a boundary edge may move, in model units; 0 (the default): not at all")
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
                "References, materials, interfaces, ridges, listed curves, corners and whatever is required are kept; "
                "new vertices of the boundary lie on the geometry: a smooth surface through its vertices, and nodes "
                "where it is curved. Where a mesh is remeshed many times, each time from the one before, give the "
                "first one as the geometry, or the CAD model: the boundary then stays where it was. A mesh of degree 2 "
                "stays one: edges are measured along their curves, and every element that is made is valid. To curve "
                "what comes of a straight one onto the same geometry, put \"remesh\" before \"elevate\" in a config "
                "(configs/remesh.json). How it is done: docs/algorithms/cavity-operator.md");
    RemeshArguments& a = all.remesh;
    add_mesh(verb, a.input);
    add_option(verb, "-o,--output", a.output, "Where the new mesh goes (" + endings_of_output() + ")")->required();
    add_metric(verb, a.metric);
    add_geometry(verb, a.geometry);
    add_geometry_tolerance(verb, a.geometry);
    const auto rounds = option_of(&config::Remesh::rounds);
    add_option(verb, "--rounds", a.rounds,
               "At most so many " + std::string(rounds.sentence) + "; they end where nothing changes much")
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

/// Arguments for the target of the adaptation.
void add_aims(CLI::App* verb, AdaptArguments& a) {
    add_option(verb, "--solution", a.solution.given,
               "The solution on MESH: a file of rows at its vertices or nodes (" + endings_of_solutions() +
                   "), or of the same mesh with fields; one cycle, as the next mesh's is not known. Or an expression "
                   "such as 'tanh((x-y)/0.05)', which is known everywhere");
    add_option(verb, "--fields", a.solution.fields, "Names of the fields to take, with commas. Default: all")
        ->delimiter(',');
    add_option(
        verb, "--solve",
        [&a](const std::vector<std::string>& given) {
            a.adapt.solve = CLI::detail::split_up(given.front());
            return !a.adapt.solve.empty();
        },
        "A command that solves, run without a shell on the first mesh and on every one that is made: its words have "
        "{mesh}, the file to read, and {solution}, the file to write; {guess} is the solution before, brought to the "
        "new mesh, {cycle} the number, {folder} the cycle's folder")
        ->type_name("COMMAND");
    add_option(verb, "--metric", a.metric.metric,
               "A metric instead: a size, a file (" + endings_of_solutions() +
                   ", or a mesh file with its field metric), or JSON such as '{\"field\": {\"polar-1\": {}}}'");
    add_option(verb, "--field", a.adapt.exact,
               "The exact solution as an expression: its errors are told by cycle. Alone: adapted to as well")
        ->type_name("EXPRESSION");
}

/// --norm, of which H1 is an alias: the norm L2 of gradients.
void add_norm(CLI::App* verb, config::SolutionMetric& metric) {
    const auto norm = option_of(&config::SolutionMetric::norm);
    add_option(verb, "--norm", metric.norm, help_of(norm) + "; H1: as --norm 2 --error-of gradients")
        ->check(within<double>(norm.limits))
        ->transform(CLI::Validator(
            [&metric, verb](std::string& given) -> std::string {
                if (given == "H1") {
                    const CLI::Option* const other = verb->get_option("--error-of");
                    if (other->count() > 0 && other->results().back() == "values")
                        return "H1 is the norm of gradients: leave --error-of values out";
                    metric.error_of = ErrorOf::gradients;
                    given = "2";
                }
                return std::string();
            },
            ""))
        ->capture_default_str();
}

void add_metric_of_solution_options(CLI::App* verb, AdaptArguments& a) {
    using S = config::SolutionMetric;
    add_option(verb, "--complexity", a.adapt.complexity,
               "Complexity of the metric, with commas by cycle, the last for all after it: about 12 times as many "
               "tetrahedra, 2.6 times as many triangles. Default: as many elements as the mesh has")
        ->delimiter(',')
        ->check(above<double>(0));
    add_norm(verb, a.of_solution);
    add_words(verb, "--error-of", a.of_solution.error_of, help_of(option_of(&S::error_of)));
    add_described<double>(verb, a.of_solution, option_of(&S::min_size));
    add_described<double>(verb, a.of_solution, option_of(&S::max_size));
    add_described<double>(verb, a.of_solution, option_of(&S::max_anisotropy));
    add_sizes(verb, a.metric.sizes);
    add_option(verb, "--geometry-error", a.metric.geometry_error,
               "Largest distance of the boundary from its geometry, both ways; what the result misses is exit code 1. "
               "Default: by the expected error of the solution, what misses that is a note, and no facet is made that "
               "is farther than with remesh; none: any")
        ->check(above<double>(0))
        ->transform(none_as("inf"));
    add_gradation(verb, a.metric.gradation);
}

void add_cycles(CLI::App* verb, AdaptArguments& a) {
    using S = config::Adaptation;
    add_option(verb, "--cycles", a.cycles,
               "So many cycles at most; they end where the error has converged. Default: 8, of a solution's file 1")
        ->check(between<int>(1, 1000));
    add_option(verb, "--degree", a.degree, "Of the meshes that are made: 1, straight, or 2, curved")
        ->check(between<int>(1, 2))
        ->capture_default_str();
    add_described<double>(verb, a.adapt, option_of(&S::convergence_tolerance));
    add_words(verb, "--result", a.adapt.result, help_of(option_of(&S::result)));
    add_option(verb, "--timeout", a.adapt.timeout, "How long the solver may take each time. Default: any time")
        ->check(at_least<double>(0));
    add_option(verb, "--folder", a.adapt.folder,
               "Where the cycles are kept, each in a folder of its own, with series.pvd for ParaView and "
               "cycles.json. Default: with --solve OUTPUT's name with .cycles; else nothing is kept");
    add_option(verb, "--from", a.from, "Go on from this cycle of an earlier run; those after it are made anew")
        ->check(at_least<double>(0));
    add_option(
        verb, "--mesh-file", a.adapt.mesh,
        "The name of a cycle's mesh, whose ending is the format that the solver reads (" + endings_of_output() + ")")
        ->capture_default_str();
    add_option(verb, "--solution-file", a.adapt.solution,
               "The name of the file that the solver writes: rows at the mesh's vertices or nodes, in its file's "
               "order (" +
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
        "A cycle takes the mesh and its solution, makes the metric of so many elements that interpolates it best, "
        "remeshes, puts the edges' nodes where it is interpolated best, and brings the solution to the new mesh; every "
        "mesh is valid. The boundary stays on the geometry: that of --geometry or --cad, else the first mesh's. Cycles "
        "end when the error has converged (--convergence-tolerance), after --cycles of them, or by Ctrl-C; the mesh "
        "with the least error is then in OUTPUT (--result). How it works: docs/algorithms/adaptation.md");
    AdaptArguments& a = all.adapt;
    add_mesh(verb, a.input);
    add_option(verb, "-o,--output", a.output, "Where the result goes (" + endings_of_output() + ")")->required();
    add_aims(verb, a);
    add_metric_of_solution_options(verb, a);
    add_cycles(verb, a);
    add_geometry(verb, a.geometry);
    add_geometry_tolerance(verb, a.geometry);
    add_option(verb, "--output-solution", a.solution.output,
               "Where the last solution goes (" + endings_of_solutions() + ", or with the mesh)");
    add_words(verb, "--transfer", a.solution.method, help_of(option_of(&TransferOptions::method)));
    add_bound(verb, a);
    add_pipeline(verb, a);
    return {[&a](const Host&) { return adapt_command(a); }, [&a] { return pipeline_of(a); }};
}

}  // namespace camber::app
