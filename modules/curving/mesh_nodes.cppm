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

/// Nodes of a whole mesh: faces of its boundary, the objective shape, limits of what an objective moves.
export namespace camber {

/// Extends the displacement of the boundary's curves over its smooth faces and projects the nodes onto the geometry, so
/// that layers that end at a curved wall follow their own wall within it (3D; 2D meshes have no such faces). Nodes of
/// ridges and fixed nodes of `boundary_nodes` (one an edge, on the geometry) stay. In each face, the part of their
/// displacement that is not the projection onto the face is extended with weight 1/area, and added to the nodes of the
/// face before these are projected again. Facets on one surface or on surfaces with a common tangent plane are one
/// face. Facets without a surface belong to a face only where their patch is plane. Nodes out of reach of a
/// displacement keep their bytes. Errors: as extend_displacement.
template <int D>
[[nodiscard]] Outcome<Column<LagrangeNode<D>>> extend_over_faces(
    const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds, const Column<LagrangeNode<D>>& boundary_nodes,
    const Features<D>& features, const Geometry<D>& geometry, const Execution& execution);

/// The kinds with edges of walls and inner sheets that have no geometry and are not plane as `volume`: their nodes
/// follow the volume in extend_boundary, since a thin layer beside such a wall has no room for a flat one. Fixed edges
/// stay. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<Column<EdgeKind>> kinds_that_follow(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                          const Features<D>& features, const Geometry<D>& geometry,
                                                          const Execution& execution);

/// How far the shape of elements is evened out.
struct ShapeOptions {
    ExtensionOptions extension;
    /// Of the programmes. Without cuts elements count by their coefficients, which are close where shapes are good.
    EdgeProgrammeOptions programme{.tolerance = 1e-3, .max_cuts = 0};
    double enough = 0.95;    ///< elements with such a scaled Jacobian are let be
    double min_gain = 1e-3;  ///< a step must raise the smallest scaled Jacobian around its edge by so much
    /// Elements are raised together that are less than this above the worst, of max(1, |worst|).
    double band = 0.02;
    int rings = 2;               ///< of elements that are raised with the worst, where these alone do not rise
    std::size_t max_steps = 20;  ///< in one band, for each of its elements
    int max_bands = 100;
};

/// What `shape` came to.
template <int D>
struct Shaped {
    Proposal<D> proposal;
    int iterations = 0;          ///< of the linear extension
    std::size_t solved = 0;      ///< edges that it was solved for
    std::size_t steps = 0;       ///< nodes moved by programmes
    double after_extension = 0;  ///< smallest scaled Jacobian of the mesh, at most `enough`
    double smallest = 0;         ///< the same in the end
};

/// The second verb with the elements' shape as its aim, for a mesh without a field: boundary edges take
/// `boundary_nodes`, and nodes of volume edges are put so that the scaled Jacobian is as even as it may: by the linear
/// extension of the boundary's displacement, then by programmes of single edges, worst elements first, each of which
/// raises the smallest scaled Jacobian around its edge as far as that edge can, until all have `enough` or the worst
/// cannot be raised. The same bytes for any number of threads. Errors: as extend_boundary.
template <int D>
[[nodiscard]] Outcome<Shaped<D>> shape(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                       const Column<LagrangeNode<D>>& boundary_nodes,
                                       const Incidence<ElementId>& shells, const ShapeOptions& options,
                                       const Execution& execution);

}  // namespace camber

namespace camber {

/// What programmes of single edges came to.
template <int D>
struct Polished {
    Buffer<LagrangeNode<D>> nodes;
    std::size_t steps = 0;  ///< nodes moved
    double before = 0;      ///< smallest scaled Jacobian of the mesh, at most `enough`
    double smallest = 0;    ///< the same in the end
};

/// Nodes of volume edges moved so that the smallest scaled Jacobian rises: band after band of the worst elements, in
/// rounds. In a round the programmes of the edges around all elements of the band are solved, but for those around
/// which nothing has changed since; then elements, the worst first, take the edge that raises the smallest value around
/// it most, unless one that came before has changed an element there. So the result does not depend on the threads.
/// Where the worst of a band do not rise, the elements around them are raised too, and then the band is tried once
/// more. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<Polished<D>> polish(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                          Buffer<LagrangeNode<D>> nodes, const Incidence<ElementId>& shells,
                                          const ShapeOptions& options, const Execution& execution);

}  // namespace camber

