// Meshes with facets for tests of partitions.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "dice.hpp"
#include "meshes.hpp"

import camber.core;
import camber.bezier;
import camber.partition;

namespace cut {

using namespace camber;
using testing::must;
using testing::one_thread;

/// A randomly numbered lattice with its boundary. Its mid nodes are off the chords, and its references are consecutive
/// numbers.
template <int D>
QuadraticMesh<D> mesh(std::uint64_t seed, int cells) {
    testing::LatticeOptions<D> options;
    options.cells.fill(cells);
    options.seed = seed + 1;
    LinearMesh<D> linear = testing::lattice_mesh(options);
    Buffer<SimplexVertices<D - 1>> facets;
    for (const ElementFace face :
         boundary_faces<D>(must(neighbours(linear, must(balls(linear, one_thread)), one_thread))))
        facets.push_back(testing::face_of(linear, face));
    const auto counted = [](std::size_t n) {
        return must(map_each(one_thread, n, [](std::size_t i) { return static_cast<Reference>(i + 1); }));
    };
    linear.point_references = counted(linear.points.size());
    linear.elements.references = counted(linear.elements.size());
    linear.facets.references = counted(facets.size());
    linear.facets.vertices = std::move(facets);
    QuadraticMesh<D> result = must(elevate(std::move(linear), one_thread));
    testing::Dice dice(seed);
    Buffer<LagrangeNode<D>> nodes = take(std::move(result.mid_nodes));
    for (LagrangeNode<D>& node : nodes) node.point[0] += 0.01 * static_cast<double>(dice.below(10));
    result.mid_nodes = std::move(nodes);
    return result;
}

/// Assigns each element to a random part.
template <int D>
CellParts any_parts(const LinearMesh<D>& mesh, std::size_t parts, std::uint64_t seed) {
    testing::Dice dice(seed);
    Buffer<std::int32_t> of;
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) of.push_back(static_cast<std::int32_t>(dice.below(parts)));
    return must(parts_of_cells<D>(mesh, std::move(of), one_thread));
}

}  // namespace cut
