module;
#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>
export module camber.cad:geometry;
import camber.core;
import camber.surface;
import :association;
import :model;

export namespace camber {

/// A CAD model as the geometry of a mesh: surfaces are its faces, curves its edges, corners its vertices, by the
/// model's numbers. Facets of the mesh lie on what they are associated with; other facets (of a mesh that was made from
/// it) on that face which fits them best of those that their reference lies on. An edge between two faces is on the
/// model's edge there, even where both are smooth, if it lies along that edge; else on the nearest face. Faces that the
/// mesh joins (CadAssociation::joined) are one surface for projections.
/// In 2D surfaces are its edges, corners its vertices.
template <int D>
struct CadGeometry {
    CadModel model;
    CadAssociation association;
    LinearMesh<D> mesh;  ///< that of the association

    /// Whether all of the mesh's boundary is on the model.
    [[nodiscard]] bool is_whole() const { return association.facets == mesh.facets.size(); }
    /// Whether a facet is the one of its number of that mesh, and on the model.
    [[nodiscard]] bool has(const FacetSite<D>& facet) const {
        return facet.id.valid() && facet.id.index() < mesh.facets.size() && association.faces[facet.id] != no_face &&
               facet_site(mesh, facet.id).corners == facet.corners;
    }
    /// The faces (in 2D edges) that facets of a reference lie on; none of an unknown one.
    [[nodiscard]] std::span<const std::size_t> of_reference(Reference reference) const {
        const auto& all = association.of_references;
        const auto row = std::lower_bound(all.begin(), all.end(), reference,
                                          [](const auto& entry, Reference r) { return entry.first < r; });
        if (row == all.end() || row->first != reference) return {};
        return row->second;
    }
    /// The faces (in 2D edges) that the mesh has facets on, rising.
    [[nodiscard]] std::vector<std::size_t> met() const {
        std::vector<std::size_t> all;
        for (const auto& [reference, faces] : association.of_references)
            all.insert(all.end(), faces.begin(), faces.end());
        std::sort(all.begin(), all.end());
        all.erase(std::unique(all.begin(), all.end()), all.end());
        return all;
    }
};
[[nodiscard]] std::shared_ptr<const GeometryModel<2>> model_of(CadGeometry<2> cad);
[[nodiscard]] std::shared_ptr<const GeometryModel<3>> model_of(CadGeometry<3> cad);

}  // namespace camber
