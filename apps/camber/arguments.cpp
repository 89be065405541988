// What the verbs take from the command line.
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
import camber.recipes;
import camber.run;
import camber.shapes;

namespace camber::app {

namespace {

void add_histogram(CLI::App* verb, bool& histogram) {
    verb->add_flag("--histogram", histogram,
                   "Also print how gains, lengths, curvatures and Jacobians are spread, before and after correction");
}

void add_settings(CLI::App* verb, std::vector<std::string>& settings, std::optional<int>& threads, bool& print_config,
                  bool& dry_run) {
    verb->add_option("--set", settings,
                     "Override one option of the config: path=value, e.g. stages/curve/objective=length")
        ->type_name("PATH=VALUE");
    verb->add_option("--threads", threads, "Threads to use; 0: all. The result does not depend on it")
        ->check(at_least<double>(0));
    verb->add_flag("--print-config", print_config, "Print the pipeline with every default, and stop");
    verb->add_flag("--dry-run", dry_run,
                   "Read the input and tell what would be done, with memory and time expected; write nothing");
}

void add_metric(CLI::App* verb, MetricChoice& a) {
    verb->add_option("--metric", a.metric,
                     "natural, a size such as 0.1, solution (what interpolates --solution best), a file (" +
                         endings_of_solutions() +
                         ", or a mesh file with its field metric), or JSON such as '{\"field\": {\"polar-1\": {}}}'")
        ->default_str("natural");
    add_sizes(verb, a.sizes);
    verb->add_option(
            "--geometry-error", a.geometry_error,
            "Largest distance of chords from the boundary's own surface; intersected with the metric. Default: "
            "any")
        ->check(above<double>(0));
    verb->add_option("--gradation", a.gradation,
                     "Largest ratio of the metric's sizes at adjacent edges. Default: as the metric is")
        ->check(within<double>(camber::option_of(&camber::config::Gradation::ratio).limits));
    verb->add_option("--complexity", a.complexity,
                     "Scale the metric, once it is graded, to this complexity: about 12 times as many tetrahedra, 2.6 "
                     "times as many triangles. Default: as the metric is")
        ->check(above<double>(0));
}

}  // namespace

void add_geometry(CLI::App* verb, GeometryArguments& a) {
    verb->add_option("--geometry", a.geometry,
                     "surrogate (from the mesh), straight, or JSON such as "
                     "'{\"analytic\": [{\"references\": [1], \"sphere\": {\"radius\": 5}}]}' or "
                     "'{\"mesh\": \"first.meshb\"}': the boundary of another mesh of the body")
        ->default_str("surrogate");
    verb->add_option("--cad", a.cad,
                     "The CAD model that the boundary is put onto (" + std::string(camber::cad_endings) +
                         "); --geometry may have analytic surfaces beside it, by reference");
    add_words(verb, "--cad-unit", a.cad_unit,
              "The unit of the mesh's coordinates, to which the CAD model is converted. Default: file, coordinates are "
              "as the model's file has them");
    verb->add_option("--cad-seconds", a.cad_seconds,
                     "How long reading the CAD model may take (s). Default: 10, and 1 for each megabyte of its file")
        ->check(at_least<double>(0));
    verb->add_option("--cad-memory", a.cad_memory,
                     "How much memory reading the CAD model may take (MB). Default: 1000, and 50 times its file")
        ->check(at_least<double>(0));
}

void add_bound(CLI::App* verb, PipelineArguments& a) {
    verb->add_option(
            "--min-scaled-jacobian", a.min_scaled_jacobian,
            "Every element's scaled Jacobian must be at least this, from 0 and below 1; what is not: exit code "
            "1. Without it: 0.1 where it can be had")
        ->check(within<double>(camber::option_of(&camber::config::Validate::min_scaled_jacobian).limits));
}

void add_pipeline(CLI::App* verb, PipelineArguments& a) {
    add_format(verb, a.format, mesh_format_names());
    add_flat(verb, a.flat);
    verb->add_option("--report", a.report, "Also write the figures as JSON");
    verb->add_option("--vtu", a.vtu, "Also write the mesh with the run's fields for ParaView (.vtu)");
    verb->add_option("--plots", a.plots, "Also write histograms as SVG files into this folder");
    verb->add_option("--page", a.page, "Also write the mesh and the figures as a page for a browser (.html)");
    add_settings(verb, a.settings, a.threads, a.print_config, a.dry_run);
}

namespace {

void add_run(CLI::App& app, Verb& verb) {
    CLI::App* run = app.add_subcommand("run", "Run a pipeline described in JSON");
    run->add_option("config", verb.run.config, "The pipeline; paths of inputs are relative to its folder")->required();
    run->add_flag("--allow-commands", verb.run.allow_commands,
                  "Let the config run the command of its adapt/solve: only of configs that you trust");
    run->add_option("--from", verb.run.from, "Of a config with cycles: go on from this one of an earlier run")
        ->check(at_least<int>(0));
    add_settings(run, verb.run.settings, verb.run.threads, verb.run.print_config, verb.run.dry_run);
    add_histogram(run, verb.run.histogram);
}

void add_curve(CLI::App& app, Verb& verb) {
    CLI::App* curve = app.add_subcommand("curve", "Curve a straight mesh: elevate, curve, validate, relax, commit");
    CurveArguments& a = verb.curve;
    curve->add_option("input", a.input, "The mesh (" + endings_of_input() + ")")->required();
    curve->add_option("-o,--output", a.output, "Where the curved mesh goes (" + endings_of_output() + ")")->required();
    add_metric(curve, a.metric);
    add_geometry(curve, a.geometry);
    add_words(curve, "--objective", a.objective,
              help_of(camber::option_of(&camber::config::Curve::objective)) +
                  ". Default: solution where there is --solution and no --metric, else " +
                  std::string(camber::word_of(camber::config::Curve{}.objective)));
    add_bound(curve, a);
    add_solution_along(curve, a.solution);
    add_pipeline(curve, a);
    add_histogram(curve, a.histogram);
}

void add_repair(CLI::App& app, Verb& verb) {
    CLI::App* repair = app.add_subcommand(
        "repair",
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
    repair->add_option("input", a.input, "The curved mesh (" + endings_of_input() + ")")->required();
    repair->add_option("-o,--output", a.output, "Where the repaired mesh goes (" + endings_of_output() + ")")
        ->required();
    repair
        ->add_option("--boundary-tolerance", a.boundary_tolerance,
                     "How far the node of a boundary edge may move, in model units; 0 (the default): not at all")
        ->check(at_least<double>(0));
    add_geometry(repair, a.geometry);
    add_bound(repair, a);
    add_solution_along(repair, a.solution);
    add_pipeline(repair, a);
    add_histogram(repair, a.histogram);
}

void add_remesh(CLI::App& app, Verb& verb) {
    CLI::App* remesh = app.add_subcommand(
        "remesh",
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
    remesh->add_option("input", a.input, "The mesh (" + endings_of_input() + ")")->required();
    remesh->add_option("-o,--output", a.output, "Where the new mesh goes (" + endings_of_output() + ")")->required();
    add_metric(remesh, a.metric);
    add_geometry(remesh, a.geometry);
    const auto rounds = camber::option_of(&camber::config::Remesh::rounds);
    remesh
        ->add_option("--rounds", a.rounds,
                     "At most so many " + std::string(rounds.sentence) + "; they end where nothing changes much")
        ->check(within<int>(rounds.limits));
    add_words(remesh, "--objective", a.objective,
              help_of(camber::option_of(&camber::config::Remesh::objective)) +
                  ". Default: " + std::string(camber::word_of(camber::config::Remesh{}.objective)));
    remesh->add_option("--output-metric", a.output_metric,
                       "Also write the metric at the new vertices (" + endings_of_solutions() + ")");
    add_solution_along(remesh, a.solution);
    add_pipeline(remesh, a);
    add_histogram(remesh, a.histogram);
}

void add_check(CLI::App& app, Verb& verb) {
    CLI::App* check = app.add_subcommand(
        "check",
        "Is it a good mesh? Of any mesh of degree 1 or 2, made by whatever program; nothing is changed.\n\n"
        "  camber check wing-p2.meshb                       the report\n"
        "  camber check wing-p2.meshb --worst 50            with more of the worst elements\n"
        "  camber check wing-p2.meshb --json > check.json   all of it for scripts\n"
        "  camber check wing-p2.meshb --elements            each element's verdict, as CSV\n"
        "  camber check wing-p2.meshb --field 'tanh((sqrt(x^2+y^2+z^2) - 0.5)/0.01)'\n"
        "                                                   does curvature pay for a front on this sphere?\n"
        "  camber check wing.meshb --metric wing.solb       is it unit for this metric?\n"
        "  camber check wing-p2.meshb --metric wing.solb    the same straight and along its curves\n\n"
        "An element of degree 2 is valid where det J is positive everywhere; its scaled Jacobian is the smallest "
        "det J as a share of that of the straight element with the same vertices (other programs mean Knupp's measure "
        "by the name). Of a straight mesh the quality is told: the mean ratio. Beyond its elements the mesh is "
        "examined: conformity, orientation, nodes, boundary, and whether walls pass through each other, curved as they "
        "are. "
        "Of a field (x, y, z, pi, + - * / ^, c ? a : b, sqrt, exp, "
        "tanh ...) the errors of its interpolants are told, in L2 and H1: of degree 1 and 2 with straight edges, and "
        "of "
        "the mesh as it is; a ratio straight / as it is above 1 says that curvature pays at equal unknowns "
        "(docs/algorithms/interpolation-error.md). In a metric an element of degree 2 has the quality 1 / mean "
        "distortion: 1 is unit, 0 folded (docs/algorithms/distortion.md). What each line means: "
        "docs/algorithms/check.md");
    CheckArguments& a = verb.check;
    using Options = camber::run::CheckOptions;
    check->add_option("input", a.input, "The mesh (" + endings_of_input() + ")")->required();
    add_described<double>(check, a.options, camber::option_of(&Options::min_scaled_jacobian));
    add_described<double>(check, a.options, camber::option_of(&Options::ridge_angle));
    add_flat(check, a.flat);
    add_described<int>(check, a.options, camber::option_of(&Options::worst));
    check
        ->add_option("--field", a.options.fields,
                     "An expression of x, y (and z) whose interpolants' errors are told; again for more fields")
        ->allow_extra_args(false)
        ->type_name("EXPRESSION");
    check->add_option(
        "--metric", a.metric,
        "A metric file: lengths of edges and qualities of elements in it are told, and how many edges are "
        "of unit length; of degree 2 straight and along the curves, with a bound of the quality at every point");
    check->add_option(
        "--vtu", a.vtu,
        "Also write the mesh with each element's verdict, scaled Jacobian and quality for ParaView (.vtu)");
    check->add_option("--threads", a.threads, "Threads to use; 0: all")->check(at_least<double>(0));
    check->add_flag("--histogram,!--no-histogram", a.histogram,
                    "How the scaled Jacobians (of a straight mesh: the quality) are spread; shown by default");
    check->add_option("--page", a.page,
                      "Also write mesh and report as a page for a browser (.html), as camber report does");
    check->add_flag("--json", a.json, "One JSON object instead of the report");
    check->add_flag("--elements", a.elements,
                    "A line of CSV for each element instead of the report; with --json as columns in the object");
}

void add_report(CLI::App& app, Verb& verb) {
    CLI::App* report = app.add_subcommand(
        "report",
        "A mesh and what check says of it as one page for a browser: its curved faces, to be turned, cut and coloured, "
        "the worst elements, histograms, numbers. The page is one file that needs no network.\n\n"
        "  camber report wing-p2.meshb -o wing.html\n"
        "  camber report wing.meshb --metric wing.solb -o wing.html    also coloured by its anisotropy\n"
        "  camber report flow.vtu -o flow.html                         and by the file's own fields\n"
        "  camber curve wing.meshb -o wing-p2.meshb --report report.json\n"
        "  camber report report.json -o wing.html                      before and after correction\n\n"
        "The page: docs/page.md");
    ReportArguments& a = verb.report;
    using Options = camber::run::CheckOptions;
    report
        ->add_option("input", a.input,
                     "The mesh (" + endings_of_input() +
                         "), or the report.json of a run, whose "
                         "mesh is where it was written or beside it")
        ->required();
    report->add_option("-o,--output", a.output, "The page (.html)")->required();
    add_described<double>(report, a.options, camber::option_of(&Options::min_scaled_jacobian));
    add_flat(report, a.flat);
    add_described<int>(report, a.options, camber::option_of(&Options::worst));
    report->add_option("--metric", a.metric,
                       "A metric file: faces can be coloured by its anisotropy, and check tells "
                       "lengths and qualities in it");
    report->add_option("--solution", a.solution,
                       "Fields to colour by: a solution file, or a mesh file with the same "
                       "nodes. Default: those of the mesh's own file");
    add_described<int>(report, a.page, camber::option_of(&camber::run::PageOptions::inner_faces));
    report->add_option("--threads", a.threads, "Threads to use; 0: all. The page does not depend on it")
        ->check(at_least<double>(0));
}

void add_inspection(CLI::App& app, Verb& verb) {
    CLI::App* geometry = app.add_subcommand(
        "geometry",
        "What the boundary of a mesh is, and how far it is from a geometry. Of any mesh of degree 1 or 2; nothing is "
        "changed.\n\n"
        "  camber geometry wing.meshb                              patches, ridges, corners, suspicious places\n"
        "  camber geometry wing.meshb --ridge-angle 30             what would be ridges from 30 degrees on?\n"
        "  camber geometry wing-p2.meshb --cad wing.step           distances from the CAD model and back, face by "
        "face\n"
        "  camber geometry wing-p2.meshb --cad wing.step -o d.vtu  the same as fields of the facets, for ParaView\n"
        "  camber geometry wing.meshb --surface smooth.vtu         the smooth surface that curving would take\n"
        "  camber geometry wing.meshb --json > geometry.json       all of it for scripts\n\n"
        "Ridges are edges where facets turn by more than the ridge angle, where references change, and those that the "
        "file lists; patches are what is smooth between them; a facet in the same plane as its neighbour turns by 0 "
        "degrees. Suspicious is what a change of the angle would change, and what no smooth surface looks like: knife "
        "edges, tips of cones, vertices whose normals spread. Look there before you curve: list edges as Ridges in the "
        "file, give facets of different surfaces different references, or choose another angle.\n\n"
        "Distances go both ways. From the boundary to the geometry they say how well the mesh follows what it knows; "
        "from the geometry to the boundary, what it has left out: of a CAD model points are taken on all its faces and "
        "edges, of other geometries only where the mesh has facets. Without a geometry it is the smooth surface "
        "through the mesh's own vertices, which says how much its facets, or its curves, differ from that, and nothing "
        "of "
        "the part that was meant. More: docs/algorithms/distances.md");
    GeometryCommandArguments& a = verb.geometry;
    using Options = camber::run::InspectOptions;
    geometry->add_option("input", a.input, "The mesh (" + endings_of_input() + ")")->required();
    geometry->add_option("-o,--output", a.output,
                         "Also write the mesh with its patches and the distances of its facets for ParaView (.vtu)");
    geometry->add_option("--surface", a.surface,
                         "Also write the geometry over the mesh's facets for ParaView (.vtu): each facet in 36 small "
                         "ones, with normals");
    add_geometry(geometry, a.geometry);
    add_described<double>(geometry, a.options, camber::option_of(&Options::ridge_angle));
    add_described<int>(geometry, a.options, camber::option_of(&Options::worst));
    add_flat(geometry, a.flat);
    geometry->add_option("--threads", a.threads, "Threads to use; 0: all")->check(at_least<double>(0));
    geometry->add_flag("--json", a.json, "One JSON object instead of the report");
}

void add_convert(CLI::App& app, Verb& verb) {
    CLI::App* convert = app.add_subcommand(
        "convert",
        "A mesh or a solution in another format.\n\n"
        "  camber convert wing.meshb -o wing.mesh                      binary to ASCII, and back\n"
        "  camber convert wing-p2.meshb -o wing.vtu --cells lagrange   for ParaView, Lagrange cells\n"
        "  camber convert wing.meshb -o wing.vtu --metric wing.solb    with a solution's fields\n"
        "  camber convert part.msh -o part.mfem                        from Gmsh to MFEM\n"
        "  camber convert wing.solb -o wing.sol                        solutions alone\n"
        "  camber convert flow.vtu -o flow.sol                         the fields at a mesh's nodes\n\n"
        "What the format cannot hold is told on standard error. More: docs/formats.md");
    ConvertArguments& a = verb.convert;
    convert->add_option("input", a.input, mesh_or_solution())->required();
    convert
        ->add_option("-o,--output", a.output,
                     "Mesh: " + camber::listed(camber::endings_written(camber::mesh_formats())) +
                         "; solution: " + camber::listed(camber::endings_written(camber::solution_formats())))
        ->required();
    add_format(convert, a.format, mesh_format_names());
    add_words(convert, "--cells", a.cells, "Cells of degree 2 in a .vtu: quadratic (the default) or lagrange");
    convert->add_option("--metric", a.metric,
                        "A solution on the mesh's vertices, whose fields go along (.vtu, .vtk, .msh, .cgns, .xdmf)");
    auto* const elevate =
        convert->add_flag("--elevate", a.elevate, "Degree 1 to 2 first: each edge gets a node at its middle");
    convert->add_flag("--straighten", a.straighten, "Degree 2 to 1 first: the nodes of edges are left out")
        ->excludes(elevate);
    add_read(convert, a.read);
    convert->add_option("--threads", a.threads, "Threads to use; 0: all")->check(at_least<double>(0));
}

void add_generate(CLI::App& app, Verb& verb) {
    CLI::App* generate = app.add_subcommand(
        "generate",
        "A straight mesh of a shape, without a file: to try things on, and at any size.\n\n"
        "  camber generate shell -o shell.meshb --set inner_size=0.3 --set inner_layer/count=5   between two spheres\n"
        "  camber generate shell --structure prisms --elements 2e7 -o big.meshb                  fast at any size\n"
        "  camber generate annulus -o ring.mesh --elements 1000                                  between two circles\n"
        "  camber generate box -o box.msh --set 'cells=[20, 10, 10]' --set 'high=[2, 1, 1]'      a lattice, cut\n"
        "  camber generate rectangle -o square.vtu --set 'grading=[1, 50]' --set warp=0.04       the same in 2D, "
        "mapped\n"
        "  camber generate bump -o channel.mesh --set floor_layer/count=8                        a channel's floor\n"
        "  camber generate '{\"box\": {\"cells\": [9, 9, 9]}}' -o box.meshb                      as configs say it\n"
        "  camber generate configs/spheres.json -o spheres.meshb                                 what a config begins "
        "with\n\n"
        "The options of a shape: camber explain shell (annulus, box, rectangle, bump, layer); those of layers are "
        "inner_layer/count and so on. The same options give the same bytes, whatever the threads. More: "
        "docs/algorithms/delaunay-and-shapes.md");
    GenerateArguments& a = verb.generate;
    generate->add_option("shape", a.shape, "A shape's name, its JSON, or a file with that or with a config")
        ->required();
    generate
        ->add_option(
            "-o,--output", a.output,
            "Where the mesh goes (" + camber::listed(camber::endings_written(camber::mesh_formats()), ", ") + ")")
        ->required();
    generate->add_option("--set", a.settings, "One option of the shape: path=value")->type_name("PATH=VALUE");
    generate
        ->add_option("--elements", a.elements,
                     "About so many tetrahedra or triangles (within 20 per cent, but for very few): sizes or cells are "
                     "scaled, layers stay as they are")
        ->check(between<double>(1, static_cast<double>(camber::max_entities)));
    add_words(generate, "--structure", a.structure,
              "Of a shell or annulus: " + std::string(camber::option_of(&camber::ShellOptions<3>::structure).sentence));
    add_format(generate, a.format, mesh_format_names());
    generate->add_option("--threads", a.threads, "Threads to use; 0: all. The result does not depend on it")
        ->check(at_least<double>(0));
    generate->add_flag("--print-config", a.print_config, "Print the pipeline that makes this mesh, and stop");
}

void add_plot(CLI::App& app, Verb& verb) {
    CLI::App* plot =
        app.add_subcommand("plot",
                           "Histograms of a run as SVG pictures, before and after correction.\n\n"
                           "  camber curve wing.meshb -o wing-p2.meshb --report report.json\n"
                           "  camber plot report.json -o plots                a file for each quantity in this folder\n"
                           "  camber plot report.json -o histograms.svg       all in one");
    plot->add_option("report", verb.plot.report, "The report.json of a run")->required();
    plot->add_option("-o,--output", verb.plot.output, "A folder, or one file (.svg)")->required();
}

void add_others(CLI::App& app, Verb& verb) {
    CLI::App* info = app.add_subcommand("info", "What a mesh or a solution file holds");
    info->add_option("input", verb.info.input, mesh_or_solution())->required();
    add_read(info, verb.info.read);
    info->add_flag("--json", verb.info.json, "One JSON object instead of a table");
    CLI::App* explain = app.add_subcommand("explain", "What a stage or a source does, and its options");
    explain->add_option("topic", verb.topic, "Such as curve, relax, shell; none: list them");
    app.add_subcommand("schema", "The JSON Schema of a pipeline, for editors");
}

}  // namespace

void add_quiet(CLI::App& app) {
    const std::vector<std::string> give_data{"info", "explain", "schema"};
    for (CLI::App* verb : app.get_subcommands({}))
        if (std::ranges::find(give_data, verb->get_name()) == give_data.end())
            verb->add_flag_callback(
                "--quiet", [] { set_voice(Voice::quiet); },
                "Say nothing but errors and what is missed: no table, no notes, no progress");
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
