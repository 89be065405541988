// Allowed orders of stages: the table of `check_order` agrees with the runs.
#include <doctest/doctest.h>

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "any_mesh.hpp"
#include "sanitized.hpp"

import camber.core;
import camber.config;
import camber.io;
import camber.recipes;
import camber.reports;

using namespace camber;
using Stages = std::vector<config::Stage>;

namespace {

/// Returns one stage of each alternative of `config::Stage`.
Stages every_stage() {
    return []<class... S>(std::type_identity<std::variant<S...>>) {
        return Stages{S{}...};
    }(std::type_identity<config::Stage>{});
}

void sequences(std::size_t length, const Stages& prefix, const std::function<void(const Stages&)>& f) {
    f(prefix);
    if (prefix.size() == length) return;
    for (const config::Stage& stage : every_stage()) {
        Stages longer = prefix;
        longer.push_back(stage);
        sequences(length, longer, f);
    }
}

config::Pipeline small_square() {
    auto pipeline =
        config::read_pipeline(R"({"input": {"generate": {"rectangle": {"cells": [2, 1]}}}, "threads": 1})", "test");
    REQUIRE(pipeline);
    return *pipeline;
}

/// Result of a run and the names of its steps.
struct StageRun {
    Outcome<run::Run> run;
    std::vector<std::string> steps;
};
StageRun run_of(config::Pipeline pipeline, AnyMesh mesh, const Stages& stages) {
    pipeline.stages = stages;
    std::vector<std::string> steps;
    auto run = run::run_pipeline(pipeline, {DecodedMesh{std::move(mesh), {}}, {}},
                                 [&](std::string_view name, const auto& body) {
                                     steps.emplace_back(name);
                                     return body(Execution{.threads = 1});
                                 });
    return {std::move(run), std::move(steps)};
}

/// Moves one mid node off the middle of its chord.
AnyMesh bent(AnyMesh mesh, double by = 0.01) {
    auto& quadratic = std::get<Mesh<2>>(mesh);
    auto nodes = take(std::move(quadratic.edge_nodes));
    nodes[0].point += Vec<2>{{by, by}};
    quadratic.edge_nodes = std::move(nodes);
    return mesh;
}

std::string error_of(const Stages& stages, int degree) {
    const auto order = run::check_order(stages, degree);
    return order ? "" : describe(order.error());
}

}  // namespace

TEST_CASE("allowed sequences of stages run and others are rejected before the first step") {
    const config::Pipeline pipeline = small_square();
    const auto square = run::generate_shape(std::get<config::Shape>(pipeline.input.source));
    REQUIRE(square);
    const auto curved = run_of(pipeline, square->mesh, {config::Elevate{}});
    REQUIRE(curved.run);
    const auto check_sequences = [&](const AnyMesh& mesh, int degree) {
        sequences(camber::testing::less_if_sanitized<std::size_t>(3, 2), {}, [&](const Stages& stages) {
            const bool allowed = run::check_order(stages, degree).has_value();
            const StageRun stage_run = run_of(pipeline, mesh, stages);
            CHECK(stage_run.run.has_value() == allowed);
            CHECK(stage_run.steps.empty() == !allowed);
        });
    };
    check_sequences(square->mesh, 1);
    check_sequences(bent(curved.run->mesh), 2);
}

TEST_CASE("elevate accepts a quadratic mesh with straight edges and rejects a curved one") {
    const config::Pipeline pipeline = small_square();
    const auto square = run::generate_shape(std::get<config::Shape>(pipeline.input.source));
    REQUIRE(square);
    const auto elevated = run_of(pipeline, square->mesh, {config::Elevate{}});
    REQUIRE(elevated.run);
    const auto again = run_of(pipeline, elevated.run->mesh, {config::Elevate{}});
    REQUIRE(again.run);
    CHECK(again.run->mesh == elevated.run->mesh);
    CHECK_FALSE(run_of(pipeline, bent(elevated.run->mesh), {config::Elevate{}}).run);
    CHECK(run_of(pipeline, bent(elevated.run->mesh, 1e-16), {config::Elevate{}}).run);  // rounding of text files
}

TEST_CASE("elevate rejects small curvature far away from the origin") {
    // Elements of size 1e-6 at (1e6, 1e6), with a node moved by 1e-8.
    const config::Pipeline pipeline = small_square();
    const auto square = run::generate_shape(std::get<config::Shape>(pipeline.input.source));
    REQUIRE(square);
    auto linear = testing::mesh_in<LinearMesh<2>>(square->mesh);
    auto points = take(std::move(linear.points));
    for (Vec<2>& x : points) x = Vec<2>{{1e6, 1e6}} + 1e-6 * x;
    linear.points = std::move(points);
    const auto elevated = run_of(pipeline, as_mesh(linear), {config::Elevate{}});
    REQUIRE(elevated.run);
    CHECK(run_of(pipeline, elevated.run->mesh, {config::Elevate{}}).run);
    CHECK_FALSE(run_of(pipeline, bent(elevated.run->mesh, 1e-8), {config::Elevate{}}).run);
}

TEST_CASE("stages after the first error do not change the error") {
    for (const int degree : {1, 2})
        sequences(3, {}, [&](const Stages& stages) {
            const std::string error = error_of(stages, degree);
            for (const config::Stage& next : every_stage()) {
                Stages longer = stages;
                longer.push_back(next);
                if (!error.empty()) CHECK(error_of(longer, degree) == error);
            }
        });
}

TEST_CASE("the error of a sequence states the stage and the stage that must precede it") {
    CHECK(error_of({config::Elevate{}, config::Relax{}}, 1) == "/stages/1: stage \"relax\" needs \"curve\" before it");
    CHECK(error_of({config::Curve{}}, 1) == "/stages/0: stage \"curve\" needs \"elevate\" before it");
    CHECK(error_of({config::Validate{}}, 1).find("the mesh has degree 1, but stage \"validate\"") == 0);
    CHECK(error_of({config::Elevate{}, config::Elevate{}}, 1).find("/stages/1: the mesh is quadratic already") == 0);
    CHECK(error_of({config::Elevate{}}, 2).find("the mesh is quadratic already (give the straight mesh") == 0);
    CHECK(error_of({config::Relax{}, config::Commit{}}, 2).empty());
}
