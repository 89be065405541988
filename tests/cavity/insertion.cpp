// Where a point lies, the cavity of its insertion, and its way out again.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "dice.hpp"
#include "domains.hpp"
#include "filling.hpp"
#include "mesh_laws.hpp"
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

/// What the point's insertion takes out and makes of it; from each element as a hint, it is the same.
template <int D>
struct Expected {
    std::size_t elements, facets, lines;
    VertexPlace place;
    int dimension;
};
template <int D>
void expect_insertion(const DynamicMesh<D>& mesh, const Vec<D>& point, const Expected<D>& expected) {
    for (std::size_t hint = 0; hint < mesh.elements.size(); ++hint) {
        const Insertion<D> in = must(insertion(mesh, point, ElementId(hint)));
        CHECK(in.cavity.elements.size() == expected.elements);
        CHECK(in.cavity.facets.size() == expected.facets);
        CHECK(in.cavity.lines.size() == expected.lines);
        CHECK(in.place == expected.place);
        CHECK(in.site.dimension() == expected.dimension);
        CHECK(in.is_at_vertex() == (expected.dimension == 0));
        if (in.is_at_vertex()) {
            CHECK(mesh.points[in.vertex] == point);
            continue;
        }
        Patch<D> patch{mesh.stamp, {.vertex = {}, .place = point}, in.cavity, {}};
        StarWorkspace<D> workspace;
        REQUIRE(star(mesh, in.cavity, {}, workspace, patch.star) == StarFailure::none);
        CHECK(patch.star.place == in.place);
        CHECK(fills(mesh, patch));
        CHECK(unless_all_holds(must(replace_cavities<D>(mesh, {&patch, 1})).mesh, kept_by(mesh)) == std::string());
    }
}

}  // namespace

TEST_CASE("a point in a triangle, on an edge, on a curve, at a vertex") {
    const auto mesh = two_materials<2>();
    expect_insertion<2>(mesh, {{0.5, 0.25}}, {1, 0, 0, VertexPlace::inside, 2});
    expect_insertion<2>(mesh, {{0.25, 0.25}}, {2, 0, 0, VertexPlace::inside, 1});
    expect_insertion<2>(mesh, {{1, 0.25}}, {2, 1, 0, VertexPlace::surface, 1});
    expect_insertion<2>(mesh, {{0.25, 0}}, {1, 1, 0, VertexPlace::surface, 1});
    expect_insertion<2>(mesh, {{0, 1}}, {3, 2, 0, VertexPlace::surface, 0});
    expect_insertion<2>(mesh, {{1, 0}}, {3, 3, 0, VertexPlace::corner, 0});
}

TEST_CASE("a point in a tetrahedron, on a face, an edge, a facet, a line, at a vertex") {
    const auto mesh = two_materials<3>();
    expect_insertion<3>(mesh, {{0.75, 0.5, 0.25}}, {1, 0, 0, VertexPlace::inside, 3});
    expect_insertion<3>(mesh, {{0.75, 0.25, 0.25}}, {2, 0, 0, VertexPlace::inside, 2});
    expect_insertion<3>(mesh, {{0.25, 0.25, 0.25}}, {6, 0, 0, VertexPlace::inside, 1});
    expect_insertion<3>(mesh, {{0.75, 0.25, 0}}, {1, 1, 0, VertexPlace::surface, 2});
    expect_insertion<3>(mesh, {{1, 0.75, 0.25}}, {2, 1, 0, VertexPlace::surface, 2});
    expect_insertion<3>(mesh, {{0.25, 0.25, 0}}, {2, 2, 0, VertexPlace::surface, 1});
    expect_insertion<3>(mesh, {{0.25, 0, 0}}, {2, 2, 1, VertexPlace::line, 1});
    expect_insertion<3>(mesh, {{1, 0.25, 0}}, {3, 3, 1, VertexPlace::line, 1});
    const Insertion<3> at_vertex = must(insertion<3>(mesh, {{1, 1, 1}}));
    CHECK(at_vertex.is_at_vertex());
    CHECK(at_vertex.place == VertexPlace::surface);
    CHECK(mesh.points[at_vertex.vertex] == Vec<3>{{1, 1, 1}});
}