export namespace camber {

/// Draws offsets of edges back, in place, until what they add to the error of a smooth function is at most the share
/// `loss` of it, by a model: its third derivatives are even, |∇²u| = ℓ|∇³u| with ℓ the domain's radius of gyration, and
/// the P2 interpolant errs by them on straight edges. An offset d of the edge e adds 24 ∇²u[e, d] to its third
/// derivative along e (see docs/algorithms/smooth-loss.md), in L2 and in H1
///
///   g_e = (24 ℓ |e| |d|)² Σ_K |K|/n (1/Σ|K|h⁶ + 0.1/(a_K² Σ|K|h⁴)),   Σ_e g_e k_e² ≤ (1 + loss)² − 1,   k_e = 1/(1 +
///   (g_e/c)²),
///
/// K: the elements around the edge, of n edges and the smallest height a_K; h² the mean of their squared edges. Offsets
/// are multiplied by k_e with the largest c for which the sum holds: those that cost most per element go first. Returns
/// how many were more than halved. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_smooth_loss(const QuadraticMesh<D>& mesh, const Incidence<ElementId>& shells,
                                                     double loss, std::span<Vec<D>> offsets,
                                                     const Execution& execution);

/// A part of a mesh with its offsets, one an edge; those of other parts do not count.
template <int D>
struct PartLosses {
    const QuadraticMesh<D>& mesh;
    const Incidence<ElementId>& shells;
    OwnVertices owned;
    std::span<Vec<D>> offsets;
};
/// The same of all parts of a mesh: their own offsets are drawn back. How many of those here were more than halved.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_smooth_loss(std::span<const PartLosses<D>> parts, double loss,
                                                     BetweenParts<D>& between, const Execution& execution);

}  // namespace camber

/// A field that goes along with its walls: the displacement of the boundary's nodes is extended into the volume, and
/// the metric read through that. docs/algorithms/curved-back-mesh.md.
export namespace camber {

/// Where nodes go along with the boundary: where they are `extended` (one an edge: see extend_boundary), but the
/// middles of chords where the displacement is less than a hundredth of the metric's unit at both ends, so that nothing
/// is searched where nothing moves. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> noticeable_nodes(const QuadraticMesh<D>& mesh,
                                                                std::span<const LagrangeNode<D>> extended,
                                                                const Column<LogMetric<D>>& log_metrics,
                                                                const Execution& execution);

/// Of these nodes (one an edge) those of a back mesh, for make_curved_back_mesh: displacements that would bring an
/// element below a tenth of the straight one's Jacobian are limited, on the boundary too; so it is the field's map
/// alone, and no place for a mesh's nodes. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> back_mesh_nodes(const QuadraticMesh<D>& mesh,
                                                               std::span<const LagrangeNode<D>> nodes,
                                                               const Incidence<ElementId>& shells,
                                                               const Execution& execution);

/// A part of a mesh with nodes, one an edge, those of other parts as they have them.
template <int D>
struct PartNodes {
    const QuadraticMesh<D>& mesh;
    const Incidence<ElementId>& shells;
    OwnVertices owned;
    std::span<LagrangeNode<D>> nodes;
};
/// The same of the parts of a mesh that are here, in place.
template <int D>
[[nodiscard]] Outcome<Done> limit_to_back_mesh(std::span<const PartNodes<D>> parts, BetweenParts<D>& between,
                                               const Execution& execution);

/// Nodes as their elements bear them: where `base` + `offsets` (one row an edge) would bring an element's scaled
/// Jacobian below `least`, those of its edges go only a part of their way, the largest of 3/4, 1/2, 1/4 and 0 that
/// holds it, or the best where none does; an edge takes the least share that its elements ask for. Elements around what
/// was limited are looked at again, until none asks for more (through a stack of layers that is a round a layer), and
/// shares multiply. What an edge alone does not see: error in the gradient grows as
/// 1/det J, so that a few elements that are nearly flat cost more than all others gain. The number of edges that
/// were limited. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_by_jacobian(const QuadraticMesh<D>& mesh,
                                                     std::span<const LagrangeNode<D>> base,
                                                     const Incidence<ElementId>& shells, double least,
                                                     std::span<Vec<D>> offsets, const Execution& execution);

/// A part of a mesh with its rows: one an edge, those of other parts as they have them.
template <int D>
struct PartOffsets {
    const QuadraticMesh<D>& mesh;
    std::span<const LagrangeNode<D>> base;  ///< none: the middles of chords
    const Incidence<ElementId>& shells;
    OwnVertices owned;
    std::span<Vec<D>> offsets;
};
/// The same of the parts of a mesh that are here; how many of their own edges were limited.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_by_jacobian(std::span<const PartOffsets<D>> parts, double least,
                                                     BetweenParts<D>& between, const Execution& execution);

}  // namespace camber
