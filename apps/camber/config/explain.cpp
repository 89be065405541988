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
import camber.io;
import camber.cavity;
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

struct Topic {
    std::string name;
    std::string text;
};

template <class S>
Topic topic_of_struct() {
    const auto& d = Described<S>::get();
    std::string text = fmt::format("{}\n\n{}", d.name, wrapped(d.doc, 2));
    if (d.fields.empty()) text += "\n  no options\n";
    const Json defaults = Codec<S>::write(S{});
    for (const auto& f : d.fields) {
        std::string facts = f.type(f.limits);
        if (!f.unit_name.empty()) facts += "; in " + f.unit_name;
        if (f.is_required)
            facts += "; required";
        else if (f.keys.size() == 1 && !defaults[f.keys[0]].is_structured())
            facts += "; default " + defaults[f.keys[0]].dump();
        text += fmt::format("\n  {}: {}\n{}", f.name, facts, wrapped(f.doc, 6));
    }
    return {d.name, std::move(text)};
}

template <class V>
Topic topic_of_choice() {
    const auto& c = Described<V>::get();
    std::string text = fmt::format("{}\n\n{}\n", c.name, wrapped(c.doc, 2));
    for (const auto& a : c.alternatives) text += fmt::format("  {:<12} {}\n", a.key, a.doc);
    text += fmt::format("\n  in JSON: {}\n", Codec<V>::type({}));
    return {c.name, std::move(text)};
}

/// The words of a choice that have no options of their own to be a topic by.
template <class V>
void add_words(std::vector<Topic>& topics) {
    const auto& choice = Described<V>::get();
    each_alternative<V>([&](auto index, auto sample) {
        const auto& word = choice.alternatives[index];
        const auto same = [&](const Topic& t) { return t.name == word.key; };
        if (std::any_of(topics.begin(), topics.end(), same)) return;
        topics.push_back(
            {word.key, fmt::format("{0}\n\n{1}\n  in \"{2}\": {{\"{0}\": {3}}}\n  see also: camber "
                                   "explain {2}\n",
                                   word.key, wrapped(word.doc, 2), choice.name, Codec<decltype(sample)>::type({}))});
    });
}

/// One topic a stage, and the output, which is what comes after them.
std::vector<Topic> with_stages(std::vector<Topic> topics) {
    each_alternative<Stage>([&](auto, auto stage) { topics.push_back(topic_of_struct<decltype(stage)>()); });
    topics.push_back(topic_of_struct<Output>());
    return topics;
}

std::vector<Topic> with_words(std::vector<Topic> topics) {
    add_words<Metric>(topics);
    add_words<MetricOperation>(topics);
    return topics;
}

const std::vector<Topic>& all_topics() {
    static const std::vector<Topic> all = with_words(with_stages({topic_of_struct<Pipeline>(),
                                                                  topic_of_struct<Input>(),
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
    return fail(ErrorKind::usage, "unknown topic", std::string(topic), {}, suggestion(topic, topics()));
}

}  // namespace camber::config
