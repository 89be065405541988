module;
#include <cstddef>
#include <span>
#include <vector>
export module camber.curving:mesh_nodes;
import camber.core;
import camber.bezier;
import camber.extension;
import camber.metric;
import camber.surface;
import camber.validity;
import camber.optimisation;

/// Nodes of a whole mesh: extension over faces, optimisation of shapes, limits.
export namespace camber {

/// Extends displacements of boundary curves over the smooth faces beside them (3D; no change in 2D), so that layers
/// that end at these faces follow the curves (docs/algorithms/boundary-displacement.md). `boundary_nodes` has one row
/// per edge, on the geometry. Nodes of ridges and fixed nodes do not move. Facets form one face if they are on one
/// surface, on surfaces with a common tangent plane, or in a plane patch without a surface. Errors: those of
/// `extend_displacement`.
template <int D>
[[nodiscard]] Outcome<Column<LagrangeNode<D>>> extend_over_faces(
    const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds, const Column<LagrangeNode<D>>& boundary_nodes,
    const Features<D>& features, const Geometry<D>& geometry, const Execution& execution);

/// Returns `kinds`, with the kind `volume` for edges on curved boundaries and sheets without geometry.
/// `extend_boundary` can then move their nodes, since thin layers do not fit beside straight edges. Fixed edges are
/// unchanged. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<Column<EdgeKind>> kinds_with_following(const QuadraticMesh<D>& mesh,
                                                             const Column<EdgeKind>& kinds, const Features<D>& features,
                                                             const Geometry<D>& geometry, const Execution& execution);

struct ShapeOptions {
    ExtensionOptions extension;
    /// With `max_cuts` 0, elements are not bisected. Their Bézier coefficients then rate them; these are close to the
    /// Jacobian for good shapes.
    EdgeProgramOptions program{.tolerance = 1e-3, .max_cuts = 0};
    double enough = 0.95;    ///< elements that reach this scaled Jacobian are skipped
    double min_gain = 1e-3;  ///< minimum increase of the scaled Jacobian by a step
    /// Let w be the smallest scaled Jacobian. Elements less than band · max(1, |w|) above w are improved together.
    double band = 0.02;
    int rings = 2;               ///< if the worst elements cannot be improved, this number of element rings around them
                                 ///< is improved too
    std::size_t max_steps = 20;  ///< maximum number of steps per element of a band
    int max_bands = 100;
};

template <int D>
struct Shaped {
    Proposal<D> proposal;
    int iterations = 0;
    std::size_t solved = 0;
    std::size_t steps = 0;
    double after_extension = 0;  ///< smallest scaled Jacobian after `extend_boundary`, at most `enough`
    double smallest = 0;
};

/// Curves a mesh without a field and makes its smallest scaled Jacobian large (docs/algorithms/shape.md). First, volume
/// nodes follow the extended displacement of `boundary_nodes`. Then linear programs move the nodes of single edges to
/// maximise the smallest scaled Jacobian around the edge. They end when all elements reach `enough` or the worst cannot
/// be improved. Bitwise independent of the number of threads. Errors: those of `extend_boundary`.
template <int D>
[[nodiscard]] Outcome<Shaped<D>> shape(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                       const Column<LagrangeNode<D>>& boundary_nodes,
                                       const Incidence<ElementId>& shells, const ShapeOptions& options,
                                       const Execution& execution);

}  // namespace camber

namespace camber {

template <int D>
struct Polished {
    Buffer<LagrangeNode<D>> nodes;
    std::size_t steps = 0;
    double before = 0;  ///< smallest scaled Jacobian at the start, at most `enough`
    double smallest = 0;
};

/// Increases the smallest scaled Jacobian by moving volume nodes, in bands of the worst elements
/// (docs/algorithms/shape.md). In each iteration every element of the band, worst first, moves the node of its best
/// edge. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<Polished<D>> polish(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                          Buffer<LagrangeNode<D>> nodes, const Incidence<ElementId>& shells,
                                          const ShapeOptions& options, const Execution& execution);

}  // namespace camber

