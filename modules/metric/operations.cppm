module;
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <tuple>
export module camber.metric:operations;
import camber.core;
import :spd;

export namespace camber {

/// Edge matrix of the regular unit simplex: columns p_i − p_0.
template <int D>
[[nodiscard]] inline Mat<D> regular_simplex() {
    Mat<D> j;
    if constexpr (D == 2) {
        j.column = {Vec<2>{{1, 0}}, Vec<2>{{0.5, std::sqrt(3.0) / 2}}};
    } else {
        j.column = {Vec<3>{{1, 0, 0}}, Vec<3>{{0.5, std::sqrt(3.0) / 2, 0}},
                    Vec<3>{{0.5, std::sqrt(3.0) / 6, std::sqrt(2.0 / 3.0)}}};
    }
    return j;
}

/// The natural (mesh-implied) metric of a straight simplex, for which all its edges have length 1: M = B^{-T} B^{-1}
/// with B = J J_ref^{-1}. From the singular values of B: log M = −2 log σ, so that needles and pancakes keep their
/// digits. Orientation does not matter; a flat simplex gives infinities.
template <int D>
[[nodiscard]] inline LogMetric<D> natural_log_metric(const std::array<Vec<D>, D + 1>& p) {
    Mat<D> j;
    for (int i = 0; i < D; ++i) j.column[i] = p[i + 1] - p[0];
    EigenSystem<D> s = left_singular(j * inverse(regular_simplex<D>()));
    for (int i = 0; i < D; ++i) s.values[i] = -2 * log(s.values[i]);
    return {composed(s)};
}

/// The natural metric of a mesh at its vertices: the log-Euclidean mean over the ball, weighted by the volume of the
/// elements; elements of zero volume have none, and no say. Vertices without other elements get the identity metric.
/// Of a surface alone that of the triangles in their planes, and their geometric mean along the normals.
/// Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LogMetric<D>>> natural_log_metrics(const LinearMesh<D>& mesh,
                                                                const Incidence<ElementId>& balls,
                                                                const Execution& execution);

template <int D>
struct NaturalLogMetrics {
    Buffer<LogMetric<D>> straight, curved;
};
/// Of a mesh of degree 2, with straight edges and with its own. The latter: at a vertex each element counts as the
/// straight one with its tangents there, P_k − P_v + 4 u_vk (u: how far a node is from the middle of its chord), whose
/// natural metric is F⁻ᵀ M_K F⁻¹ with F the Jacobian of the curved element over the straight one. Weighted by the
/// volume of the straight elements. An element that is turned over or flattened to less than a twentieth there counts
/// as if it were straight.
template <int D>
[[nodiscard]] Outcome<NaturalLogMetrics<D>> curved_natural_log_metrics(const QuadraticMesh<D>& mesh,
                                                                       const Incidence<ElementId>& balls,
                                                                       const Execution& execution);

/// How many digits the numbers of a tensor file hold.
enum class TensorPrecision { four_bytes, eight_bytes };

/// Logs of a file's tensors, and how many of them rounding had made indefinite.
template <int D>
struct TensorLogs {
    Buffer<LogMetric<D>> log_metrics;
    std::size_t floored = 0;  ///< tensors with an eigenvalue that was within rounding of zero, or below, and was raised
};

/// Logs of the metrics of a file: `rows` of sym_size<D> numbers, xx xy yy (xz yz zz). Rounding alone makes strongly
/// anisotropic ones indefinite. With δ what rounding by the file's reals can do to an eigenvalue (at most a few ε
/// λ_max, and nothing where the axes are those of the coordinates), eigenvalues from −8 δ to δ are raised to δ and
/// counted. Errors (entity "metric at vertex N"): NaN or infinite numbers, eigenvalues that are negative beyond
/// rounding, sizes far beyond the range of lengths (`check_sizes` tells of all), a zero tensor, a row of zeros: such a
/// tensor is singular, and rounding cannot have made it so.
template <int D>
[[nodiscard]] Outcome<TensorLogs<D>> log_metrics_of_tensors(std::span<const double> rows, TensorPrecision precision,
                                                            const Execution& execution);

}  // namespace camber

