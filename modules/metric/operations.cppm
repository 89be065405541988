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

/// Returns the log of the natural metric M of a straight simplex, in which all its edges have length 1. With the edge
/// matrices J of the simplex and J_ref of `regular_simplex`, M = B⁻ᵀ B⁻¹ for B = J J_ref⁻¹. The function computes log M
/// from the singular values of B, which is accurate for needles. The result is independent of orientation, and infinite
/// for flat simplices.
template <int D>
[[nodiscard]] inline LogMetric<D> natural_log_metric(const std::array<Vec<D>, D + 1>& p) {
    Mat<D> j;
    for (int i = 0; i < D; ++i) j.column[i] = p[i + 1] - p[0];
    EigenSystem<D> s = left_singular(j * inverse(regular_simplex<D>()));
    for (int i = 0; i < D; ++i) s.values[i] = -2 * log(s.values[i]);
    return {composed(s)};
}

/// Returns at each vertex the volume-weighted log-Euclidean mean of the natural metrics of the elements around it. Flat
/// elements are ignored. Vertices without other elements get the identity metric. Standalone surfaces: see
/// `natural_surface_log_metrics`. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LogMetric<D>>> natural_log_metrics(const LinearMesh<D>& mesh,
                                                                const Incidence<ElementId>& balls,
                                                                const Execution& execution);

template <int D>
struct NaturalLogMetrics {
    Buffer<LogMetric<D>> straight, curved;
};
/// Returns the natural metrics at the vertices of a quadratic mesh, computed with straight and with curved edges
/// (docs/algorithms/curved-back-mesh.md). For curved edges, an element contributes at vertex v the natural metric of
/// the straight element that its edge tangents at v span. The weight is the volume V of the element with straight
/// edges. The straight edges are used if the spanned element is inverted or smaller than V/20.
template <int D>
[[nodiscard]] Outcome<NaturalLogMetrics<D>> curved_natural_log_metrics(const QuadraticMesh<D>& mesh,
                                                                       const Incidence<ElementId>& balls,
                                                                       const Execution& execution);

enum class TensorPrecision { four_bytes, eight_bytes };

template <int D>
struct TensorLogs {
    Buffer<LogMetric<D>> log_metrics;
    std::size_t floored = 0;  ///< number of tensors with eigenvalues that were raised because of rounding errors
};

/// Returns the logs of metric tensors from a file. `rows` has sym_size<D> numbers for each tensor: xx xy yy (xz yz zz).
/// Rounding alone can make strongly anisotropic tensors indefinite. Its effect on an eigenvalue has a bound δ: a few ε
/// λ_max, and 0 for axes along the coordinates (ε: relative precision). Eigenvalues from −8 δ to δ are raised to δ.
/// Errors (entity "metric at vertex N"):
/// - numbers that are not finite;
/// - eigenvalues below −8 δ;
/// - sizes far out of range (see `check_sizes`);
/// - a zero tensor or zero row, which rounding cannot cause.
template <int D>
[[nodiscard]] Outcome<TensorLogs<D>> log_metrics_of_tensors(std::span<const double> rows, TensorPrecision precision,
                                                            const Execution& execution);

}  // namespace camber

