module;
#include <array>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include <nlohmann/json.hpp>
module camber.config;
import camber.core;
import camber.fields;
import camber.shapes;
import camber.metric;
import camber.io;
import :codec;
import :description;
import :json;
import :text;
import :values;

namespace camber::config {

namespace {

/// A part given as an argument: JSON when it looks so, else one word.
Outcome<Json> parse_part(std::string_view text, std::string_view name) {
    const auto first = text.find_first_not_of(" \t\n");
    const bool is_json = first != std::string_view::npos && (text[first] == '{' || text[first] == '"');
    return is_json ? parse_json(text, name) : Outcome<Json>(Json(std::string(text)));
}

template <class T>
Outcome<T> read_part(std::string_view text, std::string_view name) {
    auto json = parse_part(text, name);
    if (!json) return fail(json.error());
    return Codec<T>::read(*json, {std::string(name), ""}, {});
}

/// The shape that JSON describes alone, or as the input of a whole pipeline.
Outcome<Shape> shape_of(const Json& json, const Place& place) {
    if (!json.is_object() || !json.contains("input")) return Codec<Shape>::read(json, place, {});
    auto pipeline = Codec<Pipeline>::read(json, place, {});
    if (!pipeline) return fail(std::move(pipeline.error()));
    if (auto* shape = std::get_if<Shape>(&pipeline->input.source)) return *shape;
    return bad(place.at("input"), "reads a mesh, it generates none", "use camber convert, or camber run");
}

void put_below(FilePath& file, std::string_view folder) {
    const std::filesystem::path path(file.path);
    if (!file.path.empty() && file.path != "-" && path.is_relative())  // "-": standard input
        file.path = (std::filesystem::path(folder) / path).lexically_normal().string();
}

void put_below(Metric& metric, std::string_view folder) {
    if (auto* file = std::get_if<FilePath>(&metric)) put_below(*file, folder);
    if (auto* solution = std::get_if<SolutionMetric>(&metric))
        for (FilePath& file : solution->intersect) put_below(file, folder);
}

}  // namespace

Outcome<Pipeline> read_pipeline(std::string_view text, std::string_view name, std::span<const std::string> overrides) {
    auto json = parse_json(text, name);
    if (!json) return fail(json.error());
    if (!overrides.empty() && json->is_object()) {
        // Overrides may name what the text leaves to the defaults.
        const Json defaults = Codec<Pipeline>::write({});
        for (const auto& [key, value] : defaults.items())
            if (key != "input" && !json->contains(key)) (*json)[key] = value;
        for (const std::string& assignment : overrides)
            if (auto done = override_value(*json, assignment); !done) return fail(done.error());
    }
    return Codec<Pipeline>::read(*json, {std::string(name), ""}, {});
}

Outcome<Metric> read_metric(std::string_view text, std::string_view name) {
    // A file is meant by what has an ending or a folder, and by a word that is not near to one of the metric's own.
    const bool is_json = text.find_first_of("{\"") != std::string_view::npos;
    const bool is_word = text.find_first_of("./\\") == std::string_view::npos;
    if (!is_json && !text.empty() && !(is_word && !nearest(text, Codec<Metric>::keys()).empty()))
        return Metric(FilePath{std::string(text)});
    return read_part<Metric>(text, name);
}

Outcome<Geometry> read_geometry(std::string_view text, std::string_view name) {
    return read_part<Geometry>(text, name);
}

Outcome<Shape> read_shape(std::string_view text, std::string_view name, std::span<const std::string> overrides) {
    auto json = parse_part(text, name);
    if (!json) return fail(json.error());
    auto shape = shape_of(*json, {std::string(name), ""});
    if (!shape || overrides.empty()) return shape;
    // Overrides may name what the text leaves to the defaults.
    Json options = Codec<Shape>::options(*shape);
    for (const std::string& assignment : overrides)
        if (auto done = override_value(options, assignment); !done) return fail(done.error());
    return Codec<Shape>::read(Json{{name_of(*shape), std::move(options)}}, {"--set", ""}, {});
}

std::string name_of(const Shape& shape) { return Codec<Shape>::key(shape); }

std::string write_pipeline(const Pipeline& pipeline) {
    return Codec<Pipeline>::write(pipeline).dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Parts parts_of(const Pipeline& pipeline) {
    const auto text = [](const Json& json) {
        return json.is_string() ? json.get<std::string>() : json.dump(-1, ' ', false, Json::error_handler_t::replace);
    };
    const Input& input = pipeline.input;
    const std::string flat = input.flat == Flat{} ? "" : " flat=" + text(Codec<Flat>::write(input.flat));
    const auto* const file = std::get_if<FilePath>(&input.source);
    Parts parts{(file != nullptr ? file->path : text(Codec<MeshSource>::write(input.source))) + flat,
                text(Codec<Metric>::write(pipeline.metric)),
                text(Codec<Geometry>::write(pipeline.geometry)),
                {},
                {}};
    parts.metric_operations.reserve(pipeline.metric_operations.size());
    for (const MetricOperation& operation : pipeline.metric_operations)
        parts.metric_operations.push_back(text(Codec<MetricOperation>::write(operation)));
    parts.stages.reserve(pipeline.stages.size());
    for (const Stage& stage : pipeline.stages) {
        std::string line = Codec<Stage>::key(stage);
        const Json options = Codec<Stage>::options(stage);
        const Json defaults =
            std::visit([](const auto& s) { return Codec<std::remove_cvref_t<decltype(s)>>::write({}); }, stage);
        for (const auto& [key, value] : options.items())
            if (value != defaults[key]) line += " " + key + "=" + text(value);
        parts.stages.push_back(std::move(line));
    }
    return parts;
}

std::string pipeline_schema() {
    Json schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", "Camber pipeline"}};
    schema.update(Codec<Pipeline>::schema({}));
    schema["properties"]["$schema"] = {{"type", "string"}, {"description", "this schema, for editors"}};
    return schema.dump(2) + "\n";
}

Pipeline with_inputs_below(Pipeline pipeline, std::string_view folder) {
    if (auto* file = std::get_if<FilePath>(&pipeline.input.source)) put_below(*file, folder);
    FilePath of_solution{pipeline.solution.file};
    put_below(of_solution, folder);
    pipeline.solution.file = of_solution.path;
    put_below(pipeline.metric, folder);
    if (auto* cad = std::get_if<Cad>(&pipeline.geometry)) put_below(cad->file, folder);
    if (auto* other = std::get_if<FilePath>(&pipeline.geometry)) put_below(*other, folder);
    FilePath of_metric{pipeline.metric_mesh};
    put_below(of_metric, folder);
    pipeline.metric_mesh = of_metric.path;
    for (MetricOperation& operation : pipeline.metric_operations)
        if (auto* intersect = std::get_if<Intersect>(&operation)) put_below(intersect->metric, folder);
    return pipeline;
}

}  // namespace camber::config
