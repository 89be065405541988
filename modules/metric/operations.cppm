module;
#include <limits>
export module camber.metric:operations;
import camber.core;
import :spd;

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

}  // namespace camber
