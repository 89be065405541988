// How scattered a mesh is, and the order along the curve: of any numbering the same places in the same order.
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

/// A lattice with any cells left out, numbered at random unless the seed is 0.
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

/// Of elements numbered at random: 2k/((k + 1)(2k + 1)), the mean distance of the least of k numbers from [0, 1].
template <int D>
constexpr double scatter_at_random = 2.0 * (D + 1) / ((D + 2) * (2 * D + 3));

template <int D>
void scatter_laws(int cells) {
    CAPTURE(D);
    const auto ordered = lattice<D>(cells, 0), shuffled = lattice<D>(cells, 5);
    CHECK(must(scatter(ordered, alone)) < 0.02);
    CHECK(must(scatter(shuffled, alone)) == doctest::Approx(scatter_at_random<D>).epsilon(0.05));
    CHECK_FALSE(must(better_order(ordered, any_mesh, alone)).has_value());
    CHECK_FALSE(must(better_order(shuffled, {.min_elements = 1'000'000}, alone)).has_value());
    const auto better = must(better_order(shuffled, any_mesh, alone));
    REQUIRE(better.has_value());
    CHECK(better->scatter == must(scatter(shuffled, alone)));
    CHECK(must(scatter(must(renumbered(shuffled, better->renumbering, alone)), alone)) < 0.01);
}

template <int D>
void places_law(std::uint64_t seed) {
    Dice dice(seed);
    const int cells = 1 + static_cast<int>(dice.below(D == 2 ? 12 : 5));
    const auto one = lattice<D>(cells, seed | 1U), other = lattice<D>(cells, 2 * seed + 3);
    const auto order = must(space_filling_order(one, alone));
    RC_ASSERT(names_each_once(order.vertices));
    RC_ASSERT(names_each_once(order.elements));
    const auto by_three = must(space_filling_order(one, Execution{.threads = 3}));
    RC_ASSERT(order.vertices.before == by_three.vertices.before);
    RC_ASSERT(order.elements.before == by_three.elements.before);
    const auto made = must(renumbered(one, order, alone));
    RC_ASSERT(made.points == must(renumbered(other, must(space_filling_order(other, alone)), alone)).points);
    const auto lowest = [&](std::size_t e) { return std::ranges::min(made.elements.vertices[e]); };
    for (std::size_t e = 1; e < made.elements.size(); ++e) RC_ASSERT(lowest(e - 1) <= lowest(e));
}

}  // namespace

TEST_CASE("a mesh in random order is found, and none that is in a good one") {
    scatter_laws<2>(60);
    scatter_laws<3>(16);
}

TEST_CASE("order along the curve") {
    property("2D: the same places, whatever the numbering", [](std::uint64_t seed) { places_law<2>(seed); });
    property("3D: the same places, whatever the numbering", [](std::uint64_t seed) { places_law<3>(seed); });
}

TEST_CASE("neighbours on the curve of a square are cells of a quarter, of a quarter of it …") {
    LinearMesh<2> mesh;
    Buffer<Vec<2>> points;
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) points.push_back({{static_cast<double>(x), static_cast<double>(y)}});
    mesh.points = std::move(points);
    const auto order = must(space_filling_order(mesh, alone));
    std::vector<std::uint32_t> ids;
    for (const VertexId v : order.vertices.before) ids.push_back(v.value);
    CHECK(ids == std::vector<std::uint32_t>{0, 4, 1, 5, 8, 12, 9, 13, 2, 6, 3, 7, 10, 14, 11, 15});
}

TEST_CASE("what has no extent, or a great one, is put into order too") {
    for (const double size : {0.0, 1e-60, 1.7e308}) {
        CAPTURE(size);
        LinearMesh<3> mesh;
        Buffer<Vec<3>> points;
        for (int i = 0; i < 5; ++i) points.push_back({{i % 2 == 0 ? size : -size, 7, 0}});
        mesh.points = std::move(points);
        const auto order = must(space_filling_order(mesh, alone));
        CHECK(names_each_once(order.vertices));
        const std::uint32_t first = order.vertices.before[0].value;
        CHECK(first == (size == 0 ? 0U : 1U));
    }
    CHECK(must(space_filling_order(LinearMesh<2>{}, alone)).vertices.before.empty());
    CHECK(must(scatter(LinearMesh<2>{}, alone)) == 0);
}
