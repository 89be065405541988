// Descriptions of pipelines and stages
module;
#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <variant>
#include <vector>
#include <nlohmann/json.hpp>
module camber.config;
import camber.core;
import camber.metric;
import camber.edge_optimisation;
import camber.transfer;
import camber.validity;
import camber.io;
import camber.surface;
import camber.operation;
import camber.adapt;
import camber.curving;
import camber.repair;
import camber.recipes;
import :codec;
import :description;

namespace camber::config {

const Choice<MeshSource>& Described<MeshSource>::get() {
    static const std::string file = "a mesh file (" + camber::listed(endings_read(mesh_formats()), ", ") + ")";
    static const auto choice =
        choice_of<MeshSource>("source", "one of them: " + file + ", or an example domain", key<FilePath>("mesh", file),
                              key<Shape>("generate", "an example domain"));
    return choice;
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
         field<S>(option_of(&S::flat))},
        [](const S& s) -> std::string {
            const bool generated = std::holds_alternative<Shape>(s.source);
            return generated && s.flat != Flat::plane ? "\"flat\" is for a mesh file" : std::string();
        }};
    return description;
}

const Description<GivenSolution>& Described<GivenSolution>::get() {
    static const Description<GivenSolution> description{
        "solution",
        "Fields at the nodes of the input's mesh. They go along to the mesh that is made; a metric may be made for "
        "them, and nodes of edges placed (the objective solution).",
        listed<GivenSolution>(), [](const GivenSolution& s) -> std::string {
            if (!s.file.empty() && !s.expression.empty()) return "\"file\" and \"expression\" are two solutions";
            if (!s.expression.empty() && !s.fields.empty()) return "\"fields\" are names of a file's";
            if (!std::ranges::all_of(s.weights, [](double w) { return w >= 0; })) return "\"weights\" are 0 or more";
            return {};
        }};
    return description;
}

const Description<Features>& Described<Features>::get() {
    static const Description<Features> description{
        "features",
        "What counts as a ridge where neither the file's edges nor references say so; what required entities of the "
        "boundary hold.",
        listed<Features>(),
        {}};
    return description;
}

const Description<BoundaryTolerance>& Described<BoundaryTolerance>::get() {
    static const Description<BoundaryTolerance> description{
        "geometry_tolerance",
        "Largest distances from the geometry at which nodes and vertices of the boundary count as being on it. A run "
        "whose result exceeds them ends with exit code 1.",
        listed<BoundaryTolerance>(),
        {}};
    return description;
}

const Description<Output>& Described<Output>::get() {
    static const Description<Output> description{
        "output", "Files to write, relative to the working directory.",
        [] {
            auto fields = listed<Output>();
            for (auto& field : fields) {
                if (field.name == option_of(&Output::mesh).name)
                    field.doc = "the mesh, in the format of its ending (" +
                                camber::listed(endings_written(mesh_formats()), ", ") + "); empty: none";
                if (field.name == option_of(&Output::format).name)
                    field.doc += " (" + camber::listed(names_written(mesh_formats()), ", ", ", ") + ")";
            }
            return fields;
        }(),
        [](const Output& o) -> std::string {
            const auto names = names_written(mesh_formats());
            if (o.format.empty() || std::ranges::find(names, o.format) != names.end()) return {};
            return "\"format\": " + in_quotes(o.format) + " is no format that is written (" +
                   suggestion(o.format, {names.begin(), names.end()}) + ")";
        }};
    return description;
}

const Description<Pipeline>& Described<Pipeline>::get() {
    static const Description<Pipeline> description{
        "pipeline",
        "A run of Camber: a mesh, a metric, a geometry, stages, outputs. Input paths are relative to the config's "
        "folder, output "
        "paths to the working directory.",
        listed<Pipeline>(),
        {}};
    return description;
}

const Description<Elevate>& Described<Elevate>::get() {
    static const Description<Elevate> description{
        "elevate", "Linear to quadratic: each edge gets a node at its middle; no point of the mesh moves.", {}, {}};
    return description;
}

const Description<Curve>& Described<Curve>::get() {
    static const Description<Curve> description{
        "curve",
        "Moves each edge's node: boundary nodes onto the geometry, volume nodes where the objective asks for "
        "them: by default where what the metric is made for is interpolated best.",
        listed<Curve>(),
        {}};
    return description;
}

