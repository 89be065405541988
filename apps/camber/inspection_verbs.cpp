// Arguments of the verbs that examine and show meshes, and of those that explain the program.
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
        "  camber check wing-p2.meshb                       the report\n"
        "  camber check wing-p2.meshb --worst 50            with more of the worst elements\n"
        "  camber check wing-p2.meshb --json > check.json   all of it for scripts\n"
        "  camber check wing-p2.meshb --elements            each element's verdict, as CSV\n"
        "  camber check wing-p2.meshb --field 'tanh((sqrt(x^2+y^2+z^2) - 0.5)/0.01)'\n"
        "                                                   does curvature pay for a front on this sphere?\n"
        "  camber check wing.meshb --metric wing.solb       is it unit for this metric?\n"
        "  camber check wing-p2.meshb --metric wing.solb    the same straight and along its curves\n\n"
        "An element of degree 2 is valid where det J is positive everywhere; its scaled Jacobian is the smallest det J "
        "as a share of that of the straight element with the same vertices (other programs mean Knupp's measure by the "
        "name). Of a straight mesh the quality is told: the mean ratio. Beyond its elements the mesh is examined: "
        "conformity, orientation, nodes, boundary, and whether walls pass through each other, curved as they are. Of a "
        "field (x, y, z, pi, + - * / ^, c ? a : b, sqrt, exp, tanh ...) the errors of its interpolants are told, in L2 "
        "and H1: of degree 1 and 2 with straight edges, and of the mesh as it is; a ratio straight / as it is above 1 "
        "says that curvature pays at equal unknowns (docs/algorithms/interpolation-error.md). In a metric an element "
        "of degree 2 has the quality 1 / mean distortion: 1 is unit, 0 folded (docs/algorithms/distortion.md). What "
        "each line means: docs/algorithms/check.md");
    CheckArguments& a = all.check;
    using Options = run::CheckOptions;
    add_mesh(verb, a.input);
    add_described<double>(verb, a.options, option_of(&Options::min_scaled_jacobian));
    add_described<double>(verb, a.options, option_of(&Options::ridge_angle));
    add_flat(verb, a.flat);
    add_described<int>(verb, a.options, option_of(&Options::worst));
    add_option(verb, "--field", a.options.fields,
               "An expression of x, y (and z) whose interpolants' errors are told; again for more fields")
        ->allow_extra_args(false)
        ->type_name("EXPRESSION");
    add_option(verb, "--metric", a.metric,
               "A metric file: lengths of edges and qualities of elements in it are told, and how many edges are of "
               "unit length; of degree 2 straight and along the curves, with a bound of the quality at every point");
    add_option(verb, "--vtu", a.vtu,
               "Also write the mesh with each element's verdict, scaled Jacobian and quality for ParaView (.vtu)");
    add_threads(verb, a.threads);
    add_flag(verb, "--histogram,!--no-histogram", a.histogram,
             "How the scaled Jacobians (of a straight mesh: the quality) are spread; shown by default");
    add_option(verb, "--page", a.page,
               "Also write mesh and report as a page for a browser (.html), as camber report does");
    add_flag(verb, "--json", a.json, "One JSON object instead of the report");
    add_flag(verb, "--elements", a.elements,
             "A line of CSV for each element instead of the report; with --json as columns in the object");
    return {[&a](const Host&) { return check_command(a); }};
}

Work declare_report(CLI::App* verb, Arguments& all) {
    add_details(verb,
                "  camber report wing-p2.meshb -o wing.html\n"
                "  camber report wing.meshb --metric wing.solb -o wing.html    also coloured by its anisotropy\n"
                "  camber report flow.vtu -o flow.html                         and by the file's own fields\n"
                "  camber curve wing.meshb -o wing-p2.meshb --report report.json\n"
                "  camber report report.json -o wing.html                      before and after correction\n\n"
                "The page: docs/page.md");
    ReportArguments& a = all.report;
    using Options = run::CheckOptions;
    add_option(verb, "input", a.input,
               "The mesh (" + endings_of_input() +
                   "), or the report.json of a run, whose mesh is where it was written or beside it")
        ->required();
    add_option(verb, "-o,--output", a.output, "The page (.html)")->required();
    add_described<double>(verb, a.options, option_of(&Options::min_scaled_jacobian));
    add_flat(verb, a.flat);
    add_described<int>(verb, a.options, option_of(&Options::worst));
    add_option(verb, "--metric", a.metric,
               "A metric file: faces can be coloured by its anisotropy, and check tells lengths and qualities in it");
    add_option(verb, "--solution", a.solution,
               "Fields to colour by: a solution file, or a mesh file with the same nodes. Default: those of the mesh's "
               "own file");
    add_described<int>(verb, a.page, option_of(&run::PageOptions::inner_faces));
    add_threads(verb, a.threads);
    return {[&a](const Host&) { return report_command(a); }};
}

Work declare_geometry(CLI::App* verb, Arguments& all) {
    add_details(
        verb,
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
        "of the part that was meant. More: docs/algorithms/distances.md");
    GeometryCommandArguments& a = all.geometry;
    using Options = run::InspectOptions;
    add_mesh(verb, a.input);
    add_option(verb, "-o,--output", a.output,
               "Also write the mesh with its patches and the distances of its facets for ParaView (.vtu)");
    add_option(verb, "--surface", a.surface,
               "Also write the geometry over the mesh's facets for ParaView (.vtu): each facet in 36 small ones, with "
               "normals");
    add_geometry(verb, a.geometry);
    add_described<double>(verb, a.options, option_of(&Options::ridge_angle));
    add_described<int>(verb, a.options, option_of(&Options::worst));
    add_flat(verb, a.flat);
    add_threads(verb, a.threads);
    add_flag(verb, "--json", a.json, "One JSON object instead of the report");
    return {[&a](const Host&) { return geometry_command(a); }};
}

