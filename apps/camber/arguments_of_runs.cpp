// What the verbs that run a pipeline take from the command line.
#include "argument_kinds.hpp"
#include "arguments.hpp"

#include <string>
#include <CLI/CLI.hpp>

import camber.core;
import camber.commands;
import camber.config;
import camber.recipes;

namespace camber::app {

namespace {

void add_partition(CLI::App* verb, PipelineArguments& a) {
    const auto partition = camber::option_of(&camber::config::Output::partition);
    add_option(verb, "--partition", a.partition,
               "The mesh in so many parts for a solver, as convert has it: -o OUT.pvtu, which names its pieces")
        ->check(within<int>(partition.limits));
}

}  // namespace

void add_run(CLI::App& app, Verb& verb) {
    CLI::App* run = add_verb(app, "run", "Run a pipeline described in JSON");
    add_option(run, "config", verb.run.config, "The pipeline; paths of inputs are relative to its folder")->required();
    add_flag(run, "--allow-commands", verb.run.allow_commands,
             "Let the config run the command of its adapt/solve: only of configs that you trust");
    add_option(run, "--from", verb.run.from, "Of a config with cycles: go on from this one of an earlier run")
        ->check(at_least<int>(0));
    add_settings(run, verb.run.settings, verb.run.threads, verb.run.print_config, verb.run.dry_run);
    add_force(run, verb.run.force);
    add_histogram(run, verb.run.histogram);
}

void add_curve(CLI::App& app, Verb& verb) {
    CLI::App* curve = add_verb(app, "curve", "Curve a straight mesh: elevate, curve, validate, relax, commit");
    CurveArguments& a = verb.curve;
    add_option(curve, "input", a.input, "The mesh (" + endings_of_input() + ")")->required();
    add_option(curve, "-o,--output", a.output, "Where the curved mesh goes (" + endings_of_output() + ")")->required();
    add_metric(curve, a.metric);
    add_geometry(curve, a.geometry);
    add_geometry_tolerance(curve, a.geometry);
    add_words(curve, "--objective", a.objective,
              help_of(camber::option_of(&camber::config::Curve::objective)) +
                  ". Default: solution where there is --solution and no --metric, else " +
                  std::string(camber::word_of(camber::config::Curve{}.objective)));
    const auto blocks = camber::option_of(&camber::config::Curve::blocks);
    add_option(curve, "--blocks", a.blocks, help_of(blocks))->check(within<int>(blocks.limits));
    add_option(curve, "--memory", a.memory,
               help_of(camber::option_of(&camber::config::Curve::memory)) + ". 2G: 2 gibibytes")
        ->transform(CLI::AsSizeValue(false));
    add_bound(curve, a);
    add_solution_along(curve, a.solution);
    add_partition(curve, a);
    add_pipeline(curve, a);
    add_force(curve, a.force);
    add_histogram(curve, a.histogram);
}

void add_repair(CLI::App& app, Verb& verb) {
    CLI::App* repair = add_verb(
        app, "repair",
        "Repair a curved mesh made elsewhere: validate, relax, commit.\n\n"
        "  camber repair broken.meshb -o valid.meshb\n"
        "  camber repair broken.meshb -o valid.meshb --boundary-tolerance 1e-3\n\n"
        "The boundary stays as it is, bit for bit, interfaces between materials too: nodes of the volume move, and, if "
        "need be, its vertices. With --cad, or analytic surfaces, the boundary's nodes are first put onto these, and "
        "slide on "
        "them where nothing else helps. With --boundary-tolerance T the nodes of boundary edges may move too where "
        "nothing "
        "else helps, each by T at most (between them the surface then moves by 4/3 T at most); boundary vertices never "
        "do. Elements that cannot be repaired are listed with the reason, the mesh is written with them, and the exit "
        "code is 1. How it is done: docs/algorithms/repair.md");
    RepairArguments& a = verb.repair;
    add_option(repair, "input", a.input, "The curved mesh (" + endings_of_input() + ")")->required();
    add_option(repair, "-o,--output", a.output, "Where the repaired mesh goes (" + endings_of_output() + ")")
        ->required();
    add_option(repair, "--boundary-tolerance", a.boundary_tolerance,
               "How far the node of a boundary edge may move, in model units; 0 (the default): not at all")
        ->check(at_least<double>(0));
    add_geometry(repair, a.geometry);
    add_geometry_tolerance(repair, a.geometry);
    add_bound(repair, a);
    add_solution_along(repair, a.solution);
    add_pipeline(repair, a);
    add_force(repair, a.force);
    add_histogram(repair, a.histogram);
}

void add_remesh(CLI::App& app, Verb& verb) {
    CLI::App* remesh = add_verb(
        app, "remesh",
        "Bring a mesh, straight or curved, to a metric: split, collapse, swap and smooth until its edges are of unit "
        "length.\n\n"
        "  camber remesh wing.meshb --metric wing.solb -o finer.meshb\n"
        "  camber remesh wing.meshb --metric 0.1 -o even.meshb\n"
        "  camber remesh wing.meshb --metric wing.solb -o finer.meshb --output-metric finer.solb\n"
        "  camber remesh two.meshb -o three.meshb --geometry '{\"mesh\": \"one.meshb\"}'\n\n"
        "References, materials, interfaces, ridges, listed curves, corners and whatever is required are kept; new "
        "vertices of the boundary lie on the geometry: a smooth surface through its vertices, and nodes where it is "
        "curved. Where a mesh is remeshed many times, each time from the one before, give the first "
        "one as the geometry, or the CAD model: the boundary then stays where it was. A mesh of degree 2 stays one: "
        "edges are measured along their curves, and every "
        "element that is made is valid. To curve what comes of a straight one onto the same geometry, put \"remesh\" "
        "before \"elevate\" in a config (configs/remesh.json). How it is done: docs/algorithms/cavity-operator.md");
    RemeshArguments& a = verb.remesh;
    add_option(remesh, "input", a.input, "The mesh (" + endings_of_input() + ")")->required();
    add_option(remesh, "-o,--output", a.output, "Where the new mesh goes (" + endings_of_output() + ")")->required();
    add_metric(remesh, a.metric);
    add_geometry(remesh, a.geometry);
    add_geometry_tolerance(remesh, a.geometry);
    const auto rounds = camber::option_of(&camber::config::Remesh::rounds);
    add_option(remesh, "--rounds", a.rounds,
               "At most so many " + std::string(rounds.sentence) + "; they end where nothing changes much")
        ->check(within<int>(rounds.limits));
    const auto blocks = camber::option_of(&camber::config::Remesh::blocks);
    add_option(remesh, "--blocks", a.blocks, help_of(blocks))->check(within<int>(blocks.limits));
    add_words(remesh, "--objective", a.objective,
              help_of(camber::option_of(&camber::config::Remesh::objective)) +
                  ". Default: " + std::string(camber::word_of(camber::config::Remesh{}.objective)));
    add_option(remesh, "--output-metric", a.output_metric,
               "Also write the metric at the new vertices (" + endings_of_solutions() + ")");
    add_solution_along(remesh, a.solution);
    add_partition(remesh, a);
    add_pipeline(remesh, a);
    add_force(remesh, a.force);
    add_histogram(remesh, a.histogram);
}

}  // namespace camber::app
