// Meshes for remeshing: boxes with holes, two materials and a baffle. All surfaces are flat, so that a mesh that keeps
// to its surfaces and lines preserves the domain.
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
import camber.cavity;

namespace camber::testing {

template <int D>
Vec<D> middle_of(const LinearMesh<D>& mesh, const SimplexVertices<D>& simplex) {
    Vec<D> sum;
    for (const VertexId v : simplex) sum += mesh.points[v];
    return sum / (D + 1.0);
}

/// Position of a face in the domain.
enum class FaceKind : std::uint8_t { boundary, interface, inside };

/// Sets the material of each element from its corners, and adds a facet to each face with a reference other than 0.
/// `reference_of` gets the corners of the face, a point on its inner side, and its kind.
template <int D, class MaterialOf, class ReferenceOf>
LinearMesh<D> with_facets(LinearMesh<D> mesh, MaterialOf&& material_of, ReferenceOf&& reference_of) {
    Buffer<Reference> materials(mesh.elements.size());
    for (std::size_t e = 0; e < materials.size(); ++e) materials[e] = material_of(corners(mesh, e));
    const auto across = must(neighbours(mesh, must(balls(mesh, one_thread)), one_thread));
    Buffer<SimplexVertices<D - 1>> facets;
    Buffer<Reference> references;
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        for (int i = 0; i <= D; ++i) {
            const ElementId other = across[e][i];
            if (other.valid() && other.index() < e) continue;
            const SimplexVertices<D - 1> face = face_of(mesh, {ElementId(e), static_cast<std::uint32_t>(i)});
            std::array<Vec<D>, D> places;
            for (int k = 0; k < D; ++k) places[k] = mesh.points[face[k]];
            const FaceKind kind = !other.valid()                               ? FaceKind::boundary
                                  : materials[other.index()] != materials[e] ? FaceKind::interface
                                                                             : FaceKind::inside;
            const Reference reference = reference_of(places, mesh.points[mesh.elements.vertices[e][i]], kind);
            if (reference == 0) continue;
            facets.push_back(face);
            references.push_back(reference);
        }
    mesh.elements.references = std::move(materials);
    mesh.facets = {std::move(facets), std::move(references), {}};
    return mesh;
}

/// Reference of a face of an axis-parallel box: two references per axis, the even one on the far side.
template <int D>
Reference side_of_box(const std::array<Vec<D>, D>& face, const Vec<D>& within) {
    Reference reference = 0;
    for (int axis = 0; axis < D; ++axis)
        if (std::ranges::all_of(face, [&](const Vec<D>& p) { return p[axis] == face[0][axis]; }))
            reference = 1 + 2 * axis + (within[axis] < face[0][axis] ? 1 : 0);
    return reference;
}

/// Adds two materials and, with `with_baffle`, a baffle at half height in the second; sides, interface and baffle have
/// their own references.
template <int D>
LinearMesh<D> with_references(LinearMesh<D> mesh, const std::array<int, D>& cells, bool with_baffle) {
    const double split = (cells[0] + 1) / 2;
    const double baffle = (cells[1] + 1) / 2;
    const auto material_of = [split](const std::array<Vec<D>, D + 1>& p) {
        return std::ranges::any_of(p, [&](const Vec<D>& q) { return q[0] < split; }) ? 1 : 2;
    };
    const auto reference_of = [&](const std::array<Vec<D>, D>& face, const Vec<D>& within, FaceKind kind) -> Reference {
        if (kind == FaceKind::boundary) return side_of_box<D>(face, within);
        if (kind == FaceKind::interface) return 20;
        const bool lies_there =
            std::ranges::all_of(face, [&](const Vec<D>& p) { return p[1] == baffle && p[0] >= split; });
        return with_baffle && lies_there ? 30 : 0;
    };
    return with_facets<D>(std::move(mesh), material_of, reference_of);
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
    return must(make_dynamic(mesh, must(unique_edges(mesh, one_thread)), {}, one_thread));
}

}  // namespace camber::testing
