module;
#include <array>
export module camber.bezier:edge;
import camber.core;

export namespace camber {

/// The Bézier control point of a P2 edge: where its end tangents meet. It does not lie on the curve.
template <int D>
struct ControlPoint {
    Vec<D> point;
    friend bool operator==(const ControlPoint&, const ControlPoint&) = default;
};

/// P_11 = (4 P^l − P_20 − P_02)/2 (paper §2.1).
template <int D>
[[nodiscard]] constexpr ControlPoint<D> control_point(const Vec<D>& p20, const LagrangeNode<D>& mid,
                                                      const Vec<D>& p02) {
    return {2.0 * mid.point - midpoint(p20, p02)};
}

/// P^l = (P_20 + 2 P_11 + P_02)/4.
template <int D>
[[nodiscard]] constexpr LagrangeNode<D> lagrange_node(const Vec<D>& p20, const ControlPoint<D>& p11,
                                                      const Vec<D>& p02) {
    return {0.5 * (midpoint(p20, p02) + p11.point)};
}

/// A P2 edge by its Lagrange nodes (paper §2.2.1).
template <int D>
struct QuadraticEdge {
    Vec<D> p20;
    LagrangeNode<D> mid;
    Vec<D> p02;

    [[nodiscard]] static constexpr QuadraticEdge straight(const Vec<D>& a, const Vec<D>& b) {
        return {a, {midpoint(a, b)}, b};
    }

    /// l(t) = (1−t)(1−2t) P_20 + 4t(1−t) P^l + t(2t−1) P_02, written from the straight edge and the node's offset so
    /// that a straight edge stays straight to rounding.
    [[nodiscard]] constexpr Vec<D> point(double t) const {
        return (1 - t) * p20 + t * p02 + 4 * t * (1 - t) * offset();
    }
    /// l'(t) = (4t−3) P_20 + 4(1−2t) P^l + (4t−1) P_02.
    [[nodiscard]] constexpr Vec<D> derivative(double t) const { return (p02 - p20) + 4 * (1 - 2 * t) * offset(); }

    [[nodiscard]] constexpr Vec<D> chord() const { return p02 - p20; }
    /// The node's distance vector from the middle of the chord.
    [[nodiscard]] constexpr Vec<D> offset() const { return mid.point - midpoint(p20, p02); }
};

/// |P^l − M_11| / |P_20 − P_02| (paper §4).
template <int D>
[[nodiscard]] inline double curvature(const QuadraticEdge<D>& edge) {
    return norm(edge.offset()) / norm(edge.chord());
}

/// Edge e of the mesh with its node.
template <int D>
[[nodiscard]] constexpr QuadraticEdge<D> edge_of(const QuadraticMesh<D>& mesh, EdgeId e) {
    const auto& [a, b] = mesh.edges.vertices[e];
    return {mesh.linear.points[a], mesh.mid_nodes[e], mesh.linear.points[b]};
}

}  // namespace camber