export namespace camber {

/// Reduces edge offsets in place until they add at most the fraction `loss` to the error of a smooth function, in L2
/// and in H1. The offset of edge e is multiplied by k_e = 1/(1 + (g_e/c)²), where g_e is the squared error that it adds
/// in the model of docs/algorithms/smooth-loss.md. c is the largest number with
///
///   Σ_e g_e k_e² ≤ (1 + loss)² − 1,
///
/// so the most costly offsets shrink most. Returns the number of offsets that were more than halved. Errors: stopped,
/// memory.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_smooth_loss(const QuadraticMesh<D>& mesh, const Incidence<ElementId>& shells,
                                                     double loss, std::span<Vec<D>> offsets,
                                                     const Execution& execution);

/// A part of a mesh; rows of `offsets` for edges that other parts own are ignored.
template <int D>
struct PartLosses {
    const QuadraticMesh<D>& mesh;
    const Incidence<ElementId>& shells;
    OwnVertices owned;
    std::span<Vec<D>> offsets;
};
/// Limits the offsets of all parts together. Returns the number of offsets in the local parts that were more than
/// halved.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_smooth_loss(std::span<const PartLosses<D>> parts, double loss,
                                                     PartCommunication<D>& between, const Execution& execution);

}  // namespace camber

/// Nodes for back meshes whose fields follow the extended displacement of the boundary
/// (docs/algorithms/curved-back-mesh.md).
export namespace camber {

/// Returns the nodes `extended` (from `extend_boundary`). To avoid searches, chord middles replace nodes with
/// displacements below 0.01 in the metrics of both ends. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> noticeable_nodes(const QuadraticMesh<D>& mesh,
                                                                std::span<const LagrangeNode<D>> extended,
                                                                const Column<LogMetric<D>>& log_metrics,
                                                                const Execution& execution);

/// Limits `nodes` (one per edge) so that the Jacobian of each element is at least a tenth of the straight one, also at
/// the boundary. The result defines the map of `make_curved_back_mesh`, not a mesh. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> back_mesh_nodes(const QuadraticMesh<D>& mesh,
                                                               std::span<const LagrangeNode<D>> nodes,
                                                               const Incidence<ElementId>& shells,
                                                               const Execution& execution);

/// A part of a mesh. Edges that another part owns have the same `nodes` in both parts.
template <int D>
struct PartNodes {
    const QuadraticMesh<D>& mesh;
    const Incidence<ElementId>& shells;
    OwnVertices owned;
    std::span<LagrangeNode<D>> nodes;
};
template <int D>
[[nodiscard]] Outcome<Done> limit_to_back_mesh(std::span<const PartNodes<D>> parts, PartCommunication<D>& between,
                                               const Execution& execution);

/// Reduces `offsets` from the nodes `base` (one row per edge) until scaled Jacobians reach `least`
/// (docs/algorithms/edge-accuracy.md). Each element below `least` chooses a factor for its offsets: the largest of 3/4,
/// 1/2, 1/4 and 0 with which it reaches `least`, or else the one with the largest Jacobian. The offset of an edge is
/// multiplied by the minimum factor of its elements. Elements around changed edges are then checked again. Returns the
/// number of limited edges. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_by_jacobian(const QuadraticMesh<D>& mesh,
                                                     std::span<const LagrangeNode<D>> base,
                                                     const Incidence<ElementId>& shells, double least,
                                                     std::span<Vec<D>> offsets, const Execution& execution);

/// A part of a mesh. Edges that another part owns have the same `offsets` in both parts.
template <int D>
struct PartOffsets {
    const QuadraticMesh<D>& mesh;
    std::span<const LagrangeNode<D>> base;  ///< chord middles if empty
    const Incidence<ElementId>& shells;
    OwnVertices owned;
    std::span<Vec<D>> offsets;
};
/// Limits the offsets of the parts together; returns the number of limited edges that the local parts own.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_by_jacobian(std::span<const PartOffsets<D>> parts, double least,
                                                     PartCommunication<D>& between, const Execution& execution);

}  // namespace camber
