module;
#include <cstddef>
#include <span>
export module camber.metric:tensors;
import camber.core;
import :spd;

export namespace camber {

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
