// What the verbs of solutions take from the command line.
#include <string>
#include <vector>
#include <CLI/CLI.hpp>

#include "argument_kinds.hpp"
#include "arguments.hpp"

import camber.core;
import camber.commands;
import camber.io;
import camber.metric;
import camber.recipes;
import camber.solution_metric;
import camber.transfer;

namespace camber::app {

namespace {

void add_solution(CLI::App* verb, std::string& solution, std::vector<std::string>& fields) {
    verb->add_option("--solution", solution,
                     "The solution: a file of rows at the vertices or nodes (" + endings_of_solutions() +
                         "), or a mesh file with fields at its nodes (.vtu, .msh, .cgns)")
        ->required();
    verb->add_option("--fields", fields,
                     "Names of the fields to take, with commas; of a solution file field_1 and so on. Default: all")
        ->delimiter(',');
}

}  // namespace

void add_metric_of_solution(CLI::App& app, Verb& verb) {
    CLI::App* metric = app.add_subcommand(
        "metric",
        "The metric that a solution asks for: of all meshes with so many elements the one that interpolates it "
        "best.\n\n"
        "  camber metric wing.meshb --solution u.solb -o m.solb --elements 100000\n"
        "  camber metric wing-p2.meshb --solution u.solb -o m.solb --norm 2 --gradation 1.5\n"
        "  camber metric flow.vtu --solution flow.vtu --fields mach -o m.sol --vertices 20000 --geometry-error 1e-3\n"
        "  camber metric wing.meshb --solution u.solb -o m.solb --size 3=0.01 --min-size 1e-5\n\n"
        "Derivatives are recovered at the vertices, from all nodes of a mesh of degree 2, one-sided where materials "
        "meet: Hessians for elements of degree 1, third derivatives for those of degree 2. Several fields, and the "
        "components of a vector, have equal shares and are intersected; sizes by reference and the geometry's own "
        "are fixed, the solution's part is scaled until all of it has the complexity, gradation included. Then "
        "camber remesh brings the mesh to it, and camber transfer the solution to that mesh. More: "
        "docs/algorithms/metric-from-solution.md");
    MetricArguments& a = verb.metric;
    auto& of = a.options;
    metric->add_option("input", a.input, "The mesh (" + endings_of_input() + ")")->required();
    add_solution(metric, a.solution, a.fields);
    metric
        ->add_option("-o,--output", a.output,
                     "Where the metric goes (" + endings_of_solutions() + ", or .vtu with the mesh)")
        ->required();
    metric->add_option("--degree", a.degree, "Degree of the elements that are to interpolate. Default: the solution's")
        ->check(CLI::Range(1, 2));
    metric->add_option("--norm", of.norm.p, "p of the L^p norm of the error; 0: the largest error anywhere")
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str();
    add_words(metric, "--error-of", of.norm.error_of,
              "What the norm is of: the error's values (the default), or its gradients");
    const auto amount = [&](const char* name, camber::AmountOf what, const char* sentence) {
        metric
            ->add_option_function<double>(
                name,
                [&of, what](const double& n) {
                    of.metric.amount = n;
                    of.metric.of = what;
                },
                sentence)
            ->check(CLI::PositiveNumber);
    };
    amount("--complexity", camber::AmountOf::complexity, "Its complexity, the integral of sqrt(det M)");
    amount("--vertices", camber::AmountOf::vertices, "The same for about so many vertices");
    amount("--elements", camber::AmountOf::elements,
           "The same for about so many elements. Default: as many as the mesh has");
    metric
        ->add_option_function<double>(
            "--gradation",
            [&of](const double& ratio) { of.metric.gradation = camber::GradationOptions{.ratio = ratio}; },
            "Largest ratio of the sizes of adjacent edges. Default: not limited")
        ->check(CLI::Range(1.0001, 1000.0));
    metric->add_option("--min-size", of.metric.min_size, "Smallest size; 0: none")->check(CLI::NonNegativeNumber);
    metric->add_option("--max-size", of.metric.max_size, "Largest size; 0: the domain's diameter")
        ->check(CLI::NonNegativeNumber);
    metric
        ->add_option("--max-anisotropy", of.metric.max_anisotropy,
                     "Largest ratio of sizes; 0: none, but for the 1e5 that derivatives alone may ask for; a larger "
                     "one raises that")
        ->check(CLI::NonNegativeNumber);
    metric
        ->add_option("--geometry-error", of.chord_error,
                     "Largest distance of chords from the boundary's own surface; 0: not asked")
        ->check(CLI::NonNegativeNumber);
    metric
        ->add_option(
            "--size", a.sizes,
            "A size at boundary facets by their reference, as 3=0.01, or DIMENSION:REFERENCE=SIZE; again for more")
        ->allow_extra_args(false);
    add_flat(metric, a.flat);
    metric->add_option("--threads", a.threads, "Threads to use; 0: all. The result does not depend on it")
        ->check(CLI::NonNegativeNumber);
}

void add_transfer(CLI::App& app, Verb& verb) {
    CLI::App* transfer = app.add_subcommand(
        "transfer",
        "A solution on another mesh of the domain: on one that was remeshed, or any.\n\n"
        "  camber transfer old.meshb new.meshb --solution u.solb -o v.solb\n"
        "  camber transfer old.meshb new.meshb --solution u.solb -o v.solb --method conserve\n\n"
        "Nodes that stayed where they were keep their values to the bit; others take the old field's value where they "
        "are in the old mesh, curved as it is, or at the nearest point of its boundary. conserve: where elements "
        "changed the field of least difference in L2 that keeps the integrals by material. More: "
        "docs/algorithms/transfer.md");
    TransferArguments& a = verb.transfer;
    transfer->add_option("old", a.old_mesh, "The mesh of the solution (" + endings_of_input() + ")")->required();
    transfer->add_option("new", a.new_mesh, "The mesh that it is brought to")->required();
    add_solution(transfer, a.solution, a.fields);
    transfer
        ->add_option("-o,--output", a.output,
                     "Where it goes (" + endings_of_solutions() + ", or .vtu with the new mesh)")
        ->required();
    add_words(transfer, "--method", a.options.method, "interpolate (the default), or conserve");
    add_words(transfer, "--bounds", a.options.bounds,
              "conserve only: none (the default), or local: no value beyond the old ones around");
    add_flat(transfer, a.flat);
    transfer->add_option("--threads", a.threads, "Threads to use; 0: all. The result does not depend on it")
        ->check(CLI::NonNegativeNumber);
}

}  // namespace camber::app
