// Checks that hold for any valid mesh of a domain.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <set>
#include <vector>

#include <doctest/doctest.h>

import camber.core;
import camber.shapes;

namespace camber::testing {

/// Euler characteristic V − E + F − … of the cells of a mesh.
template <int D>
long euler_characteristic(const LinearMesh<D>& mesh) {
    std::array<std::set<std::vector<VertexId>>, D + 1> cells;
    for (const auto& s : mesh.elements.vertices)
        for (unsigned subset = 1; subset < 1U << (D + 1); ++subset) {
            std::vector<VertexId> cell;
            for (int i = 0; i <= D; ++i)
                if ((subset >> i & 1U) != 0) cell.push_back(s[i]);
            std::sort(cell.begin(), cell.end());
            cells[cell.size() - 1].insert(cell);
        }
    long sum = 0;
    for (int k = 0; k <= D; ++k) sum += (k % 2 == 0 ? 1 : -1) * static_cast<long>(cells[k].size());
    return sum;
}

template <int D>
double total_volume(const LinearMesh<D>& mesh) {
    double sum = 0;
    for (const auto& s : mesh.elements.vertices) sum += determinant(mesh.points, s) / (D == 2 ? 2 : 6);
    return sum;
}

/// The enclosed volume as the flux of x through the facets, divided by D; correct if the facets are closed and face
/// outwards.
inline double enclosed_volume(const LinearMesh<2>& mesh) {
    double sum = 0;
    for (const auto& [a, b] : mesh.facets.vertices) sum += cross(mesh.points[a], mesh.points[b]) / 2;
    return sum;
}
inline double enclosed_volume(const LinearMesh<3>& mesh) {
    double sum = 0;
    for (const auto& [a, b, c] : mesh.facets.vertices) sum += det(mesh.points[a], mesh.points[b], mesh.points[c]) / 6;
    return sum;
}

/// True if each face of facets (edge in 3D, vertex in 2D) belongs to two facets.
template <int D>
bool boundary_is_closed(const LinearMesh<D>& mesh) {
    std::map<std::vector<VertexId>, int> count;
    for (const auto& facet : mesh.facets.vertices)
        for (int skip = 0; skip < D; ++skip) {
            std::vector<VertexId> face;
            for (int i = 0; i < D; ++i)
                if (i != skip) face.push_back(facet[i]);
            std::sort(face.begin(), face.end());
            ++count[face];
        }
    return !count.empty() && std::all_of(count.begin(), count.end(), [](const auto& c) { return c.second == 2; });
}

template <int D>
void check_valid_mesh(const LinearMesh<D>& mesh, long characteristic, std::set<Reference> references) {
    for (const auto& s : mesh.elements.vertices) CHECK(determinant(mesh.points, s) > 0);
    CHECK(euler_characteristic(mesh) == characteristic);
    CHECK(boundary_is_closed(mesh));
    CHECK(enclosed_volume(mesh) == doctest::Approx(total_volume(mesh)).epsilon(1e-12));
    std::set<VertexId> used;
    for (const auto& s : mesh.elements.vertices) used.insert(s.begin(), s.end());
    CHECK(used.size() == mesh.points.size());
    CHECK(std::set<Reference>(mesh.facets.references.begin(), mesh.facets.references.end()) == references);
    CHECK(mesh.elements.references.size() == mesh.elements.size());
    CHECK(mesh.point_references.size() == mesh.points.size());
    CHECK(unique_edges(mesh, Execution{.threads = 1}).has_value());
}

/// Checks that the vertices of facets of this reference, and no others, are on the sphere to rounding.
template <int D>
void check_on_sphere(const LinearMesh<D>& mesh, Reference reference, const Vec<D>& centre, double radius) {
    std::set<VertexId> on_facets;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        if (mesh.facets.references[f] == reference)
            on_facets.insert(mesh.facets.vertices[f].begin(), mesh.facets.vertices[f].end());
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
        const double off = std::abs(distance(mesh.points[v], centre) - radius);
        if (on_facets.contains(VertexId(v)))
            CHECK(off <= 4e-16 * (radius + 4 * norm(centre)));
        else
            CHECK(off > 1e-3 * radius);
    }
}

}  // namespace camber::testing
