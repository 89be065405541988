// Explanations of keys, and texts of values
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
module camber.config;
import camber.core;
import camber.metric;
import camber.solution_metric;
import camber.io;
import camber.shapes;
import camber.fields;
import camber.recipes;
import :codec;
import :description;

namespace camber::config {

namespace {

/// A text in lines of at most `width` letters, each with the indent.
std::string wrapped(const std::string& text, std::size_t indent, std::size_t width = 96) {
    std::istringstream words(text);
    std::string out, line, word;
    while (words >> word) {
        if (!line.empty() && indent + line.size() + 1 + word.size() > width) {
            out += std::string(indent, ' ') + line + "\n";
            line.clear();
        }
        line += (line.empty() ? "" : " ") + word;
    }
    return out + std::string(indent, ' ') + line + "\n";
}

/// A word that stands somewhere in a config, and what it says there.
struct Word {
    std::string name;
    std::string text;
};

struct Topic {
    std::string name;
    std::string text;
    std::vector<Word> words = {};  ///< of its options or alternatives
};

/// The keys of an option, and those of its values that are words.
template <class S>
void add_words(const Field<S>& option, const std::string& in, const std::string& text, std::vector<Word>& words) {
    const auto add = [&](const std::string& name) {
        words.push_back({name, fmt::format("{}, in {}\n{}\n  see also: camber explain {}\n", name, in, text, in)});
    };
    for (const std::string& key : option.keys) {
        add(key);
        const Json schema = option.schema(key, option.limits);
        if (!schema.contains("enum")) continue;
        for (const Json& value : schema["enum"])
            if (value.is_string() && value.get<std::string>() != key) add(value.get<std::string>());
    }
}

template <class S>
Topic topic_of_struct() {
    const auto& d = Described<S>::get();
    std::string text = fmt::format("{}\n\n{}", d.name, wrapped(d.doc, 2));
    if (d.fields.empty()) text += "\n  no options\n";
    const Json defaults = Codec<S>::write(S{});
    std::vector<Word> words;
    for (const auto& f : d.fields) {
        std::string facts = f.type(f.limits);
        if (!f.unit_name.empty()) facts += "; in " + f.unit_name;
        if (f.is_required)
            facts += "; required";
        else if (f.keys.size() == 1 && !defaults[f.keys[0]].is_structured())
            facts += "; default " + defaults[f.keys[0]].dump();
        const std::string option = fmt::format("\n  {}: {}\n{}", f.name, facts, wrapped(f.doc, 6));
        text += option;
        add_words(f, d.name, option, words);
    }
    return {d.name, std::move(text), std::move(words)};
}

template <class V>
Topic topic_of_choice() {
    const auto& c = Described<V>::get();
    std::string text = fmt::format("{}\n\n{}\n", c.name, wrapped(c.doc, 2));
    std::vector<Word> words;
    each_alternative<V>([&](auto index, auto sample) {
        const auto& [key, doc] = c.alternatives[index];
        text += fmt::format("  {:<12} {}\n", key, doc);
        words.push_back(
            {key, fmt::format("{0}\n\n{1}\n  in \"{2}\": {{\"{0}\": {3}}}\n  see also: camber explain {2}\n", key,
                              wrapped(doc, 2), c.name, Codec<decltype(sample)>::type({}))});
    });
    text += fmt::format("\n  in JSON: {}\n", Codec<V>::type({}));
    return {c.name, std::move(text), std::move(words)};
}

/// One topic a stage, and cycles of them and the output, which come after.
std::vector<Topic> with_stages(std::vector<Topic> topics) {
    each_alternative<Stage>([&](auto, auto stage) { topics.push_back(topic_of_struct<decltype(stage)>()); });
    topics.push_back(topic_of_struct<Adaptation>());
    topics.push_back(topic_of_struct<Output>());
    return topics;
}

/// Words of sources and operations that have no options of their own are topics as well.
std::vector<Topic> with_words(std::vector<Topic> topics) {
    for (const std::string_view choice : {"metric", "metric_operations"}) {
        const auto of = [&](std::string_view name) { return std::ranges::find(topics, name, &Topic::name); };
        const auto words = of(choice)->words;
        for (const Word& word : words)
            if (of(word.name) == topics.end()) topics.push_back({word.name, word.text});
    }
    return topics;
}

const std::vector<Topic>& all_topics() {
    static const std::vector<Topic> all = with_words(with_stages({topic_of_struct<Pipeline>(),
                                                                  topic_of_struct<Input>(),
                                                                  topic_of_struct<GivenSolution>(),
                                                                  topic_of_choice<Shape>(),
                                                                  topic_of_struct<ShellOptions<3>>(),
                                                                  topic_of_struct<ShellOptions<2>>(),
                                                                  topic_of_struct<BoxOptions<3>>(),
                                                                  topic_of_struct<BoxOptions<2>>(),
                                                                  topic_of_struct<BumpOptions>(),
                                                                  topic_of_struct<BoundaryLayer>(),
                                                                  topic_of_choice<Metric>(),
                                                                  topic_of_struct<NaturalMetric>(),
                                                                  topic_of_struct<ConstantMetric>(),
                                                                  topic_of_struct<SurfaceMetric>(),
                                                                  topic_of_struct<ReferenceSize>(),
                                                                  topic_of_struct<GeometryMetric>(),
                                                                  topic_of_struct<SolutionMetric>(),
                                                                  topic_of_choice<FieldMetric>(),
                                                                  topic_of_struct<LinearField>(),
                                                                  topic_of_struct<PolarOneField>(),
                                                                  topic_of_struct<PolarTwoField>(),
                                                                  topic_of_struct<PlanarShock>(),
                                                                  topic_of_struct<SphericalShock>(),
                                                                  topic_of_struct<RotatingField>(),
                                                                  topic_of_choice<MetricExpression>(),
                                                                  topic_of_choice<MetricOperation>(),
                                                                  topic_of_struct<Gradation>(),
                                                                  topic_of_struct<Bound>(),
                                                                  topic_of_struct<Complexity>(),
                                                                  topic_of_choice<Geometry>(),
                                                                  topic_of_struct<Surrogate>(),
                                                                  topic_of_struct<Straight>(),
                                                                  topic_of_struct<AnalyticSurface>(),
                                                                  topic_of_struct<Cad>(),
                                                                  topic_of_struct<Plane>(),
                                                                  topic_of_struct<Sphere>(),
                                                                  topic_of_struct<Cylinder>(),
                                                                  topic_of_struct<Torus>(),
                                                                  topic_of_struct<Features>(),
                                                                  topic_of_choice<Stage>()}));
    return all;
}

}  // namespace

std::vector<std::string> topics() {
    std::vector<std::string> names;
    for (const Topic& t : all_topics()) names.push_back(t.name);
    return names;
}

Outcome<std::string> explain(std::string_view topic) {
    for (const Topic& t : all_topics())
        if (t.name == topic) return t.text;
    std::string text;
    for (const Topic& t : all_topics())
        for (const Word& word : t.words)
            if (word.name == topic && text.find(word.text) == std::string::npos)
                text += (text.empty() ? "" : "\n") + word.text;
    if (!text.empty()) return text;
    return fail(ErrorKind::usage, "unknown topic", std::string(topic), {}, suggestion(topic, topics()));
}

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
