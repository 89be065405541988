module;
#include <array>
#include <cstdint>
#include <span>
#include <tuple>
export module camber.edge_optimisation:edge_accuracy;
import camber.core;
import camber.metric;

/// Edge nodes of best interpolation for a metric, in closed form (docs/algorithms/edge-accuracy.md).
export namespace camber {

/// Source of the change of log M along an edge.
enum class ChangeSource : std::uint8_t {
    recovered,  ///< recovered gradients at the ends, which smooth noisy metrics
    of_ends,    ///< difference of the ends: exact for uniformly turning axes, up to about a radian
};

/// Origin of a metric, which determines the meaning of its sizes.
enum class MetricKind : std::uint8_t {
    automatic,          ///< unknown field
    hessian,            ///< |∇²u|, for elements of degree 1
    third_derivatives,  ///< |∇³u|^{2/3}, for elements of degree 2
    geometry,           ///< from a geometry, distances or manual sizes: only the axes are used
    natural,            ///< metric of the mesh itself: sizes grow away from features
};
[[nodiscard]] constexpr auto words(MetricKind) {
    return words_of(Word{MetricKind::automatic, "automatic"}, Word{MetricKind::hessian, "hessian"},
                    Word{MetricKind::third_derivatives, "third_derivatives"}, Word{MetricKind::geometry, "geometry"},
                    Word{MetricKind::natural, "natural"});
}

struct EdgeAccuracyOptions {
    MetricKind metric_kind = MetricKind::automatic;
    double metric_norm = 2;  ///< exponent p of the L^p norm whose error the metric minimises; 0: the maximum norm
    double size_share = 0;   ///< share of the displacement towards smaller sizes; 0: chosen by share_of_sizes
    ChangeSource change = ChangeSource::recovered;

    [[nodiscard]] static constexpr auto options() {
        using S = EdgeAccuracyOptions;
        return std::tuple(
            option("metric_kind", &S::metric_kind,
                   "accuracy only: origin of the metric, which determines the meaning of its sizes. hessian: a "
                   "solution, for elements of degree 1; third_derivatives: a solution, for elements of degree 2; "
                   "geometry: only the axes of the metric count; natural: the mesh; automatic: natural for the mesh's "
                   "own metric, else unknown"),
            option("metric_norm", &S::metric_norm,
                   "metric_kind hessian and third_derivatives only: exponent p of the norm L^p whose error the metric "
                   "minimises. 0: the maximum norm")
                .at_least(0),
            option("size_share", &S::size_share,
                   "accuracy only: shift of nodes towards smaller sizes where sizes vary, as a share of the shift of "
                   "a geodesic. 0: the value for metric_kind")
                .at_least(0)
                .at_most(3));
    }
    friend bool operator==(const EdgeAccuracyOptions&, const EdgeAccuracyOptions&) = default;
};

/// Share σ of the geodesic's displacement towards smaller sizes: `size_share` or, if that is 0, a value for the metric
/// kind. In L^p with k = 1 (hessian) or 2 (third_derivatives), σ = (k + 1)/3 · (p(k + 1) + D)/(p(k + 1)); (k + 1)/3 in
/// the maximum norm. Unknown fields have 2/3, geometries 0, natural metrics 1.
[[nodiscard]] double share_of_sizes(const EdgeAccuracyOptions& options, int dimension);

/// Computes offsets d of mid nodes from the back mesh positions; chords[i] = P_02 − P_20. L = R diag(λ) Rᵀ is the mean
/// of log(Fᵀ M F) at the ends, with the Jacobian F of the curved back mesh. With e = chords[i], c = Rᵀ e, D_k = Rᵀ(∂_k
/// L)R (∂_k along axis k), A = Σ c_k D_k (or Rᵀ(L_b − L_a)R, see ChangeSource) and x_ij = λ_i − λ_j
///
///   8 d_j = Σ_{i≠j} w(x_ij) A_ij c_i + σ [ Σ_ik K_ij K_jk (D_k)_ij c_k c_i − ½ Σ_ab K_ja K_jb (D_j)_ab c_a c_b ],
///   w(x) = (1 − e^{−|x|})²/|x| · min(1, e^{−x}), K_ij = e^{−|x_ij|}, σ = share_of_sizes.
///
/// For natural metrics the bracket is ½ (γ·c)² γ_j/|γ|², γ_k = K_jk Σ_i K_ij (D_k)_ii / Σ_i K_ij. Both parts of the sum
/// fade if the edge does not resolve the metric; shifts along the chord are limited to 1/5. F at the midpoint maps d to
/// space. All spans have the same size. Results are bitwise independent of other edges and of the instruction set.
template <int D>
void accurate_offsets(std::span<const Vec<D>> chords, std::span<const EdgeEnds<D>> ends,
                      const EdgeAccuracyOptions& options, std::span<Vec<D>> offsets,
                      Instructions set = widest_instructions());

/// Data at an end of an edge in a straight back mesh: metric, its gradient, and the metric prepared for measuring
/// lengths.
template <int D>
struct EndSample {
    const LogMetric<D>* log_metric = nullptr;
    const LogGradient<D>* gradient = nullptr;
    const MeasuringMetric<D>* measure = nullptr;
};
template <int D>
using EndSamples = std::array<EndSample<D>, 2>;

/// Computes the offsets of `accurate_offsets`, and the lengths of the edges (quadratic_edge_length). All spans have the
/// same size.
template <int D>
void bent_edges(std::span<const Vec<D>> chords, std::span<const EndSamples<D>> ends, const EdgeAccuracyOptions& options,
                std::span<Vec<D>> offsets, std::span<double> lengths, Instructions set = widest_instructions());

}  // namespace camber
