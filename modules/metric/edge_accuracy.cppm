module;
#include <array>
#include <cstdint>
#include <span>
#include <tuple>
export module camber.metric:edge_accuracy;
import camber.core;
import :back_mesh;
import :unit_mesh;

/// The node of an edge by which functions that the metric belongs to are interpolated best: a closed form, nothing is
/// minimised. Derivation, bounds and figures: docs/algorithms/edge-accuracy.md.
export namespace camber {

/// How the change of log M along an edge is known.
enum class ChangeAlong : std::uint8_t {
    recovered,  ///< by the recovered gradients at its ends: they smooth metrics that are noisy, as a mesh's own is
    of_ends,    ///< by its ends themselves: exact for axes that turn evenly, up to about a radian within the edge
};

struct EdgeAccuracyOptions {
    /// How far sizes that change draw a node into the finer side, as a share of what the geodesic asks for. The best is
    /// 2/3 where M = |H| of what is interpolated (its Hessian), 1 where M ~ |∇³u|^{2/3}, 0 where sizes tell nothing;
    /// the default is in the middle, since nobody says which.
    double size_share = 0.5;
    ChangeAlong change = ChangeAlong::recovered;

    [[nodiscard]] static constexpr auto options() {
        using S = EdgeAccuracyOptions;
        return std::tuple(option("size_share", &S::size_share,
                                 "accuracy only: how far sizes that change draw nodes into the finer side, as a share "
                                 "of what a geodesic asks for: 2/3 where the metric is the Hessian of what is to be "
                                 "interpolated, 1 where it is made of third derivatives, 0 for axes alone")
                              .at_least(0)
                              .at_most(1));
    }
    friend bool operator==(const EdgeAccuracyOptions&, const EdgeAccuracyOptions&) = default;
};

/// Offsets of mid nodes from where the back mesh has them: chords[i] = P_02 − P_20, ends[i] what that edge sees. L, at
/// the middle, is the mean of log(Fᵀ M F) at the ends, and its gradient likewise. With L = R diag(λ) Rᵀ, c = Rᵀ e, D_k
/// = Rᵀ(∂_k L)R (∂_k along axis k), A = Σ c_k D_k (or Rᵀ(L_b − L_a)R, see ChangeAlong) and x_ij = λ_i − λ_j, in the
/// frame of the axes
///
///   8 d_j = Σ_{i≠j} w(x_ij) A_ij c_i  +  σ [ Σ_i K_ij A_ij c_i − ½ Σ_{ab} K_ab sqrt(K_ja K_jb) (D_j)_ab c_a c_b ],
///   w(x) = (1 − e^{−|x|})²/|x| · min(1, e^{−x}),  K_ij = e^{−|x_ij|}, σ = size_share:
///
/// axes that turn, and sizes that change among axes that are alike. Where axes turn by more than they are resolved to
/// (about a radian within the edge) the first part fades; the second where sizes change by a large factor within it,
/// and where it is longer than √2 in the metric, so that the mesh does not resolve what the metric asks for. An
/// offset that would shift the node along its edge by more than 1/5 of the chord is shortened to that. Through F at the
/// middle it goes into space. All three spans are of one size. Each edge has the same bytes in any company and with
/// any instructions.
template <int D>
void accurate_offsets(std::span<const Vec<D>> chords, std::span<const EdgeEnds<D>> ends,
                      const EdgeAccuracyOptions& options, std::span<Vec<D>> offsets,
                      Instructions set = widest_instructions());

/// What is ready to measure with at both ends of an edge.
template <int D>
using EndMeasures = std::array<const MeasuringMetric<D>*, 2>;

/// Edges as the curves that accuracy gives them, and how long these are (bent_length), with what is ready to measure
/// with at both ends. Nothing of them is bent by the mesh itself: `is_bent` is not looked at. All spans are of one
/// size.
template <int D>
void bent_edges(std::span<const Vec<D>> chords, std::span<const EdgeEnds<D>> ends,
                std::span<const EndMeasures<D>> measures, const EdgeAccuracyOptions& options, std::span<Vec<D>> offsets,
                std::span<double> lengths, Instructions set = widest_instructions());

}  // namespace camber
