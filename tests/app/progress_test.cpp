// Progress of the stages of a run: shares of the whole stage, although most stages consist of several loops.
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

/// A stage and the shares that it reported.
struct StageShares {
    std::string stage;
    std::vector<double> shares = {};
};

StepWrapper listening(std::vector<StageShares>& reported, int threads) {
    return [&reported, threads](std::string_view stage, const auto& body) {
        reported.push_back({std::string(stage)});
        return body(Execution{.threads = threads, .progress = [&reported](std::size_t done, std::size_t total) {
                                  reported.back().shares.push_back(static_cast<double>(done) /
                                                                   static_cast<double>(total));
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

/// Runs a config and returns the shares reported by each stage.
std::vector<StageShares> reported_shares(const std::string& config, int threads) {
    const auto pipeline = pipeline_of(config);
    std::vector<StageShares> reported;
    auto run = run::run_pipeline(pipeline, {generated(pipeline), {}}, listening(reported, threads));
    REQUIRE_MESSAGE(run.has_value(), (run ? std::string() : describe(run.error())));
    return reported;
}

const std::string shell_in_space =
    R"("input": {"generate": {"shell": {"structure": "prisms", "inner_size": 0.2, "outer_size": 0.4}}})";
const std::string coarse_shell =
    R"("input": {"generate": {"shell": {"structure": "prisms", "inner_size": 0.5, "outer_size": 1.5}}})";
const std::string bump = R"("input": {"generate": {"bump": {}}})";

void check_shares(const std::vector<StageShares>& reported) {
    for (const auto& [stage, shares] : reported) {
        CAPTURE(stage);
        REQUIRE_FALSE(shares.empty());
        CHECK(shares.front() >= 0);
        CHECK(std::ranges::is_sorted(shares));
        CHECK(shares.back() == 1);
    }
}

}  // namespace

TEST_CASE("each stage reports increasing shares that end at 1") {
    for (const std::string& input : {coarse_shell, bump})
        for (const std::string& rest :
             {std::string(), std::string(R"(, "stages": ["elevate", {"curve": {"objective": "energy"}}, "commit"])"),
              std::string(R"(, "metric_operations": [{"gradation": {}}, {"complexity": {"target": 1000}}])"),
              std::string(R"(, "metric": {"surface": {"tangent_size": 0.2, "normal_size": 0.1}})"),
              std::string(R"(, "geometry": "straight", "output": {"vtu": "not_written.vtu"})")})
            for (const int threads : {1, 2}) {
                CAPTURE(input);
                CAPTURE(rest);
                check_shares(reported_shares(input + rest, threads));
            }
}

// Guards against stages of several loops that report no share of their work.
TEST_CASE("stages that take long on large meshes report at least three shares before the end") {
    for (const auto& [stage, shares] : reported_shares(shell_in_space, 2)) {
        CAPTURE(stage);
        for (const std::string_view name :
             {"prepare", "elevate", "surface", "extension", "metric", "curve", "validate", "measure"})
            if (stage == name) CHECK(std::ranges::count_if(shares, [](double s) { return s < 1; }) >= 3);
    }
}

TEST_CASE("stages of a check report increasing shares of at most 1") {
    const auto pipeline = pipeline_of(shell_in_space);
    std::vector<StageShares> reported;
    REQUIRE(run::check_mesh(generated(pipeline), {}, {}, listening(reported, 2)));
    for (const auto& [stage, shares] : reported) {
        CAPTURE(stage);
        CHECK(std::ranges::is_sorted(shares));
        CHECK((shares.empty() || shares.back() <= 1));
    }
}
