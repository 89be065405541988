module;
#include <memory>
export module camber.cad:geometry;
import camber.core;
import camber.surface;
import :association;
import :model;

export namespace camber {

/// A CAD model as the geometry of a mesh: surfaces are its faces, curves its edges, corners its vertices, by the
/// model's numbers. Facets of the mesh lie on what they are associated with; other facets (of a mesh that was made from
/// it) on that face which fits them best of those that their reference lies on. An edge between two faces is on the
/// model's edge there, even where both are smooth.
struct CadGeometry {
    CadModel model;
    CadAssociation association;
    LinearMesh<3> mesh;  ///< that of the association
};
[[nodiscard]] std::shared_ptr<const GeometryModel<3>> model_of(CadGeometry cad);

}  // namespace camber
