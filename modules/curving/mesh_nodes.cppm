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

/// Nodes of a whole mesh: boundary faces, shape objective, limits.
export namespace camber {

/// Extends displacements of boundary curves over smooth faces and projects nodes onto the geometry, so that layers
/// ending at a curved boundary follow it (3D; no change in 2D). Ridge nodes and fixed nodes of `boundary_nodes` (a row
/// an edge, on the geometry) stay. In each face, their displacement from their projection onto it is extended with
/// weight 1/area; nodes are shifted and projected again. Facets on one surface, or with a common tangent plane, form
/// one face; facets without a surface only if their patch is plane. Nodes without displacement keep their bytes.
/// Errors: as `extend_displacement`.
template <int D>
[[nodiscard]] Outcome<Column<LagrangeNode<D>>> extend_over_faces(
    const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds, const Column<LagrangeNode<D>>& boundary_nodes,
    const Features<D>& features, const Geometry<D>& geometry, const Execution& execution);

/// The kinds, with edges on boundaries and sheets without a geometry, and not plane, as `volume`: their nodes follow
/// `extend_boundary`, since thin layers do not fit beside flat edges. Fixed edges stay. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<Column<EdgeKind>> kinds_that_follow(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                          const Features<D>& features, const Geometry<D>& geometry,
                                                          const Execution& execution);

struct ShapeOptions {
    ExtensionOptions extension;
    /// Without cuts elements count by coefficients, which are close for good shapes.
    EdgeProgrammeOptions programme{.tolerance = 1e-3, .max_cuts = 0};
    double enough = 0.95;    ///< elements with this scaled Jacobian are skipped
    double min_gain = 1e-3;  ///< minimum gain of a step
    /// Width above the worst of elements raised together, times max(1, |worst|).
    double band = 0.02;
    int rings = 2;               ///< around the worst, if these alone do not rise
    std::size_t max_steps = 20;  ///< per element of a band
    int max_bands = 100;
};

template <int D>
struct Shaped {
    Proposal<D> proposal;
    int iterations = 0;          ///< of the linear extension
    std::size_t solved = 0;      ///< edges in the linear extension
    std::size_t steps = 0;       ///< nodes moved by programs
    double after_extension = 0;  ///< smallest scaled Jacobian, at most `enough`
    double smallest = 0;         ///< the same at the end
};

/// Curves a mesh without a field so that scaled Jacobians are as even as possible. Volume nodes follow the extended
/// displacement of `boundary_nodes`. Then linear programs of single edges, worst elements first, maximise the smallest
/// scaled Jacobian around them, until all reach `enough` or the worst cannot rise. Same bytes for any number of
/// threads. Errors: as `extend_boundary`.
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
    std::size_t steps = 0;  ///< nodes moved
    double before = 0;      ///< smallest scaled Jacobian, at most `enough`
    double smallest = 0;    ///< the same at the end
};

/// Raises the smallest scaled Jacobian by moving volume nodes, in bands of the worst elements. Each round solves the
/// programs of edges around the band where elements changed. Then elements, worst first, apply their best edge, unless
/// an earlier one changed its elements; so threads do not matter. If a band's worst do not rise, elements around are
/// raised too and the band is tried once more. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<Polished<D>> polish(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                          Buffer<LagrangeNode<D>> nodes, const Incidence<ElementId>& shells,
                                          const ShapeOptions& options, const Execution& execution);

}  // namespace camber

export namespace camber {

/// Reduces edge offsets in place until they add at most the share `loss` to the error of a smooth function. Model:
/// uniform third derivatives; |∇²u| = ℓ|∇³u| with ℓ the domain's radius of gyration; P2 interpolation on straight edges
/// errs by third derivatives. An offset d of edge e adds 24 ∇²u[e, d] to that along e (docs/algorithms/smooth-loss.md),
/// in L2 and in H1:
///
///   g_e = (24 ℓ |e| |d|)² Σ_K |K|/n (1/Σ|K|h⁶ + 0.1/(a_K² Σ|K|h⁴)),
///   Σ_e g_e k_e² ≤ (1 + loss)² − 1, k_e = 1/(1 + (g_e/c)²),
///
/// K: elements around the edge, of n edges and smallest height a_K; h²: the mean of their squared edges. Offsets are
/// multiplied by k_e with the largest c that meets the bound, so the most costly shrink first. Returns the number more
/// than halved. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_smooth_loss(const QuadraticMesh<D>& mesh, const Incidence<ElementId>& shells,
                                                     double loss, std::span<Vec<D>> offsets,
                                                     const Execution& execution);

/// A part of a mesh. Offsets: one an edge; those of other parts are ignored.
template <int D>
struct PartLosses {
    const QuadraticMesh<D>& mesh;
    const Incidence<ElementId>& shells;
    OwnVertices owned;
    std::span<Vec<D>> offsets;
};
/// The same for all parts, each with its own offsets. Returns the number here.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_smooth_loss(std::span<const PartLosses<D>> parts, double loss,
                                                     BetweenParts<D>& between, const Execution& execution);

}  // namespace camber

/// Fields that follow the extended displacement of the boundary. docs/algorithms/curved-back-mesh.md.
export namespace camber {

/// `extended` nodes (see `extend_boundary`), but chord middles where both ends' metrics measure less than 0.01, to
/// avoid searches. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> noticeable_nodes(const QuadraticMesh<D>& mesh,
                                                                std::span<const LagrangeNode<D>> extended,
                                                                const Column<LogMetric<D>>& log_metrics,
                                                                const Execution& execution);

/// Limits nodes (one an edge) for `make_curved_back_mesh` to a tenth of the straight Jacobian, on the boundary too. The
/// result is only the field's map, not nodes of a mesh. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> back_mesh_nodes(const QuadraticMesh<D>& mesh,
                                                               std::span<const LagrangeNode<D>> nodes,
                                                               const Incidence<ElementId>& shells,
                                                               const Execution& execution);

/// Nodes: one an edge; other parts' as in those.
template <int D>
struct PartNodes {
    const QuadraticMesh<D>& mesh;
    const Incidence<ElementId>& shells;
    OwnVertices owned;
    std::span<LagrangeNode<D>> nodes;
};
/// The same for local parts of a mesh, in place.
template <int D>
[[nodiscard]] Outcome<Done> limit_to_back_mesh(std::span<const PartNodes<D>> parts, BetweenParts<D>& between,
                                               const Execution& execution);

/// Limits `offsets` from `base` (a row an edge) so that scaled Jacobians reach `least`. Elements below it allow the
/// largest share of 3/4, 1/2, 1/4 and 0 that reaches it, or the best one; edges take the minimum of their elements.
/// Elements around changes are checked again until none changes (one round a layer in a stack); shares multiply. Almost
/// flat elements would cost more than others gain: gradient errors grow as 1/det J. Returns the number of limited
/// edges. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_by_jacobian(const QuadraticMesh<D>& mesh,
                                                     std::span<const LagrangeNode<D>> base,
                                                     const Incidence<ElementId>& shells, double least,
                                                     std::span<Vec<D>> offsets, const Execution& execution);

/// Rows: one an edge; other parts' as in those.
template <int D>
struct PartOffsets {
    const QuadraticMesh<D>& mesh;
    std::span<const LagrangeNode<D>> base;  ///< empty: chord middles
    const Incidence<ElementId>& shells;
    OwnVertices owned;
    std::span<Vec<D>> offsets;
};
/// The same for local parts; returns their own edges limited.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_by_jacobian(std::span<const PartOffsets<D>> parts, double least,
                                                     BetweenParts<D>& between, const Execution& execution);

}  // namespace camber
