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

/// Nodes of a whole mesh: extension over boundary faces, optimisation of shapes, and limits.
export namespace camber {

/// Extends displacements of boundary curves over smooth faces and projects nodes onto the geometry, so that layers that
/// end at a curved boundary follow it (3D; no change in 2D). `boundary_nodes` has one row per edge, on the geometry.
/// Nodes of ridges and fixed nodes stay. Their displacement from their projection onto each adjacent face is extended
/// over the face with weight 1/area; its nodes are shifted and projected again. Facets on one surface, or on surfaces
/// with a common tangent plane, form one face. Facets without a surface belong to a face only if their patch is plane.
/// Nodes without displacement do not change at all. Errors: those of `extend_displacement`.
template <int D>
[[nodiscard]] Outcome<Column<LagrangeNode<D>>> extend_over_faces(
    const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds, const Column<LagrangeNode<D>>& boundary_nodes,
    const Features<D>& features, const Geometry<D>& geometry, const Execution& execution);

/// Returns the kinds, with `volume` for edges on curved boundaries and sheets that have no geometry. The nodes of these
/// edges follow `extend_boundary`, since thin layers do not fit beside straight edges. Fixed edges are unchanged.
/// Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<Column<EdgeKind>> kinds_with_following(const QuadraticMesh<D>& mesh,
                                                             const Column<EdgeKind>& kinds, const Features<D>& features,
                                                             const Geometry<D>& geometry, const Execution& execution);

struct ShapeOptions {
    ExtensionOptions extension;
    /// Without cuts, elements are rated by Bézier coefficients, which are close to the Jacobian for well-shaped
    /// elements.
    EdgeProgramOptions program{.tolerance = 1e-3, .max_cuts = 0};
    double enough = 0.95;    ///< elements with this scaled Jacobian are skipped
    double min_gain = 1e-3;  ///< minimum increase of the scaled Jacobian by a step
    /// All elements up to this value, times max(1, |worst|), above the worst one are improved together (a band).
    double band = 0.02;
    int rings = 2;  ///< rings of elements around the worst that are improved too if the worst alone cannot be
    std::size_t max_steps = 20;  ///< maximum number of steps per element of a band
    int max_bands = 100;
};

template <int D>
struct Shaped {
    Proposal<D> proposal;
    int iterations = 0;          ///< iterations of the linear extension
    std::size_t solved = 0;      ///< edges in the linear extension
    std::size_t steps = 0;       ///< number of moves of nodes by linear programs
    double after_extension = 0;  ///< smallest scaled Jacobian, at most `enough`
    double smallest = 0;         ///< smallest scaled Jacobian at the end, at most `enough`
};

/// Curves a mesh without a field so that scaled Jacobians are as even as possible. Volume nodes first follow the
/// extended displacement of `boundary_nodes`. Then linear programs of single edges maximise the smallest scaled
/// Jacobian around the edge, worst elements first. They end when all elements reach `enough` or the worst cannot be
/// improved. The number of threads does not change a bit of the result. Errors: those of `extend_boundary`.
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
    std::size_t steps = 0;  ///< number of moves of nodes
    double before = 0;      ///< smallest scaled Jacobian, at most `enough`
    double smallest = 0;    ///< smallest scaled Jacobian at the end, at most `enough`
};

/// Increases the smallest scaled Jacobian by moving volume nodes, in bands of the worst elements. Each iteration solves
/// the programs of the band's edges around which elements changed. Then each element, worst first, applies its best
/// edge, unless an earlier element changed the elements around that edge. So the result does not depend on threads. If
/// the worst of a band do not improve, the elements around are improved too and the band is tried once more. Errors:
/// stopped, memory.
template <int D>
[[nodiscard]] Outcome<Polished<D>> polish(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                          Buffer<LagrangeNode<D>> nodes, const Incidence<ElementId>& shells,
                                          const ShapeOptions& options, const Execution& execution);

}  // namespace camber

