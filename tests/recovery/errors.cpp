// Errors of recovery, with the position of the invalid value.
#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <limits>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "fields.hpp"

import camber.core;
import camber.recovery;

using namespace camber;
using namespace camber::testing;

namespace {

const QuadraticMesh<2>& mesh() {
    static const QuadraticMesh<2> m = bent_mesh<2>({3, 3}, 0);
    return m;
}
Column<double> bilinear(int degree) {
    return values_of<2>(mesh(), degree, [](const Vec<2>& x) { return x[0] * x[1]; });
}
Error error_of(const QuadraticMesh<2>& m, const std::vector<Column<double>>& fields,
               const RecoveryOptions& options = {}, const Execution& execution = one_thread) {
    const auto out = recover_derivatives<2>(m, fields, options, execution);
    REQUIRE(!out.has_value());
    return out.error();
}
Column<double> with(Column<double> column, std::size_t i, double value) {
    auto values = take(std::move(column));
    values[i] = value;
    return values;
}

}  // namespace

TEST_CASE("recovery rejects fields whose number of values does not fit the mesh") {
    const auto few = error_of(mesh(), {Column<double>(Buffer<double>(5, 0.0))});
    CHECK(few.kind == ErrorKind::usage);
    CHECK(few.what == "field 1 has 5 values");
    CHECK(few.remedy == "give all fields of a call one value per vertex (16), or one per vertex and one per edge (49)");
    CHECK(error_of(mesh(), {bilinear(2), bilinear(1)}).what == "field 2 has 16 values");
    CHECK(error_of(mesh(), {bilinear(1), bilinear(2)}).what == "field 2 has 49 values");
    auto without = mesh();
    without.mid_nodes = {};
    CHECK(error_of(without, {bilinear(2)}).kind == ErrorKind::input);
}

TEST_CASE("recovery rejects values and coordinates that are not finite") {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinity = std::numeric_limits<double>::infinity();
    const auto at_vertex = error_of(mesh(), {bilinear(2), with(bilinear(2), 3, nan)});
    CHECK(at_vertex.kind == ErrorKind::usage);
    CHECK(describe(at_vertex) ==
          "vertex 4: the value of field 2 is not a finite number (give a solution that has converged)");
    const auto at_edge = error_of(mesh(), {with(bilinear(2), 16 + 5, -infinity)});
    CHECK(at_edge.entity->kind == "edge");
    CHECK(at_edge.entity->number == 6U);

    auto invalid = mesh();
    auto nodes = take(std::move(invalid.mid_nodes));
    nodes[2].point[1] = nan;
    invalid.mid_nodes = std::move(nodes);
    const auto place = error_of(invalid, {bilinear(2)});
    CHECK(place.kind == ErrorKind::input);
    CHECK(describe(place) == "edge 3: has a coordinate that is not a finite number (repair the mesh)");
    CHECK(recover_derivatives<2>(invalid, std::array{bilinear(1)}, {}, one_thread).has_value());
}

TEST_CASE("recovery rejects derivatives that overflow") {
    const auto small = mapped<2>(mesh(), [](const Vec<2>& x) { return 1e-60 * x; });
    auto values = take(bilinear(2));
    for (double& u : values) u *= 1e200;
    const auto error = error_of(small, {bilinear(2), Column<double>(std::move(values))});
    CHECK(error.kind == ErrorKind::usage);
    CHECK(error.what == "derivatives of field 2 are too large for floating-point numbers");
    CHECK(error.entity->kind == "vertex");
    CHECK(recover_derivatives<2>(small, std::array{bilinear(2)}, {}, one_thread).has_value());
}

TEST_CASE("recovery rejects a mesh without element references") {
    auto no_materials = mesh();
    no_materials.linear.elements.references = {};
    CHECK(error_of(no_materials, {bilinear(1)}).what == "there are 0 references for 18 elements");
}

TEST_CASE("recovery rejects fewer than one ring of elements") {
    CHECK(error_of(mesh(), {bilinear(1)}, {.rings = 0}).what.find("must be at least 1") != std::string::npos);
}

TEST_CASE("recovery stops on request") {
    std::stop_source source;
    source.request_stop();
    CHECK(error_of(mesh(), {bilinear(1)}, {}, Execution{.threads = 1, .stop = source.get_token()}).kind ==
          ErrorKind::stopped);
}
