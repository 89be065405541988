// What the stages of a run tell of themselves: shares of the whole stage, though most are made of many loops.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

import camber.core;
import camber.config;
import camber.io;
import camber.recipes;
import camber.reports;

using namespace camber;

namespace {

/// A stage of a run, and the shares that it told.
struct Told {
    std::string stage;
    std::vector<double> shares = {};
};

Around listening(std::vector<Told>& told, int threads) {
    return [&told, threads](std::string_view stage, const auto& body) {
        told.push_back({std::string(stage)});
        return body(Execution{.threads = threads, .progress = [&told](std::size_t done, std::size_t total) {
                                  told.back().shares.push_back(static_cast<double>(done) / static_cast<double>(total));
                              }});
    };
}

DecodedMesh generated(const config::Pipeline& pipeline) {
    auto mesh = run::generate_shape(std::get<config::Shape>(pipeline.input.source), Execution{.threads = 1});
    REQUIRE(mesh);
    return std::move(*mesh);
}

config::Pipeline pipeline_of(const std::string& rest) {
    auto pipeline = config::read_pipeline("{" + rest + "}", "test");
    REQUIRE(pipeline);
    return *pipeline;
}

/// What the run of a config tells, with so many threads.
std::vector<Told> told_by(const std::string& config, int threads) {
    const auto pipeline = pipeline_of(config);
    std::vector<Told> told;
    auto run = run::run_pipeline(pipeline, {generated(pipeline), {}}, listening(told, threads));
    REQUIRE_MESSAGE(run.has_value(), (run ? std::string() : describe(run.error())));
    return told;
}

const std::string shell_in_space =
    R"("input": {"generate": {"shell": {"structure": "prisms", "inner_size": 0.2, "outer_size": 0.4}}})";
const std::string coarse_shell =
    R"("input": {"generate": {"shell": {"structure": "prisms", "inner_size": 0.5, "outer_size": 1.5}}})";
const std::string bump = R"("input": {"generate": {"bump": {}}})";

void check_shares(const std::vector<Told>& told) {
    for (const auto& [stage, shares] : told) {
        CAPTURE(stage);
        REQUIRE_FALSE(shares.empty());
        CHECK(shares.front() >= 0);
        CHECK(std::ranges::is_sorted(shares));
        CHECK(shares.back() == 1);
    }
}

}  // namespace

TEST_CASE("each stage tells rising shares of itself, and in the end the whole") {
    for (const std::string& input : {coarse_shell, bump})
        for (const std::string& rest :
             {std::string(), std::string(R"(, "stages": ["elevate", {"curve": {"objective": "energy"}}, "commit"])"),
              std::string(R"(, "metric_operations": [{"gradation": {}}, {"complexity": {"target": 1000}}])"),
              std::string(R"(, "metric": {"surface": {"tangent_size": 0.2, "normal_size": 0.1}})"),
              std::string(R"(, "geometry": "straight", "output": {"vtu": "not_written.vtu"})")})
            for (const int threads : {1, 2}) {
                CAPTURE(input);
                CAPTURE(rest);
                check_shares(told_by(input + rest, threads));
            }
}

// Guards against stages of several loops that report no share of their work.
TEST_CASE("stages that take long on large meshes tell more than their end") {
    for (const auto& [stage, shares] : told_by(shell_in_space, 2)) {
        CAPTURE(stage);
        for (const std::string_view name :
             {"prepare", "elevate", "surface", "extension", "metric", "curve", "validate", "measure"})
            if (stage == name) CHECK(std::ranges::count_if(shares, [](double s) { return s < 1; }) >= 3);
    }
}

TEST_CASE("so do the stages of a check") {
    const auto pipeline = pipeline_of(shell_in_space);
    std::vector<Told> told;
    REQUIRE(run::check_mesh(generated(pipeline), {}, {}, listening(told, 2)));
    for (const auto& [stage, shares] : told) {
        CAPTURE(stage);
        CHECK(std::ranges::is_sorted(shares));
        CHECK((shares.empty() || shares.back() <= 1));
    }
}
