// What the verbs that tell of a mesh, and change nothing, take from the command line.
#include "argument_kinds.hpp"
#include "arguments.hpp"

#include <string>
#include <CLI/CLI.hpp>

import camber.core;
import camber.commands;
import camber.recipes;
import camber.reports;

namespace camber::app {

void add_check(CLI::App& app, Verb& verb) {
    CLI::App* check = add_verb(
        app, "check",
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
    add_option(check, "input", a.input, "The mesh (" + endings_of_input() + ")")->required();
    add_described<double>(check, a.options, camber::option_of(&Options::min_scaled_jacobian));
    add_described<double>(check, a.options, camber::option_of(&Options::ridge_angle));
    add_flat(check, a.flat);
    add_described<int>(check, a.options, camber::option_of(&Options::worst));
    add_option(check, "--field", a.options.fields,
               "An expression of x, y (and z) whose interpolants' errors are told; again for more fields")
        ->allow_extra_args(false)
        ->type_name("EXPRESSION");
    add_option(check, "--metric", a.metric,
               "A metric file: lengths of edges and qualities of elements in it are told, and how many edges are "
               "of unit length; of degree 2 straight and along the curves, with a bound of the quality at every point");
    add_option(check, "--vtu", a.vtu,
               "Also write the mesh with each element's verdict, scaled Jacobian and quality for ParaView (.vtu)");
    add_threads(check, a.threads);
    add_flag(check, "--histogram,!--no-histogram", a.histogram,
             "How the scaled Jacobians (of a straight mesh: the quality) are spread; shown by default");
    add_option(check, "--page", a.page,
               "Also write mesh and report as a page for a browser (.html), as camber report does");
    add_flag(check, "--json", a.json, "One JSON object instead of the report");
    add_flag(check, "--elements", a.elements,
             "A line of CSV for each element instead of the report; with --json as columns in the object");
}

void add_report(CLI::App& app, Verb& verb) {
    CLI::App* report = add_verb(
        app, "report",
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
    add_option(report, "input", a.input,
               "The mesh (" + endings_of_input() +
                   "), or the report.json of a run, whose "
                   "mesh is where it was written or beside it")
        ->required();
    add_option(report, "-o,--output", a.output, "The page (.html)")->required();
    add_described<double>(report, a.options, camber::option_of(&Options::min_scaled_jacobian));
    add_flat(report, a.flat);
    add_described<int>(report, a.options, camber::option_of(&Options::worst));
    add_option(report, "--metric", a.metric,
               "A metric file: faces can be coloured by its anisotropy, and check tells "
               "lengths and qualities in it");
    add_option(report, "--solution", a.solution,
               "Fields to colour by: a solution file, or a mesh file with the same "
               "nodes. Default: those of the mesh's own file");
    add_described<int>(report, a.page, camber::option_of(&camber::run::PageOptions::inner_faces));
    add_threads(report, a.threads);
}

void add_inspection(CLI::App& app, Verb& verb) {
    CLI::App* geometry = add_verb(
        app, "geometry",
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
    add_option(geometry, "input", a.input, "The mesh (" + endings_of_input() + ")")->required();
    add_option(geometry, "-o,--output", a.output,
               "Also write the mesh with its patches and the distances of its facets for ParaView (.vtu)");
    add_option(geometry, "--surface", a.surface,
               "Also write the geometry over the mesh's facets for ParaView (.vtu): each facet in 36 small "
               "ones, with normals");
    add_geometry(geometry, a.geometry);
    add_described<double>(geometry, a.options, camber::option_of(&Options::ridge_angle));
    add_described<int>(geometry, a.options, camber::option_of(&Options::worst));
    add_flat(geometry, a.flat);
    add_threads(geometry, a.threads);
    add_flag(geometry, "--json", a.json, "One JSON object instead of the report");
}

void add_plot(CLI::App& app, Verb& verb) {
    CLI::App* plot =
        add_verb(app, "plot",
                 "Histograms of a run as SVG pictures, before and after correction.\n\n"
                 "  camber curve wing.meshb -o wing-p2.meshb --report report.json\n"
                 "  camber plot report.json -o plots                a file for each quantity in this folder\n"
                 "  camber plot report.json -o histograms.svg       all in one");
    add_option(plot, "report", verb.plot.report, "The report.json of a run")->required();
    add_option(plot, "-o,--output", verb.plot.output, "A folder, or one file (.svg)")->required();
}

}  // namespace camber::app
