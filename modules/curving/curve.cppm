module;
#include <cstddef>
#include <span>
export module camber.curving:curve;
import camber.core;
import camber.metric;
import camber.validity;
import :edge_target;

export namespace camber {

/// What `curve` found beside the nodes.
struct CurveStatistics {
    std::size_t volume_edges = 0;
    std::size_t curved_edges = 0;  ///< volume edges whose node left the middle of the chord
    std::size_t polished = 0;      ///< searches that a kink of the field stopped and a pattern search ended
    std::size_t exhausted = 0;     ///< searches that ran out of iterations
    std::size_t shortened = 0;     ///< minimisers that the finer rule found longer than the chord, and pulled back
    std::size_t outside = 0;       ///< edges with samples beyond the back mesh, of those that were measured or searched
    std::size_t lost = 0;          ///< edges with samples that were not found in it, likewise
    std::size_t drawn_back = 0;    ///< nodes for accuracy that go a part of their way, for their elements
    std::size_t by_walls = 0;      ///< nodes for accuracy that walls move, by more than 1/1000 of the chord
    std::size_t by_metric = 0;     ///< that the metric moves, likewise
    std::size_t held_back = 0;     ///< that go less than half of it, for smooth functions: see limit_smooth_loss

    CurveStatistics& operator+=(const CurveStatistics& other);
};

/// A proposal for every edge, and the lengths of the volume edges on the true field.
template <int D>
struct Curved {
    Proposal<D> proposal;
    Column<double> straight_lengths;  ///< by report_points; 0 on boundary edges and on those that are not measured
    Column<double> lengths;           ///< of the proposal's edges, likewise
    CurveStatistics statistics;
};

/// The targets of all edges as a proposal. They are one a edge.
template <int D>
[[nodiscard]] Curved<D> in_columns(const LinearMesh<D>& mesh, std::span<const EdgeTarget<D>> targets,
                                   const Column<EdgeKind>& kinds);

/// The second verb on a whole mesh: volume edges take the nodes that the options' aim asks for in the field `back`,
/// whose mesh must be `mesh` with straight edges or with those of `base`; boundary edges take `base`, which has one row
/// an edge: for edges of the boundary their nodes on the geometry (see camber.surface), for those of the volume where
/// the back mesh has them, the middles of their chords in a straight one. From there searches begin, and offsets for
/// accuracy count. Edges do not see one another, so the cost is linear and the order does not matter. Errors: columns
/// that do not fit the mesh; options out of range (usage); stopped.
template <int D>
[[nodiscard]] Outcome<Curved<D>> curve(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                       const Column<LagrangeNode<D>>& base, const Incidence<ElementId>& shells,
                                       const BackMesh<D>& back, const CurveOptions& options,
                                       const Execution& execution);

/// Offsets for accuracy of the edges of one kind, from where the back mesh has their nodes; 0 of all others, and of
/// those that no element holds. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<Vec<D>>> accurate_offsets(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                       EdgeKind kind, const Incidence<ElementId>& shells,
                                                       const BackMesh<D>& back, const EdgeAccuracyOptions& options,
                                                       const Execution& execution);

/// `curve` without a field: volume edges stay straight.
template <int D>
[[nodiscard]] Outcome<Curved<D>> curve_boundary(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                const Column<LagrangeNode<D>>& boundary_nodes,
                                                const Execution& execution);

/// Lengths on the true field of the volume edges, by report_points; 0 on boundary edges and on those that are not
/// measured.
struct EdgeLengths {
    Column<double> straight;  ///< of the chords
    Column<double> curved;
};

/// Lengths of a proposal in any field. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<EdgeLengths> edge_lengths(const EdgeSet<D>& edges, const Proposal<D>& proposal,
                                                const Incidence<ElementId>& shells, const BackMesh<D>& back,
                                                MeasuredEdges measured, const Execution& execution);

/// Lengths of a later proposal, whose vertices may have moved since `curved` was made: against the chords as they are
/// then. What did not change is not measured again. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<EdgeLengths> updated_lengths(const EdgeSet<D>& edges, const Curved<D>& curved,
                                                   const Proposal<D>& after, const Incidence<ElementId>& shells,
                                                   const BackMesh<D>& back, MeasuredEdges measured,
                                                   const Execution& execution);

}  // namespace camber