export namespace camber {

/// Reduces edge offsets in place until they add at most the fraction `loss` to the error of a smooth function. Model:
/// third derivatives are uniform; |∇²u| = ℓ|∇³u| with ℓ the domain's radius of gyration. On straight edges the P2 error
/// is due to third derivatives. An offset d of edge e adds 24 ∇²u[e, d] to the third derivative along e
/// (docs/algorithms/smooth-loss.md), in L2 and in H1:
///
///   g_e = (24 ℓ |e| |d|)² Σ_K |K|/n (1/Σ|K|h⁶ + 0.1/(a_K² Σ|K|h⁴)),
///   Σ_e g_e k_e² ≤ (1 + loss)² − 1, k_e = 1/(1 + (g_e/c)²),
///
/// where K are the elements around the edge, with n edges and smallest height a_K, and h² is the mean of their squared
/// edge lengths. Offsets are multiplied by k_e with the largest c that satisfies the bound, so the most costly offsets
/// shrink most. Returns the number of offsets that are more than halved. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_smooth_loss(const QuadraticMesh<D>& mesh, const Incidence<ElementId>& shells,
                                                     double loss, std::span<Vec<D>> offsets,
                                                     const Execution& execution);

/// A part of a mesh. `offsets` has one row per edge; rows of edges that other parts own are ignored.
template <int D>
struct PartLosses {
    const QuadraticMesh<D>& mesh;
    const Incidence<ElementId>& shells;
    OwnVertices owned;
    std::span<Vec<D>> offsets;
};
/// Limits the offsets of all parts together, each part with its own `offsets`. Returns the number of more than halved
/// offsets in these parts.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_smooth_loss(std::span<const PartLosses<D>> parts, double loss,
                                                     PartCommunication<D>& between, const Execution& execution);

}  // namespace camber

/// Fields whose mesh follows the extended displacement of the boundary. docs/algorithms/curved-back-mesh.md.
export namespace camber {

/// Returns the nodes `extended` (see `extend_boundary`), or chord middles where the displacement is shorter than 0.01
/// in the metrics of both ends, to avoid searches. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> noticeable_nodes(const QuadraticMesh<D>& mesh,
                                                                std::span<const LagrangeNode<D>> extended,
                                                                const Column<LogMetric<D>>& log_metrics,
                                                                const Execution& execution);

/// Limits `nodes` (one per edge) so that the Jacobian is at least a tenth of the straight one, also at the boundary.
/// The result is for `make_curved_back_mesh`: it defines the field's map, not a mesh. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> back_mesh_nodes(const QuadraticMesh<D>& mesh,
                                                               std::span<const LagrangeNode<D>> nodes,
                                                               const Incidence<ElementId>& shells,
                                                               const Execution& execution);

/// A part of a mesh. `nodes` has one row per edge; rows of edges that other parts own hold those parts' nodes.
template <int D>
struct PartNodes {
    const QuadraticMesh<D>& mesh;
    const Incidence<ElementId>& shells;
    OwnVertices owned;
    std::span<LagrangeNode<D>> nodes;
};
/// Limits nodes like `back_mesh_nodes`, for the local parts of a mesh, in place.
template <int D>
[[nodiscard]] Outcome<Done> limit_to_back_mesh(std::span<const PartNodes<D>> parts, PartCommunication<D>& between,
                                               const Execution& execution);

/// Limits `offsets` from `base` (one row per edge) so that scaled Jacobians reach `least`. An element below `least`
/// allows the largest fraction 3/4, 1/2, 1/4 or 0 of its offsets that reaches it, or else the best one. Each edge uses
/// the minimum over its elements. Elements around changed edges are checked again until no edge changes (one iteration
/// per layer in a stack); fractions multiply. Reason: almost flat elements would cost more accuracy than other elements
/// gain, since gradient errors grow as 1/det J. Returns the number of limited edges. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_by_jacobian(const QuadraticMesh<D>& mesh,
                                                     std::span<const LagrangeNode<D>> base,
                                                     const Incidence<ElementId>& shells, double least,
                                                     std::span<Vec<D>> offsets, const Execution& execution);

/// A part of a mesh, with one row per edge. Rows of edges that other parts own hold those parts' values.
template <int D>
struct PartOffsets {
    const QuadraticMesh<D>& mesh;
    std::span<const LagrangeNode<D>> base;  ///< chord middles if empty
    const Incidence<ElementId>& shells;
    OwnVertices owned;
    std::span<Vec<D>> offsets;
};
/// Limits the offsets of local parts together. Returns the number of limited edges that these parts own.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_by_jacobian(std::span<const PartOffsets<D>> parts, double least,
                                                     PartCommunication<D>& between, const Execution& execution);

}  // namespace camber
