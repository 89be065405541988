#include <doctest/doctest.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

import camber.core;
import camber.config;
import camber.recipes;

using namespace camber;
using namespace camber::config;

namespace {

std::string error_of(const std::string& text) {
    const auto pipeline = read_pipeline(text, "config.json");
    if (pipeline) return "no error";
    CHECK(pipeline.error().kind == ErrorKind::usage);
    return describe(pipeline.error());
}

/// Returns the error of a config with this part and valid other parts.
std::string error_with(const std::string& part) { return error_of(R"({"input": {"mesh": "a.mesh"}, )" + part + "}"); }

}  // namespace

TEST_CASE("unknown keys are rejected with their path and the nearest known key") {
    CHECK(error_with(R"("stages": ["elevate", {"curve": {"objectiv": "energy"}}])") ==
          "config.json: /stages/1/curve/objectiv: unknown key (did you mean \"objective\"?)");
    CHECK(error_with(R"("outptu": {})") == "config.json: /outptu: unknown key (did you mean \"output\"?)");
    CHECK(error_with(R"("stages": [{"relaxx": {}}])") ==
          "config.json: /stages/0/relaxx: unknown key (did you mean \"relax\"?)");
    CHECK(error_with(R"("output": {"qqqqqqqqq": 1})") ==
          "config.json: /output/qqqqqqqqq: unknown key (known: mesh, format, report, vtu, vtu_cells, metric, solution, "
          "plots, page, "
          "distances, partition)");
    CHECK(error_with(R"("metric": "naturl")") ==
          "config.json: /metric: unknown word \"naturl\" (did you mean \"natural\"?)");
    CHECK(error_with(R"("output": {"$schema": "only at the top"})")
              .starts_with("config.json: /output/$schema: unknown key"));
}

TEST_CASE("wrong types are rejected with the expected type") {
    CHECK(error_of("[]") ==
          "config.json: expected an object, got an array (known: input, solution, metric, metric_mesh, "
          "metric_operations, "
          "geometry, "
          "features, geometry_tolerance, geometry_bound, "
          "stages, adapt, threads, output)");
    CHECK(error_with(R"("threads": "two")") ==
          "config.json: /threads: expected a whole number, got the string \"two\"");
    CHECK(error_with(R"("threads": 1.5)") == "config.json: /threads: expected a whole number, got 1.5");
    CHECK(error_with(R"("features": {"ridge_angle": null})") ==
          "config.json: /features/ridge_angle: expected a number, got null");
    CHECK(error_with(R"("stages": {})") == "config.json: /stages: expected an array, got an object");
    CHECK(error_with(R"("stages": [{"curve": {"objective": 3}}])") ==
          "config.json: /stages/0/curve/objective: expected \"accuracy\" or \"energy\" or \"length\" or \"shape\" or "
          "\"solution\", got "
          "3");
    CHECK(error_of(R"({"input": {"mesh": "a", "flat": "surfaces"}})") ==
          "config.json: /input/flat: expected \"plane\" or \"surface\", got the string \"surfaces\" (did you mean "
          "\"surface\"?)");
    CHECK(error_of(R"({"input": "a.mesh"})") ==
          "config.json: /input: expected an object, got the string \"a.mesh\" (known: mesh, generate, flat)");
    CHECK(error_with(R"("output": {"mesh": 3})") == "config.json: /output/mesh: expected a string, got 3");
    CHECK(error_with(R"("metric": {"file": 3})") == "config.json: /metric/file: expected a file's path, got 3");
    CHECK(error_with(R"("metric": {"natural": {}, "file": "a"})") ==
          "config.json: /metric: expected an object with one key, got 2 keys (known: natural, file, constant, surface, "
          "field, expression, sizes, geometry, solution)");
    CHECK(
        error_with(R"("metric": "constant")").starts_with("config.json: /metric: give either \"sizes\" or \"tensor\""));
    CHECK(error_with(R"("metric": "file")").starts_with("config.json: /metric: \"file\" needs its options"));
}

TEST_CASE("values out of range are rejected with the range") {
    CHECK(error_with(R"("threads": -1)") == "config.json: /threads: must be at least 0 and at most 4096, got -1");
    CHECK(
        error_with(R"("threads": 99999999999999999999)").starts_with("config.json: /threads: expected a whole number"));
    CHECK(error_with(R"("stages": [{"relax": {"theta": 1}}])") ==
          "config.json: /stages/0/relax/theta: must be above 0 and below 1, got 1");
    CHECK(error_with(R"("stages": [{"curve": {"quadrature_points": 1}}])") ==
          "config.json: /stages/0/curve/quadrature_points: must be at least 2 and at most 12, got 1");
    CHECK(error_with(R"("metric": {"constant": {"sizes": [1, -2]}})") ==
          "config.json: /metric/constant/sizes/1: must be above 0, got -2");
    CHECK(error_with(R"("metric": {"constant": {"sizes": [1, 2, 3, 4]}})") ==
          "config.json: /metric/constant/sizes: expected 0 to 3 items, got 4");
    CHECK(error_of(R"({"input": {"generate": {"box": {"cells": [1, 1]}}}})") ==
          "config.json: /input/generate/box/cells: expected 3 items, got 2");
    CHECK(error_of(R"({"input": {"generate": {"shell": {"seed": -1}}}})")
              .starts_with("config.json: /input/generate/shell/seed: must be"));
}

