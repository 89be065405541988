module;
#include <array>
#include <cstddef>
module camber.recovery:at_lattice;
import camber.bezier;
import camber.core;
import :element_values;
import :fit;
import :monomials;

namespace camber {

/// Where the nodes of an element's edges are off the middles of their chords.
template <int D>
using EdgeOffsets = std::array<Vec<D>, edges_per_simplex<D>>;
template <int D>
using Lattice = std::array<Vec<D>, node_count<lattice_degree, D>>;

template <int D>
[[nodiscard]] EdgeOffsets<D> edge_offsets(const QuadraticMesh<D>& mesh, ElementId e) {
    EdgeOffsets<D> offsets{};
    if (mesh.mid_nodes.empty()) return offsets;
    for (std::size_t k = 0; k < offsets.size(); ++k) offsets[k] = edge_of(mesh, mesh.edges.of_elements[e][k]).offset();
    return offsets;
}

/// F(λ) = Σ λ_v x_v + Σ 4 λ_i λ_j offset of the edge from i to j.
template <int D>
[[nodiscard]] Vec<D> place_within(const LinearMesh<D>& mesh, ElementId e, const EdgeOffsets<D>& offsets,
                                  const std::array<double, D + 1>& at) {
    Vec<D> x;
    for (std::size_t v = 0; v <= D; ++v) x += at[v] * mesh.points[mesh.elements.vertices[e][v]];
    for (int k = 0; k < edges_per_simplex<D>; ++k) x += edge_shape<D>(at, k) * offsets[k];
    return x;
}

template <int D>
[[nodiscard]] Lattice<D> lattice_of(const LinearMesh<D>& mesh, ElementId e, const EdgeOffsets<D>& offsets) {
    constexpr auto& all = multi_indices<lattice_degree, D>;
    Lattice<D> places{};
    for (std::size_t q = 0; q < places.size(); ++q) {
        std::array<double, D + 1> at{};
        for (std::size_t v = 0; v <= D; ++v) at[v] = all[q][v] * (1.0 / lattice_degree);
        places[q] = place_within(mesh, e, offsets, at);
    }
    return places;
}

/// A polynomial in y at these y.
template <int D, int P>
[[nodiscard]] std::array<double, node_count<lattice_degree, D>> values_at(const Coefficients<D, P>& c,
                                                                          const Lattice<D>& places) {
    std::array<double, node_count<lattice_degree, D>> values{};
    for (std::size_t q = 0; q < values.size(); ++q) {
        std::array<double, monomials_up_to<D>(P)> m{1.0};
        values[q] = c[0];
        for (std::size_t i = 1; i < m.size(); ++i) {
            m[i] = m[monomials<D, P>[i].parent] * places[q][monomials<D, P>[i].axis];
            values[q] += c[i] * m[i];
        }
    }
    return values;
}

}  // namespace camber
