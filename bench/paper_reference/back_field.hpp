// Discrete field of the paper: log-metrics at the vertices of a straight mesh, linear in each tetrahedron.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "matrix.hpp"

namespace paper {

inline constexpr std::uint32_t no_element = 0xffffffffU;

struct BackVertex {
    Vector point;
    Symmetric log_metric;
};
/// A tetrahedron: its vertices and the element across the face opposite each vertex (`no_element` at the boundary).
struct BackElement {
    std::array<std::uint32_t, 4> vertices;
    std::array<std::uint32_t, 4> neighbours;
};

struct BackField {
    std::vector<BackVertex> vertices;
    std::vector<BackElement> elements;
};

/// Element of a point, barycentric coordinates and their gradients. `steps` is the number of visited elements.
struct Place {
    std::uint32_t element = no_element;
    std::array<double, 4> u{};
    std::array<Vector, 4> gradient{};
    int steps = 0;
};

/// Walks from `hint` through the face that p is farthest beyond. Returns nothing if the walk leaves the mesh.
[[nodiscard]] std::optional<Place> locate(const BackField& field, const Vector& p, std::uint32_t hint);

/// Returns log M = Σ u_j log M_j, with N = 3 also its gradient Σ ∇u_j log M_j.
template <std::size_t N>
[[nodiscard]] inline Jet<N> log_metric_at(const BackField& field, const Place& place) {
    Jet<N> sum{};
    for (std::size_t j = 0; j < 4; ++j) {
        const Symmetric& log = field.vertices[field.elements[place.element].vertices[j]].log_metric;
        add(sum.value, place.u[j], log);
        for (std::size_t n = 0; n < N; ++n) add(sum.slope[n], place.gradient[j][n], log);
    }
    return sum;
}

}  // namespace paper
