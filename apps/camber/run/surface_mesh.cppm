module;
#include <cstddef>
export module camber.run:surface_mesh;
import camber.core;
import camber.bezier;
import camber.io;
import camber.surface;

export namespace camber::run {

/// What of a geometry stands over the facets of a mesh, as a surface of small straight facets to be looked at: of each
/// facet a lattice of its own, so that normals may break between them. Fields: `normal` of points; of cells `facet`,
/// the number of the mesh's facet, and `patch`.
struct SurfaceMesh {
    AnyMesh mesh;
    MeshFields fields;
};
/// Each facet in 36 (2D: 6). A facet without a surface is its own plane. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<SurfaceMesh> surface_mesh(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                const Geometry<D>& geometry, const Execution& execution);

}  // namespace camber::run
