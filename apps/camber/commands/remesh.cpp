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

constexpr const char* remesh_alone = R"({"input": {"mesh": "-"}, "stages": ["remesh"]})";

}  // namespace

Outcome<config::Pipeline> pipeline_of(const RemeshArguments& arguments) {
    auto pipeline = pipeline_of(remesh_alone, arguments);
    if (!pipeline) return pipeline;
    if (auto set = set_metric(arguments.metric, *pipeline); !set) return fail(set.error());
    if (auto set = set_geometry(arguments.geometry, *pipeline); !set) return fail(set.error());
    if (arguments.rounds)
        for (config::Stage& stage : pipeline->stages)
            if (auto* remesh = std::get_if<config::Remesh>(&stage)) remesh->rounds = *arguments.rounds;
    if (arguments.blocks)
        for (config::Stage& stage : pipeline->stages)
            if (auto* remesh = std::get_if<config::Remesh>(&stage)) remesh->blocks = *arguments.blocks;
    if (arguments.objective)
        for (config::Stage& stage : pipeline->stages)
            if (auto* remesh = std::get_if<config::Remesh>(&stage)) remesh->objective = *arguments.objective;
    if (!arguments.output_metric.empty()) pipeline->output.metric = arguments.output_metric;
    return pipeline;
}

int remesh_command(const RemeshArguments& arguments, Host host) {
    return run_verb(pipeline_of(arguments), arguments, std::move(host));
}

}  // namespace camber::app
