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

const Choice& Described<MeshSource>::get() {
    static const std::string file = "a mesh file (" + camber::listed(endings_read(mesh_formats()), ", ") + ")";
    static const Choice choice =
        choice_of<MeshSource>("source", "one of them: " + file + ", or an example domain", key<FilePath>("mesh", file),
                              key<Shape>("generate", "an example domain"));
    return choice;
}
const Description& Described<Input>::get() {
    using S = Input;
    static const Description description =
        described<S>("input", "Where the mesh comes from.", {inlined(&S::source), field<S>(option_of(&S::flat))},
                     [](const S& s) -> std::string {
                         const bool generated = std::holds_alternative<Shape>(s.source);
                         return generated && s.flat != Flat::plane ? "\"flat\" is for a mesh file" : std::string();
                     });
    return description;
}

const Description& Described<GivenSolution>::get() {
    static const Description description = described<GivenSolution>(
        "solution",
        "Fields at the nodes of the input's mesh. They go along to the mesh that is made; a metric may be made for "
        "them, and nodes of edges placed (the objective solution).",
        [](const GivenSolution& s) -> std::string {
            if (!s.file.empty() && !s.expression.empty()) return "\"file\" and \"expression\" are two solutions";
            if (!s.expression.empty() && !s.fields.empty()) return "\"fields\" are names of a file's";
            if (!std::ranges::all_of(s.weights, [](double w) { return w >= 0; })) return "\"weights\" are 0 or more";
            return {};
        });
    return description;
}

const Description& Described<Features>::get() {
    static const Description description = described<Features>(
        "features",
        "What counts as a ridge where neither the file's edges nor references say so; what required entities of the "
        "boundary hold.");
    return description;
}

const Description& Described<BoundaryTolerance>::get() {
    static const Description description = described<BoundaryTolerance>(
        "geometry_tolerance",
        "Largest distances from the geometry at which nodes and vertices of the boundary count as being on it. A run "
        "whose result exceeds them ends with exit code 1.");
    return description;
}

const Description& Described<Output>::get() {
    static const Description description = described<Output>(
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
        });
    return description;
}

const Description& Described<Pipeline>::get() {
    static const Description description = described<Pipeline>(
        "pipeline",
        "A run of Camber: a mesh, a metric, a geometry, stages, outputs. Input paths are relative to the config's "
        "folder, output "
        "paths to the working directory.");
    return description;
}

const Description& Described<Elevate>::get() {
    static const Description description = described<Elevate>(
        "elevate", "Linear to quadratic: each edge gets a node at its middle; no point of the mesh moves.");
    return description;
}

const Description& Described<Curve>::get() {
    static const Description description = described<Curve>(
        "curve",
        "Moves each edge's node: boundary nodes onto the geometry, volume nodes where the objective asks for "
        "them: by default where what the metric is made for is interpolated best.");
    return description;
}

const Description& Described<Validate>::get() {
    static const Description description =
        described<Validate>("validate", "Judges every element by certified bounds of its Jacobian's determinant.");
    return description;
}

const Description& Described<Relax>::get() {
    static const Description description =
        described<Relax>("relax",
                         "Repairs what is not valid, at the least loss of what the stage before "
                         "wanted: volume edges first, surface edges "
                         "last.");
    return description;
}

const Description& Described<Commit>::get() {
    static const Description description = described<Commit>("commit", "Makes the planned nodes the mesh's own.");
    return description;
}

const Description& Described<Reinsert>::get() {
    static const Description description = described<Reinsert>(
        "reinsert",
        "The paper's global algorithm: every vertex is put in again where it is, by the cavity operator with its ball "
        "as "
        "the cavity, and the nodes of its edges go to where curve wants them, or a part of the way. No element that is "
        "valid stops being so at any time. In place of curve, validate, relax and commit. Of the options of relax its "
        "bounds count.");
    return description;
}

const Description& Described<Collapse>::get() {
    static const Description description =
        described<Collapse>("collapse",
                            "Of a mesh of degree 1 or 2: edges that are short in the metric go, "
                            "one end into the other, the shortest first.");
    return description;
}

const Description& Described<Split>::get() {
    static const Description description = described<Split>(
        "split",
        "Of a mesh of degree 1 or 2: edges that are long in the metric get a vertex at their middle by length, the "
        "longest first; those of the boundary on the geometry. The halves of a curved one keep its curve.");
    return description;
}

const Description& Described<Swap>::get() {
    static const Description description =
        described<Swap>("swap",
                        "Of a mesh of degree 1 or 2: edges and faces of bad elements are "
                        "exchanged where the worst element becomes better for it.");
    return description;
}

const Description& Described<Smooth>::get() {
    static const Description description =
        described<Smooth>("smooth",
                          "Of a mesh of degree 1 or 2: vertices move to where their edges are "
                          "nearer to unit, as far as the worst element around "
                          "them becomes better; those of smooth surfaces on the geometry.");
    return description;
}

const Description& Described<Mend>::get() {
    static const Description description = described<Mend>(
        "improve", "Of a mesh of degree 1 or 2: swaps and moves for bad elements alone, turn after turn.");
    return description;
}

const Description& Described<Remesh>::get() {
    static const Description description = described<Remesh>(
        "remesh",
        "Brings a mesh to the metric, of degree 1, or of degree 2 with its curves (after commit, or as it was read): "
        "rounds of collapse, split, swap and smooth, until edges are of unit length and nothing changes much; improve "
        "at "
        "last. References, materials, interfaces, ridges, listed curves, corners and whatever is required are kept, "
        "and no valid element becomes an invalid one. The metric is made of the mesh as it is before; the geometry "
        "too, and what follows is curved onto it.");
    return description;
}

const Choice& Described<Stage>::get() {
    static const Choice choice = choice_of<Stage>(
        "stages", "One step of the pipeline.", key<Elevate>("elevate", "linear to quadratic"),
        key<Curve>("curve", "plan where nodes go"), key<Validate>("validate", "judge every element"),
        key<Relax>("relax", "repair what is not valid"), key<Commit>("commit", "make the plan the mesh"),
        key<Reinsert>("reinsert", "curve cavity by cavity"), key<Collapse>("collapse", "remove short edges"),
        key<Split>("split", "divide long edges"), key<Swap>("swap", "exchange edges and faces of bad elements"),
        key<Smooth>("smooth", "move vertices"), key<Mend>("improve", "swap and move for bad elements alone"),
        key<Remesh>("remesh", "bring a mesh to the metric"));
    return choice;
}

}  // namespace camber::config
