// Many random operations on a random domain, with its laws looked at along the way.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "dice.hpp"
#include "domains.hpp"
#include "mesh_laws.hpp"
#include "random_operations.hpp"

import camber.core;
import camber.cavity;

namespace camber::testing {

/// What became of the tries, by kind.
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

/// How operations are run: how large the mesh may grow, and how often it is looked at.
struct RunOptions {
    std::size_t steps = 400;
    std::size_t max_elements = 600;
    std::size_t steps_a_check = 16;
};

/// A random domain some of whose entities must stay.
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

/// Small meshes grow, large ones shrink.
template <int D>
std::size_t next_kind(const DynamicMesh<D>& mesh, std::size_t max_elements, Dice& dice) {
    constexpr auto all = kinds<D>();
    for (;;) {
        const std::size_t kind = dice.below(all.size());
        if (mesh.element_count() <= max_elements || all[kind].operation == Operation::collapse) return kind;
    }
}

/// Operations whose geometry fits as well. Says which law broke, and at which step; nothing where all hold.
template <int D>
std::string run_operations(std::uint64_t seed, const RunOptions& options, Tally<D>& tally) {
    Dice dice(seed);
    DynamicMesh<D> mesh = dynamic_of(domain_with_required<D>(seed));
    const Kept<D> kept = kept_by(mesh);
    StarWorkspace<D> workspace;
    const auto broken_at = [&](std::size_t step, const std::string& law) {
        return "seed " + std::to_string(seed) + ", step " + std::to_string(step) + ": " + law;
    };
    for (std::size_t step = 0; step < options.steps; ++step) {
        const std::size_t kind = next_kind(mesh, options.max_elements, dice);
        const auto [patch, refused] = Trying<D>(mesh, dice, workspace).planned(kinds<D>()[kind]);
        tally.count(kind, refused);
        if (!patch) continue;
        const DynamicMesh<D> before = mesh;
        auto [after, changes] = must(replace_cavities<D>(std::move(mesh), {&*patch, 1}));
        mesh = std::move(after);
        if (const std::string law = step % 8 == 0 ? unless_told(before, mesh, changes) : ""; !law.empty())
            return broken_at(step, law);
        if (step % options.steps_a_check != 0) continue;
        if (const std::string law = unless_topology_holds(mesh, kept); !law.empty()) return broken_at(step, law);
    }
    const std::string law = unless_all_holds(mesh, kept);
    return law.empty() ? "" : broken_at(options.steps, law);
}

/// The same by topology alone: elements may be inverted here.
template <int D>
std::string run_topology(std::uint64_t seed, const RunOptions& options, Tally<D>& tally) {
    Dice dice(seed);
    DynamicMesh<D> mesh = dynamic_of(domain_with_required<D>(seed));
    const Kept<D> kept = kept_by(mesh);
    StarWorkspace<D> workspace;
    for (std::size_t step = 0; step < options.steps; ++step) {
        const std::size_t kind = next_kind(mesh, options.max_elements, dice);
        const auto [patch, refused] = Trying<D>(mesh, dice, workspace).starred(kinds<D>()[kind]);
        tally.count(kind, refused);
        if (!patch) continue;
        mesh = must(replace_cavities<D>(std::move(mesh), {&*patch, 1})).mesh;
        if (step % options.steps_a_check != 0) continue;
        if (const std::string law = unless_topology_holds(mesh, kept); !law.empty())
            return "seed " + std::to_string(seed) + ", step " + std::to_string(step) + ": " + law;
    }
    for (const std::string& broken : {unless_parts_stay(mesh, kept), unless_as_made_anew(mesh)})
        if (!broken.empty()) return "seed " + std::to_string(seed) + ": " + broken;
    return "";
}

}  // namespace camber::testing
