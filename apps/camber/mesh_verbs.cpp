// Arguments of the verbs that make or convert meshes, metrics and solutions: metric, transfer, convert, generate.
#include "arguments.hpp"

#include <cstddef>
#include <string>
#include <vector>
#include <CLI/CLI.hpp>

import camber.core;
import camber.commands;
import camber.config;
import camber.io;
import camber.metric;
import camber.recipes;
import camber.shapes;
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
void add_options_of_metric(CLI::App* verb, config::SolutionMetric& m) {
    using S = config::SolutionMetric;
    add_described<int>(verb, m, option_of(&S::degree));
    add_described<double>(verb, m, option_of(&S::norm));
    add_words(verb, "--error-of", m.error_of, help_of(option_of(&S::error_of)));
    add_described<double>(verb, m, option_of(&S::complexity));
    add_described<double>(verb, m, option_of(&S::vertices));
    add_described<double>(verb, m, option_of(&S::elements));
    verb->get_option("--complexity")->excludes("--vertices")->excludes("--elements");
    verb->get_option("--vertices")->excludes("--elements");
    add_described<double>(verb, m, option_of(&S::min_size));
    add_described<double>(verb, m, option_of(&S::max_size));
    add_described<double>(verb, m, option_of(&S::max_anisotropy));
    add_option(verb, "--geometry-angle", m.geometry.angle,
               help_of(option_of(&config::GeometryMetric::angle)) + " (degrees)")
        ->check(within<double>(option_of(&config::GeometryMetric::angle).limits));
    add_described<double>(verb, m.geometry, option_of(&config::GeometryMetric::gap_elements));
}

}  // namespace

