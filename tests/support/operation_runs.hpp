// Runs many random operations on a random domain and checks invariants in between.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "dice.hpp"
#include "domains.hpp"
#include "mesh_invariants.hpp"
#include "random_operations.hpp"

import camber.core;
import camber.cavity;

namespace camber::testing {

/// Number of attempts by kind and result.
template <int D>
struct Tally {
    struct Row {
        std::size_t accepted = 0;
        std::array<std::size_t, refusals> refused{};
    };
    std::array<Row, kinds<D>().size()> rows{};

    void count(std::size_t kind, Refusal refused) {
        Row& row = rows[kind];
        ++(refused == Refusal::none ? row.accepted : row.refused[static_cast<std::size_t>(refused)]);
    }
    [[nodiscard]] std::size_t least() const {
        std::size_t least = rows[0].accepted;
        for (const Row& row : rows) least = std::min(least, row.accepted);
        return least;
    }
};

/// Number of steps, maximum mesh size and interval of the checks.
struct RunOptions {
    std::size_t steps = 400;
    std::size_t max_elements = 600;
    std::size_t steps_a_check = 16;
};

/// A random domain, in half of the cases with required entities.
template <int D>
LinearMesh<D> domain_with_required(std::uint64_t seed) {
    LinearMesh<D> mesh = random_domain<D>(seed);
    Dice dice(seed + 3);
    if (dice.below(2) == 0) return mesh;
    mesh.required_vertices = Buffer<VertexId>{VertexId(dice.below(mesh.points.size()))};
    mesh.facets.required = Buffer<std::uint32_t>{static_cast<std::uint32_t>(dice.below(mesh.facets.size()))};
    mesh.elements.required = Buffer<std::uint32_t>{static_cast<std::uint32_t>(dice.below(mesh.elements.size()))};
    return mesh;
}

/// Returns a random kind; a collapse if the mesh is too large.
template <int D>
std::size_t next_kind(const DynamicMesh<D>& mesh, std::size_t max_elements, Dice& dice) {
    constexpr auto all = kinds<D>();
    for (;;) {
        const std::size_t kind = dice.below(all.size());
        if (mesh.element_count() <= max_elements || all[kind].operation == Operation::collapse) return kind;
    }
}

/// Runs operations that keep elements positive. Returns the violated invariant and its step, or an empty string.
template <int D>
std::string run_operations(std::uint64_t seed, const RunOptions& options, Tally<D>& tally) {
    Dice dice(seed);
    DynamicMesh<D> mesh = dynamic_of(domain_with_required<D>(seed));
    const Invariants<D> invariants = invariants_of(mesh);
    StarWorkspace<D> workspace;
    const auto broken_at = [&](std::size_t step, const std::string& violation) {
        return "seed " + std::to_string(seed) + ", step " + std::to_string(step) + ": " + violation;
    };
    for (std::size_t step = 0; step < options.steps; ++step) {
        const std::size_t kind = next_kind(mesh, options.max_elements, dice);
        const auto [patch, refused] = Trying<D>(mesh, dice, workspace).planned(kinds<D>()[kind]);
        tally.count(kind, refused);
        if (!patch) continue;
        const DynamicMesh<D> before = mesh;
        auto [after, changes] = must(replace_cavities<D>(std::move(mesh), {&*patch, 1}));
        mesh = std::move(after);
        if (const std::string violation = step % 8 == 0 ? changes_violation(before, mesh, changes) : "";
            !violation.empty())
            return broken_at(step, violation);
        if (step % options.steps_a_check != 0) continue;
        if (const std::string violation = topology_violation(mesh, invariants); !violation.empty())
            return broken_at(step, violation);
    }
    const std::string violation = invariant_violation(mesh, invariants);
    return violation.empty() ? "" : broken_at(options.steps, violation);
}

/// Runs operations by topology only: elements may be inverted.
template <int D>
std::string run_topology(std::uint64_t seed, const RunOptions& options, Tally<D>& tally) {
    Dice dice(seed);
    DynamicMesh<D> mesh = dynamic_of(domain_with_required<D>(seed));
    const Invariants<D> invariants = invariants_of(mesh);
    StarWorkspace<D> workspace;
    for (std::size_t step = 0; step < options.steps; ++step) {
        const std::size_t kind = next_kind(mesh, options.max_elements, dice);
        const auto [patch, refused] = Trying<D>(mesh, dice, workspace).starred(kinds<D>()[kind]);
        tally.count(kind, refused);
        if (!patch) continue;
        mesh = must(replace_cavities<D>(std::move(mesh), {&*patch, 1})).mesh;
        if (step % options.steps_a_check != 0) continue;
        if (const std::string violation = topology_violation(mesh, invariants); !violation.empty())
            return "seed " + std::to_string(seed) + ", step " + std::to_string(step) + ": " + violation;
    }
    for (const std::string& broken : {characteristics_violation(mesh, invariants), rebuild_violation(mesh)})
        if (!broken.empty()) return "seed " + std::to_string(seed) + ": " + broken;
    return "";
}

}  // namespace camber::testing
