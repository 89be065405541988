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

/// Where the metric at a quadrature point comes from.
enum class Along : std::uint8_t {
    nodes,   ///< the paper's (6): exp of the quadratic through the logs at P_20, P^l, P_02; only P^l is located
    points,  ///< each quadrature point is located, and its metric interpolated there
};

/// What an edge's search has cost so far.
struct Work {
    int iterations = 0;
    int values = 0;     ///< lengths without gradient
    int gradients = 0;  ///< lengths with gradient
    int walks = 0;
    int steps = 0;  ///< elements that the walks looked at
};

struct Length {
    double value = 0;
    Vector gradient{};
};

/// An edge between two vertices of the field; it keeps the element where the last point was found.
class Edge {
  public:
    Edge(const BackField& field, Along along, std::uint32_t a, std::uint32_t b, std::uint32_t hint);

    [[nodiscard]] Vector middle() const { return 0.5 * (p20_ + p02_); }
    [[nodiscard]] const Work& work() const { return work_; }
    [[nodiscard]] Work& work() { return work_; }

    /// The length; infinite where a point that must be located lies beyond the mesh.
    [[nodiscard]] double value(const Vector& node);
    /// With its gradient, which is 0 where the length is infinite.
    [[nodiscard]] Length value_and_gradient(const Vector& node);
    /// M⁻¹ at a point of the mesh.
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
