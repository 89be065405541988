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

/// Natural metric of a straight simplex, in which its edges have length 1: M = B^{-T} B^{-1} with B = J J_ref^{-1}
/// (J_ref: regular simplex). log M = −2 log σ from the singular values σ of B is accurate for needles. Independent of
/// orientation; infinite for flat simplices.
template <int D>
[[nodiscard]] inline LogMetric<D> natural_log_metric(const std::array<Vec<D>, D + 1>& p) {
    Mat<D> j;
    for (int i = 0; i < D; ++i) j.column[i] = p[i + 1] - p[0];
    EigenSystem<D> s = left_singular(j * inverse(regular_simplex<D>()));
    for (int i = 0; i < D; ++i) s.values[i] = -2 * log(s.values[i]);
    return {composed(s)};
}

/// Volume-weighted log-Euclidean means of natural metrics over vertex balls, without flat elements. Vertices without
/// other elements get the identity metric. Standalone surfaces: see `natural_surface_log_metrics`. Errors: memory,
/// stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LogMetric<D>>> natural_log_metrics(const LinearMesh<D>& mesh,
                                                                const Incidence<ElementId>& balls,
                                                                const Execution& execution);

template <int D>
struct NaturalLogMetrics {
    Buffer<LogMetric<D>> straight, curved;
};
/// Natural metrics of a quadratic mesh, with straight edges and with its own (docs/algorithms/curved-back-mesh.md). At
/// vertex v a curved element counts as the straight element whose edges are its tangents at v, with weight of the
/// straight volume. Elements that are inverted at v, or have less than a twentieth of their volume there, count as
/// straight.
template <int D>
[[nodiscard]] Outcome<NaturalLogMetrics<D>> curved_natural_log_metrics(const QuadraticMesh<D>& mesh,
                                                                       const Incidence<ElementId>& balls,
                                                                       const Execution& execution);

enum class TensorPrecision { four_bytes, eight_bytes };

template <int D>
struct TensorLogs {
    Buffer<LogMetric<D>> log_metrics;
    std::size_t floored = 0;  ///< number of tensors with raised eigenvalues, which were within rounding of zero
};

/// Logs of the metrics of a file: each of `rows` holds sym_size<D> numbers, xx xy yy (xz yz zz). Rounding alone can
/// make strongly anisotropic tensors indefinite. δ bounds its effect on an eigenvalue: at most a few ε λ_max, zero for
/// axes along the coordinates. Eigenvalues from −8 δ to δ are raised to δ, and their tensors counted. Errors (entity
/// "metric at vertex N"): numbers that are not finite; eigenvalues below −8 δ; sizes far out of range (see
/// `check_sizes`); a zero tensor or row, which rounding cannot cause.
template <int D>
[[nodiscard]] Outcome<TensorLogs<D>> log_metrics_of_tensors(std::span<const double> rows, TensorPrecision precision,
                                                            const Execution& execution);

}  // namespace camber

export namespace camber {

/// All bounds except `min_size` only reduce sizes. `max_anisotropy` acts last and reduces long sizes.
struct MetricBounds {
    double min_size = 0;                                              ///< model units
    double max_size = std::numeric_limits<double>::infinity();        ///< model units
    double max_anisotropy = std::numeric_limits<double>::infinity();  ///< largest size over smallest size, ≥ 1
};
template <int D>
[[nodiscard]] LogMetric<D> apply_bounds(const LogMetric<D>& log_metric, const MetricBounds& bounds);

/// Errors (usage): a non-positive bound, min_size above max_size, max_anisotropy below 1; stopped.
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> apply_bounds(const Column<LogMetric<D>>& field, const MetricBounds& bounds,
                                                         const Execution& execution);

/// Intersection at each vertex. Errors (usage): columns of different sizes; stopped.
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> intersection(const Column<LogMetric<D>>& a, const Column<LogMetric<D>>& b,
                                                         const Execution& execution);

/// Checks that sizes are in `min_length` to `max_length`, so that squared metric entries keep all digits. Errors
/// (input, entity "metric at vertex N"): a size out of range; stopped.
template <int D>
[[nodiscard]] Outcome<Done> check_sizes(const Column<LogMetric<D>>& field, const Execution& execution);

/// Computes C = ∫ sqrt(det M) of the log-Euclidean field, linear in each element, exactly
/// (docs/algorithms/natural-and-made-metrics.md). A mesh of regular unit simplices has 6√2 C tetrahedra (4/√3 C
/// triangles). Standalone surfaces use M on the triangles' planes. Errors (usage): the column of another mesh; stopped.
template <int D>
[[nodiscard]] Outcome<double> complexity(const LinearMesh<D>& mesh, const Column<LogMetric<D>>& field,
                                         const Execution& execution);

/// Errors: stopped.
template <int D>
[[nodiscard]] Outcome<double> largest_anisotropy(const Column<LogMetric<D>>& field, const Execution& execution);

/// M ← (target/C)^{2/D} M. Errors (usage): a target that is not positive; a zero or infinite complexity; those of
/// `complexity`.
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> scale_to_complexity(const LinearMesh<D>& mesh,
                                                                const Column<LogMetric<D>>& field, double target,
                                                                const Execution& execution);

/// Growth of a vertex metric with the distance from the vertex (Alauzet, "Size gradation control of anisotropic
/// meshes", 2010).
enum class GradationSpace : std::uint8_t {
    metric,    ///< all sizes grow with the metric distance, which preserves anisotropy
    physical,  ///< each size grows with the distance, which tends to isotropy
    mixed,     ///< geometric mean of both, weighted by `physical_share`
};
[[nodiscard]] constexpr auto words(GradationSpace) {
    return words_of(Word{GradationSpace::metric, "metric"}, Word{GradationSpace::physical, "physical"},
                    Word{GradationSpace::mixed, "mixed"});
}

struct GradationOptions {
    GradationSpace space = GradationSpace::mixed;
    double ratio = 1.5;  ///< β: sizes grow by log β per unit length
    double physical_share = 0.125;
    int max_sweeps = 1000;
    /// Sweeps end if no size shrinks by more than this fraction.
    double tolerance = 1e-6;