Work declare_plot(CLI::App* verb, Arguments& all) {
    PlotArguments& a = all.plot;
    add_details(verb,
                "  camber curve wing.meshb -o wing-p2.meshb --report report.json\n"
                "  camber plot report.json -o plots                a file for each quantity in this folder\n"
                "  camber plot report.json -o histograms.svg       all in one");
    add_option(verb, "report", a.report, "The report.json of a run")->required();
    add_option(verb, "-o,--output", a.output, "A folder, or one file (.svg)")->required();
    return {[&a](const Host&) { return plot_command(a); }};
}

Work declare_picture(CLI::App* verb, Arguments& all) {
    add_details(
        verb,
        "  camber picture wing-p2.meshb -o wing.png                     as pixels\n"
        "  camber picture wing-p2.meshb -o cut.png --cut x=0.5          what lies beyond x = 0.5 is left out\n"
        "  camber picture ring.mesh -o ring.svg --size 600x600          as curves, to be enlarged at will\n"
        "  camber picture wing-p2.meshb -o worst.png --worst 10         the ten worst elements are marked\n"
        "  camber picture wing.msh -o wall.png --hide farfield          without the facets of a group\n"
        "  camber picture wing.meshb -o m.png --metric wing.solb        the anisotropy of a metric\n"
        "  camber picture wing.meshb -o u.png --solution u.solb --no-edges --background dark\n\n"
        "A cut leaves out whole elements, those whose centroid lies beyond the plane. There is no perspective: "
        "lengths on the paper stay in proportion. The same bytes for any number of threads. More: docs/pictures.md");
    PictureArguments& a = all.picture;
    add_mesh(verb, a.input);
    add_option(verb, "-o,--output", a.output, "Where the picture goes (.png, .svg)")->required();
    add_option(verb, "--size", a.size, "Width and height in pixels")->type_name("WxH")->default_str("1200x900");
    add_option(verb, "--cut", a.cut,
               "The plane beyond which elements are left out: x=0.5 keeps what is below, x>0.5 what is above, "
               "A,B,C,D what has A x + B y + C z <= D")
        ->type_name("PLANE");
    add_option(
        verb, "--show", a.show,
        "The only groups that are drawn, by name or reference number: in 3D of boundary facets and of elements, in "
        "2D of elements. A number means elements if no boundary facet has it")
        ->type_name("GROUP,...");
    add_option(verb, "--hide", a.hide, "The groups that are not drawn, in the same way. What is behind them is seen")
        ->type_name("GROUP,...");
    add_option(verb, "--view", a.view,
               "Where you look from: front, back, left, right, top, bottom, or a direction X,Y,Z. Default: "
               "obliquely; with --cut onto what is cut")
        ->type_name("FROM");
    add_option(verb, "--zoom", a.zoom,
               "Only the box around a point, with this half width: X,Y,Z,RADIUS, in 2D X,Y,RADIUS")
        ->type_name("PLACE");
    add_words(verb, "--colour", a.colour,
              "What the colours stand for. Default: what is given by --solution or --metric, else scaled Jacobians, of "
              "a straight mesh the quality");
    add_option(verb, "--solution", a.solution,
               "A solution on the mesh (" + endings_of_solutions() + ", or a mesh file with fields)");
    add_option(verb, "--field", a.field, "The name of its field. Default: the first")->type_name("NAME");
    add_option(verb, "--metric", a.metric, "A metric on the mesh, whose anisotropy is shown");
    add_words(verb, "--background", a.background, "What is behind the mesh");
    add_flag(verb, "--no-edges", a.no_edges, "Leave out the edges of the mesh");
    add_option(verb, "--worst", a.worst,
               "The number of worst elements to mark. Elements that cannot be seen are not marked")
        ->check(between<int>(0, 1000));
    add_flat(verb, a.flat);
    add_threads(verb, a.threads);
    return {[&a](const Host&) { return picture_command(a); }};
}

Work declare_info(CLI::App* verb, Arguments& all) {
    InfoArguments& a = all.info;
    add_option(verb, "input", a.input, mesh_or_solution())->required();
    add_read(verb, a.read);
    add_flag(verb, "--json", a.json, "One JSON object instead of a table");
    return {[&a](const Host&) { return info_command(a); }};
}

Work declare_explain(CLI::App* verb, Arguments& all) {
    add_details(verb,
                "  camber explain                       lists all words by group\n"
                "  camber explain relax                 a stage and its options\n"
                "  camber explain --geometry-error      an option\n"
                "  camber explain 'scaled Jacobian'     a word of the tables");
    add_option(verb, "topic", all.topic, "The word, such as curve, --geometry-error, complexity. Default: list all");
    return {[&topic = all.topic, program = verb->get_parent()](const Host&) {
        const auto text = topic.empty() ? list_explained_words(*program) : explanation_of(*program, topic);
        return text.map([](const std::string& t) { return end_with(t); });
    }};
}

Work declare_help(CLI::App* verb, Arguments& all) {
    add_option(verb, "command", all.help_of, "The command, such as curve. Default: the program");
    return {[&name = all.help_of, program = verb->get_parent()](const Host&) {
        return help_text_of(*program, name).map([](const std::string& text) { return end_with(text); });
    }};
}

Work declare_schema(CLI::App* verb, Arguments& all) {
    add_option(verb, "of", all.schema, "config, report, check or geometry. Default: config");
    return {[&of = all.schema](const Host&) { return schema_command(of); }};
}

}  // namespace camber::app
