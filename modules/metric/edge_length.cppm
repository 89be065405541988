module;
#include <cmath>
#include <cstddef>
export module camber.metric:edge_length;
import camber.core;
import camber.bezier;
import :back_mesh;
import :quadrature;
import :spd;

export namespace camber {

/// A Riemannian length, and how many of its samples lay beyond the back mesh.
struct EdgeLength {
    double length = 0;
    int outside = 0;
    int lost = 0;
};

/// ∫ sqrt(l'ᵀ M(l) l') dt on the true field, that of the back mesh at the points of the curve. `hint`: an element near
/// the edge's first vertex.
template <int D>
[[nodiscard]] EdgeLength riemannian_length(const BackMesh<D>& back, const QuadraticEdge<D>& edge,
                                           const Quadrature& rule, ElementId hint);

/// The metric along a P2 edge as the paper has it (§2.1, eq. 3 and 4): log M(t) quadratic through log M_20, log M(P^l),
/// log M_02.
template <int D>
struct EdgeField {
    LogMetric<D> l20, mid, l02;

    [[nodiscard]] LogMetric<D> at(double t) const {
        return {(1 - t) * (1 - 2 * t) * l20.l + 4 * t * (1 - t) * mid.l + t * (2 * t - 1) * l02.l};
    }
    /// The virtual log-metric of eq. (4): log M_11 = (4 log M(P^l) − log M_20 − log M_02)/2.
    [[nodiscard]] LogMetric<D> virtual_mid() const { return {2.0 * mid.l - 0.5 * (l20.l + l02.l)}; }
};

/// The field along an edge of which the end vertices' log-metrics and the middle node's place are known.
template <int D>
[[nodiscard]] EdgeField<D> edge_field(const BackMesh<D>& back, const QuadraticEdge<D>& edge, ElementId hint);

/// ∫ sqrt(l'ᵀ M(t) l') dt with the field of the three nodes.
template <int D>
[[nodiscard]] double riemannian_length(const EdgeField<D>& field, const QuadraticEdge<D>& edge, const Quadrature& rule);

}  // namespace camber
