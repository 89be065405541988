module;
#include <array>
#include <cstddef>
export module camber.metric:distortion_bound;
import camber.core;
import camber.bezier;
import :distortion;
import :spd;

export namespace camber {

/// What is known of the least 1/η (see :distortion) of an element: it is at least `bound` (to rounding), and 1/η is
/// `attained` at a point that was looked at. The bound is −1, below which no quality is, where det J is not known to
/// be positive.
struct LeastQuality {
    double bound = -1, attained = 1;
    friend bool operator==(const LeastQuality&, const LeastQuality&) = default;
};

/// How long to look: until the bound is `enough`, or `share` of what is attained, or after so many bisections.
struct BoundEffort {
    double enough = 1;
    double share = 0.95;
    int bisections = 64;
};
inline constexpr int max_bisections = 128;

/// Bounds of det A by its Bézier coefficients and of tr(AᵀA) by its own, with the range of the metric, on parts of the
/// element: the part of the lowest bound is bisected again and again, along the edge on which A and M change most. The
/// bound converges to the least quality with the size of the parts. On a straight element in a constant metric it is
/// the quality at once. Bisections beyond `max_bisections` are not made.
template <int D>
[[nodiscard]] LeastQuality bound_quality(const QuadraticNodes<D>& nodes, const VertexLogMetrics<D>& vertices,
                                         const BoundEffort& effort = {});

}  // namespace camber
