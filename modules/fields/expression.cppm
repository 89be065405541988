module;
#include <span>
#include <string>
#include <variant>
#include <vector>
export module camber.fields:expression;
import camber.core;
import camber.metric;

/// Metric fields written as expressions of the coordinates x, y and (3D) z, in muparser's notation: numbers,
/// + − * / ^, comparisons, && and ||, c ? a : b, pi, and functions as sqrt, exp, log (natural), sin, tanh, atan2, abs,
/// min, max.
export namespace camber {

/// One size everywhere in all directions (model units).
struct SizeExpression {
    std::string size;
    friend bool operator==(const SizeExpression&, const SizeExpression&) = default;
};
/// A size along each axis.
struct SizesExpression {
    std::vector<std::string> sizes;
    friend bool operator==(const SizesExpression&, const SizesExpression&) = default;
};
/// The entries of M, lower triangle by rows: xx, xy, yy (xz, yz, zz); 1/length².
struct TensorExpression {
    std::vector<std::string> tensor;
    friend bool operator==(const TensorExpression&, const TensorExpression&) = default;
};
/// A metric by one size, by a size along each axis, or by its entries.
using MetricExpression = std::variant<SizeExpression, SizesExpression, TensorExpression>;

/// log M at points. Errors (usage): another number of expressions than the dimension asks for; one that cannot be read,
/// with the expression and the position in it; a value that is not finite, a size that is not positive, a tensor that
/// is not positive definite, with the vertex and its coordinates; stopped.
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> log_metrics_of(const MetricExpression& expression,
                                                           std::span<const Vec<D>> points, const Execution& execution);

}  // namespace camber
