module;
#include <cstddef>
#include <span>
export module camber.surface:curved_surrogate;
import camber.core;
import camber.bezier;
import :features;
import :geometry;
import :surrogate;

export namespace camber {

/// What became of the patches of a mesh that has curves.
struct CurvedPatches {
    std::size_t smooth = 0;    ///< patches with curves of their own, that one surface goes through
    std::size_t as_read = 0;   ///< those whose curved facets stay as they are, with their kinks
    double largest_angle = 0;  ///< by which the smooth ones turn between their pieces, in radians
    double mean_angle = 0;     ///< the root mean square of these turns
};

template <int D>
struct CurvedSurrogate {
    Surrogate<D> surrogate;
    CurvedPatches patches;
};

/// The boundary of a curved mesh (`nodes`: one an edge) as a smooth surface through its vertices and nodes. `straight`
/// is the surrogate of its straight facets: patches keep it where all of their edges' nodes lie on it (to 1e-6 of the
/// chord), or all in the middles of chords: they have no curves of their own. If there are others, the surrogate is
/// that of the facets cut at their nodes, so normals and tangents are fitted to vertices and nodes; pieces of patches
/// without curves go through the nodes that `straight` has. Curves that are no smooth surface's, since facets of degree
/// 2 turn between each other by more than a quarter of what straight ones do (root mean squares over the patch), and
/// patches of one facet stay as they are: these pieces are the mesh's own facets, exactly. Ridges, patches and their
/// neighbours are those of the straight mesh. Patches of planes are flat where the nodes are in them too. `prescribed`:
/// as build_surrogate has it. Errors: `straight` is not of this mesh (ErrorKind::internal), stopped.
template <int D>
[[nodiscard]] Outcome<CurvedSurrogate<D>> with_curves(Surrogate<D> straight, const LinearMesh<D>& mesh,
                                                      const EdgeSet<D>& edges, const Features<D>& features,
                                                      std::span<const LagrangeNode<D>> nodes,
                                                      const GeometryModel<D>& prescribed,
                                                      const SurrogateOptions& options, const Execution& execution);

}  // namespace camber
