// Runs that reorder a mesh internally: the results equal those of the same run in the order of the mesh.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "any_mesh.hpp"
#include "meshes.hpp"
#include "sanitized.hpp"

import camber.core;
import camber.bezier;
import camber.config;
import camber.io;
import camber.ordering;
import camber.recipes;
import camber.reports;

using namespace camber;
using camber::testing::must;
using camber::testing::one_thread;

namespace {

constexpr OrderingOptions always{.min_elements = 0, .max_scatter = 0};
constexpr OrderingOptions never{.min_elements = std::numeric_limits<std::size_t>::max()};

template <class EntityId>
Permutation<EntityId> any_order(std::size_t count) {
    Buffer<EntityId> ids(count);
    for (std::size_t i = 0; i < count; ++i) ids[i] = EntityId(i);
    std::shuffle(ids.begin(), ids.end(), std::mt19937_64(count));
    return must(permutation(Column<EntityId>(std::move(ids)), one_thread));
}

/// Generates the mesh of a shape in random order.
template <int D>
LinearMesh<D> shuffled(const std::string& shape) {
    const auto pipeline = must(config::read_pipeline(R"({"input": {"generate": )" + shape + "}}", "test"));
    const auto result = must(run::generate_shape(std::get<config::Shape>(pipeline.input.source), one_thread));
    auto mesh = testing::mesh_in<LinearMesh<D>>(result.mesh);
    const Renumbering order{any_order<VertexId>(mesh.points.size()), any_order<ElementId>(mesh.elements.size())};
    return must(renumbered(std::move(mesh), order, one_thread));
}
LinearMesh<3> shell() {
    return shuffled<3>(camber::testing::less_if_sanitized(
        R"({"shell": {"structure": "prisms", "inner_size": 0.5, "outer_size": 0.9}})",
        R"({"shell": {"structure": "prisms", "inner_size": 1.0, "outer_size": 1.8}})"));
}
LinearMesh<2> annulus() { return shuffled<2>(R"({"annulus": {"inner_size": 0.25, "outer_size": 0.4}})"); }

Outcome<run::Run> run_of(const std::string& rest, run::Inputs inputs, int threads = 1) {
    const auto pipeline = must(config::read_pipeline(R"({"input": {"mesh": "-"})" + rest + "}", "test"));
    return run::run_pipeline(pipeline, std::move(inputs), [threads](std::string_view, const auto& body) {
        return body(Execution{.threads = threads});
    });
}

/// A size at each vertex, growing with the distance from the origin.
template <int D>
Solution sizes_of(const LinearMesh<D>& mesh) {
    Buffer<double> sizes;
    for (const Vec<D>& p : mesh.points) sizes.push_back(0.1 + 0.3 * norm(p));
    return {.dimension = D, .fields = {FieldKind::scalar}, .rows = mesh.points.size(), .values = std::move(sizes)};
}

/// Compares up to 1e-7: sums over balls have another order, and a sample on a face may use the element on its other
/// side.
template <class T>
bool close(const Column<T>& a, const Column<T>& b) {
    if (a.size() != b.size()) return false;
    for (std::size_t i = 0; i < a.size(); ++i) {
        if constexpr (std::is_same_v<T, double>) {
            if (std::isnan(a[i]) != std::isnan(b[i])) return false;
            if (std::abs(a[i] - b[i]) > 1e-7 * std::max(1.0, std::abs(b[i]))) return false;
        } else if (a[i] != b[i]) {
            return false;
        }
    }
    return true;
}
bool close(const MeshField& a, const MeshField& b) {
    return a.name == b.name && a.centring == b.centring && a.kind == b.kind &&
           std::visit([&](const auto& rows) { return close(rows, std::get<std::decay_t<decltype(rows)>>(b.values)); },
                      a.values);
}

template <int D>
bool close_nodes(const QuadraticMesh<D>& a, const QuadraticMesh<D>& b) {
    const auto near = [](const Vec<D>& p, const Vec<D>& q) { return norm(p - q) < 1e-9; };
    return std::ranges::equal(a.linear.points, b.linear.points, near) &&
           std::ranges::equal(a.mid_nodes, b.mid_nodes,
                              [&](const auto& p, const auto& q) { return near(p.point, q.point); });
}

void check_same_elements(const run::Report& a, const run::Report& b) {
    CHECK(a.invalid_elements == b.invalid_elements);
    CHECK(a.undecided_elements == b.undecided_elements);
    CHECK(a.elements_below_bound == b.elements_below_bound);
    REQUIRE(a.validity.has_value() == b.validity.has_value());
    if (a.validity) CHECK(a.validity->worst == b.validity->worst);
}

/// Checks that mesh, fields, metric and reported elements of a reordered run equal those of a run in input order.
template <int D>
run::Run check_same_run(const std::string& rest, const run::Inputs& inputs) {
    CAPTURE(rest);
    run::Inputs here = inputs, there = inputs;
    here.ordering = never;
    there.ordering = always;
    const run::Run run_in_input_order = must(run_of(rest, here)), run_reordered = must(run_of(rest, there));
    CHECK_FALSE(run_in_input_order.report.reordered.has_value());
    CHECK(run_reordered.report.reordered.has_value());
    const auto own = testing::mesh_in<QuadraticMesh<D>>(run_in_input_order.mesh);
    const auto other = testing::mesh_in<QuadraticMesh<D>>(run_reordered.mesh);
    CHECK(other.linear.elements == own.linear.elements);
    CHECK(other.linear.facets == own.linear.facets);
    CHECK(other.linear.edges == own.linear.edges);
    CHECK(other.edges == own.edges);
    CHECK(close_nodes(own, other));
    check_same_elements(run_reordered.report, run_in_input_order.report);
    REQUIRE(run_in_input_order.fields.size() == run_reordered.fields.size());
    for (const MeshField& field : run_in_input_order.fields) {
        CAPTURE(field.name);
        const MeshField* const same = run_reordered.fields.find(field.name, field.centring);
        REQUIRE(same != nullptr);
        CHECK(close(*same, field));
    }
    REQUIRE(run_in_input_order.metric.has_value() == run_reordered.metric.has_value());
    if (run_in_input_order.metric) CHECK(close(run_in_input_order.metric->values, run_reordered.metric->values));
    const run::Run by_three = must(run_of(rest, there, 3));
    CHECK(by_three.mesh == run_reordered.mesh);
    for (const MeshField& field : run_reordered.fields)
        CHECK(close(*by_three.fields.find(field.name, field.centring), field));
    return run_reordered;
}

const std::string validate_stage = R"("validate": {"min_scaled_jacobian": 0.97})";
const std::string with_vtu = R"(, "output": {"vtu": "none.vtu"})";
const std::string with_outputs = R"(, "output": {"vtu": "none.vtu", "metric": "none.sol"})";

template <int D>
void check_runs(const LinearMesh<D>& mesh) {
    run::Inputs inputs{DecodedMesh{AnyMesh(as_mesh(mesh)), {}}, {}};
    const auto result = check_same_run<D>(
        R"(, "stages": ["elevate", "curve", {)" + validate_stage + R"(}, "commit"])" + with_outputs, inputs);
    CHECK_FALSE(result.report.elements_below_bound.empty());
    CHECK_FALSE(result.fields.empty());
    const auto curved = check_same_run<D>(R"(, "stages": [{)" + validate_stage + "}]" + with_outputs,
                                          {DecodedMesh{result.mesh, {}}, {}});
    CHECK(curved.report.elements_below_bound == result.report.elements_below_bound);
    inputs.metric = sizes_of(mesh);
    check_same_run<D>(R"(, "metric": {"file": "sizes.sol"}, "stages": ["elevate", "curve", "commit"])" + with_outputs,
                      inputs);
}

}  // namespace