export namespace camber {

/// Bounds of the sizes of metrics. `max_anisotropy` is applied last and reduces large sizes.
struct MetricBounds {
    double min_size = 0;                                              ///< model units
    double max_size = std::numeric_limits<double>::infinity();        ///< model units
    double max_anisotropy = std::numeric_limits<double>::infinity();  ///< largest size over smallest size, ≥ 1
};
template <int D>
[[nodiscard]] LogMetric<D> apply_bounds(const LogMetric<D>& log_metric, const MetricBounds& bounds);

/// Errors (usage): `min_size` negative or above `max_size`, `max_size` not positive, `max_anisotropy` below 1; stopped.
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> apply_bounds(const Column<LogMetric<D>>& field, const MetricBounds& bounds,
                                                         const Execution& execution);

template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> intersection(const Column<LogMetric<D>>& a, const Column<LogMetric<D>>& b,
                                                         const Execution& execution);

/// Checks that sizes are between `min_length` and `max_length`, so that squares of metric entries keep all digits.
/// Errors (input, entity "metric at vertex N"): a size out of range; stopped.
template <int D>
[[nodiscard]] Outcome<Done> check_sizes(const Column<LogMetric<D>>& field, const Execution& execution);

/// Computes the complexity C = ∫ sqrt(det M) dx exactly, for log M linear in each element
/// (docs/algorithms/natural-and-made-metrics.md). If all elements are regular simplices with edge length 1 in M, there
/// are 6√2 C tetrahedra (4/√3 C triangles). On standalone surfaces M is restricted to the planes of the triangles.
/// Errors (usage): the column of another mesh; stopped.
template <int D>
[[nodiscard]] Outcome<double> complexity(const LinearMesh<D>& mesh, const Column<LogMetric<D>>& field,
                                         const Execution& execution);

/// Errors: stopped.
template <int D>
[[nodiscard]] Outcome<double> largest_anisotropy(const Column<LogMetric<D>>& field, const Execution& execution);

/// Scales the metrics M to the complexity `target`: M ← (target/C)^{2/D} M for the present complexity C. Errors
/// (usage): a target that is not positive; a zero or infinite complexity; those of `complexity`.
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> scale_to_complexity(const LinearMesh<D>& mesh,
                                                                const Column<LogMetric<D>>& field, double target,
                                                                const Execution& execution);

/// Distance that determines how the sizes of a metric grow away from its vertex (Alauzet, "Size gradation control of
/// anisotropic meshes", 2010).
enum class GradationSpace : std::uint8_t {
    metric,    ///< all sizes grow with the distance in the metric, which preserves anisotropy
    physical,  ///< each size grows with the Euclidean distance, so metrics become isotropic far away
    mixed,     ///< geometric mean of the sizes of both rules; `physical` has the weight `physical_share`
};
[[nodiscard]] constexpr auto words(GradationSpace) {
    return words_of(Word{GradationSpace::metric, "metric"}, Word{GradationSpace::physical, "physical"},
                    Word{GradationSpace::mixed, "mixed"});
}

struct GradationOptions {
    GradationSpace space = GradationSpace::mixed;
    double ratio = 1.5;  ///< β: over the length l, sizes grow by the factor 1 + l log β
    double physical_share = 0.125;
    int max_sweeps = 1000;
    /// Sweeps end when no size shrinks by more than this fraction.
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

/// Returns the metric that vertex p spans at vertex q, a limit of the sizes there. Its axes are those of the metric at
/// p, rotated by `turn` (the rotation from p to q). Formulas: docs/algorithms/natural-and-made-metrics.md.
template <int D>
[[nodiscard]] EigenSystem<D> spanned_metric(const EigenSystem<D>& at_p, const AxesTurn<D>& turn, const Vec<D>& pq,
                                            const GradationOptions& options);

template <int D>
struct Graded {
    Column<LogMetric<D>> log_metrics;
    int sweeps = 0;
    bool converged = false;  ///< false if sweeps ended because of `max_sweeps`
    std::size_t changed = 0;
};

/// Limits the growth of sizes along edges, between whose ends axes may rotate. Each sweep intersects each vertex metric
/// with those that its neighbours span there (`spanned_metric`). Sizes never grow. Results do not depend on threads or
/// edge order. Errors (usage): ratio not above 1, share outside 0 to 1, columns of another mesh; stopped.
template <int D>
[[nodiscard]] Outcome<Graded<D>> apply_gradation(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                 const Column<LogMetric<D>>& field, const GradationOptions& options,
                                                 const Execution& execution);

/// Returns the maximum of log(h/h_s) over all edges: h is a size at one end, and h_s the size that the other end spans
/// there. It is at most 0 if the growth limit holds.
template <int D>
[[nodiscard]] Outcome<double> gradation_excess(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                               const Column<LogMetric<D>>& field, const GradationOptions& options,
                                               const Execution& execution);

/// Options of the surface metric (paper, §4.1), which is thin along the boundary normal and isotropic in the volume.
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

/// Normals at vertices: none in the volume, one for each smooth side of the boundary. Zero vectors are ignored; length,
/// orientation and order do not matter.
template <int D>
using VertexNormals = Incidence<Vec<D>>;

/// Computes M = R diag(λ_min, λ_min, λ_max) Rᵀ at boundary vertices, where the last column of R is the normal. If a
/// vertex has several normals, their metrics are intersected. Errors (usage): a non-positive size; stopped.
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> surface_log_metrics(const VertexNormals<D>& normals,
                                                                const SurfaceMetricOptions& options,
                                                                const Execution& execution);

}  // namespace camber
