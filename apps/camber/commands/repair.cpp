module;
#include <optional>
#include <variant>
#include <vector>
module camber.commands;
import camber.core;
import camber.config;

namespace camber::app {

namespace {

/// Nothing is elevated and nothing is curved: the mesh brings its own nodes.
constexpr const char* base = R"({"input": {"mesh": "-"}, "stages": ["validate", "relax", "commit"]})";

}  // namespace

Outcome<config::Pipeline> pipeline_of(const RepairArguments& arguments) {
    auto pipeline = pipeline_of(base, arguments);
    if (!pipeline) return pipeline;
    if (auto set = set_geometry(arguments.geometry, *pipeline); !set) return fail(set.error());
    if (!arguments.boundary_tolerance) return pipeline;
    for (config::Stage& stage : pipeline->stages)
        if (auto* relax = std::get_if<config::Relax>(&stage)) relax->boundary_tolerance = *arguments.boundary_tolerance;
    return pipeline;
}

int repair_command(const RepairArguments& arguments) { return run_verb(pipeline_of(arguments), arguments); }

}  // namespace camber::app
