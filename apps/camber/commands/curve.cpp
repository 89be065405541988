module;
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.commands;
import camber.core;
import camber.config;

namespace camber::app {

namespace {

Outcome<config::Metric> metric_of(const std::string& text) {
    // An array is no file's name but JSON, though no metric either: the reader of configs says why.
    const auto first = text.find_first_not_of(" \t\n");
    if (first != std::string::npos && text[first] == '[')
        if (auto array = config::read_pipeline(text, "--metric"); !array) return fail(array.error());
    return config::read_metric(text, "--metric");
}

Outcome<config::Pipeline> curving(const CurveArguments& arguments) {
    auto pipeline = pipeline_of(R"({"input": {"mesh": "-"}})", arguments);
    if (!pipeline) return pipeline;
    if (arguments.metric) {
        auto metric = metric_of(*arguments.metric);
        if (!metric) return fail(metric.error());
        pipeline->metric = std::move(*metric);
    }
    if (arguments.geometry) {
        auto geometry = config::read_geometry(*arguments.geometry, "--geometry");
        if (!geometry) return fail(geometry.error());
        pipeline->geometry = std::move(*geometry);
    }
    if (arguments.objective)
        for (config::Stage& stage : pipeline->stages)
            if (auto* curve = std::get_if<config::Curve>(&stage)) curve->objective = *arguments.objective;
    return pipeline;
}

}  // namespace

int curve_command(const CurveArguments& arguments) { return run_verb(curving(arguments), arguments); }

}  // namespace camber::app