    [[nodiscard]] static constexpr auto options() {
        using S = GradationOptions;
        return std::tuple(
            option("ratio", &S::ratio, "largest ratio of the sizes of adjacent edges").above(1).at_most(1000),
            option("space", &S::space,
                   "metric: all sizes grow at the same rate, which preserves anisotropy; physical: each size grows "
                   "with the distance, which tends to isotropy; mixed: a mean of the two"),
            option("physical_share", &S::physical_share, "mixed only: weight of physical. 0: as metric, 1: as physical")
                .at_least(0)
                .at_most(1),
            option("max_sweeps", &S::max_sweeps, "largest number of sweeps over the mesh")
                .at_least(1)
                .at_most(1000000));
    }
    friend bool operator==(const GradationOptions&, const GradationOptions&) = default;
};

/// Metric that p spans at q: the axes of M_p turned by `turn` (from M_p to M_q), with sizes that grow as `options`
/// require. Formulas: docs/algorithms/natural-and-made-metrics.md.
template <int D>
[[nodiscard]] EigenSystem<D> spanned_metric(const EigenSystem<D>& at_p, const AxesTurn<D>& turn, const Vec<D>& pq,
                                            const GradationOptions& options);

template <int D>
struct Graded {
    Column<LogMetric<D>> log_metrics;
    int sweeps = 0;          ///< number of sweeps with changes
    bool converged = false;  ///< false if `max_sweeps` ended the sweeps
    std::size_t changed = 0;
};

/// Limits the growth of sizes along edges, whose axes may turn. Sweeps intersect each vertex metric with those that its
/// neighbours span there (`spanned_metric`), until none changes. Sizes never grow. Results do not depend on threads or
/// edge order. Errors (usage): ratio not above 1, share outside 0 to 1, columns of another mesh; stopped.
template <int D>
[[nodiscard]] Outcome<Graded<D>> apply_gradation(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                 const Column<LogMetric<D>>& field, const GradationOptions& options,
                                                 const Execution& execution);

/// Largest log of the factor by which a size exceeds the size spanned along an edge; at most 0 if the growth limit
/// holds.
template <int D>
[[nodiscard]] Outcome<double> gradation_excess(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                               const Column<LogMetric<D>>& field, const GradationOptions& options,
                                               const Execution& execution);

/// Surface metric of paper §4.1: thin along the boundary normal, isotropic in the volume.
struct SurfaceMetricOptions {
    double tangent_size = 1;            ///< size in the tangent plane: λ_min = tangent_size⁻²
    double normal_size = 0.1;           ///< size along the normal: λ_max = normal_size⁻²; default as in the paper
    std::optional<double> volume_size;  ///< size at volume vertices (model units); default: tangent_size

    [[nodiscard]] static constexpr auto options() {
        using S = SurfaceMetricOptions;
        return std::tuple(
            option("tangent_size", &S::tangent_size, "size along the boundary").unit("model units").above(0).required(),
            option("normal_size", &S::normal_size,
                   "size normal to the boundary; a tenth of tangent_size is suitable "
                   "for curving")
                .unit("model units")
                .above(0)
                .required());
    }
};

/// Unit normals at vertices: none in the volume, one per smooth side of the boundary. Zero vectors, orientation and
/// order are ignored.
template <int D>
using VertexNormals = Incidence<Vec<D>>;

/// Computes M = R diag(λ_min, λ_min, λ_max) Rᵀ, last axis along the normal, intersected over the sides at a vertex.
/// Errors (usage): a non-positive size; stopped.
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> surface_log_metrics(const VertexNormals<D>& normals,
                                                                const SurfaceMetricOptions& options,
                                                                const Execution& execution);

}  // namespace camber
