module;
#include <cstdint>
#include <span>
export module camber.curving:edge_target;
import camber.core;
import camber.metric;
import camber.validity;
import camber.programmes;

export namespace camber {

/// What the search for one edge's node met.
struct SearchFlags {
    std::uint8_t volume = 0, curved = 0, polished = 0, exhausted = 0, shortened = 0, outside = 0, lost = 0;
};

/// Where an edge's node ought to be before validity is asked for, and what that makes of its length.
template <int D>
struct EdgeTarget {
    LagrangeNode<D> node;
    EdgeChange change = EdgeChange::straight;
    SearchFlags flags;
    /// Riemannian lengths on the true field by report_points, with the middle of the chord and with `node`; 0 on
    /// boundary edges.
    double straight_length = 0, length = 0;
};

/// Of an edge of the boundary: its place on the geometry.
template <int D>
[[nodiscard]] EdgeTarget<D> boundary_target(const QuadraticMesh<D>& mesh, EdgeId edge, const LagrangeNode<D>& node);

/// Of an edge in the volume: the node that makes it shortest in the field `back`, whose mesh is the straight form of
/// `mesh`; `present` is one of the starts of the search, unless it is the middle of the chord. An edge that no element
/// holds has no field to follow and stays straight.
template <int D>
[[nodiscard]] EdgeTarget<D> volume_target(const QuadraticMesh<D>& mesh, EdgeId edge, const LagrangeNode<D>& present,
                                          std::span<const ElementId> shell, const BackMesh<D>& back,
                                          const EdgeRules& rules, const EdgeMinimiserOptions& options);

}  // namespace camber
