module;
#include <array>
#include <cmath>
#include <cstddef>
export module camber.metric:natural;
import camber.core;
import :eigen;
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

}  // namespace camber
