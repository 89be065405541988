// What the verb adapt takes from the command line.
#include "argument_kinds.hpp"
#include "arguments.hpp"

#include <string>
#include <vector>
#include <CLI/CLI.hpp>

import camber.core;
import camber.commands;
import camber.config;
import camber.solution_metric;
import camber.transfer;

namespace camber::app {

namespace {

using camber::config::Adaptation;
using camber::config::SolutionMetric;

/// Arguments for the target of the adaptation.
void add_aims(CLI::App* verb, AdaptArguments& a) {
    add_option(verb, "--solution", a.solution.given,
               "The solution on MESH: a file of rows at its vertices or nodes (" + endings_of_solutions() +
                   "), or of the same mesh with fields; one cycle, as the next mesh's is not known. Or an "
                   "expression such as 'tanh((x-y)/0.05)', which is known everywhere");
    add_option(verb, "--fields", a.solution.fields, "Names of the fields to take, with commas. Default: all")
        ->delimiter(',');
    add_option(
        verb, "--solve",
        [&a](const std::vector<std::string>& given) {
            a.adapt.solve = CLI::detail::split_up(given.front());
            return !a.adapt.solve.empty();
        },
        "A command that solves, run without a shell on the first mesh and on every one that is made: its words "
        "have {mesh}, the file to read, and {solution}, the file to write; {guess} is the solution before, brought "
        "to the new mesh, {cycle} the number, {folder} the cycle's folder")
        ->type_name("COMMAND");
    add_option(verb, "--metric", a.metric.metric,
               "A metric instead: a size, a file (" + endings_of_solutions() +
                   ", or a mesh file with its field metric), or JSON such as '{\"field\": {\"polar-1\": {}}}'");
    add_option(verb, "--field", a.adapt.exact,
               "The exact solution as an expression: its errors are told by cycle. Alone: adapted to as well")
        ->type_name("EXPRESSION");
}

/// --norm, of which H1 is an alias: the norm L2 of gradients.
void add_norm(CLI::App* verb, SolutionMetric& metric) {
    const auto norm = camber::option_of(&SolutionMetric::norm);
    add_option(verb, "--norm", metric.norm, help_of(norm) + "; H1: as --norm 2 --error-of gradients")
        ->check(within<double>(norm.limits))
        ->transform(CLI::Validator(
            [&metric, verb](std::string& given) -> std::string {
                if (given == "H1") {
                    const CLI::Option* const other = verb->get_option("--error-of");
                    if (other->count() > 0 && other->results().back() == "values")
                        return "H1 is the norm of gradients: leave --error-of values out";
                    metric.error_of = camber::ErrorOf::gradients;
                    given = "2";
                }
                return std::string();
            },
            ""))
        ->capture_default_str();
}

void add_metric_of_solution_options(CLI::App* verb, AdaptArguments& a) {
    using S = SolutionMetric;
    add_option(verb, "--complexity", a.adapt.complexity,
               "Complexity of the metric, with commas by cycle, the last for all after it: about 12 times as many "
               "tetrahedra, 2.6 times as many triangles. Default: as many elements as the mesh has")
        ->delimiter(',')
        ->check(above<double>(0));
    add_norm(verb, a.of_solution);
    add_words(verb, "--error-of", a.of_solution.error_of, help_of(camber::option_of(&S::error_of)));
    add_described<double>(verb, a.of_solution, camber::option_of(&S::min_size));
    add_described<double>(verb, a.of_solution, camber::option_of(&S::max_size));
    add_described<double>(verb, a.of_solution, camber::option_of(&S::max_anisotropy));
    add_sizes(verb, a.metric.sizes);
    add_option(verb, "--geometry-error", a.metric.geometry_error,
               "Largest distance of the boundary from its geometry, both ways; what the result misses is exit "
               "code 1. Default: by the expected error of the solution, what misses that is a note, and no facet is "
               "made that is "
               "farther than with remesh; none: any")
        ->check(above<double>(0))
        ->transform(none_as("inf"));
    add_option(verb, "--gradation", a.metric.gradation,
               "Largest ratio of the metric's sizes at adjacent edges; 0: not limited. Default: 2.5 for the metric of "
               "a solution, others as they are")
        ->check(zero_or(camber::option_of(&camber::config::Gradation::ratio).limits));
}

void add_cycles(CLI::App* verb, AdaptArguments& a) {
    using S = Adaptation;
    add_option(verb, "--cycles", a.cycles,
               "So many cycles at most; they end where the error has converged. Default: 8, of a solution's file 1")
        ->check(between<int>(1, 1000));
    add_option(verb, "--degree", a.degree, "Of the meshes that are made: 1, straight, or 2, curved")
        ->check(between<int>(1, 2))
        ->capture_default_str();
    add_described<double>(verb, a.adapt, camber::option_of(&S::convergence_tolerance));
    add_words(verb, "--result", a.adapt.result, help_of(camber::option_of(&S::result)));
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

void add_adapt(CLI::App& app, Verb& verb) {
    CLI::App* adapt = add_verb(
        app, "adapt",
        "Adapt a mesh to a solution, cycle after cycle: metric, remesh, curve, transfer; and the solver in between.\n\n"
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
        "with the least "
        "error is then in OUTPUT (--result). How it works: docs/algorithms/adaptation.md");
    AdaptArguments& a = verb.adapt;
    add_option(adapt, "input", a.input, "The mesh (" + endings_of_input() + ")")->required();
    add_option(adapt, "-o,--output", a.output, "Where the result goes (" + endings_of_output() + ")")->required();
    add_aims(adapt, a);
    add_metric_of_solution_options(adapt, a);
    add_cycles(adapt, a);
    add_geometry(adapt, a.geometry);
    add_geometry_tolerance(adapt, a.geometry);
    add_option(adapt, "--output-solution", a.solution.output,
               "Where the last solution goes (" + endings_of_solutions() + ", or with the mesh)");
    add_words(adapt, "--transfer", a.solution.method, help_of(camber::option_of(&camber::TransferOptions::method)));
    add_bound(adapt, a);
    add_pipeline(adapt, a);
}

}  // namespace camber::app
