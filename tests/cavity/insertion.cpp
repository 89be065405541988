// The cavity of a point insertion, and its removal.
#include <cstddef>
#include <cstdint>
#include <string>

#include "dice.hpp"
#include "domains.hpp"
#include "filling.hpp"
#include "insertion.hpp"
#include "mesh_invariants.hpp"
#include "property.hpp"
#include "random_operations.hpp"

import camber.core;
import camber.cavity;

using namespace camber;
using namespace camber::testing;

namespace {

/// Two by two (by two) cells of two materials: the interface is x = 1.
template <int D>
DynamicMesh<D> two_materials() {
    LatticeOptions<D> options;
    options.cells.fill(2);
    return dynamic_of(with_references<D>(lattice_mesh(options), options.cells, false));
}

/// The cavity of an insertion, and the new vertex.
template <int D>
struct Expected {
    std::size_t elements, facets, lines;
    VertexPlace place;
    int dimension;
};
template <int D>
void expect_insertion(const DynamicMesh<D>& mesh, const Vec<D>& point, const Expected<D>& expected) {
    const Insertion<D> in = insertion(mesh, point).value();
    CHECK(in.cavity.elements.size() == expected.elements);
    CHECK(in.cavity.facets.size() == expected.facets);
    CHECK(in.cavity.lines.size() == expected.lines);
    CHECK(in.place == expected.place);
    CHECK(in.site.dimension() == expected.dimension);
    CHECK(in.is_at_vertex() == (expected.dimension == 0));
    if (in.is_at_vertex()) {
        CHECK(mesh.points[in.vertex] == point);
        return;
    }
    Patch<D> patch{mesh.stamp, {.vertex = {}, .place = point}, in.cavity, {}};
    StarWorkspace<D> workspace;
    REQUIRE(star(mesh, in.cavity, {}, workspace, patch.star) == StarFailure::none);
    CHECK(patch.star.place == in.place);
    CHECK(fills(mesh, patch));
    CHECK(invariant_violation(must(replace_cavities<D>(mesh, {&patch, 1})).mesh, invariants_of(mesh)) == std::string());
}

}  // namespace

TEST_CASE("insertion finds the cavity and place of a point in 2D") {
    const auto mesh = two_materials<2>();
    expect_insertion<2>(mesh, {{0.5, 0.25}}, {1, 0, 0, VertexPlace::inside, 2});
    expect_insertion<2>(mesh, {{0.25, 0.25}}, {2, 0, 0, VertexPlace::inside, 1});
    expect_insertion<2>(mesh, {{1, 0.25}}, {2, 1, 0, VertexPlace::surface, 1});
    expect_insertion<2>(mesh, {{0.25, 0}}, {1, 1, 0, VertexPlace::surface, 1});
    expect_insertion<2>(mesh, {{0, 1}}, {3, 2, 0, VertexPlace::surface, 0});
    expect_insertion<2>(mesh, {{1, 0}}, {3, 3, 0, VertexPlace::corner, 0});
}

TEST_CASE("insertion finds the cavity and place of a point in 3D") {
    const auto mesh = two_materials<3>();
    expect_insertion<3>(mesh, {{0.75, 0.5, 0.25}}, {1, 0, 0, VertexPlace::inside, 3});
    expect_insertion<3>(mesh, {{0.75, 0.25, 0.25}}, {2, 0, 0, VertexPlace::inside, 2});
    expect_insertion<3>(mesh, {{0.25, 0.25, 0.25}}, {6, 0, 0, VertexPlace::inside, 1});
    expect_insertion<3>(mesh, {{0.75, 0.25, 0}}, {1, 1, 0, VertexPlace::surface, 2});
    expect_insertion<3>(mesh, {{1, 0.75, 0.25}}, {2, 1, 0, VertexPlace::surface, 2});
    expect_insertion<3>(mesh, {{0.25, 0.25, 0}}, {2, 2, 0, VertexPlace::surface, 1});
    expect_insertion<3>(mesh, {{0.25, 0, 0}}, {2, 2, 1, VertexPlace::line, 1});
    expect_insertion<3>(mesh, {{1, 0.25, 0}}, {3, 3, 1, VertexPlace::line, 1});
    const Insertion<3> at_vertex = insertion<3>(mesh, {{1, 1, 1}}).value();
    CHECK(at_vertex.is_at_vertex());
    CHECK(at_vertex.place == VertexPlace::surface);
    CHECK(mesh.points[at_vertex.vertex] == Vec<3>{{1, 1, 1}});
}

namespace {

/// Collapses the new vertex into each neighbour that allows it. One of them restores the elements.
template <int D>
void check_insert_and_remove(std::uint64_t seed) {
    const DynamicMesh<D> mesh = dynamic_of(random_domain<D>(seed));
    const Invariants<D> invariants = invariants_of(mesh);
    Dice dice(seed);
    StarWorkspace<D> workspace;
    const auto place = static_cast<VertexPlace>(dice.below(D));
    const auto in = Trying<D>(mesh, dice, workspace).planned({Operation::insert, place}).patch;
    RC_PRE(in.has_value());
    auto [with, changes] = must(replace_cavities<D>(mesh, {&*in, 1}));
    RC_ASSERT(invariant_violation(with, invariants) == std::string());
    const VertexId point = changes.points.front();
    RC_ASSERT(with.states[point].place == place);
    Patch<D> out{with.stamp, {}, {}, {}};
    cavity_of_vertex(with, point, out.removed);
    bool found = false;
    for (const VertexId v : in->star.boundary) {
        out.point.vertex = v;
        if (!may_collapse(with, out.removed, point, v)) continue;
        if (star(with, out.removed, v, workspace, out.star) != StarFailure::none || !fills(with, out)) continue;
        const auto back = must(replace_cavities<D>(with, {&out, 1})).mesh;
        RC_ASSERT(invariant_violation(back, invariants) == std::string());
        RC_ASSERT(back.vertex_count() == mesh.vertex_count());
        found = found || by_places(back) == by_places(mesh);
    }
    RC_ASSERT(found);
}

}  // namespace

TEST_CASE("insertion and removal of a point restore the mesh") {
    property("removal of an inserted point restores the mesh, 2D",
             [](std::uint64_t seed) { check_insert_and_remove<2>(seed); });
    property("removal of an inserted point restores the mesh, 3D",
             [](std::uint64_t seed) { check_insert_and_remove<3>(seed); }, {.count = 60});
}
