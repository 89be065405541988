module;
#include <functional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <nlohmann/json.hpp>
module camber.config;
import camber.core;
import camber.io;
import :codec;
import :description;
import :json;
import :values;

namespace camber::config {

const Choice<MeshSource>& Described<MeshSource>::get() {
    static const std::string file = "a mesh file (" + listed(endings_read(mesh_formats()), ", ") + ")";
    static const Choice<MeshSource> choice{"source",
                                           "one of them: " + file + ", or an example domain",
                                           {{"mesh", file}, {"generate", "an example domain"}}};
    return choice;
}
const Words& Described<Flat>::get() {
    static const Words words{{"plane", "surface"}};
    return words;
}
const Description<Input>& Described<Input>::get() {
    using S = Input;
    static const Description<S> description{
        "input",
        "Where the mesh comes from.",
        {[] {
             auto source = inlined(&S::source);
             source.is_required = true;
             return source;
         }(),
         field("flat", &S::flat,
               "what a file's triangles are that have no tetrahedra and one z: a plane mesh in 2D, written with its z "
               "again; or a surface in space")},
        [](const S& s) -> std::string {
            const bool generated = std::holds_alternative<Shape>(s.source);
            return generated && s.flat != Flat::plane ? "\"flat\" is for a mesh file" : std::string();
        }};
    return description;
}

const Words& Described<Required>::get() {
    static const Words words{{"keep", "geometry"}};
    return words;
}
const Description<Features>& Described<Features>::get() {
    using S = Features;
    static const Description<S> description{
        "features",
        "What counts as a ridge where neither the file's edges nor references say so; what required entities of the "
        "boundary hold.",
        {field("ridge_angle", &S::ridge_angle, "facets that meet at more than this angle make a ridge")
             .unit("degrees")
             .above(0)
             .at_most(180),
         field("required_boundary", &S::required_boundary,
               "nodes of required edges and facets on the boundary: keep, where they are; geometry, onto it as all "
               "others. In the volume they always stay, and so do required vertices")},
        {}};
    return description;
}

const Words& Described<VtuCells>::get() {
    static const Words words{{"quadratic", "lagrange"}};
    return words;
}

const Description<Output>& Described<Output>::get() {
    using S = Output;
    static const Description<S> description{
        "output",
        "Files to write, relative to the working directory.",
        {field("mesh", &S::mesh,
               "the mesh, in the format of its ending (" + listed(endings_written(mesh_formats()), ", ") +
                   "); empty: none"),
         field("report", &S::report, "the figures of the run, as JSON; empty: none"),
         field(
             "vtu", &S::vtu,
             "the mesh with the run's fields (Jacobians, curvatures, gains, metric …) for ParaView (.vtu), beside the "
             "mesh; empty: none"),
         field("vtu_cells", &S::vtu_cells,
               "VTK's quadratic cells, which everything reads, or its Lagrange cells of degree 2"),
         field("plots", &S::plots, "a folder for histograms of the run as SVG files; empty: none")},
        {}};
    return description;
}

const Description<Pipeline>& Described<Pipeline>::get() {
    using S = Pipeline;
    static const Description<S> description{
        "pipeline",
        "A run of Camber: a mesh, a metric, a geometry, stages, outputs. Input paths are relative to the config's "
        "folder, output "
        "paths to the working directory.",
        {field("input", &S::input, "where the mesh comes from").required(),
         field("metric", &S::metric, "the field of sizes and directions that edges follow"),
         field("metric_operations", &S::metric_operations, "what is done to the metric first, in this order")
             .count(0, 1000),
         field("geometry", &S::geometry, "the shape that boundary nodes are put onto"),
         field("features", &S::features, "ridges of the boundary"),
         field("stages", &S::stages, "what is done, in this order").count(0, 1000),
         field("threads", &S::threads, "threads to use; 0: all that the machine has").at_least(0).at_most(4096),
         field("output", &S::output, "files to write")},
        {}};
    return description;
}

}  // namespace camber::config
