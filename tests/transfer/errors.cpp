// Errors of transfer, and meshes with few elements.
#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "fields.hpp"
#include "meshes.hpp"

import camber.core;
import camber.bezier;
import camber.transfer;

using namespace camber;
using namespace camber::testing;

namespace {

Error refused(const QuadraticMesh<2>& from, const std::vector<TransferField>& fields, const QuadraticMesh<2>& to,
              const TransferOptions& options = {}, const Execution& execution = one_thread) {
    const auto out = transfer<2>(from, fields, to, options, execution);
    REQUIRE(!out);
    return out.error();
}

TransferField with_value(TransferField field, std::size_t i, double value) {
    auto values = take(std::move(field.values));
    values[i] = value;
    field.values = std::move(values);
    return field;
}

}  // namespace

TEST_CASE("transfer rejects invalid fields and options") {
    Dice dice(1);
    const auto mesh = quadratic(rough_box<2>(2, 1));
    const std::size_t nodes = node_count_of(mesh, 2), vertices = node_count_of(mesh, 1);
    const auto good = rough_field(nodes, 2, 2, dice);
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();

    auto error = refused(mesh, {good, rough_field(vertices, 2, 2, dice)}, mesh);
    CHECK(error.kind == ErrorKind::usage);
    CHECK(error.where == "field 2");
    CHECK(error.what ==
          std::to_string(2 * vertices) + " values for " + std::to_string(nodes) + " nodes of 2 components");

    error = refused(mesh, {with_value(good, 2 * 4 + 1, nan)}, mesh);
    CHECK(error.kind == ErrorKind::input);
    CHECK(error.entity->kind == "vertex");
    CHECK(error.entity->number == 5);
    error = refused(mesh, {with_value(good, 2 * (vertices + 3), std::numeric_limits<double>::infinity())}, mesh);
    CHECK(error.entity->kind == "edge");
    CHECK(error.entity->number == 4);

    CHECK(refused(mesh, {{.components = 2, .degree = 3, .values = good.values}}, mesh).kind == ErrorKind::usage);
    CHECK(refused(mesh, {{.components = 0, .degree = 2, .values = {}}}, mesh).kind == ErrorKind::usage);
    CHECK(refused(mesh, {good}, mesh, {.points = 2}).kind == ErrorKind::usage);
}

TEST_CASE("transfer stops on request") {
    Dice dice(1);
    const auto mesh = quadratic(rough_box<2>(2, 1));
    const auto good = rough_field(node_count_of(mesh, 2), 2, 2, dice);
    std::stop_source source;
    source.request_stop();
    CHECK(refused(mesh, {good}, mesh, {}, {.threads = 1, .stop = source.get_token()}).kind == ErrorKind::stopped);
}

TEST_CASE("transfer rejects invalid meshes") {
    Dice dice(1);
    const auto mesh = quadratic(rough_box<2>(2, 1));
    const auto field = rough_field(node_count_of(mesh, 2), 2, 1, dice);
    auto broken = mesh;
    auto mid_nodes = take(broken.mid_nodes);
    mid_nodes[2].point[1] = std::numeric_limits<double>::quiet_NaN();
    broken.mid_nodes = mid_nodes;
    auto error = refused(mesh, {field}, broken);
    CHECK(error.kind == ErrorKind::input);
    CHECK(error.where == "the new mesh");
    CHECK(error.entity->kind == "edge");
    CHECK(error.entity->number == 3);
    CHECK(refused(broken, {field}, mesh).where == "the old mesh");

    const QuadraticMesh<2> empty;
    CHECK(refused(empty, {TransferField{}}, mesh).kind == ErrorKind::input);
    mid_nodes.pop_back();
    broken.mid_nodes = mid_nodes;
    CHECK(refused(mesh, {field}, broken).kind == ErrorKind::usage);
}

TEST_CASE("transfer handles empty meshes and a mesh of one element") {
    Dice dice(1);
    const auto mesh = quadratic(rough_box<3>(2, 1));
    const QuadraticMesh<3> empty;
    for (const auto& method : words(TransferMethod{})) {
        const TransferOptions options{.method = method.value};
        CHECK(transferred<3>(mesh, {}, mesh, options).fields.empty());
        CHECK(transferred<3>(empty, {TransferField{}}, empty, options).fields[0].values.empty());
        CHECK(transferred<3>(mesh, {rough_field(node_count_of(mesh, 2), 2, 1, dice)}, empty, options)
                  .fields[0]
                  .values.empty());
        // One tetrahedron across many elements.
        const auto one = quadratic(
            mesh_of<3>(Buffer<Vec<3>>{{{0.1, 0.1, 0.1}}, {{0.9, 0.2, 0.1}}, {{0.2, 0.8, 0.1}}, {{0.1, 0.2, 0.9}}},
                       Buffer<SimplexVertices<3>>{{VertexId(0), VertexId(1), VertexId(2), VertexId(3)}}));
        const std::vector<Function<3>> functions{polynomial<3>(2, dice)};
        const auto out = transferred<3>(mesh, {field_of(mesh, 2, functions)}, one, {});
        CHECK(largest_difference(out.fields[0], field_of(one, 2, functions)) < 1e-13);
    }
}
