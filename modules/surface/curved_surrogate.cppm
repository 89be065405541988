module;
#include <span>
export module camber.surface:curved_surrogate;
import camber.core;
import camber.bezier;
import :surrogate;

export namespace camber {

/// The boundary of a curved mesh (`nodes`: one an edge) as it is. Patches keep their smooth surface where all of their
/// edges' nodes lie on it (to 1e-6 of the chord), or all in the middles of chords: they have no curves of their own.
/// The others have the mesh's own facets and edges, of degree 2 and raised to 3, which is exact: they meet in the
/// edges' curves, and their tangent planes are what the mesh makes of them. Patches of planes are flat where the nodes
/// are in them too. Errors: the surrogate is not of this mesh (ErrorKind::internal), stopped.
template <int D>
[[nodiscard]] Outcome<Surrogate<D>> with_curves(Surrogate<D> surrogate, const LinearMesh<D>& mesh,
                                                const EdgeSet<D>& edges, std::span<const LagrangeNode<D>> nodes,
                                                const Execution& execution);

}  // namespace camber