Work declare_metric(CLI::App* verb, Arguments& all) {
    add_details(
        verb,
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
    MetricArguments& a = all.metric;
    add_mesh(verb, a.input);
    add_solution(verb, a.solution, a.metric.fields);
    add_option(verb, "-o,--output", a.output,
               "Where the metric goes (" + endings_of_solutions() + ", or .vtu with the mesh)")
        ->required();
    add_format(verb, a.format, field_format_names());
    add_options_of_metric(verb, a.metric);
    add_option(verb, "--gradation", a.metric.gradation,
               "Largest ratio of the sizes of adjacent edges; 0: not limited. Default: 2.5")
        ->check(zero_or(option_of(&config::Gradation::ratio).limits));
    add_option(verb, "--geometry-error", a.metric.geometry.chord_error,
               "Largest distance of chords from the boundary's own surface; 0 or none: any")
        ->check(at_least<double>(0))
        ->transform(none_as("0"));
    add_sizes(verb, a.sizes);
    verb->add_option_function<std::vector<std::string>>(
            "--intersect",
            [&a](const std::vector<std::string>& files) {
                for (const std::string& file : files) a.metric.intersect.push_back({file});
            },
            "A metric of the same mesh that is fixed too (" + endings_of_solutions() + "); again for more")
        ->allow_extra_args(false);
    add_flat(verb, a.flat);
    add_threads(verb, a.threads);
    return {[&a](const Host&) { return metric_command(a); }};
}

Work declare_transfer(CLI::App* verb, Arguments& all) {
    add_details(
        verb,
        "  camber transfer old.meshb new.meshb --solution u.solb -o v.solb\n"
        "  camber transfer old.meshb new.meshb --solution u.solb -o v.solb --method conserve\n\n"
        "Nodes that stayed where they were keep their values to the bit; others take the old field's value where they "
        "are in the old mesh, curved as it is, or at the nearest point of its boundary. conserve: where elements "
        "changed the field of least difference in L2 that keeps the integrals by material. More: "
        "docs/algorithms/transfer.md");
    TransferArguments& a = all.transfer;
    add_option(verb, "old", a.old_mesh, "The mesh of the solution (" + endings_of_input() + ")")->required();
    add_option(verb, "new", a.new_mesh, "The mesh that it is brought to")->required();
    add_solution(verb, a.solution, a.fields);
    add_option(verb, "-o,--output", a.output,
               "Where it goes (" + endings_of_solutions() + ", or .vtu with the new mesh)")
        ->required();
    add_format(verb, a.format, field_format_names());
    add_words(verb, "--method", a.options.method, "interpolate (the default), or conserve");
    add_words(verb, "--bounds", a.options.bounds,
              "conserve only: none (the default), or local: no value beyond the old ones around");
    add_flat(verb, a.flat);
    add_threads(verb, a.threads);
    return {[&a](const Host&) { return transfer_command(a); }};
}

Work declare_convert(CLI::App* verb, Arguments& all) {
    add_details(verb,
                "  camber convert wing.meshb -o wing.mesh                      binary to ASCII, and back\n"
                "  camber convert wing-p2.meshb -o wing.vtu --cells lagrange   for ParaView, Lagrange cells\n"
                "  camber convert wing.meshb -o wing.vtu --metric wing.solb    with a solution's fields\n"
                "  camber convert part.msh -o part.mfem                        from Gmsh to MFEM\n"
                "  camber convert wing-p2.meshb -o wing.pvtu --partition 64    for a solver on 64 processes\n"
                "  camber convert wing.solb -o wing.sol                        solutions alone\n"
                "  camber convert flow.vtu -o flow.sol                         the fields at a mesh's nodes\n\n"
                "What the format cannot hold is told on standard error. More: docs/formats.md");
    ConvertArguments& a = all.convert;
    add_option(verb, "input", a.input, mesh_or_solution())->required();
    add_option(verb, "-o,--output", a.output,
               "Mesh: " + listed(endings_written(mesh_formats())) +
                   "; solution: " + listed(endings_written(solution_formats())))
        ->required();
    add_format(verb, a.format, mesh_format_names());
    add_words(verb, "--cells", a.cells, "Cells of degree 2 in a .vtu: quadratic (the default) or lagrange");
    add_option(verb, "--metric", a.metric,
               "A solution on the mesh's vertices, whose fields go along (.vtu, .vtk, .msh, .cgns, .xdmf)");
    auto* const elevate =
        add_flag(verb, "--elevate", a.elevate, "Degree 1 to 2 first: each edge gets a node at its middle");
    add_flag(verb, "--straighten", a.straighten, "Degree 2 to 1 first: the nodes of edges are left out")
        ->excludes(elevate);
    add_option(verb, "--partition", a.partition,
               "In so many parts for a solver, by Scotch: files OUT.1.EXT … with the numbers of nodes and cells in the "
               "whole, beside it OUT with the field partition; or -o OUT.pvtu, which names its pieces")
        ->check(CLI::Range(std::size_t{1}, std::size_t{1} << 20U));
    add_read(verb, a.read);
    add_threads(verb, a.threads);
    add_force(verb, a.force);
    return {[&a](const Host& host) { return convert_command(a, host); }};
}

Work declare_generate(CLI::App* verb, Arguments& all) {
    add_details(
        verb,
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
    GenerateArguments& a = all.generate;
    add_option(verb, "shape", a.shape, "A shape's name, its JSON, or a file with that or with a config")->required();
    add_option(verb, "-o,--output", a.output,
               "Where the mesh goes (" + listed(endings_written(mesh_formats()), ", ") + ")")
        ->required();
    add_option(verb, "--set", a.settings, "One option of the shape: path=value")->type_name("PATH=VALUE");
    add_option(verb, "--elements", a.elements,
               "About so many tetrahedra or triangles (within 20 per cent, but for very few): sizes or cells are "
               "scaled, layers stay as they are")
        ->check(between<double>(1, static_cast<double>(max_entities)));
    add_words(verb, "--structure", a.structure,
              "Of a shell or annulus: " + std::string(option_of(&ShellOptions<3>::structure).sentence));
    add_format(verb, a.format, mesh_format_names());
    add_threads(verb, a.threads);
    add_flag(verb, "--print-config", a.print_config, "Print the pipeline that makes this mesh, and stop");
    return {[&a](const Host& host) { return generate_command(a, host); }};
}

}  // namespace camber::app
