#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <variant>
#include <vector>
#include <nlohmann/json.hpp>

import camber.core;
import camber.shapes;
import camber.repair;
import camber.recipes;
import camber.config;

using namespace camber;
using namespace camber::config;

namespace {

Pipeline read(const std::string& text, const std::vector<std::string>& overrides = {}) {
    auto pipeline = read_pipeline(text, "config.json", overrides);
    if (!pipeline) FAIL(describe(pipeline.error()));
    return *pipeline;
}

const std::string everything = R"({
    "$schema": "schema.json",
    "input": {"generate": {"shell": {"inner_layer": {"count": 8, "first_height": 0.02}, "structure": "prisms", "seed": 7}}},
    "metric": {"constant": {"sizes": [1, 2, 3]}},
    "geometry": {"analytic": [{"references": [1, 2], "sphere": {"centre": [0, 0, 0], "radius": 5}},
                              {"references": [3], "plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}]},
    "features": {"ridge_angle": 30},
    "stages": ["elevate", {"curve": {"objective": "length", "quadrature_points": 6}}, {"validate": {}},
               {"relax": {"method": "backtracking", "theta": 0.5}}, {"commit": {}}],
    "threads": 2,
    "output": {"mesh": "out.meshb", "report": "report.json"}
})";

}  // namespace

TEST_CASE("a config sets the stated values and defaults fill the rest") {
    const Pipeline p = read(everything);
    const auto& shell = std::get<ShellOptions<3>>(std::get<config::Shape>(p.input.source));
    CHECK(shell.inner_layer.count == 8);
    CHECK(shell.inner_layer.growth == BoundaryLayer{}.growth);
    CHECK(shell.structure == ShellStructure::prisms);
    CHECK(shell.seed == 7);
    CHECK(shell.outer_radius == ShellOptions<3>{}.outer_radius);
    CHECK(std::get<ConstantMetric>(p.metric).sizes == std::vector<double>{1, 2, 3});
    const auto& surfaces = std::get<Analytic>(p.geometry).surfaces;
    REQUIRE(surfaces.size() == 2);
    CHECK(surfaces[0].references == std::vector<Reference>{1, 2});
    CHECK(std::get<Sphere>(surfaces[0].surface).radius == 5);
    CHECK(std::get<Plane>(surfaces[1].surface).normal == std::vector<double>{0, 0, 1});
    REQUIRE(p.stages.size() == 5);
    CHECK(std::get<Curve>(p.stages[1]).objective == Objective::length);
    CHECK(std::get<Curve>(p.stages[1]).quadrature_points == 6);
    CHECK(std::get<Curve>(p.stages[1]).max_iterations == Curve{}.max_iterations);
    CHECK(std::get<Relax>(p.stages[3]).method == RepairMethod::backtracking);
    CHECK(p.threads == 2);
    CHECK(p.output.mesh == "out.meshb");
}

TEST_CASE("a written config is read back with the same values") {
    const std::vector<std::string> texts{
        everything,
        R"({"input": {"mesh": "a.meshb"}})",
        R"({"input": {"mesh": "a.meshb"}, "metric": {"file": "m.solb"}, "geometry": "straight", "stages": []})",
        R"({"input": {"mesh": "a.meshb", "flat": "surface"}})",
        R"({"input": {"generate": "annulus"}, "metric": {"constant": {"tensor": [1, 0, 1]}}})",
        R"({"input": {"generate": {"bump": {"cells": [10, 3]}}}, "metric": {"natural": {}}})",
        R"({"input": {"generate": {"rectangle": {"high": [2, 0.1]}}}, "geometry": {"analytic": [
            {"references": [1], "torus": {"centre": [0,0,0], "axis": [0,0,1], "major_radius": 3, "minor_radius": 1}},
            {"references": [2], "cylinder": {"point": [0,0,0], "axis": [0,0,1], "radius": 0.1}}]}})",
        R"({"input": {"generate": {"box": {"cells": [1, 2, 3], "seed": 18446744073709551615}}}})"};
    for (const std::string& text : texts) {
        const Pipeline p = read(text);
        const std::string written = write_pipeline(p);
        CHECK(read(written) == p);
        CHECK(write_pipeline(read(written)) == written);
    }
}

TEST_CASE("a plain word selects the alternative with default options") {
    CHECK(std::holds_alternative<NaturalMetric>(read(R"({"input": {"mesh": "a"}, "metric": "natural"})").metric));
    CHECK(read(R"({"input": {"mesh": "a"}, "stages": ["curve"]})").stages == std::vector<Stage>{Curve{}});
}

