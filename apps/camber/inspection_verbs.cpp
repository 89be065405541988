#include "arguments.hpp"

#include <string>
#include <CLI/CLI.hpp>

#include "help.hpp"
import camber.core;
import camber.commands;
import camber.drawing;
import camber.io;
import camber.recipes;
import camber.reports;

namespace camber::app {

Work declare_check(CLI::App* verb, Arguments& all) {
    add_details(
        verb,
        "  camber check wing-p2.meshb                       print the report\n"
        "  camber check wing-p2.meshb --worst 50            with more of the worst elements\n"
        "  camber check wing-p2.meshb --json > check.json   the whole report for scripts\n"
        "  camber check wing-p2.meshb --elements            each element's verdict, as CSV\n"
        "  camber check wing-p2.meshb --field 'tanh((sqrt(x^2+y^2+z^2) - 0.5)/0.01)'\n"
        "                                                   interpolation errors of a front on a sphere\n"
        "  camber check wing.meshb --metric wing.solb       edge lengths in this metric\n"
        "  camber check wing-p2.meshb --metric wing.solb    the same, straight and along the curves\n\n"
        "An element of degree 2 is valid if det J is positive everywhere. Its scaled Jacobian is the minimum of det J "
        "divided by det J of the straight element with the same vertices. Other programs use this name for Knupp's "
        "measure. For a straight mesh, the report has the quality, which is the mean ratio. check also examines the "
        "whole mesh: conformity, orientation, nodes, boundary, and crossing of curved facets.\n\n"
        "A field is an expression of x, y, z and pi with + - * / ^, c ? a : b, sqrt, exp, tanh ... For a field, the "
        "report has the L2 and H1 errors of its interpolants: of degree 1 and 2 on straight edges, and on the curved "
        "mesh. If the error on straight edges divided by that on the curved mesh is above 1, curved elements are more "
        "accurate with the same number of unknowns (docs/algorithms/interpolation-error.md). In a metric, the quality "
        "of an element of degree 2 is 1 divided by its mean distortion: 1 is regular, 0 is folded "
        "(docs/algorithms/distortion.md). All lines of the report: docs/algorithms/check.md");
    CheckArguments& a = all.check;
    using Options = run::CheckOptions;
    add_mesh(verb, a.input);
    add_described<double>(verb, a.options, option_of(&Options::min_scaled_jacobian));
    add_described<double>(verb, a.options, option_of(&Options::ridge_angle));
    add_flat(verb, a.flat);
    add_described<int>(verb, a.options, option_of(&Options::worst));
    add_option(verb, "--field", a.options.fields,
               "Expression of x, y (and z) whose interpolation errors are reported. Can be repeated")
        ->allow_extra_args(false)
        ->type_name("EXPRESSION");
    add_option(verb, "--metric", a.metric,
               "Metric file. The report then has lengths of edges, the share of unit edges and qualities of elements "
               "in it. For degree 2 it has them straight and along the curves, with a bound of the quality at every "
               "point");
    add_option(verb, "--vtu", a.vtu,
               "Also write the mesh with each element's verdict, scaled Jacobian and quality for ParaView (.vtu)");
    add_threads(verb, a.threads);
    add_flag(verb, "--histogram,!--no-histogram", a.histogram,
             "Histogram of the scaled Jacobians, or of the qualities of a straight mesh; shown by default");
    add_option(verb, "--page", a.page,
               "Also write mesh and report as a page for a browser (.html), as camber report does");
    add_flag(verb, "--json", a.json, "Print one JSON object instead of the report");
    add_flag(verb, "--elements", a.elements,
             "Print a line of CSV for each element instead of the report; with --json, add columns to the object");
    return {[&a](const Host&) { return check_command(a); }};
}

Work declare_report(CLI::App* verb, Arguments& all) {
    add_details(verb,
                "  camber report wing-p2.meshb -o wing.html\n"
                "  camber report wing.meshb --metric wing.solb -o wing.html    also coloured by anisotropy\n"
                "  camber report flow.vtu -o flow.html                         coloured by fields of the file\n"
                "  camber curve wing.meshb -o wing-p2.meshb --report report.json\n"
                "  camber report report.json -o wing.html                      before and after correction\n\n"
                "Contents of the page: docs/page.md");
    ReportArguments& a = all.report;
    using Options = run::CheckOptions;
    add_option(verb, "input", a.input,
               "The mesh (" + endings_of_input() +
                   "), or the report.json of a run. The mesh of the run must be at its original path or next to the "
                   "report")
        ->required();
    add_option(verb, "-o,--output", a.output, "The page (.html)")->required();
    add_described<double>(verb, a.options, option_of(&Options::min_scaled_jacobian));
    add_flat(verb, a.flat);
    add_described<int>(verb, a.options, option_of(&Options::worst));
    add_option(verb, "--metric", a.metric,
               "Metric file. It adds a colouring by anisotropy, and lengths and qualities in the metric to the report");
    add_option(verb, "--solution", a.solution,
               "Fields to colour by: a solution file, or a mesh file with the same nodes. Default: the fields of the "
               "mesh file");
    add_described<int>(verb, a.page, option_of(&run::PageOptions::inner_faces));
    add_threads(verb, a.threads);
    return {[&a](const Host&) { return report_command(a); }};
}

Work declare_geometry(CLI::App* verb, Arguments& all) {
    add_details(
        verb,
        "  camber geometry wing.meshb                              patches, ridges, corners, suspicious places\n"
        "  camber geometry wing.meshb --ridge-angle 30             the ridges with a ridge angle of 30 degrees\n"
        "  camber geometry wing-p2.meshb --cad wing.step           distances to and from the CAD model, by face\n"
        "  camber geometry wing-p2.meshb --cad wing.step -o d.vtu  the same as fields of the facets, for ParaView\n"
        "  camber geometry wing.meshb --surface smooth.vtu         the smooth surface that curving uses\n"
        "  camber geometry wing.meshb --json > geometry.json       the whole report for scripts\n\n"
        "Ridges are edges where facets turn by more than the ridge angle, edges between references, and edges that the "
        "file lists as ridges. Patches are the smooth parts between ridges. Two facets in one plane turn by 0 degrees. "
        "Suspicious places depend on the ridge angle, or have no smooth surface: knife edges, tips of cones, vertices "
        "with divergent normals. Check them before curving. To correct them, list edges as Ridges in the file, assign "
        "different references to facets of different surfaces, or choose another angle.\n\n"
        "Distances are measured in both directions. The distance from the boundary to the geometry shows how closely "
        "the mesh follows the geometry. The distance from the geometry to the boundary shows parts that the mesh "
        "misses. For a CAD model it is sampled on all faces and edges, for other geometries only opposite the facets "
        "of the mesh. Without a geometry, the reference is the smooth surface through the vertices of the mesh. The "
        "distance then measures the deviation of facets or curves from that surface, not from the original part. More: "
        "docs/algorithms/distances.md");
    GeometryCommandArguments& a = all.geometry;
    using Options = run::InspectOptions;
    add_mesh(verb, a.input);
    add_option(verb, "-o,--output", a.output,
               "Also write the mesh with its patches and the distances of its facets for ParaView (.vtu)");
    add_option(verb, "--surface", a.surface,
               "Also write the geometry over the mesh's facets for ParaView (.vtu): 36 triangles for each facet, with "
               "normals");
    add_geometry(verb, a.geometry);
    add_described<double>(verb, a.options, option_of(&Options::ridge_angle));
    add_described<int>(verb, a.options, option_of(&Options::worst));
    add_flat(verb, a.flat);
    add_threads(verb, a.threads);
    add_flag(verb, "--json", a.json, "Print one JSON object instead of the report");
    return {[&a](const Host&) { return geometry_command(a); }};
}

Work declare_plot(CLI::App* verb, Arguments& all) {
    PlotArguments& a = all.plot;
    add_details(verb,
                "  camber curve wing.meshb -o wing-p2.meshb --report report.json\n  camber plot report.json -o "
                "plots                a file for each quantity in this folder\n  camber plot report.json -o "
                "histograms.svg       one file for all quantities");
    add_option(verb, "report", a.report, "report.json of a run")->required();
    add_option(verb, "-o,--output", a.output, "Folder, or one file (.svg), to write")->required();
    return {[&a](const Host&) { return plot_command(a); }};
}

Work declare_picture(CLI::App* verb, Arguments& all) {
    add_details(
        verb,
        "  camber picture wing-p2.meshb -o wing.png                     pixels\n"
        "  camber picture wing-p2.meshb -o cut.png --cut x=0.5          without the elements beyond x = 0.5\n"
        "  camber picture ring.mesh -o ring.svg --size 600x600          vector graphics\n"
        "  camber picture wing-p2.meshb -o worst.png --worst 10         marks the ten worst elements\n"
        "  camber picture wing.msh -o wall.png --hide farfield          without the facets of a group\n"
        "  camber picture wing.meshb -o m.png --metric wing.solb        the anisotropy of a metric\n"
        "  camber picture wing.meshb -o u.png --solution u.solb --no-edges --background dark\n\n"
        "A cut removes whole elements: those with their centroid beyond the plane. The projection is parallel, so "
        "lengths stay in proportion. The number of threads does not change the file. More: docs/pictures.md");
    PictureArguments& a = all.picture;
    add_mesh(verb, a.input);
    add_option(verb, "-o,--output", a.output, "Output picture (.png, .svg)")->required();
    add_option(verb, "--size", a.size, "Width and height in pixels")->type_name("WxH")->default_str("1200x900");
    add_option(verb, "--cut", a.cut,
               "Plane beyond which elements are left out. x=0.5: keeps elements below; x>0.5: keeps elements above; "
               "A,B,C,D: keeps elements with A x + B y + C z <= D")
        ->type_name("PLANE");
    add_option(
        verb, "--show", a.show,
        "Draw only these groups, given by name or reference number. In 3D they are groups of boundary facets and "
        "elements, in 2D of elements. A number refers to elements if no boundary facet has it")
        ->type_name("GROUP,...");
    add_option(verb, "--hide", a.hide,
               "Do not draw these groups, given as for --show. Objects behind them become "
               "visible")
        ->type_name("GROUP,...");
    add_option(verb, "--view", a.view,
               "Direction of view: front, back, left, right, top, bottom, or the viewpoint's direction X,Y,Z. Default: "
               "oblique; with --cut, onto the cut")
        ->type_name("FROM");
    add_option(verb, "--zoom", a.zoom,
               "Draw only the box around a point with this half width: X,Y,Z,RADIUS, in 2D X,Y,RADIUS")
        ->type_name("PLACE");
    add_words(verb, "--colour", a.colour,
              "Quantity shown by colours. Default: the field of --solution or the anisotropy of --metric, otherwise "
              "scaled Jacobians (qualities of a straight mesh)");
    add_option(verb, "--solution", a.solution,
               "Solution on the mesh (" + endings_of_solutions() + ", or a mesh file with fields)");
    add_option(verb, "--field", a.field, "Name of the field to show. Default: the first")->type_name("NAME");
    add_option(verb, "--metric", a.metric, "Metric on the mesh, whose anisotropy is shown");
    add_words(verb, "--background", a.background, "Background of the picture");
    add_flag(verb, "--no-edges", a.no_edges, "Leave out the edges of the mesh");
    add_option(verb, "--worst", a.worst, "Number of worst elements to mark. Hidden elements are not marked")
        ->check(between<int>(0, 1000));
    add_flat(verb, a.flat);
    add_threads(verb, a.threads);
    return {[&a](const Host&) { return picture_command(a); }};
}

Work declare_info(CLI::App* verb, Arguments& all) {
    InfoArguments& a = all.info;
    add_option(verb, "input", a.input, mesh_or_solution())->required();
    add_read(verb, a.read);
    add_flag(verb, "--json", a.json, "Print one JSON object instead of a table");
    return {[&a](const Host&) { return info_command(a); }};
}

Work declare_explain(CLI::App* verb, Arguments& all) {
    add_details(verb,
                "  camber explain                       lists all words by group\n"
                "  camber explain relax                 explains a stage and its options\n"
                "  camber explain --geometry-error      explains an option\n"
                "  camber explain 'scaled Jacobian'     explains a word of the tables");
    add_option(verb, "topic", all.topic, "Word, such as curve, --geometry-error, complexity. Default: list all words");
    return {[&topic = all.topic, program = verb->get_parent()](const Host&) {
        const auto text = topic.empty() ? list_explained_words(*program) : explanation_of(*program, topic);
        return text.map([](const std::string& t) { return end_with(t); });
    }};
}

Work declare_help(CLI::App* verb, Arguments& all) {
    add_option(verb, "command", all.help_of, "Command, such as curve. Default: the program");
    return {[&name = all.help_of, program = verb->get_parent()](const Host&) {
        return help_text_of(*program, name).map([](const std::string& text) { return end_with(text); });
    }};
}

Work declare_schema(CLI::App* verb, Arguments& all) {
    add_option(verb, "of", all.schema, "Document: config, report, check or geometry. Default: config");
    return {[&of = all.schema](const Host&) { return schema_command(of); }};
}

}  // namespace camber::app
