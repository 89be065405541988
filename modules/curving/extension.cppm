module;
#include <cstddef>
export module camber.curving:extension;
import camber.core;
import camber.bezier;
import camber.validity;

export namespace camber {

/// How far the linear extension goes.
struct ExtensionOptions {
    /// Of the residual, relative to the first: below the first layer's height as a share of the wall's sagitta, or the
    /// layer folds (1e-3 at anisotropy 10^4).
    double tolerance = 1e-6;
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
    double residual = 0;  ///< relative to the first
};

/// Carries the displacement of the given nodes off the middles of their chords into the volume: nodes of volume edges
/// get the displacement u that minimises Σ over the straight elements of ∫ |∇u|² dx, u in the space of the P2 edge
/// functions 4 ξ_i ξ_j (vertices stay). det (I + ∇u) is the scaled Jacobian. Since the gradient is taken in space, u
/// varies least across thin elements: a stack of layers moves with its wall. Solved by conjugate gradients, the same
/// bytes for any number of threads. Errors: columns that do not fit the mesh (internal), stopped.
template <int D>
[[nodiscard]] Outcome<Extension<D>> extend_boundary(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                    const Column<LagrangeNode<D>>& boundary_nodes,
                                                    const Incidence<ElementId>& shells, const ExtensionOptions& options,
                                                    const Execution& execution);

}  // namespace camber
