module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
module camber.transfer:projection;
import camber.core;
import camber.bezier;
import :block;
import :interpolate;
import :mass_matrix;
import :materials;
import :patches;
import :reference_mass;
import :same;
import :sources;
import :sums;
import :transferred;

namespace camber {

/// What the projection of one degree works on.
template <int D, int K>
struct Projection {
    Block block;
    ReferenceMass<D, K> reference;
    MassMatrix<D, K> matrix;
    /// The integrals that each group is to have, those of the old field: group after group, all components.
    std::vector<Sum> before;
    Buffer<double> residual;             ///< ∫ φ_i (u_old − u): of each component all unknowns
    Buffer<double> low, high;            ///< where asked for: of each unknown the components' limits
    std::size_t spread = 0, unkept = 0;  ///< see TransferStatistics

    [[nodiscard]] std::span<double> residual_of(std::size_t c) {
        return std::span(residual).subspan(c * matrix.size(), matrix.size());
    }
    /// Adds of each component.
    void add(std::size_t c, std::span<const double> change) {
        for (std::size_t u = 0; u < change.size(); ++u)
            block.values[matrix.node_of()[u] * block.components + c] += change[u];
    }
};

/// What all of a projection reads.
template <int D>
struct TransferScene {
    const QuadraticMesh<D>& old_mesh;
    const QuadraticMesh<D>& new_mesh;
    const Materials<D>& materials;
    const Same& same;
    const Sources<D>& sources;
    const Changed& changed;
    const Buffer<std::uint32_t>& near;
    const TransferOptions& options;
};

/// Fills the residuals of both degrees, those with components, and the limits where asked for, by one quadrature over
/// the changed elements; tells `patches` which old elements lie there. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Done> integrate_residuals(const TransferScene<D>& scene, Projection<D, 1>& linear,
                                                Projection<D, 2>& quadratic, PatchSearch<D>& patches,
                                                const Execution& execution);

/// Puts the integrals over each group back to those of the old field, by the least change in L2 on each patch: δ with
/// least δᵀMδ among those with Cδ = g, C the integrals of the basis by group: δ = M⁻¹Cᵀλ, (C M⁻¹Cᵀ) λ = g. What a
/// patch's free nodes cannot reach, since it has none of a material, is given to that material's other patches by the
/// least change in L2 of all of them, and `before` says so.
template <int D, int K>
[[nodiscard]] Outcome<Done> keep_integrals(const TransferScene<D>& scene,
                                           const typename PatchSearch<D>::Patches& patches,
                                           Projection<D, K>& projection, const Execution& execution);

/// Cuts the free values to their limits, and gives what that took from a group's integral to those of its nodes that
/// are within theirs, each by the same share of what it may move.
template <int D, int K>
[[nodiscard]] Outcome<Done> keep_limits(const TransferScene<D>& scene, const typename PatchSearch<D>::Patches& patches,
                                        Projection<D, K>& projection, const Execution& execution);

/// The integrals over the old elements of each group, for `Projection::before`.
template <int D, int K>
[[nodiscard]] Outcome<std::vector<Sum>> integrals_before(const TransferScene<D>& scene,
                                                         const typename PatchSearch<D>::Patches& patches,
                                                         const Projection<D, K>& projection,
                                                         const Execution& execution);

/// By how much the new integrals over each group fall short of the old ones: group after group, all components.
template <int D, int K>
[[nodiscard]] Outcome<std::vector<double>> missing_integrals(const TransferScene<D>& scene,
                                                             const typename PatchSearch<D>::Patches& patches,
                                                             const Projection<D, K>& projection,
                                                             const Execution& execution);

/// The values of `conserve` in place of the interpolated ones. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Interpolated> conserve(const TransferScene<D>& scene, std::span<const TransferField> fields,
                                             Interpolated interpolated, const Execution& execution);

}  // namespace camber
