module;
#include <array>
#include <cstdint>
#include <span>
#include <tuple>
export module camber.edge_optimisation:edge_accuracy;
import camber.core;
import camber.metric;

/// The node of an edge by which functions that the metric belongs to are interpolated best: a closed form, nothing is
/// minimised. Derivation, bounds and figures: docs/algorithms/edge-accuracy.md.
export namespace camber {

/// How the change of log M along an edge is known; the gradient agrees with it.
enum class ChangeAlong : std::uint8_t {
    recovered,  ///< by the recovered gradients at its ends: they smooth metrics that are noisy, as a mesh's own is
    of_ends,    ///< by its ends themselves: exact for axes that turn evenly, up to about a radian within the edge
};

/// What a metric was made of, and so what its sizes tell.
enum class MetricKind : std::uint8_t {
    automatic,          ///< a field that nothing is known of
    hessian,            ///< |∇²u|: elements of degree 1 for u
    third_derivatives,  ///< |∇³u|^{2/3}: elements of degree 2
    geometry,           ///< of a geometry, of distances, by hand: axes alone count
    natural,            ///< the mesh's own: sizes grow away from something
};
[[nodiscard]] constexpr auto words(MetricKind) {
    return words_of(Word{MetricKind::automatic, "automatic"}, Word{MetricKind::hessian, "hessian"},
                    Word{MetricKind::third_derivatives, "third_derivatives"}, Word{MetricKind::geometry, "geometry"},
                    Word{MetricKind::natural, "natural"});
}

struct EdgeAccuracyOptions {
    MetricKind metric_kind = MetricKind::automatic;
    double metric_norm = 2;  ///< p of L^p; 0: the maximum norm
    double size_share = 0;   ///< σ; 0: see share_of_sizes
    ChangeAlong change = ChangeAlong::recovered;

    [[nodiscard]] static constexpr auto options() {
        using S = EdgeAccuracyOptions;
        return std::tuple(
            option("metric_kind", &S::metric_kind,
                   "accuracy only: what the metric was made of, which says what its sizes tell: hessian, of a solution "
                   "for elements of degree 1; third_derivatives, for elements of degree 2; geometry, axes alone count; "
                   "natural, the mesh's own; automatic, natural where it is the mesh's own, else something unknown"),
            option("metric_norm", &S::metric_norm,
                   "of the kinds hessian and third_derivatives: the p of the norm L^p whose error the metric is for; "
                   "0: the maximum norm")
                .at_least(0),
            option("size_share", &S::size_share,
                   "accuracy only: how far sizes that change draw nodes into the finer side, as a share of what a "
                   "geodesic asks for; 0: what belongs to metric_kind")
                .at_least(0)
                .at_most(3));
    }
    friend bool operator==(const EdgeAccuracyOptions&, const EdgeAccuracyOptions&) = default;
};

/// σ, how far sizes that change draw a node into the finer side, as a share of what a geodesic asks for: `size_share`,
/// or where that is 0 what belongs to the kind. With k = 1 (hessian) or 2 (third_derivatives) in L^p all sizes vary
/// with the solution, and σ = (k + 1)/3 · (p(k + 1) + D)/(p(k + 1)); (k + 1)/3 in the maximum norm. Of fields that
/// nothing is known of 2/3, of geometries 0, of natural metrics 1.
[[nodiscard]] double share_of_sizes(const EdgeAccuracyOptions& options, int dimension);

/// Offsets of mid nodes from where the back mesh has them: chords[i] = P_02 − P_20, ends[i] what that edge sees. L, at
/// the middle, is the mean of log(Fᵀ M F) at the ends, and its gradient likewise. With L = R diag(λ) Rᵀ, c = Rᵀ e, D_k
/// = Rᵀ(∂_k L)R (∂_k along axis k), A = Σ c_k D_k (or Rᵀ(L_b − L_a)R, see ChangeAlong) and x_ij = λ_i − λ_j, in the
/// frame of the axes
///
///   8 d_j = Σ_{i≠j} w(x_ij) A_ij c_i  +  σ [ Σ_ik K_ij K_jk (D_k)_ij c_k c_i − ½ Σ_ab K_ja K_jb (D_j)_ab c_a c_b ],
///   w(x) = (1 − e^{−|x|})²/|x| · min(1, e^{−x}),  K_ij = e^{−|x_ij|}, σ = share_of_sizes:
///
/// axes that turn, and sizes that change among axes that are alike. Of natural metrics the bracket is
/// ½ (γ·c)² γ_j/|γ|², γ_k = K_jk Σ_i K_ij (D_k)_ii / Σ_i K_ij: sizes grow away from something, across it. Where axes
/// turn by more than they are resolved to (about a radian within the edge) the first part fades; the second where sizes
/// change by a large factor within it, and where it is longer than √2 in the metric, so that the mesh does not resolve
/// what the metric asks for. An offset that would shift the node along its edge by more than 1/5 of the chord is
/// shortened to that. Through F at the middle it goes into space. All three spans are of one size. Each edge has the
/// same bytes in any company and with any instructions.
template <int D>
void accurate_offsets(std::span<const Vec<D>> chords, std::span<const EdgeEnds<D>> ends,
                      const EdgeAccuracyOptions& options, std::span<Vec<D>> offsets,
                      Instructions set = widest_instructions());

/// What an edge that nothing of the mesh itself bends sees at an end: the field, and what is ready to measure with.
template <int D>
struct EndSight {
    const LogMetric<D>* log_metric = nullptr;
    const LogGradient<D>* gradient = nullptr;
    const MeasuringMetric<D>* measure = nullptr;
};
template <int D>
using EndSights = std::array<EndSight<D>, 2>;

/// Edges as the curves that accuracy gives them (accurate_offsets), and how long these are (bent_length). All spans are
/// of one size.
template <int D>
void bent_edges(std::span<const Vec<D>> chords, std::span<const EndSights<D>> ends, const EdgeAccuracyOptions& options,
                std::span<Vec<D>> offsets, std::span<double> lengths, Instructions set = widest_instructions());

}  // namespace camber