TEST_CASE("a point outside of the mesh is an error") {
    const auto mesh = two_materials<3>();
    for (std::size_t hint = 0; hint < mesh.elements.size(); ++hint) {
        const auto out = insertion<3>(mesh, {{0.5, 0.5, -1e-3}}, ElementId(hint));
        REQUIRE(!out.has_value());
        CHECK(out.error().kind == ErrorKind::input);
        CHECK(describe(out.error()) == "the point (0.500000, 0.500000, -0.001000) is not in the mesh");
    }
    CHECK(!insertion<3>(mesh, {{0.5, std::numeric_limits<double>::quiet_NaN(), 0.5}}).has_value());
    CHECK(!insertion<3>(DynamicMesh<3>{}, {{0.5, 0.5, 0.5}}).has_value());
    CHECK(insertion<3>(mesh, {{0.5, 0.5, 0.5}}, ElementId(100000)).has_value());
}

TEST_CASE("what is nearer than rounding counts as on it; without a tolerance the signs are exact") {
    const auto mesh = two_materials<2>();
    CHECK(must(locate<2>(mesh, {{0.25, 1e-12}})).dimension() == 1);
    CHECK(must(locate<2>(mesh, {{0.25, -1e-12}})).dimension() == 1);
    CHECK(!locate<2>(mesh, {{0.25, -1e-6}}).has_value());
    CHECK(must(locate<2>(mesh, {{0.25, 1e-12}}, {}, 0)).dimension() == 2);
    CHECK(!locate<2>(mesh, {{0.25, -1e-300}}, {}, 0).has_value());
    CHECK(must(locate<2>(mesh, {{0.25, 0}}, {}, 0)).dimension() == 1);
    CHECK(must(locate<2>(mesh, {{0.3, 0.3}}, {}, 0)).dimension() == 1);
    CHECK(must(locate<2>(mesh, {{0.3, std::nextafter(0.3, 1.0)}}, {}, 0)).dimension() == 2);
}

TEST_CASE("a point beyond a hole is found, and one in the hole is not in the mesh") {
    LatticeOptions<2> options;
    options.cells = {3, 3};
    options.keep = [](const Cell<2>& c) { return c != Cell<2>{1, 1}; };
    const auto mesh = dynamic_of(with_references<2>(lattice_mesh(options), options.cells, false));
    for (std::size_t hint = 0; hint < mesh.elements.size(); ++hint) {
        CHECK(must(locate<2>(mesh, {{2.5, 1.75}}, ElementId(hint))).dimension() == 2);
        CHECK(!locate<2>(mesh, {{1.5, 1.5}}, ElementId(hint)).has_value());
        CHECK(must(locate<2>(mesh, {{1, 1.5}}, ElementId(hint))).dimension() == 1);
    }
}

namespace {

/// Back into each vertex around it that allows it: one of them gives the same elements again.
template <int D>
void put_in_and_taken_out(std::uint64_t seed) {
    const DynamicMesh<D> mesh = dynamic_of(random_domain<D>(seed));
    const Kept<D> kept = kept_by(mesh);
    Dice dice(seed);
    StarWorkspace<D> workspace;
    const auto place = static_cast<VertexPlace>(dice.below(D));
    const auto in = Trying<D>(mesh, dice, workspace).planned({Operation::insert, place}).patch;
    RC_PRE(in.has_value());
    auto [with, changes] = must(replace_cavities<D>(mesh, {&*in, 1}));
    RC_ASSERT(unless_all_holds(with, kept) == std::string());
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
        RC_ASSERT(unless_all_holds(back, kept) == std::string());
        RC_ASSERT(back.vertex_count() == mesh.vertex_count());
        found = found || by_places(back) == by_places(mesh);
    }
    RC_ASSERT(found);
}

}  // namespace

TEST_CASE("a point that is put in and taken out again leaves the mesh as it was") {
    property("put in and taken out, 2D", [](std::uint64_t seed) { put_in_and_taken_out<2>(seed); });
    property("put in and taken out, 3D", [](std::uint64_t seed) { put_in_and_taken_out<3>(seed); }, {.count = 60});
}
