#pragma once
// Cells of a mesh as other languages have them: by the names of their types.
#include <array>
#include <cstddef>
#include <string_view>
#include <utility>
#include <variant>

import camber.core;
import camber.io;

namespace camber::app {

/// meshio's names of K-simplices, K = 1, 2, 3, of degree 1 and 2.
inline constexpr std::array<const char*, 3> straight_names{"line", "triangle", "tetra"};
inline constexpr std::array<const char*, 3> curved_names{"line3", "triangle6", "tetra10"};

/// f(mesh of degree 2 or null, straight mesh).
template <class F>
auto on_mesh(const AnyMesh& mesh, F&& f) {
    return std::visit(
        [&]<class Mesh>(const Mesh& m) {
            if constexpr (requires { m.linear; })
                return f(&m, m.linear);
            else
                return f(static_cast<const QuadraticMesh<Mesh::dimension>*>(nullptr), m);
        },
        mesh);
}

/// f(feature edges, the edge of each in the set or null): as an array of one, as simplices of higher dimension have
/// theirs.
template <class Linear, class Curved, class F>
void on_feature_edges(const Linear& linear, const Curved* curved, F&& f) {
    if (!curved) return f(linear.edges, static_cast<const Column<std::array<EdgeId, 1>>*>(nullptr));
    Buffer<std::array<EdgeId, 1>> edges;
    edges.reserve(curved->edges.of_edges.size());
    for (const EdgeId e : curved->edges.of_edges) edges.push_back({e});
    const Column<std::array<EdgeId, 1>> column(std::move(edges));
    f(linear.edges, &column);
}

/// f(simplices, their edges or null) of the K-simplices that a mesh of its dimension may have.
template <int K, class F>
void on_cells(const AnyMesh& mesh, F&& f) {
    on_mesh(mesh, [&]<class Mesh>(const Mesh* curved, const auto& linear) {
        constexpr int D = Mesh::dimension;
        if constexpr (K == D)
            f(linear.elements, curved ? &curved->edges.of_elements : nullptr);
        else if constexpr (K == D - 1)
            f(linear.facets, curved ? &curved->edges.of_facets : nullptr);
        else if constexpr (K == 1)
            on_feature_edges(linear, curved, f);
    });
}

}  // namespace camber::app
