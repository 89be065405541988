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
import camber.io;
import camber.surface;
import camber.transfer;
import :codec;
import :description;
import :json;
import :values;

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

}  // namespace camber::config