TEST_CASE("settings override stated values, defaults and options of stages by name") {
    const std::string text = R"({"input": {"mesh": "a"}, "stages": ["elevate", {"curve": {"iterations": 3}}]})";
    CHECK(read(text, {"threads=3"}).threads == 3);
    CHECK(read(text).input.flat == Flat::plane);
    CHECK(read(text, {"input/flat=surface"}).input == Input{FilePath{"a"}, Flat::surface});
    CHECK(read(text, {"metric/file=m.sol"}).metric == Metric(FilePath{"m.sol"}));
    CHECK(read(text, {"metric=natural"}).metric == Metric(NaturalMetric{}));
    CHECK(std::get<Curve>(read(text, {"stages/1/curve/objective=length"}).stages[1]).objective == Objective::length);
    const auto curve = std::get<Curve>(read(text, {"stages/curve/quadrature_points=8"}).stages[1]);
    CHECK(curve.quadrature_points == 8);
    CHECK(curve.max_iterations == 3);
    CHECK(std::get<Relax>(read(R"({"input": {"mesh": "a"}})", {"stages/relax/theta=0.5"}).stages[3]).theta == 0.5);
    for (const char* wrong : {"threads", "=3", "stages/9/curve=1", "stages/curved/theta=1", "thread=3"})
        CHECK(read_pipeline(text, "c", std::vector<std::string>{wrong}).error().kind == ErrorKind::usage);
}

TEST_CASE("metrics and geometries are read from words, paths and JSON") {
    CHECK(*read_metric("natural", "--metric") == Metric(NaturalMetric{}));
    CHECK(*read_metric("dir/m.solb", "--metric") == Metric(FilePath{"dir/m.solb"}));
    CHECK(*read_metric(R"({"constant": {"sizes": [0.1]}})", "--metric") == Metric(ConstantMetric{{0.1}, {}}));
    CHECK(*read_geometry("straight", "--geometry") == Geometry(Straight{}));
    CHECK(describe(read_geometry("surrogat", "--geometry").error()).find("did you mean \"surrogate\"?") !=
          std::string::npos);
}

TEST_CASE("input paths are relative to the config, output paths to the working directory") {
    const Pipeline p =
        read(R"({"input": {"mesh": "../data/a.mesh"}, "metric": {"file": "/m.sol"}, "output": {"mesh": "o.mesh"}})");
    const Pipeline q = with_inputs_below(p, "configs/sub");
    CHECK(std::get<FilePath>(q.input.source).path == "configs/data/a.mesh");
    CHECK(std::get<FilePath>(q.metric).path == "/m.sol");
    CHECK(q.output.mesh == "o.mesh");
}

TEST_CASE("the schema contains every key of a written config") {
    const auto schema = nlohmann::json::parse(pipeline_schema());
    CHECK(schema["$schema"] == "https://json-schema.org/draft/2020-12/schema");
    CHECK(schema["additionalProperties"] == false);
    CHECK(schema["required"] == nlohmann::json::array({"input"}));
    const auto written = nlohmann::json::parse(write_pipeline(read(everything)));
    for (const auto& [key, value] : written.items()) CHECK(schema["properties"].contains(key));
    const auto& stages = schema["properties"]["stages"]["items"]["oneOf"];
    const auto curve = std::find_if(stages.begin(), stages.end(), [](const auto& s) {
        return s.contains("properties") && s["properties"].contains("curve");
    });
    REQUIRE(curve != stages.end());
    const auto& options = (*curve)["properties"]["curve"]["properties"];
    CHECK(options["objective"]["enum"] == nlohmann::json::array({"accuracy", "energy", "length", "shape", "solution"}));
    CHECK(options["objective"]["default"] == "accuracy");
    CHECK(options["quadrature_points"]["minimum"] == 2);
    for (const auto& [key, value] : options.items()) CHECK_FALSE(value["description"].get<std::string>().empty());
}

namespace {

/// Collects the option keys and the string values that a schema describes.
void collect_words(const nlohmann::json& schema, std::vector<std::string>& words) {
    if (schema.is_object()) {
        if (schema.contains("properties") && schema["properties"].is_object())
            for (const auto& [key, value] : schema["properties"].items()) words.push_back(key);
        if (schema.contains("enum") && schema["enum"].is_array())
            for (const auto& value : schema["enum"])
                if (value.is_string()) words.push_back(value.get<std::string>());
    }
    if (schema.is_structured())
        for (const auto& part : schema) collect_words(part, words);
}

}  // namespace

// Guards against `camber explain` without topics of the schema.
TEST_CASE("explain describes every key and value of the schema") {
    std::vector<std::string> words;
    collect_words(nlohmann::json::parse(pipeline_schema()), words);
    CHECK(words.size() > 100);
    for (const std::string& word : words) {
        if (word == "$schema") continue;  // a key of JSON schemas
        const auto text = explain(word);
        CHECK_MESSAGE(text.has_value(), word);
        if (text) CHECK(text->find(word) == 0);
    }
    CHECK(explain("mesh")->find("in \"geometry\"") != std::string::npos);
    CHECK(explain("cad")->find("unit") != std::string::npos);
}

TEST_CASE("explain describes every topic") {
    for (const std::string& topic : topics()) {
        const auto text = explain(topic);
        REQUIRE(text.has_value());
        CHECK(text->starts_with(topic));
    }
    CHECK(explain("curve")->find("max_tangential_shift") != std::string::npos);
    CHECK(explain("curve")->find("default 0.2") != std::string::npos);
    CHECK(describe(explain("curv").error()) == "curv: unknown topic (did you mean \"curve\"?)");
}
