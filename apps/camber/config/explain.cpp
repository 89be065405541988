module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
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
import camber.fields;
import camber.shapes;
import camber.metric;
import camber.recipes;
import camber.solution_metric;
import camber.io;
import :codec;
import :description;
import :json;
import :text;
import :values;

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

}  // namespace camber::config