/// Operations on a metric field given by its log-metrics at the vertices of a mesh: pure, one column in, one out.
export namespace camber {

/// Sizes and anisotropy that a metric may have. Every bound but min_size only makes sizes smaller where it binds, and
/// max_anisotropy acts last: it shrinks long sizes, never below the short ones.
struct MetricBounds {
    double min_size = 0;                                              ///< model units
    double max_size = std::numeric_limits<double>::infinity();        ///< model units
    double max_anisotropy = std::numeric_limits<double>::infinity();  ///< largest over smallest size, ≥ 1
};
/// The metric within the bounds.
template <int D>
[[nodiscard]] LogMetric<D> apply_bounds(const LogMetric<D>& log_metric, const MetricBounds& bounds);

/// Errors (usage): a bound that is not positive, min_size above max_size, max_anisotropy below 1; stopped.
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> apply_bounds(const Column<LogMetric<D>>& field, const MetricBounds& bounds,
                                                         const Execution& execution);

/// The intersection vertex by vertex. Errors (usage): columns of two sizes; stopped.
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> intersection(const Column<LogMetric<D>>& a, const Column<LogMetric<D>>& b,
                                                         const Execution& execution);

/// That every size is in the range of lengths (`min_length` to `max_length`): squares of a metric's entries are
/// numbers with all their digits then. Errors (input, entity "metric at vertex N"): a size that is not; stopped.
template <int D>
[[nodiscard]] Outcome<Done> check_sizes(const Column<LogMetric<D>>& field, const Execution& execution);

/// C = ∫ sqrt(det M) of the log-Euclidean field that is linear in each element. There sqrt(det M) is the exponential of
/// a linear function f = ½ tr log M, whose integral is exact by Hermite and Genocchi: D! |K| exp[f_0, …, f_D], a
/// divided difference over the vertices' values; so no quadrature is needed. A mesh whose elements are unit for M has
/// about 6√2 C tetrahedra (4/√3 C triangles). Of a surface alone that of the triangles, with M on their planes. Errors
/// (usage): a column that is not of this mesh; stopped.
template <int D>
[[nodiscard]] Outcome<double> complexity(const LinearMesh<D>& mesh, const Column<LogMetric<D>>& field,
                                         const Execution& execution);

/// The largest anisotropy of all. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<double> largest_anisotropy(const Column<LogMetric<D>>& field, const Execution& execution);

/// The field times the constant that gives it the complexity `target`: M ← (target/C)^{2/D} M. Errors (usage): a target
/// that is not positive, a complexity that is zero or not finite; those of `complexity`.
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> scale_to_complexity(const LinearMesh<D>& mesh,
                                                                const Column<LogMetric<D>>& field, double target,
                                                                const Execution& execution);

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

/// The surface metric of paper §4.1: thin along the normal at the boundary, isotropic in the volume. Gradation then
/// carries it into the volume.
struct SurfaceMetricOptions {
    double tangent_size = 1;            ///< in the tangent plane: λ_min = tangent_size⁻²
    double normal_size = 0.1;           ///< along the normal: λ_max = normal_size⁻²; the paper takes a tenth
    std::optional<double> volume_size;  ///< at volume vertices (model units); as tangent_size unless given

    [[nodiscard]] static constexpr auto options() {
        using S = SurfaceMetricOptions;
        return std::tuple(
            option("tangent_size", &S::tangent_size, "size along the boundary").unit("model units").above(0).required(),
            option("normal_size", &S::normal_size, "size across it; a tenth of tangent_size curves well")
                .unit("model units")
                .above(0)
                .required());
    }
};

/// Unit normals at the vertices of a mesh: none in the volume, one a smooth side on the boundary, so two at a ridge and
/// more at a corner. Their orientation does not matter, nor does their order; a zero vector counts as none.
template <int D>
using VertexNormals = Incidence<Vec<D>>;

/// exp: R diag(λ_min, λ_min, λ_max) Rᵀ with the last axis along the normal. Where a vertex has several sides their
/// metrics are intersected, so that all normals are thin. Errors (usage): a size that is not positive; stopped.
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> surface_log_metrics(const VertexNormals<D>& normals,
                                                                const SurfaceMetricOptions& options,
                                                                const Execution& execution);

}  // namespace camber
