// The length of a P2 edge on three Gauss points and its gradient with regard to the middle node (paper §2.2.1).
//
// l'(t) = (P_02 − P_20) + 4(1−2t)(P^l − mid), ∂_i dl² = 2·4(1−2t) (M l')_i + l'ᵀ (∂_i M) l', where ∂_i M is the
// derivative of the exponential in the direction ∂_i log M = 4t(1−t) Σ_j ∂_i u_j log M_j.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "back_field.hpp"
#include "matrix.hpp"

namespace paper {

/// Source of the metric at a quadrature point.
enum class Along : std::uint8_t {
    nodes,   ///< (6) of the paper: exp of the quadratic through the logs at P_20, P^l, P_02; only P^l is located
    points,  ///< each quadrature point is located, and the metric is interpolated there
};

/// Work of an edge search.
struct Work {
    int iterations = 0;
    int values = 0;     ///< evaluations of the length
    int gradients = 0;  ///< evaluations of the length with its gradient
    int walks = 0;
    int steps = 0;  ///< elements visited by walks
};

struct Length {
    double value = 0;
    Vector gradient{};
};

/// An edge between two vertices of the field. It stores the element of the last located point.
class Edge {
  public:
    Edge(const BackField& field, Along along, std::uint32_t a, std::uint32_t b, std::uint32_t hint);

    [[nodiscard]] Vector middle() const { return 0.5 * (p20_ + p02_); }
    [[nodiscard]] const Work& work() const { return work_; }
    [[nodiscard]] Work& work() { return work_; }

    /// Returns the length, or infinity if a point that must be located is outside the mesh.
    [[nodiscard]] double value(const Vector& node);
    /// Returns the length and its gradient, which is 0 if the length is infinite.
    [[nodiscard]] Length value_and_gradient(const Vector& node);
    /// Returns M⁻¹ at a point of the mesh.
    [[nodiscard]] Symmetric inverse_metric(const Vector& point);

  private:
    template <std::size_t N>
    using AtPoints = std::array<Jet<N>, 3>;

    template <std::size_t N>
    [[nodiscard]] bool find(const Vector& p, Jet<N>& log_metric);
    template <std::size_t N>
    [[nodiscard]] bool log_metrics(const Vector& node, AtPoints<N>& logs);

    const BackField* field_;
    Along along_;
    std::uint32_t at_;
    Vector p20_, p02_;
    Symmetric log20_, log02_;
    Work work_;
};

}  // namespace paper
