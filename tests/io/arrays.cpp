// Tests of the conversion between meshes and arrays in memory.
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "any_mesh.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.io;

using namespace camber;
using camber::testing::property;

namespace {

template <int D>
MeshArrays<D> fan(std::size_t cells) {
    Buffer<Vec<D>> points(cells + D);
    for (std::size_t p = 0; p < points.size(); ++p)
        for (std::size_t d = 0; d < D; ++d) points[p][d] = std::cos(static_cast<double>(p * D + d));
    Buffer<SimplexVertices<D>> rows(cells);
    Buffer<Reference> references(cells);
    for (std::size_t c = 0; c < cells; ++c) {
        for (std::size_t i = 0; i <= D; ++i) rows[c][i] = VertexId(i == 0 ? 0 : c + i);
        references[c] = static_cast<Reference>(c % 3);
    }
    MeshArrays<D> arrays{.points = Column<Vec<D>>(std::move(points))};
    arrays.elements.straight = {Column<SimplexVertices<D>>(std::move(rows)), Column<Reference>(std::move(references))};
    return arrays;
}

template <int D>
LinearMesh<D> linear_of(const DecodedMesh& mesh) {
    return testing::mesh_in<LinearMesh<D>>(mesh.mesh);
}

template <int D>
void check_shared_columns() {
    const auto arrays = fan<D>(5);
    const auto result = mesh_of_arrays<D>(arrays, {});
    REQUIRE(result);
    CHECK(linear_of<D>(*result).points.data() == arrays.points.data());
    CHECK(linear_of<D>(*result).elements.vertices.data() == arrays.elements.straight.nodes.data());
    CHECK(linear_of<D>(*result).point_references.size() == arrays.points.size());
}

/// Returns the arrays of an elevated mesh, with its mid nodes after the points.
template <int D>
MeshArrays<D> arrays_of(const QuadraticMesh<D>& mesh) {
    Buffer<Vec<D>> points(mesh.linear.points.begin(), mesh.linear.points.end());
    for (const LagrangeNode<D>& node : mesh.mid_nodes) points.push_back(node.point);
    MeshArrays<D> arrays{.points = Column<Vec<D>>(std::move(points))};
    arrays.elements.curved = {
        nodes_of_cells<D>(mesh.linear.elements.vertices, mesh.edges.of_elements, mesh.linear.points.size()),
        mesh.linear.elements.references};
    return arrays;
}

template <int D>
void check_round_trip() {
    const auto result = mesh_of_arrays<D>(fan<D>(6), {});
    REQUIRE(result);
    const auto curved = elevate(linear_of<D>(*result), {});
    REQUIRE(curved);
    const auto again = mesh_of_arrays<D>(arrays_of<D>(*curved), {});
    REQUIRE(again);
    CHECK(testing::mesh_in<QuadraticMesh<D>>(again->mesh) == *curved);
}

template <int D>
std::string error_message(MeshArrays<D> arrays) {
    const auto result = mesh_of_arrays<D>(std::move(arrays), {});
    return result ? "not refused" : describe(result.error());
}

}  // namespace

TEST_CASE("a degree-1 mesh made from arrays shares their columns") {
    check_shared_columns<2>();
    check_shared_columns<3>();
}

TEST_CASE("the arrays of a degree-2 mesh give the same mesh") {
    check_round_trip<2>();
    check_round_trip<3>();
}

TEST_CASE("points_of shares coordinates that have an owner and copies others") {
    const auto owner = std::make_shared<std::vector<double>>(std::vector<double>{0, 1, 2, 3, 4, 5});
    const auto shared = points_of<3>(*owner, owner);
    CHECK(shared.size() == 2);
    CHECK(static_cast<const void*>(shared.data()) == owner->data());
    CHECK(shared[1][2] == 5);
    const auto copied = points_of<2>(*owner, nullptr);
    CHECK(copied.size() == 3);
    CHECK(static_cast<const void*>(copied.data()) != owner->data());
}

TEST_CASE("invalid arrays are rejected with their row") {
    auto arrays = fan<3>(4);
    Buffer<Vec<3>> points(arrays.points.begin(), arrays.points.end());
    points[3][1] = std::numeric_limits<double>::infinity();
    auto infinite = arrays;
    infinite.points = Column<Vec<3>>(std::move(points));
    CHECK(error_message(infinite) == "points: row 3: has a coordinate that is not finite");
    const auto with_node = [&](std::size_t cell, std::size_t i, VertexId v) {
        auto rows = take(arrays.elements.straight.nodes);
        rows[cell][i] = v;
        auto wrong = arrays;
        wrong.elements.straight.nodes = Column<SimplexVertices<3>>(std::move(rows));
        return wrong;
    };
    CHECK(error_message(with_node(2, 1, VertexId(std::size_t{7}))) ==
          "tetra: row 2: has a node that is none of the 7 points (points are numbered from 0)");
    CHECK(error_message(with_node(1, 3, VertexId(std::size_t{0}))) == "tetra: row 1: has a node twice");
    auto too_few_references = arrays;
    too_few_references.elements.straight.references = Column<Reference>(Buffer<Reference>(2, 0));
    CHECK(error_message(too_few_references) == "tetra: 2 references of 4 cells (give one per cell, or none)");
}
