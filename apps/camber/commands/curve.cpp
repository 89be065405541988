module;
#include <algorithm>
#include <charconv>
#include <iterator>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>
module camber.commands;
import camber.core;
import camber.cad;
import camber.config;
import camber.solution_metric;

namespace camber::app {

namespace {

/// The number that the whole text is.
std::optional<double> number_of(const std::string& text) {
    double x = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), x);
    return error == std::errc{} && end == text.data() + text.size() ? std::optional(x) : std::nullopt;
}

Outcome<config::Metric> metric_of(const std::string& text) {
    if (const auto size = number_of(text)) {
        if (*size > 0) return config::Metric(config::ConstantMetric{.sizes = {*size}, .tensor = {}});
        return fail(ErrorKind::usage, text + " is no size", "--metric", {}, "give a positive one");
    }
    std::string with_point = text;
    std::ranges::replace(with_point, ',', '.');
    if (with_point != text && number_of(with_point))
        return fail(ErrorKind::usage, text + " is no size", "--metric", {}, "write it with a point: " + with_point);
    // An array is no file's name but JSON, though no metric either: the reader of configs says why.
    const auto first = text.find_first_not_of(" \t\n");
    if (first != std::string::npos && text[first] == '[')
        if (auto array = config::read_pipeline(text, "--metric"); !array) return fail(array.error());
    return config::read_metric(text, "--metric");
}

/// A solution's metric has all of it in itself: gradation within the search for its complexity.
void put_into(const MetricChoice& choice, std::vector<ReferenceSize> sizes, config::SolutionMetric& metric) {
    if (choice.complexity) {
        metric.vertices = metric.elements = 0;
        metric.complexity = *choice.complexity;
    }
    metric.gradation = choice.gradation.value_or(metric.gradation);
    metric.geometry.chord_error = choice.geometry_error.value_or(metric.geometry.chord_error);
    std::ranges::move(sizes, std::back_inserter(metric.sizes));
}

/// Whether a solution was given, and nothing else that edges are curved for. Fields of the input's own file go along.
bool is_for_solution(const CurveArguments& arguments) {
    const auto says = [](const std::string& setting) {
        return setting.find("objective") != std::string::npos || setting.starts_with("metric");
    };
    return !arguments.solution.given.empty() && !arguments.objective && !arguments.metric.metric &&
           std::ranges::none_of(arguments.settings, says);
}

}  // namespace

Outcome<config::Pipeline> pipeline_of(const CurveArguments& arguments) {
    auto pipeline = pipeline_of(R"({"input": {"mesh": "-"}})", arguments);
    if (!pipeline) return pipeline;
    if (auto set = set_metric(arguments.metric, *pipeline); !set) return fail(set.error());
    if (auto set = set_geometry(arguments.geometry, *pipeline); !set) return fail(set.error());
    const auto objective = is_for_solution(arguments) ? Objective::solution : arguments.objective;
    if (objective)
        for (config::Stage& stage : pipeline->stages)
            if (auto* curve = std::get_if<config::Curve>(&stage)) curve->objective = *objective;
    for (config::Stage& stage : pipeline->stages)
        if (auto* curve = std::get_if<config::Curve>(&stage)) {
            curve->blocks = arguments.blocks.value_or(curve->blocks);
            if (arguments.memory) curve->memory = static_cast<double>(*arguments.memory);
        }
    return pipeline;
}

Outcome<Done> set_metric(const MetricChoice& choice, config::Pipeline& pipeline) {
    if (choice.metric) {
        auto read = metric_of(*choice.metric);
        if (!read) return fail(read.error());
        pipeline.metric = std::move(*read);
    }
    auto sizes = read_sizes(choice.sizes);
    if (!sizes) return fail(sizes.error());
    if (auto* made = std::get_if<config::SolutionMetric>(&pipeline.metric)) {
        put_into(choice, std::move(sizes->sizes), *made);
        return Done{};
    }
    auto& operations = pipeline.metric_operations;
    if (!sizes->sizes.empty()) operations.emplace_back(config::Intersect{std::move(*sizes)});
    if (choice.geometry_error)
        operations.emplace_back(config::Intersect{config::GeometryMetric{.chord_error = *choice.geometry_error}});
    if (choice.gradation && *choice.gradation > 0)
        operations.emplace_back(config::Gradation{.ratio = *choice.gradation});
    if (choice.complexity) operations.emplace_back(config::Complexity{.target = *choice.complexity});
    return Done{};
}

Outcome<Done> set_geometry(const GeometryArguments& arguments, config::Pipeline& pipeline) {
    const auto& [geometry, cad, unit, vertices, seconds, memory, tolerance] = arguments;
    if (tolerance) pipeline.geometry_tolerance.nodes = *tolerance;
    if (unit && !cad)
        return fail(ErrorKind::usage, "is the unit of a CAD model, and there is none", "--cad-unit", {},
                    "give --cad too");
    if (vertices && !cad)
        return fail(ErrorKind::usage, "moves vertices onto a CAD model, and there is none", "--cad-vertices", {},
                    "give --cad too");
    config::Cad model;
    if (cad)
        model = {.file = {*cad},
                 .unit = unit.value_or(config::Cad{}.unit),
                 .vertices = vertices.value_or(config::Cad{}.vertices),
                 .seconds = seconds,
                 .memory = memory};
    if (cad) pipeline.geometry = model;
    if (!geometry) return Done{};
    auto read = config::read_geometry(*geometry, "--geometry");
    if (!read) return fail(read.error());
    if (!cad) {
        pipeline.geometry = std::move(*read);
        return Done{};
    }
    // Surfaces by reference go beside the model; any other geometry is one of all the boundary.
    auto* const beside = std::get_if<config::Analytic>(&*read);
    if (!beside)
        return fail(ErrorKind::usage, "is a geometry too", "--geometry", {},
                    "give it or --cad; beside a model \"analytic\" surfaces alone");
    model.analytic = std::move(beside->surfaces);
    pipeline.geometry = std::move(model);
    return Done{};
}

int curve_command(const CurveArguments& arguments, Host host) {
    return run_verb(pipeline_of(arguments), arguments, std::move(host));
}

}  // namespace camber::app
