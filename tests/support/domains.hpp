// Meshes to be changed: boxes of cells with holes, two materials and a baffle, all flat, so that whatever keeps to its
// surfaces and lines keeps the domain.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "meshes.hpp"

import camber.core;
import camber.dynamic;

namespace camber::testing {

template <int D>
Vec<D> middle_of(const LinearMesh<D>& mesh, const SimplexVertices<D>& simplex) {
    Vec<D> sum;
    for (const VertexId v : simplex) sum += mesh.points[v];
    return sum / (D + 1.0);
}

/// Boundary faces by the axis that they are normal to and their side, interfaces, and a baffle at half height where
/// there is one; each kind has its reference.
template <int D>
LinearMesh<D> with_references(LinearMesh<D> mesh, const std::array<int, D>& cells, bool with_baffle) {
    Buffer<Reference> materials(mesh.elements.size());
    const double split = (cells[0] + 1) / 2;
    for (std::size_t e = 0; e < materials.size(); ++e)
        materials[e] = middle_of(mesh, mesh.elements.vertices[e])[0] < split ? 1 : 2;
    const auto around = must(balls(mesh, alone));
    const auto across = must(neighbours(mesh, around, alone));
    Buffer<SimplexVertices<D - 1>> facets;
    Buffer<Reference> references;
    const double baffle = (cells[1] + 1) / 2;
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        for (int i = 0; i <= D; ++i) {
            const ElementId other = across[e][i];
            const SimplexVertices<D - 1> face = face_of(mesh, {ElementId(e), static_cast<std::uint32_t>(i)});
            Reference reference = 0;
            if (other.valid()) {
                if (other.index() < e) continue;
                const bool lies_there = std::ranges::all_of(
                    face, [&](VertexId v) { return mesh.points[v][1] == baffle && mesh.points[v][0] >= split; });
                if (materials[other.index()] != materials[e])
                    reference = 20;
                else if (with_baffle && lies_there)
                    reference = 30;
                else
                    continue;
            } else {
                for (int axis = 0; axis < D; ++axis) {
                    const double x = mesh.points[face[0]][axis];
                    if (std::ranges::all_of(face, [&](VertexId v) { return mesh.points[v][axis] == x; }))
                        reference = 1 + 2 * axis + (middle_of(mesh, mesh.elements.vertices[e])[axis] < x ? 1 : 0);
                }
            }
            facets.push_back(face);
            references.push_back(reference);
        }
    mesh.elements.references = std::move(materials);
    mesh.facets = {std::move(facets), std::move(references), {}};
    return mesh;
}

template <int D>
LinearMesh<D> random_domain(std::uint64_t seed) {
    Dice dice(seed);
    LatticeOptions<D> options;
    for (int& n : options.cells) n = 2 + static_cast<int>(dice.below(D == 2 ? 4 : 2));
    if (dice.below(2) == 1) options.keep = all_but_one_in<D>(5, seed);
    options.seed = seed + 1;
    return with_references<D>(lattice_mesh(options), options.cells, dice.below(2) == 1);
}

template <int D>
DynamicMesh<D> dynamic_of(const LinearMesh<D>& mesh) {
    return must(make_dynamic(mesh, must(unique_edges(mesh, alone)), {}, alone));
}

}  // namespace camber::testing
