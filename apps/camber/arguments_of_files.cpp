// What `convert`, `generate` and `info` take from the command line.
#include "argument_kinds.hpp"
#include "arguments.hpp"

#include <cstddef>
#include <string>
#include <CLI/CLI.hpp>

import camber.core;
import camber.commands;
import camber.io;
import camber.shapes;

namespace camber::app {

void add_convert(CLI::App& app, Verb& verb) {
    CLI::App* convert =
        add_verb(app, "convert",
                 "A mesh or a solution in another format.\n\n"
                 "  camber convert wing.meshb -o wing.mesh                      binary to ASCII, and back\n"
                 "  camber convert wing-p2.meshb -o wing.vtu --cells lagrange   for ParaView, Lagrange cells\n"
                 "  camber convert wing.meshb -o wing.vtu --metric wing.solb    with a solution's fields\n"
                 "  camber convert part.msh -o part.mfem                        from Gmsh to MFEM\n"
                 "  camber convert wing-p2.meshb -o wing.pvtu --partition 64    for a solver on 64 processes\n"
                 "  camber convert wing.solb -o wing.sol                        solutions alone\n"
                 "  camber convert flow.vtu -o flow.sol                         the fields at a mesh's nodes\n\n"
                 "What the format cannot hold is told on standard error. More: docs/formats.md");
    ConvertArguments& a = verb.convert;
    add_option(convert, "input", a.input, mesh_or_solution())->required();
    add_option(convert, "-o,--output", a.output,
               "Mesh: " + camber::listed(camber::endings_written(camber::mesh_formats())) +
                   "; solution: " + camber::listed(camber::endings_written(camber::solution_formats())))
        ->required();
    add_format(convert, a.format, mesh_format_names());
    add_words(convert, "--cells", a.cells, "Cells of degree 2 in a .vtu: quadratic (the default) or lagrange");
    add_option(convert, "--metric", a.metric,
               "A solution on the mesh's vertices, whose fields go along (.vtu, .vtk, .msh, .cgns, .xdmf)");
    auto* const elevate =
        add_flag(convert, "--elevate", a.elevate, "Degree 1 to 2 first: each edge gets a node at its middle");
    add_flag(convert, "--straighten", a.straighten, "Degree 2 to 1 first: the nodes of edges are left out")
        ->excludes(elevate);
    add_option(convert, "--partition", a.partition,
               "In so many parts for a solver, by Scotch: files OUT.1.EXT … with the numbers of nodes and cells "
               "in the whole, beside it OUT with the field partition; or -o OUT.pvtu, which names its pieces")
        ->check(CLI::Range(std::size_t{1}, std::size_t{1} << 20U));
    add_read(convert, a.read);
    add_threads(convert, a.threads);
    add_force(convert, a.force);
}

void add_generate(CLI::App& app, Verb& verb) {
    CLI::App* generate = add_verb(
        app, "generate",
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
    add_option(generate, "shape", a.shape, "A shape's name, its JSON, or a file with that or with a config")
        ->required();
    add_option(generate, "-o,--output", a.output,
               "Where the mesh goes (" + camber::listed(camber::endings_written(camber::mesh_formats()), ", ") + ")")
        ->required();
    add_option(generate, "--set", a.settings, "One option of the shape: path=value")->type_name("PATH=VALUE");
    add_option(generate, "--elements", a.elements,
               "About so many tetrahedra or triangles (within 20 per cent, but for very few): sizes or cells are "
               "scaled, layers stay as they are")
        ->check(between<double>(1, static_cast<double>(camber::max_entities)));
    add_words(generate, "--structure", a.structure,
              "Of a shell or annulus: " + std::string(camber::option_of(&camber::ShellOptions<3>::structure).sentence));
    add_format(generate, a.format, mesh_format_names());
    add_threads(generate, a.threads);
    add_flag(generate, "--print-config", a.print_config, "Print the pipeline that makes this mesh, and stop");
}

void add_others(CLI::App& app, Verb& verb) {
    CLI::App* info = add_verb(app, "info", "What a mesh or a solution file holds");
    add_option(info, "input", verb.info.input, mesh_or_solution())->required();
    add_read(info, verb.info.read);
    add_flag(info, "--json", verb.info.json, "One JSON object instead of a table");
    CLI::App* explain = add_verb(app, "explain",
                                 "Explain a word: a section, stage or source of configs, an option, a word of the "
                                 "tables.\n\n"
                                 "  camber explain                       lists all words by group\n"
                                 "  camber explain relax                 a stage and its options\n"
                                 "  camber explain --geometry-error      an option\n"
                                 "  camber explain 'scaled Jacobian'     a word of the tables");
    add_option(explain, "topic", verb.topic,
               "The word, such as curve, --geometry-error, complexity. Default: list all");
    CLI::App* help = add_verb(app, "help", "Print this text, or the help of a command");
    add_option(help, "command", verb.help_of, "The command, such as curve. Default: the program");
    CLI::App* schema = add_verb(app, "schema", "The JSON Schema of a pipeline, for editors, or of report.json");
    add_option(schema, "of", verb.schema, "config or report. Default: config");
}

}  // namespace camber::app