const Description<Validate>& Described<Validate>::get() {
    static const Description<Validate> description{
        "validate", "Judges every element by certified bounds of its Jacobian's determinant.", listed<Validate>(), {}};
    return description;
}

const Description<Relax>& Described<Relax>::get() {
    static const Description<Relax> description{"relax",
                                                "Repairs what is not valid, at the least loss of what the stage before "
                                                "wanted: volume edges first, surface edges "
                                                "last.",
                                                listed<Relax>(),
                                                {}};
    return description;
}

const Description<Commit>& Described<Commit>::get() {
    static const Description<Commit> description{"commit", "Makes the planned nodes the mesh's own.", {}, {}};
    return description;
}

const Description<Reinsert>& Described<Reinsert>::get() {
    static const Description<Reinsert> description{
        "reinsert",
        "The paper's global algorithm: every vertex is put in again where it is, by the cavity operator with its ball "
        "as "
        "the cavity, and the nodes of its edges go to where curve wants them, or a part of the way. No element that is "
        "valid stops being so at any time. In place of curve, validate, relax and commit. Of the options of relax its "
        "bounds count.",
        listed<Reinsert>(),
        {}};
    return description;
}

const Description<Collapse>& Described<Collapse>::get() {
    static const Description<Collapse> description{"collapse",
                                                   "Of a mesh of degree 1 or 2: edges that are short in the metric go, "
                                                   "one end into the other, the shortest first.",
                                                   listed<Collapse>(),
                                                   {}};
    return description;
}

const Description<Split>& Described<Split>::get() {
    static const Description<Split> description{
        "split",
        "Of a mesh of degree 1 or 2: edges that are long in the metric get a vertex at their middle by length, the "
        "longest first; those of the boundary on the geometry. The halves of a curved one keep its curve.",
        listed<Split>(),
        {}};
    return description;
}

const Description<Swap>& Described<Swap>::get() {
    static const Description<Swap> description{"swap",
                                               "Of a mesh of degree 1 or 2: edges and faces of bad elements are "
                                               "exchanged where the worst element becomes better for it.",
                                               listed<Swap>(),
                                               {}};
    return description;
}

const Description<Smooth>& Described<Smooth>::get() {
    static const Description<Smooth> description{"smooth",
                                                 "Of a mesh of degree 1 or 2: vertices move to where their edges are "
                                                 "nearer to unit, as far as the worst element around "
                                                 "them becomes better; those of smooth surfaces on the geometry.",
                                                 listed<Smooth>(),
                                                 {}};
    return description;
}

const Description<Mend>& Described<Mend>::get() {
    static const Description<Mend> description{
        "mend",
        "Of a mesh of degree 1 or 2: swaps and moves for bad elements alone, turn after turn.",
        listed<Mend>(),
        {}};
    return description;
}

const Description<Remesh>& Described<Remesh>::get() {
    static const Description<Remesh> description{
        "remesh",
        "Brings a mesh to the metric, of degree 1, or of degree 2 with its curves (after commit, or as it was read): "
        "rounds of collapse, split, swap and smooth, until edges are of unit length and nothing changes much; mend at "
        "last. References, materials, interfaces, ridges, listed curves, corners and whatever is required are kept, "
        "and no valid element becomes an invalid one. The metric is made of the mesh as it is before; the geometry "
        "too, and what follows is curved onto it.",
        listed<Remesh>(),
        {}};
    return description;
}

const Choice<Stage>& Described<Stage>::get() {
    static const auto choice = choice_of<Stage>(
        "stages", "One step of the pipeline.", key<Elevate>("elevate", "linear to quadratic"),
        key<Curve>("curve", "plan where nodes go"), key<Validate>("validate", "judge every element"),
        key<Relax>("relax", "repair what is not valid"), key<Commit>("commit", "make the plan the mesh"),
        key<Reinsert>("reinsert", "curve cavity by cavity"), key<Collapse>("collapse", "remove short edges"),
        key<Split>("split", "divide long edges"), key<Swap>("swap", "exchange edges and faces of bad elements"),
        key<Smooth>("smooth", "move vertices"), key<Mend>("mend", "swap and move for bad elements alone"),
        key<Remesh>("remesh", "bring a mesh to the metric"));
    return choice;
}

}  // namespace camber::config
