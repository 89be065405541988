module;
#include <cstddef>
#include <span>
export module camber.curving:extension;
import camber.core;
import camber.bezier;
import camber.validity;
import :extension_part;
import :parts;

export namespace camber {

/// How far the linear extension goes.
struct ExtensionOptions {
    /// Nodes end where what a step of Jacobi's would still change is below this share of the smallest height of the
    /// elements around their edge: there det (I + ∇u) is known to about as much, in layers of any anisotropy.
    double tolerance = 1e-3;
    int max_iterations = 1000;
    /// Elements count with (mean |det straight| / |det straight|)^stiffening: 0 is the plain Dirichlet energy; more
    /// makes small elements stiffer, so that large ones take up the deformation.
    double stiffening = 2;
};

/// What the extension came to.
template <int D>
struct Extension {
    Buffer<LagrangeNode<D>> nodes;  ///< one an edge
    int iterations = 0;
    double correction = 0;   ///< what is left, as the tolerance says it
    std::size_t solved = 0;  ///< edges whose displacement was asked for; all others are straight
};

/// Carries the displacement of the given nodes off the middles of their chords into the volume: nodes of volume edges
/// get the displacement u that minimises Σ over the straight elements of ∫ |∇u|² dx, u in the space of the P2 edge
/// functions 4 ξ_i ξ_j (vertices stay). det (I + ∇u) is the scaled Jacobian. Since the gradient is taken in space, u
/// varies least across thin elements: a stack of layers moves with its wall. Solved by conjugate gradients, with
/// rows for as much of the mesh as the displacement reaches by more than the tolerance; the same bytes for any number
/// of threads. Errors: columns that do not fit the mesh (internal), stopped.
template <int D>
[[nodiscard]] Outcome<Extension<D>> extend_boundary(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                    const Column<LagrangeNode<D>>& boundary_nodes,
                                                    const Incidence<ElementId>& shells, const ExtensionOptions& options,
                                                    const Execution& execution);

struct ExtensionSolve {
    int iterations = 0;
    double correction = 0;
};
/// The same for the parts of a mesh that are here, which are as they were made and of which one somewhere is displaced:
/// conjugate gradients with the diagonal as preconditioner; the D components share their steps. Rows join as the
/// residual reaches them, so each new direction is made conjugate to the last by the product itself (Polak, Ribière).
/// Sums go over the parts in their order, whoever has them.
template <int D>
[[nodiscard]] Outcome<ExtensionSolve> solve_extension(std::span<ExtensionPart<D>> parts, BetweenParts<D>& between,
                                                      const ExtensionOptions& options, const Execution& execution);

}  // namespace camber
