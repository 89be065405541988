// Metric sources and metric operations of configs: reading, writing and errors.
#include <doctest/doctest.h>

#include <string>
#include <variant>

import camber.core;
import camber.fields;
import camber.config;
import camber.recipes;
import camber.metric;

using namespace camber;
using namespace camber::config;

namespace {

config::Metric metric(const std::string& json) {
    auto value = read_metric(json, "--metric");
    if (!value) FAIL(describe(value.error()));
    return *value;
}

std::string error_of(const std::string& json) {
    const auto value = read_metric(json, "--metric");
    REQUIRE_FALSE(value.has_value());
    CHECK(value.error().kind == ErrorKind::usage);
    return describe(value.error());
}

Pipeline with_operations(const std::string& operations) {
    auto pipeline =
        read_pipeline(R"({"input": {"mesh": "a.mesh"}, "metric_operations": )" + operations + "}", "config.json");
    if (!pipeline) FAIL(describe(pipeline.error()));
    return *pipeline;
}

std::string operations_error(const std::string& operations) {
    const auto pipeline =
        read_pipeline(R"({"input": {"mesh": "a.mesh"}, "metric_operations": )" + operations + "}", "config.json");
    REQUIRE_FALSE(pipeline.has_value());
    return describe(pipeline.error());
}

}  // namespace

TEST_CASE("metric sources are read with their parameters") {
    const auto surface = std::get<SurfaceMetric>(metric(R"({"surface": {"tangent_size": 2, "normal_size": 0.2}})"));
    CHECK(surface == SurfaceMetric{2, 0.2, 0});
    const auto field = std::get<FieldMetric>(metric(R"({"field": {"polar-1": {"scale": 0.5}}})"));
    CHECK(std::get<PolarOneField>(field) == PolarOneField{.scale = 0.5});
    CHECK(std::get<FieldMetric>(metric(R"({"field": "polar-2"})")) == FieldMetric(PolarTwoField{}));
    const auto shock = std::get<FieldMetric>(
        metric(R"({"field": {"planar-shock": {"point": [0, 0], "normal": [1, 0], "width": 0.2}}})"));
    CHECK(std::get<config::PlanarShock>(shock).width == 0.2);
    CHECK(std::get<MetricExpression>(metric(R"({"expression": {"size": "0.1 + 0.2*x"}})")) ==
          MetricExpression(SizeExpression{"0.1 + 0.2*x"}));
    CHECK(std::get<MetricExpression>(metric(R"({"expression": {"sizes": ["x", "y"]}})")) ==
          MetricExpression(SizesExpression{{"x", "y"}}));
    CHECK(std::get<MetricExpression>(metric(R"({"expression": {"tensor": ["1", "0", "1"]}})")) ==
          MetricExpression(TensorExpression{{"1", "0", "1"}}));
}

TEST_CASE("errors in metric sources state their place") {
    CHECK(error_of(R"({"surface": {"tangent_size": 2}})").find("\"normal_size\" is missing") != std::string::npos);
    CHECK(error_of(R"({"surface": {"tangent_size": 0, "normal_size": 1}})").find("/surface/tangent_size") !=
          std::string::npos);
    CHECK(error_of(R"({"field": "polar-3"})").find("did you mean \"polar-") != std::string::npos);
    CHECK(error_of(R"({"field": {"polar-1": {"radios": 1}}})").find("radius") != std::string::npos);
    CHECK(error_of(R"({"expression": {"size": 3}})").find("expected a string") != std::string::npos);
    CHECK(error_of(R"({"expression": {"sizes": ["x"]}})").find("2 to 3 items") != std::string::npos);
}

TEST_CASE("metric operations are read in order, written back and resolved relative to the config") {
    const Pipeline p = with_operations(R"([{"intersect": "natural"}, {"intersect": {"file": "b.sol"}}, "gradation",
        {"gradation": {"ratio": 2, "space": "physical"}}, {"bound": {"max_size": 3}}, {"complexity": {"target": 100}}])");
    REQUIRE(p.metric_operations.size() == 6);
    CHECK(std::holds_alternative<NaturalMetric>(std::get<Intersect>(p.metric_operations[0]).metric));
    CHECK(std::get<Gradation>(p.metric_operations[2]) == Gradation{});
    CHECK(std::get<Gradation>(p.metric_operations[3]) == Gradation{.space = GradationSpace::physical, .ratio = 2});
    CHECK(std::get<Bound>(p.metric_operations[4]).max_size == 3);
    CHECK(std::get<Complexity>(p.metric_operations[5]).target == 100);
    const auto again = read_pipeline(write_pipeline(p), "again");
    REQUIRE(again.has_value());
    CHECK(*again == p);
    const Pipeline below = with_inputs_below(p, "folder");
    CHECK(std::get<FilePath>(std::get<Intersect>(below.metric_operations[1]).metric).path == "folder/b.sol");
}

TEST_CASE("errors in metric operations state their place") {
    CHECK(operations_error(R"([{"gradation": {"ratio": 1}}])").find("/metric_operations/0/gradation/ratio") !=
          std::string::npos);
    CHECK(operations_error(R"(["bound", {"bound": {"min_size": 2, "max_size": 1}}])").find("max_size must be") !=
          std::string::npos);
    CHECK(operations_error(R"([{"bound": {"max_anisotropy": 0.5}}])").find("at least 1") != std::string::npos);
    CHECK(operations_error(R"(["complexity"])").find("needs its options") != std::string::npos);
    CHECK(operations_error(R"([{"intersect": {"fiield": "polar-1"}}])").find("did you mean \"field\"") !=
          std::string::npos);
    CHECK(operations_error(R"([{"smooth": {}}])").find("gradation") != std::string::npos);
}

TEST_CASE("explain describes every metric source and operation") {
    for (const char* topic : {"surface", "field", "linear", "polar-1", "polar-2", "planar-shock", "spherical-shock",
                              "rotating", "expression", "metric_operations", "gradation", "bound", "complexity"}) {
        const auto text = explain(topic);
        REQUIRE_MESSAGE(text.has_value(), topic);
        CHECK(text->find(topic) == 0);
    }
}
