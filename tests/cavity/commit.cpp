// Committing several patches: together, in any order, and errors.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "domains.hpp"
#include "mesh_invariants.hpp"
#include "property.hpp"
#include "random_operations.hpp"

import camber.core;
import camber.cavity;

using namespace camber;
using namespace camber::testing;

namespace {

/// Patches that share no vertex of a removed element.
template <int D>
std::vector<Patch<D>> disjoint_patches(const DynamicMesh<D>& mesh, Dice& dice, std::size_t tries) {
    StarWorkspace<D> workspace;
    Trying<D> trying(mesh, dice, workspace);
    std::vector<Patch<D>> patches;
    std::vector<std::uint8_t> claimed(mesh.points.size(), 0);
    for (std::size_t t = 0; t < tries; ++t) {
        auto patch = trying.planned(kinds<D>()[dice.below(kinds<D>().size())]).patch;
        if (!patch) continue;
        std::vector<VertexId> vertices;
        for (const ElementId e : patch->removed.elements)
            for (const VertexId v : mesh.elements.vertices[e]) vertices.push_back(v);
        if (std::ranges::any_of(vertices, [&](VertexId v) { return claimed[v.index()] != 0; })) continue;
        for (const VertexId v : vertices) claimed[v.index()] = 1;
        patches.push_back(std::move(*patch));
    }
    return patches;
}

template <int D>
void check_commuting(std::uint64_t seed) {
    Dice dice(seed);
    const DynamicMesh<D> mesh = dynamic_of(random_domain<D>(seed));
    auto patches = disjoint_patches(mesh, dice, 60);
    const auto once = must(replace_cavities<D>(mesh, patches)).mesh;
    RC_ASSERT(consistency_violation(once) == std::string());
    std::reverse(patches.begin(), patches.end());
    RC_ASSERT(by_places(must(replace_cavities<D>(mesh, patches)).mesh) == by_places(once));
}

}  // namespace

TEST_CASE("disjoint patches commute") {
    property("disjoint patches commute, 2D", [](std::uint64_t seed) { check_commuting<2>(seed); });
    property("disjoint patches commute, 3D", [](std::uint64_t seed) { check_commuting<3>(seed); }, {.count = 40});
}

TEST_CASE("replace_cavities without patches changes nothing") {
    const DynamicMesh<3> mesh = dynamic_of(random_domain<3>(7));
    const auto same = must(replace_cavities<3>(mesh, {}));
    CHECK(same.mesh.elements == mesh.elements);
    CHECK(same.mesh.stamp == mesh.stamp);
    CHECK(same.changes == TopologyChanges{});
}

// Guards against a commit that accepts any verdicts of the right length.
TEST_CASE("replace_cavities rejects overlapping patches and patches of another mesh") {
    const DynamicMesh<3> mesh = dynamic_of(random_domain<3>(7));
    StarWorkspace<3> workspace;
    Dice dice(1);
    const auto patch = Trying<3>(mesh, dice, workspace).planned({Operation::insert, VertexPlace::inside}).patch.value();
    const std::array twice{patch, patch};
    const auto overlap = replace_cavities<3>(mesh, twice);
    REQUIRE(!overlap.has_value());
    CHECK(overlap.error().what == "two patches remove the same element");
    const auto changed = must(replace_cavities<3>(mesh, {&patch, 1})).mesh;
    const auto late = replace_cavities<3>(changed, {&patch, 1});
    REQUIRE(!late.has_value());
    CHECK(late.error().what == "a patch was planned for another mesh");
    CHECK(check_consistency(mesh, one_thread).has_value());
}
