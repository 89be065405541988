// Scatter of a mesh, and the space-filling order, which is independent of the numbering.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "meshes.hpp"
#include "property.hpp"

import camber.core;
import camber.ordering;

using namespace camber;
using namespace camber::testing;

namespace {

/// A lattice, numbered at random unless the seed is 0.
template <int D>
LinearMesh<D> lattice(int cells, std::uint64_t seed) {
    LatticeOptions<D> options;
    options.cells.fill(cells);
    options.seed = seed;
    return lattice_mesh(options);
}

constexpr OrderingOptions any_mesh{.min_elements = 0};

template <class EntityId>
bool names_each_once(const Permutation<EntityId>& p) {
    std::vector<char> named(p.before.size());
    for (const EntityId id : p.before) named[id.index()] = 1;
    bool inverse = p.after.size() == p.before.size();
    for (std::size_t i = 0; i < p.before.size(); ++i) inverse = inverse && p.after[p.before[i]] == EntityId(i);
    return inverse && std::ranges::all_of(named, [](char c) { return c == 1; });
}

/// Scatter of randomly numbered elements: 2k/((k + 1)(2k + 1)) with k = D + 1, the mean distance between the minima of
/// k numbers from [0, 1].
template <int D>
constexpr double scatter_at_random = 2.0 * (D + 1) / ((D + 2) * (2 * D + 3));

template <int D>
void check_scatter(int cells) {
    CAPTURE(D);
    const auto ordered = lattice<D>(cells, 0), shuffled = lattice<D>(cells, 5);
    CHECK(must(scatter(ordered, one_thread)) < 0.02);
    CHECK(must(scatter(shuffled, one_thread)) == doctest::Approx(scatter_at_random<D>).epsilon(0.05));
    CHECK_FALSE(must(better_order(ordered, any_mesh, one_thread)).has_value());
    CHECK_FALSE(must(better_order(shuffled, {.min_elements = 1'000'000}, one_thread)).has_value());
    const auto better = must(better_order(shuffled, any_mesh, one_thread));
    REQUIRE(better.has_value());
    CHECK(better->scatter == must(scatter(shuffled, one_thread)));
    CHECK(must(scatter(must(renumbered(shuffled, better->renumbering, one_thread)), one_thread)) < 0.01);
}

template <int D>
void check_order(std::uint64_t seed) {
    Dice dice(seed);
    const int cells = 1 + static_cast<int>(dice.below(D == 2 ? 12 : 5));
    const auto one = lattice<D>(cells, seed | 1U), other = lattice<D>(cells, 2 * seed + 3);
    const auto order = must(space_filling_order(one, one_thread));
    RC_ASSERT(names_each_once(order.vertices));
    RC_ASSERT(names_each_once(order.elements));
    const auto by_three = must(space_filling_order(one, Execution{.threads = 3}));
    RC_ASSERT(order.vertices.before == by_three.vertices.before);
    RC_ASSERT(order.elements.before == by_three.elements.before);
    const auto renumbered_mesh = must(renumbered(one, order, one_thread));
    RC_ASSERT(renumbered_mesh.points ==
              must(renumbered(other, must(space_filling_order(other, one_thread)), one_thread)).points);
    const auto lowest = [&](std::size_t e) { return std::ranges::min(renumbered_mesh.elements.vertices[e]); };
    for (std::size_t e = 1; e < renumbered_mesh.elements.size(); ++e) RC_ASSERT(lowest(e - 1) <= lowest(e));
}

}  // namespace

TEST_CASE("better_order improves a shuffled mesh and keeps an ordered one") {
    check_scatter<2>(60);
    check_scatter<3>(16);
}

TEST_CASE("space-filling order does not depend on the numbering of the mesh") {
    property("the order has the same positions for any numbering, 2D",
             [](std::uint64_t seed) { check_order<2>(seed); });
    property("the order has the same positions for any numbering, 3D",
             [](std::uint64_t seed) { check_order<3>(seed); });
}

TEST_CASE("space-filling order visits a square quarter by quarter") {
    LinearMesh<2> mesh;
    Buffer<Vec<2>> points;
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) points.push_back({{static_cast<double>(x), static_cast<double>(y)}});
    mesh.points = std::move(points);
    const auto order = must(space_filling_order(mesh, one_thread));
    std::vector<std::uint32_t> ids;
    for (const VertexId v : order.vertices.before) ids.push_back(v.value);
    CHECK(ids == std::vector<std::uint32_t>{0, 4, 1, 5, 8, 12, 9, 13, 2, 6, 3, 7, 10, 14, 11, 15});
}

TEST_CASE("space-filling order accepts empty meshes and any extent") {
    for (const double size : {0.0, 1e-60, 1.7e308}) {
        CAPTURE(size);
        LinearMesh<3> mesh;
        Buffer<Vec<3>> points;
        for (int i = 0; i < 5; ++i) points.push_back({{i % 2 == 0 ? size : -size, 7, 0}});
        mesh.points = std::move(points);
        const auto order = must(space_filling_order(mesh, one_thread));
        CHECK(names_each_once(order.vertices));
        const std::uint32_t first = order.vertices.before[0].value;
        CHECK(first == (size == 0 ? 0U : 1U));
    }
    CHECK(must(space_filling_order(LinearMesh<2>{}, one_thread)).vertices.before.empty());
    CHECK(must(scatter(LinearMesh<2>{}, one_thread)) == 0);
}
