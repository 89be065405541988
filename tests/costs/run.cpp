// Memory of a whole run without files: peak bytes and number of allocations per tetrahedron in each stage. The bounds
// are one sixth above the values measured when they were set. A permanent reduction should lower them; an increase
// makes all runs larger.
#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include <doctest/doctest.h>

#include "heap.hpp"
#include "shell.hpp"

import camber.core;
import camber.config;
import camber.io;
import camber.recipes;
import camber.reports;

using namespace camber;
using namespace camber::testing;

namespace {

struct StageCost {
    double bytes = 0;        ///< peak, including the mesh and results of earlier stages
    double allocations = 0;  ///< during the stage
};
using RunCost = std::map<std::string, StageCost>;

/// Costs per tetrahedron of a run with one thread.
RunCost cost_of_run(LinearMesh<3> mesh) {
    const auto pipeline = must(config::read_pipeline(R"({"input": {"mesh": "-"}, "threads": 1})", "test"));
    const auto tetrahedra = static_cast<double>(mesh.elements.size());
    DecodedMesh input{AnyMesh(as_mesh(std::move(mesh))), {}};
    const std::size_t others = heap().bytes - static_cast<std::size_t>(tetrahedra) * sizeof(SimplexVertices<3>);
    RunCost costs;
    (void)must(run::run_pipeline(pipeline, {std::move(input), {}}, [&](std::string_view stage, const auto& body) {
        begin_peak();
        const std::size_t before = heap().allocations;
        auto done = body(one_thread);
        const Heap after = heap();
        costs[std::string(stage)] = {static_cast<double>(after.peak - others) / tetrahedra,
                                     static_cast<double>(after.allocations - before) / tetrahedra};
        return done;
    }));
    return costs;
}

}  // namespace

TEST_CASE("each stage of a run stays within its bounds of memory and allocations") {
    const RunCost bounds{{"prepare", {88, 0.17}},    {"elevate", {100, 0.01}}, {"surface", {140, 0.8}},
                         {"extension", {740, 0.23}}, {"metric", {740, 0.42}},  {"curve", {560, 12.5}},
                         {"validate", {430, 0.01}},  {"relax", {430, 5.8}},    {"commit", {430, 0.01}},
                         {"measure", {460, 0.29}}};
    const RunCost costs = cost_of_run(layered_shell());
    CHECK(costs.size() == bounds.size());
    for (const auto& [stage, cost] : costs) {
        CAPTURE(stage);
        REQUIRE(bounds.contains(stage));
        CHECK(cost.bytes < bounds.at(stage).bytes);
        CHECK(cost.allocations < bounds.at(stage).allocations);
    }
}
