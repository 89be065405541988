module;
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
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
import camber.reports;
import :codec;
import :description;

namespace camber::config {

namespace {

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

struct Word {
    std::string name;
    std::string text;
};

struct Topic {
    std::string name;
    std::string text;
    std::vector<Word> words = {};  ///< words of options or alternatives
};

void add_words(const Field& option, const std::string& in, const std::string& text, std::vector<Word>& words) {
    const auto add = [&](const std::string& name) {
        words.push_back({name, fmt::format("{}, in {}\n{}\n  see also: camber explain {}\n", name, in, text, in)});
    };
    for (const std::string& key : option.keys) {
        add(key);
        const Json schema = option.schema(key);
        if (!schema.contains("enum")) continue;
        for (const Json& value : schema["enum"])
            if (value.is_string() && value.get<std::string>() != key) add(value.get<std::string>());
    }
}

Topic topic_of(const Description& d) {
    std::string text = fmt::format("{}\n\n{}", d.name, wrapped(d.doc, 2));
    if (d.fields.empty()) text += "\n  no options\n";
    const Json defaults = d.defaults();
    std::vector<Word> words;
    for (const Field& f : d.fields) {
        std::string facts = f.type();
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

Topic topic_of(const Choice& c) {
    std::string text = fmt::format("{}\n\n{}\n", c.name, wrapped(c.doc, 2));
    std::vector<Word> words;
    for (const Alternative& a : c.alternatives) {
        text += fmt::format("  {:<12} {}\n", a.key, a.doc);
        words.push_back(
            {a.key, fmt::format("{0}\n\n{1}\n  in \"{2}\": {{\"{0}\": {3}}}\n  see also: camber explain {2}\n", a.key,
                                wrapped(a.doc, 2), c.name, a.codec->type({}))});
    }
    text += fmt::format("\n  in JSON: {}\n", c.type({}));
    return {c.name, std::move(text), std::move(words)};
}

template <class... T>
std::vector<Topic> topics_of() {
    return {topic_of(Described<T>::get())...};
}

std::vector<Topic> with_words(std::vector<Topic> topics) {
    for (const std::string_view choice : {"metric", "metric_operations"}) {
        const auto of = [&](std::string_view name) { return std::ranges::find(topics, name, &Topic::name); };
        const auto words = of(choice)->words;
        for (const Word& word : words)
            if (of(word.name) == topics.end()) topics.push_back({word.name, word.text});
    }
    return topics;
}

/// Stages follow the sections that they use.
const std::vector<Topic>& all_topics() {
    static const std::vector<Topic> all = with_words(
        topics_of<Pipeline, Input, SolutionInput, Shape, ShellOptions<3>, ShellOptions<2>, BoxOptions<3>, BoxOptions<2>,
                  BumpOptions, BoundaryLayer, Metric, NaturalMetric, ConstantMetric, SurfaceMetric, ReferenceSize,
                  GeometryMetric, SolutionMetric, FieldMetric, LinearField, PolarOneField, PolarTwoField, PlanarShock,
                  SphericalShock, RotatingField, MetricExpression, MetricOperation, Gradation, Bound, Complexity,
                  Geometry, Surrogate, Straight, AnalyticSurface, Cad, Plane, Sphere, Cylinder, Torus, Features, Stage,
                  Elevate, Curve, Validate, Relax, Commit, Reinsert, Collapse, Split, Swap, Smooth, Mend, Remesh,
                  Adaptation, Output>());
    return all;
}

}  // namespace

std::vector<std::string> topics() {
    std::vector<std::string> names;
    for (const Topic& t : all_topics()) names.push_back(t.name);
    return names;
}

std::vector<TopicGroup> topic_groups() {
    std::vector<TopicGroup> groups{
        {"Sections of a config", {}},
        {"Stages", Described<Stage>::get().keys()},
        {"Shapes", {"shell", "annulus", "box", "rectangle", "bump", "layer"}},
        {"Metrics",
         {"natural", "constant", "sizes", "geometry-sizes", "metric-of-solution", "field", "linear", "polar-1",
          "polar-2", "planar-shock", "spherical-shock", "rotating", "expression"}},
        {"Operations on metrics", Described<MetricOperation>::get().keys()},
        {"Geometries", {"surrogate", "straight", "analytic", "cad", "plane", "sphere", "cylinder", "torus"}}};
    const auto has = [](const TopicGroup& group, const std::string& topic) {
        return std::ranges::find(group.topics, topic) != group.topics.end();
    };
    for (const std::string& topic : topics())
        if (std::ranges::none_of(groups, [&](const TopicGroup& group) { return has(group, topic); }))
            groups.front().topics.push_back(topic);
    return groups;
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

Outcome<Json> parse_part(std::string_view text, std::string_view name) {
    const auto first = text.find_first_not_of(" \t\n");
    const bool is_json = first != std::string_view::npos && (text[first] == '{' || text[first] == '"');
    return is_json ? parse_json(text, name) : Outcome<Json>(Json(std::string(text)));
}

template <class T>
Outcome<T> read(const Json& json, const Place& place) {
    T value{};
    if (auto done = codec_of<T>().read(json, place, {}, &value); !done) return fail(std::move(done.error()));
    return value;
}

template <class T>
Outcome<T> read_part(std::string_view text, std::string_view name) {
    auto json = parse_part(text, name);
    if (!json) return fail(json.error());
    return read<T>(*json, {std::string(name), ""});
}

Outcome<Shape> shape_of(const Json& json, const Place& place) {
    if (!json.is_object() || !json.contains("input")) return read<Shape>(json, place);
    auto pipeline = read<Pipeline>(json, place);
    if (!pipeline) return fail(std::move(pipeline.error()));
    if (auto* shape = std::get_if<Shape>(&pipeline->input.source)) return *shape;
    return bad(place.at("input"), "the config reads a mesh instead of generating one",
               "use camber convert or camber run");
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
        // Overrides can refer to keys that the text omits.
        const Json defaults = written(Pipeline{});
        for (const auto& [key, value] : defaults.items())
            if (key != "input" && !json->contains(key)) (*json)[key] = value;
        for (const std::string& assignment : overrides)
            if (auto done = override_value(*json, assignment); !done) return fail(done.error());
    }
    return read<Pipeline>(*json, {std::string(name), ""});
}

Outcome<Pipeline> with_values(const Pipeline& pipeline, std::span<const std::string> overrides, std::string_view name) {
    Json json = written(pipeline);
    for (const std::string& assignment : overrides)
        if (auto done = override_value(json, assignment); !done) return fail(done.error());
    return read<Pipeline>(json, {std::string(name), ""});
}

Outcome<Metric> read_metric(std::string_view text, std::string_view name) {
    // A text with a dot or a slash is a file. Other words are files unless they resemble a metric's name.
    const bool is_json = text.find_first_of("{\"") != std::string_view::npos;
    const bool is_word = text.find_first_of("./\\") == std::string_view::npos;
    if (!is_json && !text.empty() && !(is_word && !nearest(text, Described<Metric>::get().keys()).empty()))
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
    // Overrides can refer to keys that the text omits.
    Json options = Described<Shape>::get().options(&*shape);
    for (const std::string& assignment : overrides)
        if (auto done = override_value(options, assignment); !done) return fail(done.error());
    return read<Shape>(Json{{name_of(*shape), std::move(options)}}, {"--set", ""});
}

std::string name_of(const Shape& shape) { return Described<Shape>::get().key(&shape); }

std::string write_pipeline(const Pipeline& pipeline) {
    return written(pipeline).dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

run::PipelineTexts parts_of(const Pipeline& pipeline) {
    const auto text = [](const Json& json) {
        return json.is_string() ? json.get<std::string>() : json.dump(-1, ' ', false, Json::error_handler_t::replace);
    };
    const Input& input = pipeline.input;
    const std::string flat = input.flat == Flat{} ? "" : " flat=" + text(written(input.flat));
    const auto* const file = std::get_if<FilePath>(&input.source);
    run::PipelineTexts parts{(file != nullptr ? file->path : text(written(input.source))) + flat,
                             text(written(pipeline.metric)),
                             text(written(pipeline.geometry)),
                             {},
                             {}};
    parts.metric_operations.reserve(pipeline.metric_operations.size());
    for (const MetricOperation& operation : pipeline.metric_operations)
        parts.metric_operations.push_back(text(written(operation)));
    parts.stages.reserve(pipeline.stages.size());
    const Choice& stages = Described<Stage>::get();
    for (const Stage& stage : pipeline.stages) {
        std::string line = stages.key(&stage);
        Stage by_default;
        stages.alternatives[stage.index()].emplace(&by_default);
        const Json options = stages.options(&stage), defaults = stages.options(&by_default);
        for (const auto& [key, value] : options.items())
            if (value != defaults[key]) line += " " + key + "=" + text(value);
        parts.stages.push_back(std::move(line));
    }
    return parts;
}

std::string pipeline_schema() {
    Json schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", "Camber pipeline"}};
    schema.update(codec_of<Pipeline>().schema({}));
    schema["properties"]["$schema"] = {{"type", "string"}, {"description", "URL or path of this schema, for editors"}};
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
