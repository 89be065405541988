module;
#include <cstddef>
#include <cstdint>
export module camber.cavity:reinsert;
import camber.core;
import camber.metric;
import camber.validity;
import camber.programmes;
import camber.curving;
import camber.repair;
import :patch;
import :star;

export namespace camber {

/// How a cavity curves its edges and what it asks of its elements.
struct ReinsertOptions {
    CurveOptions edge = {};
    RepairOptions relax = {};
};

/// A mesh that is curved cavity by cavity: its nodes as they are now, and where each edge's node ought to be, as far as
/// that is known. An immutable value between two commits.
template <int D>
struct Curving {
    QuadraticMesh<D> mesh;
    Column<EdgeKind> kinds;
    Column<LagrangeNode<D>> base;  ///< of boundary edges on the geometry, of volume edges where the field has them
    Column<EdgeChange> changes;
    Column<EdgeTarget<D>> targets;
    Column<std::uint8_t> known;  ///< 1 where `targets` holds something
};

/// The P2 cavity operator on the ball of a vertex, which is reinserted (paper §3.2): the ball is emptied and starred,
/// the star elevated; edges at the vertex go to their targets, inner ones by the metric, boundary ones by projection;
/// the star's elements are validated, and edges at the vertex relaxed, volume before surface, until all are valid. The
/// boundary of the cavity keeps its nodes; for a boundary vertex that does not include the edges at it (the paper's
/// exception to step 3). A pure function: what it plans is against `curving` as it is.
///
/// The bound of relax is met with a margin, its `target`, where no surface node pays for that. Where relaxing from the
/// targets breaks an element, the edges go a part of their way from where they are.
///
/// A patch never makes an element not valid that was valid, and it brings nodes nearer to their targets: surface nodes
/// before volume nodes. Errors: options out of range (usage); the vertex's element that names a vertex twice (input).
template <int D>
[[nodiscard]] Outcome<Reinsertion<D>> reinsert(const Curving<D>& curving, const CavityTopology<D>& topology,
                                               const BackMesh<D>& back, VertexId vertex, const EdgeRules& rules,
                                               const ReinsertOptions& options);

/// How far a node is from its target, as a share of the target's offset from the middle of the chord: 0 there, 1 on the
/// straight edge.
template <int D>
[[nodiscard]] double misfit(const QuadraticMesh<D>& mesh, EdgeId edge, const LagrangeNode<D>& node,
                            const LagrangeNode<D>& target);

}  // namespace camber
