module;
#include <optional>
#include <string>
#include <utility>
module camber.commands;
import camber.core;
import camber.config;

namespace camber::app {

namespace {

Outcome<config::Pipeline> curving(const CurveArguments& arguments) {
    auto pipeline = pipeline_of(R"({"input": {"mesh": "-"}})", arguments);
    if (!pipeline) return pipeline;
    if (arguments.metric) {
        auto metric = config::read_metric(*arguments.metric, "--metric");
        if (!metric) return fail(metric.error());
        pipeline->metric = std::move(*metric);
    }
    if (arguments.geometry) {
        auto geometry = config::read_geometry(*arguments.geometry, "--geometry");
        if (!geometry) return fail(geometry.error());
        pipeline->geometry = std::move(*geometry);
    }
    return pipeline;
}

}  // namespace

int curve_command(const CurveArguments& arguments) { return run_verb(curving(arguments), arguments); }

}  // namespace camber::app