TEST_CASE("missing and contradictory keys are rejected") {
    CHECK(error_of("{}") == "config.json: \"input\" is missing");
    CHECK(error_with(R"("geometry": {"analytic": [{"references": [1]}]})") ==
          "config.json: /geometry/analytic/0: \"plane\" or \"sphere\" or \"cylinder\" or \"torus\" is missing");
    CHECK(error_with(R"("geometry": {"analytic": [{"references": [1], "sphere": {"centre": [0, 0], "radius": 1},
                         "plane": {"point": [0, 0], "normal": [0, 1]}}]})") ==
          "config.json: /geometry/analytic/0/sphere: only one of \"plane\" and \"sphere\" is allowed");
    CHECK(error_with(
              R"("geometry": {"analytic": [{"references": [1], "plane": {"point": [0, 0], "normal": [0, 0]}}]})") ==
          "config.json: /geometry/analytic/0/plane: the normal is zero");
    CHECK(error_with(R"("metric": {"constant": {"tensor": [1, 2]}})") ==
          "config.json: /metric/constant: a tensor has 3 entries (2D) or 6 (3D), got 2");
    CHECK(error_of(R"({"input": {"flat": "plane"}})") == "config.json: /input: \"mesh\" or \"generate\" is missing");
    CHECK(error_of(R"({"input": {"mesh": "a", "generate": "shell"}})") ==
          "config.json: /input/generate: only one of \"mesh\" and \"generate\" is allowed");
    CHECK(error_of(R"({"input": {"generate": "rectangle", "flat": "surface"}})") ==
          "config.json: /input: \"flat\" applies only to a mesh file");
    CHECK(error_of(R"({"input": {"mesh": ""}})") == "config.json: /input/mesh: the path is empty");
}

TEST_CASE("duplicate keys are rejected with their path") {
    CHECK(error_with(R"("threads": 1, "threads": 1)") == "config.json: /threads: the key appears twice");
    CHECK(
        error_with(R"("stages": ["elevate", {"curve": {"iterations": 1, "objective": "energy", "iterations": 2}}])") ==
        "config.json: /stages/1/curve/iterations: the key appears twice");
}

TEST_CASE("an object with more than 1000 keys is rejected") {
    std::string keys;
    for (int i = 0; i < 200000; ++i) keys += (i > 0 ? ", \"k" : "\"k") + std::to_string(i) + "\": 1";
    CHECK(error_of("{" + keys + "}") == "config.json: the object has more than 1000 keys");
    CHECK(error_with("\"stages\": [\"elevate\", {\"curve\": {" + keys + "}}]") ==
          "config.json: /stages/1/curve: the object has more than 1000 keys");
}

TEST_CASE("error messages stay short for values of a megabyte") {
    using Json = nlohmann::ordered_json;
    const std::string megabyte(std::size_t{1} << 20U, 'x');
    const Json defaults = Json::parse(write_pipeline({})), flat = defaults.flatten();
    const std::string base = R"({"input": {"mesh": "a.mesh"}, )";
    std::vector<std::string> configs{megabyte,
                                     "\"" + megabyte,
                                     "{\"" + megabyte + "\": 1}",
                                     "[\"" + megabyte + "\"]",
                                     base + "\"stages\": [\"" + megabyte + "\"]}",
                                     base + "\"stages\": [{\"curve\": {\"" + megabyte + "\": 1}}]}",
                                     base + "\"stages\": [{\"curve\": {\"objective\": \"" + megabyte + "\"}}]}",
                                     base + "\"threads\": " + std::string(megabyte.size(), '9') + "}"};
    for (const auto& [path, value] : flat.items()) {
        for (const Json& wrong : {Json(megabyte), Json{{megabyte, 1}}, Json::array({megabyte})}) {
            Json config = defaults;
            config["input"] = {{"mesh", "a.mesh"}};
            config[Json::json_pointer(path)] = wrong;
            configs.push_back(config.dump());
        }
    }
    for (const std::string& config : configs) {
        const std::string error = error_of(config);
        CAPTURE(error.substr(0, 200));
        CHECK(error.size() < 1000);
    }
    for (const std::string& setting : {megabyte, megabyte + "=1", "threads=" + megabyte, "stages/" + megabyte + "=1",
                                       "stages/0/" + megabyte + "/x=1", "output/" + megabyte + "=" + megabyte}) {
        const auto pipeline = read_pipeline(base + R"("stages": ["elevate"]})", "config.json", std::vector{setting});
        REQUIRE_FALSE(pipeline.has_value());
        CHECK(describe(pipeline.error()).size() < 1000);
    }
}

TEST_CASE("syntax errors state line and column") {
    CHECK(error_of("{\n  \"threads\": 1,,\n}").starts_with("config.json: line 2, column 16: syntax error"));
    CHECK(error_of("").starts_with("config.json: line 1, column 1: syntax error"));
    CHECK(error_of("{\"input\": \"\xff\"}").starts_with("config.json: line 1, column 12"));
    CHECK(error_of("{\"threads\": 1e999}").starts_with("config.json: number overflow"));
    CHECK(error_of("{} x").starts_with("config.json: line 1, column 4: syntax error"));
    for (const std::string& whole :
         {std::string(R"({"input": {"mesh": "a.mesh"}, "stages": ["elevate", {"curve": {"iterations": 1}}]})")})
        for (std::size_t length = 0; length < whole.size(); ++length)
            CHECK(error_of(whole.substr(0, length)).starts_with("config.json: line 1, column"));
    // Deep nesting is an error and does not overflow the stack.
    CHECK(error_of(std::string(100000, '[')) != "no error");
}
