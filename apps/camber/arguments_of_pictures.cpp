// What `picture` takes from the command line.
#include "argument_kinds.hpp"
#include "arguments.hpp"

#include <string>
#include <CLI/CLI.hpp>

import camber.core;
import camber.commands;
import camber.drawing;
import camber.io;
import camber.recipes;
import camber.reports;

namespace camber::app {

void add_picture(CLI::App& app, Verb& verb) {
    CLI::App* picture = add_verb(
        app, "picture",
        "A mesh as a picture, edges curved as they are; without a display.\n\n"
        "  camber picture wing-p2.meshb -o wing.png                     as pixels\n"
        "  camber picture wing-p2.meshb -o cut.png --cut x=0.5          what lies beyond x = 0.5 is left out\n"
        "  camber picture ring.mesh -o ring.svg --size 600x600          as curves, to be enlarged at will\n"
        "  camber picture wing-p2.meshb -o worst.png --worst 10         the ten worst elements are marked\n"
        "  camber picture wing.msh -o wall.png --hide farfield          without the facets of a group\n"
        "  camber picture wing.meshb -o m.png --metric wing.solb        the anisotropy of a metric\n"
        "  camber picture wing.meshb -o u.png --solution u.solb --no-edges --background dark\n\n"
        "A cut leaves out whole elements, those whose centroid lies beyond the plane. There is no perspective: "
        "lengths on the paper stay in proportion. The same bytes for any number of threads. More: docs/pictures.md");
    PictureArguments& a = verb.picture;
    add_option(picture, "input", a.input, "The mesh (" + endings_of_input() + ")")->required();
    add_option(picture, "-o,--output", a.output, "Where the picture goes (.png, .svg)")->required();
    add_option(picture, "--size", a.size, "Width and height in pixels")->type_name("WxH")->default_str("1200x900");
    add_option(picture, "--cut", a.cut,
               "The plane beyond which elements are left out: x=0.5 keeps what is below, x>0.5 what is above, "
               "A,B,C,D what has A x + B y + C z <= D")
        ->type_name("PLANE");
    add_option(
        picture, "--show", a.show,
        "The only groups that are drawn, by name or reference number: in 3D of boundary facets and of elements, in "
        "2D of elements. A number means elements if no boundary facet has it")
        ->type_name("GROUP,...");
    add_option(picture, "--hide", a.hide, "The groups that are not drawn, in the same way. What is behind them is seen")
        ->type_name("GROUP,...");
    add_option(picture, "--view", a.view,
               "Where you look from: front, back, left, right, top, bottom, or a direction X,Y,Z. Default: "
               "obliquely; with --cut onto what is cut")
        ->type_name("FROM");
    add_option(picture, "--zoom", a.zoom,
               "Only the box around a point, with this half width: X,Y,Z,RADIUS, in 2D X,Y,RADIUS")
        ->type_name("PLACE");
    add_words(picture, "--colour", a.colour,
              "What the colours stand for. Default: what is given by --solution or --metric, else scaled Jacobians, of "
              "a straight mesh the quality");
    add_option(picture, "--solution", a.solution,
               "A solution on the mesh (" + endings_of_solutions() + ", or a mesh file with fields)");
    add_option(picture, "--field", a.field, "The name of its field. Default: the first")->type_name("NAME");
    add_option(picture, "--metric", a.metric, "A metric on the mesh, whose anisotropy is shown");
    add_words(picture, "--background", a.background, "What is behind the mesh");
    add_flag(picture, "--no-edges", a.no_edges, "Leave out the edges of the mesh");
    add_option(picture, "--worst", a.worst,
               "The number of worst elements to mark. Elements that cannot be seen are not marked")
        ->check(between<int>(0, 1000));
    add_flat(picture, a.flat);
    add_threads(picture, a.threads);
}

}  // namespace camber::app
