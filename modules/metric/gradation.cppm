module;
#include <cstddef>
#include <cstdint>
#include <tuple>
export module camber.metric:gradation;
import camber.core;
import :eigen;
import :spd;
import :turn;

export namespace camber {

/// How a vertex's metric spreads over the space around it (Alauzet, "Size gradation control of anisotropic meshes",
/// 2010).
enum class GradationSpace : std::uint8_t {
    metric,    ///< all sizes grow alike with the distance in the metric: it keeps its anisotropy
    physical,  ///< each size grows with the distance in space: it tends to isotropy
    mixed,     ///< the geometric mean of both, by `physical_share`
};
[[nodiscard]] constexpr auto words(GradationSpace) {
    return words_of(Word{GradationSpace::metric, "metric"}, Word{GradationSpace::physical, "physical"},
                    Word{GradationSpace::mixed, "mixed"});
}

/// How fast sizes may grow.
struct GradationOptions {
    GradationSpace space = GradationSpace::mixed;
    double ratio = 1.5;  ///< β: sizes grow by log β a unit length
    double physical_share = 0.125;
    int max_sweeps = 1000;
    /// Ends when no size shrinks by more than this share in a sweep.
    double tolerance = 1e-6;

    [[nodiscard]] static constexpr auto options() {
        using S = GradationOptions;
        return std::tuple(
            option("ratio", &S::ratio, "largest ratio of the sizes of adjacent edges").above(1).at_most(1000),
            option("space", &S::space,
                   "metric: all sizes grow alike, anisotropy is kept; physical: each with the distance, towards "
                   "isotropy; mixed: between the two"),
            option("physical_share", &S::physical_share, "mixed only: 0 is metric, 1 physical").at_least(0).at_most(1),
            option("max_sweeps", &S::max_sweeps, "largest number of sweeps over the mesh")
                .at_least(1)
                .at_most(1000000));
    }
    friend bool operator==(const GradationOptions&, const GradationOptions&) = default;
};

/// The metric that p spans at q, with the axes of M_p as they turn on the way (`turn`, see turn_between: what is
/// between M_p and M_q), and sizes
///     metric    h_i (1 + l_p log β),   l_p = sqrt(pqᵀ M pq), M: M_p turned by half
///     physical  h_i + |pq| log β
///     mixed     h_i (1 + |pq|/h_i log β)^s (1 + l_p log β)^{1−s}.
template <int D>
[[nodiscard]] EigenSystem<D> spanned_metric(const EigenSystem<D>& at_p, const AxesTurn<D>& turn, const Vec<D>& pq,
                                            const GradationOptions& options);

/// The graded metric, and how it was reached.
template <int D>
struct Graded {
    Column<LogMetric<D>> log_metrics;
    int sweeps = 0;           ///< with a change, not counting the last one, which found none
    bool converged = false;   ///< false when max_sweeps ended it
    std::size_t changed = 0;  ///< vertices whose metric is not the given one
};

/// Makes sizes grow no faster than the ratio along any edge, whose axes may turn on the way: the metric at each vertex
/// is intersected with those that its neighbours span there, sweep after sweep, until none changes. A sweep reads only
/// the last one's values (Jacobi), and a vertex takes its neighbours in the order of their ids, so the result depends
/// neither on threads nor on an order of edges. Sizes never grow. Errors (usage): a ratio that is not above 1, a share
/// outside 0 to 1, columns that are not of this mesh; stopped.
template <int D>
[[nodiscard]] Outcome<Graded<D>> apply_gradation(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                 const Column<LogMetric<D>>& field, const GradationOptions& options,
                                                 const Execution& execution);

/// How far the growth law is broken: the largest share, as a logarithm, by which a size at one end of an edge exceeds
/// what the other end spans there. At most 0 where the law holds.
template <int D>
[[nodiscard]] Outcome<double> gradation_excess(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                               const Column<LogMetric<D>>& field, const GradationOptions& options,
                                               const Execution& execution);

}  // namespace camber