TEST_CASE("a run in another order gives the results of a run in the input order") {
    check_runs(annulus());
    check_runs(shell());
}

TEST_CASE("errors of reordered runs use the numbers of the input files") {
    const LinearMesh<3> mesh = shell();
    const auto error_of = [&](Solution sizes, const OrderingOptions& ordering) {
        run::Inputs inputs{DecodedMesh{AnyMesh(as_mesh(mesh)), {}}, std::move(sizes), {}, {}, ordering};
        const auto result = run_of(R"(, "metric": {"file": "sizes.sol"})", std::move(inputs));
        REQUIRE_FALSE(result);
        return describe(result.error());
    };
    Solution wrong = sizes_of(mesh);
    auto values = take(std::move(wrong.values));
    values[17] = -1;
    wrong.values = std::move(values);
    CHECK(error_of(wrong, always) == error_of(wrong, never));
    CHECK(error_of(wrong, always).find("vertex 18") != std::string::npos);
    Solution short_one = sizes_of(mesh);
    short_one.values = Column<double>{};
    short_one.rows = 0;
    CHECK(error_of(short_one, always) == error_of(short_one, never));
}

TEST_CASE("notices and corrections of prepare use the input order") {
    LinearMesh<3> mesh = shell();
    auto elements = take(std::move(mesh.elements.vertices));
    auto references = take(std::move(mesh.elements.references));
    std::swap(elements[40][0], elements[40][1]);
    elements.push_back(elements[7]);
    references.push_back(references[7]);
    mesh.elements.vertices = std::move(elements);
    mesh.elements.references = std::move(references);
    mesh.facets = {};
    const run::Inputs inputs{DecodedMesh{AnyMesh(as_mesh(mesh)), {}}, {}};
    const auto result = check_same_run<3>(R"(, "stages": ["elevate", "curve", "commit"])", inputs);
    run::Inputs here = inputs;
    here.ordering = never;
    CHECK(result.report.notices == must(run_of(R"(, "stages": ["elevate", "curve", "commit"])", here)).report.notices);
    CHECK(result.report.notices.size() >= 3);
}

TEST_CASE("remaining elements of reordered runs are reported by input numbers") {
    const auto curved =
        must(run_of(R"(, "stages": ["elevate", "curve", "commit"])", {DecodedMesh{AnyMesh(as_mesh(shell())), {}}, {}}));
    run::Inputs inputs{DecodedMesh{curved.mesh, {}}, {}, {}, {}, always};
    const auto result =
        must(run_of(R"(, "stages": [{"relax": {"min_scaled_jacobian": 0.95, "effort": 0.1}}, "commit"])" + with_vtu,
                    std::move(inputs)));
    REQUIRE_FALSE(result.report.remaining.empty());
    const MeshField* const verdicts = result.fields.find("verdict", Centring::cell);
    REQUIRE(verdicts != nullptr);
    const auto& values = std::get<Column<std::int32_t>>(verdicts->values);
    std::vector<std::size_t> bad, remaining;
    for (std::size_t e = 0; e < count_elements(std::get<Mesh<3>>(result.mesh)); ++e)
        if (values[e] != 0) bad.push_back(e + 1);
    CHECK(result.report.elements_below_bound == bad);
    for (const auto& r : result.report.remaining) remaining.push_back(r.element);
    CHECK(remaining == bad);
}

TEST_CASE("a run with a stage that changes the straight mesh is not reordered") {
    run::Inputs inputs{DecodedMesh{AnyMesh(as_mesh(annulus())), {}}, {}, {}, {}, always};
    const auto result = must(run_of(R"(, "stages": ["smooth", "elevate"])", std::move(inputs)));
    CHECK_FALSE(result.report.reordered.has_value());
}
