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
    add_option(verb, "--solution", solution,
               "The solution: a file of rows at the vertices or nodes (" + endings_of_solutions() +
                   "), or a mesh file with fields at its nodes (.vtu, .msh, .cgns)")
        ->required();
    add_option(verb, "--fields", fields,
               "Names of the fields to take, with commas; of a solution file field_1 and so on. Default: all")
        ->delimiter(',');
}

/// Arguments that are also keys of the metric {"solution": …} in a config.
void add_options_of_metric(CLI::App* verb, camber::config::SolutionMetric& m) {
    using S = camber::config::SolutionMetric;
    add_described<int>(verb, m, camber::option_of(&S::degree));
    add_described<double>(verb, m, camber::option_of(&S::norm));
    add_words(verb, "--error-of", m.error_of, help_of(camber::option_of(&S::error_of)));
    add_described<double>(verb, m, camber::option_of(&S::complexity));
    add_described<double>(verb, m, camber::option_of(&S::vertices));
    add_described<double>(verb, m, camber::option_of(&S::elements));
    verb->get_option("--complexity")->excludes("--vertices")->excludes("--elements");
    verb->get_option("--vertices")->excludes("--elements");
    add_described<double>(verb, m, camber::option_of(&S::min_size));
    add_described<double>(verb, m, camber::option_of(&S::max_size));
    add_described<double>(verb, m, camber::option_of(&S::max_anisotropy));
    add_option(verb, "--geometry-angle", m.geometry.angle,
               help_of(camber::option_of(&camber::config::GeometryMetric::angle)) + " (degrees)")
        ->check(within<double>(camber::option_of(&camber::config::GeometryMetric::angle).limits));
    add_described<double>(verb, m.geometry, camber::option_of(&camber::config::GeometryMetric::gap_elements));
}

}  // namespace

void add_sizes(CLI::App* verb, std::vector<std::string>& sizes) {
    add_option(verb, "--size", sizes,
               "A size at boundary facets by their reference, as 3=0.01, or KIND:REFERENCE,REFERENCE=SIZE with "
               "facets, edges, vertices or elements; again for more")
        ->allow_extra_args(false);
}

void add_solution_along(CLI::App* verb, SolutionChoice& a) {
    add_option(verb, "--solution", a.given,
               "Fields on the input that go along: rows at its vertices or nodes (" + endings_of_solutions() +
                   "), a file of the same mesh with fields, or an expression such as 'tanh((x-y)/0.05)' of its "
                   "nodes. curve places inner nodes where these are interpolated best, but for a --metric or an "
                   "--objective. Default: the fields of the input's own file");
    add_option(verb, "--fields", a.fields, "Names of the fields to take, with commas. Default: all")->delimiter(',');
    add_option(verb, "--output-solution", a.output,
               "Where they go (" + endings_of_solutions() +
                   ", or with the mesh). Default: with the mesh, where its format has fields");
    add_words(verb, "--transfer", a.method, help_of(camber::option_of(&camber::TransferOptions::method)));
}

void add_metric_of_solution(CLI::App& app, Verb& verb) {
    CLI::App* metric = add_verb(
        app, "metric",
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
    add_option(metric, "input", a.input, "The mesh (" + endings_of_input() + ")")->required();
    add_solution(metric, a.solution, a.metric.fields);
    add_option(metric, "-o,--output", a.output,
               "Where the metric goes (" + endings_of_solutions() + ", or .vtu with the mesh)")
        ->required();
    add_format(metric, a.format, field_format_names());
    add_options_of_metric(metric, a.metric);
    add_option(metric, "--gradation", a.metric.gradation,
               "Largest ratio of the sizes of adjacent edges; 0: not limited. Default: 2.5")
        ->check(zero_or(camber::option_of(&camber::config::Gradation::ratio).limits));
    add_option(metric, "--geometry-error", a.metric.geometry.chord_error,
               "Largest distance of chords from the boundary's own surface; 0 or none: any")
        ->check(at_least<double>(0))
        ->transform(none_as("0"));
    add_sizes(metric, a.sizes);
    metric
        ->add_option_function<std::vector<std::string>>(
            "--intersect",
            [&a](const std::vector<std::string>& files) {
                for (const std::string& file : files) a.metric.intersect.push_back({file});
            },
            "A metric of the same mesh that is fixed too (" + endings_of_solutions() + "); again for more")
        ->allow_extra_args(false);
    add_flat(metric, a.flat);
    add_threads(metric, a.threads);
}

void add_transfer(CLI::App& app, Verb& verb) {
    CLI::App* transfer = add_verb(
        app, "transfer",
        "A solution on another mesh of the domain: on one that was remeshed, or any.\n\n"
        "  camber transfer old.meshb new.meshb --solution u.solb -o v.solb\n"
        "  camber transfer old.meshb new.meshb --solution u.solb -o v.solb --method conserve\n\n"
        "Nodes that stayed where they were keep their values to the bit; others take the old field's value where they "
        "are in the old mesh, curved as it is, or at the nearest point of its boundary. conserve: where elements "
        "changed the field of least difference in L2 that keeps the integrals by material. More: "
        "docs/algorithms/transfer.md");
    TransferArguments& a = verb.transfer;
    add_option(transfer, "old", a.old_mesh, "The mesh of the solution (" + endings_of_input() + ")")->required();
    add_option(transfer, "new", a.new_mesh, "The mesh that it is brought to")->required();
    add_solution(transfer, a.solution, a.fields);
    add_option(transfer, "-o,--output", a.output,
               "Where it goes (" + endings_of_solutions() + ", or .vtu with the new mesh)")
        ->required();
    add_format(transfer, a.format, field_format_names());
    add_words(transfer, "--method", a.options.method, "interpolate (the default), or conserve");
    add_words(transfer, "--bounds", a.options.bounds,
              "conserve only: none (the default), or local: no value beyond the old ones around");
    add_flat(transfer, a.flat);
    add_threads(transfer, a.threads);
}

}  // namespace camber::app
