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

/// f(simplices, their edges in a mesh of degree 2 or null) of the K-simplices that a mesh of its dimension may have.
template <int K, class F>
void on_cells(const AnyMesh& mesh, F&& f) {
    const auto with_edges = [&]<int D>(const Mesh<D>& m, const auto& cells, const auto& edges) {
        f(cells, m.degree == 2 ? &edges : nullptr);
    };
    std::visit(
        [&]<int D>(const Mesh<D>& m) {
            if constexpr (K == D) {
                with_edges(m, m.elements.template of<simplex<K>>(),
                           m.entities.edges_of_elements.template of<simplex<K>>().ids);
            } else if constexpr (K == D - 1) {
                with_edges(m, m.facets.template of<simplex<K>>(),
                           m.entities.edges_of_facets.template of<simplex<K>>().ids);
            } else if constexpr (K == 1) {
                Buffer<std::array<EdgeId, 1>> edges;
                for (const EdgeId e : m.entities.edges_of_edges) edges.push_back({e});
                with_edges(m, m.edges, Column<std::array<EdgeId, 1>>(std::move(edges)));
            }
        },
        mesh);
}

}  // namespace camber::app
