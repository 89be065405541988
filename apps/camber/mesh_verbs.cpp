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
               "Solution: a file of rows at the vertices or nodes (" + endings_of_solutions() +
                   "), or a mesh file with fields at its nodes (.vtu, .msh, .cgns)")
        ->required();
    add_option(verb, "--fields", fields,
               "Names of the fields to use, separated by commas. Fields of a solution file are field_1, field_2 … "
               "Default: all")
        ->delimiter(',');
}

/// Adds the options that the metric {"solution": …} also has.
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
        "Derivatives are recovered at the vertices: Hessians for elements of degree 1, third derivatives for elements "
        "of degree 2, from all nodes. They are one-sided at interfaces between materials. Fields, and the components "
        "of a vector, have equal weights, and their metrics are intersected. Sizes by reference and by the geometry "
        "are fixed. The part of the solution is scaled until the total metric, with gradation, has the complexity. "
        "Then camber remesh adapts the mesh to the metric, and camber transfer transfers the solution to the new mesh. "
        "More: docs/algorithms/metric-from-solution.md");
    MetricArguments& a = all.metric;
    add_mesh(verb, a.input);
    add_solution(verb, a.solution, a.metric.fields);
    add_option(verb, "-o,--output", a.output,
               "Output file of the metric (" + endings_of_solutions() + ", or .vtu with the mesh)")
        ->required();
    add_format(verb, a.format, field_format_names());
    add_options_of_metric(verb, a.metric);
    add_option(verb, "--gradation", a.metric.gradation,
               "Largest ratio of the sizes of adjacent edges; 0: no limit. Default: 2.5")
        ->check(zero_or(option_of(&config::Gradation::ratio).limits));
    add_option(verb, "--geometry-error", a.metric.geometry.chord_error,
               "Largest distance of chords from the surface of the boundary, in model units; 0 or none: no limit")
        ->check(at_least<double>(0))
        ->transform(none_as("0"));
    add_sizes(verb, a.sizes);
    verb->add_option_function<std::vector<std::string>>(
            "--intersect",
            [&a](const std::vector<std::string>& files) {
                for (const std::string& file : files) a.metric.intersect.push_back({file});
            },
            "Metric of the same mesh to intersect with. It is not scaled (" + endings_of_solutions() +
                "); again for more")
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
        "Nodes that did not move preserve their values exactly. Other nodes take the value of the old field at their "
        "position in the old curved mesh, or at the nearest point of its boundary. In changed elements, conserve takes "
        "the field with the smallest L2 difference that preserves the integral over each material. More: "
        "docs/algorithms/transfer.md");
    TransferArguments& a = all.transfer;
    add_option(verb, "old", a.old_mesh, "Mesh of the solution (" + endings_of_input() + ")")->required();
    add_option(verb, "new", a.new_mesh, "Mesh to which the solution is transferred")->required();
    add_solution(verb, a.solution, a.fields);
    add_option(verb, "-o,--output", a.output,
               "Output solution file (" + endings_of_solutions() + ", or .vtu with the new mesh)")
        ->required();
    add_format(verb, a.format, field_format_names());
    add_words(verb, "--method", a.options.method, "Method of transfer: interpolate (the default), or conserve");
    add_words(verb, "--bounds", a.options.bounds,
              "Bounds of values, for conserve only. none: no bounds (the default); local: values stay within the old "
              "values around");
    add_flat(verb, a.flat);
    add_threads(verb, a.threads);
    return {[&a](const Host&) { return transfer_command(a); }};
}

Work declare_convert(CLI::App* verb, Arguments& all) {
    add_details(verb,
                "  camber convert wing.meshb -o wing.mesh                      binary to ASCII, and back\n"
                "  camber convert wing-p2.meshb -o wing.vtu --cells lagrange   for ParaView, Lagrange cells\n"
                "  camber convert wing.meshb -o wing.vtu --metric wing.solb    with the fields of a solution\n"
                "  camber convert part.msh -o part.mfem                        from Gmsh to MFEM\n"
                "  camber convert wing-p2.meshb -o wing.pvtu --partition 64    for a solver on 64 processes\n"
                "  camber convert wing.solb -o wing.sol                        only a solution\n"
                "  camber convert flow.vtu -o flow.sol                         the fields at the nodes of a mesh\n\n"
                "Data that the output format cannot store is reported on standard error. More: docs/formats.md");
    ConvertArguments& a = all.convert;
    add_option(verb, "input", a.input, mesh_or_solution())->required();
    add_option(verb, "-o,--output", a.output,
               "Mesh: " + listed(writable_extensions(mesh_formats())) +
                   "; solution: " + listed(writable_extensions(solution_formats())))
        ->required();
    add_format(verb, a.format, mesh_format_names());
    add_words(verb, "--cells", a.cells, "Cells of degree 2 in a .vtu file: quadratic (the default) or lagrange");
    add_option(verb, "--metric", a.metric,
               "Solution at the vertices of the mesh. Its fields are written with the mesh (.vtu, .vtk, .msh, .cgns, "
               ".xdmf)");
    auto* const elevate =
        add_flag(verb, "--elevate", a.elevate, "Convert degree 1 to 2 first: each edge gets a node at its middle");
    add_flag(verb, "--straighten", a.straighten, "Convert degree 2 to 1 first: the nodes of edges are removed")
        ->excludes(elevate);
    add_option(verb, "--partition", a.partition,
               "Number of parts of the mesh for a parallel solver, computed by Scotch. The files OUT.1.EXT … have the "
               "global numbers of nodes and cells; OUT has the field partition. With -o OUT.pvtu, that file lists the "
               "pieces")
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
        "  camber generate box -o box.msh --set 'cells=[20, 10, 10]' --set 'high=[2, 1, 1]'      a structured box\n"
        "  camber generate rectangle -o square.vtu --set 'grading=[1, 50]' --set warp=0.04       in 2D, graded, "
        "warped\n"
        "  camber generate bump -o channel.mesh --set floor_layer/count=8                        a channel with a "
        "layer\n"
        "  camber generate '{\"box\": {\"cells\": [9, 9, 9]}}' -o box.meshb                      the JSON of configs\n"
        "  camber generate configs/spheres.json -o spheres.meshb                                 the input mesh of a "
        "config\n\n"
        "Options of a shape: camber explain shell (annulus, box, rectangle, bump, layer). Options of layers are "
        "inner_layer/count and so on. The same options give the same file for any number of threads. More: "
        "docs/algorithms/delaunay-and-shapes.md");
    GenerateArguments& a = all.generate;
    add_option(verb, "shape", a.shape, "Name of a shape, its JSON, or a file with that JSON or with a config")
        ->required();
    add_option(verb, "-o,--output", a.output,
               "Output mesh file (" + listed(writable_extensions(mesh_formats()), ", ") + ")")
        ->required();
    add_option(verb, "--set", a.settings, "Set one option of the shape: path=value")->type_name("PATH=VALUE");
    add_option(verb, "--elements", a.elements,
               "Approximate number of tetrahedra or triangles, within 20 percent except for very small numbers. Sizes "
               "or cells are scaled, layers are not")
        ->check(between<double>(1, static_cast<double>(max_entities)));
    add_words(verb, "--structure", a.structure,
              "Structure of a shell or annulus. " + std::string(option_of(&ShellOptions<3>::structure).sentence));
    add_format(verb, a.format, mesh_format_names());
    add_threads(verb, a.threads);
    add_flag(verb, "--print-config", a.print_config, "Print the pipeline that generates this mesh, and stop");
    return {[&a](const Host& host) { return generate_command(a, host); }};
}

}  // namespace camber::app
