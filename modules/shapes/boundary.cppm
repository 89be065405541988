module;
#include <functional>
#include <span>
#include <utility>
export module camber.shapes:boundary;
import camber.core;

export namespace camber {

/// The reference of a boundary facet, from its vertices.
template <int D>
using FacetReference = std::function<Reference(const SimplexVertices<D - 1>&)>;

/// A whole mesh from its points and elements: facets on the boundary, outwards oriented, and between elements of
/// different materials, out of the one of lower number; vertices with the least reference of their facets, inner ones
/// with 0; where references meet, corners (2D) or ridges and corners (3D: where ridges end or more than two meet).
/// Errors: an element without positive volume (usage: the sizes do not fit together).
template <int D>
[[nodiscard]] Outcome<LinearMesh<D>> bounded_mesh(Buffer<Vec<D>> points, Buffer<SimplexVertices<D>> elements,
                                                  Buffer<Reference> materials,
                                                  const FacetReference<D>& facet_reference);

/// The same of one material: reference 1.
template <int D>
[[nodiscard]] Outcome<LinearMesh<D>> bounded_mesh(Buffer<Vec<D>> points, Buffer<SimplexVertices<D>> elements,
                                                  const FacetReference<D>& facet_reference) {
    Buffer<Reference> materials(elements.size(), Reference{1});
    return bounded_mesh<D>(std::move(points), std::move(elements), std::move(materials), facet_reference);
}

/// D! times the volume (area in 2D) of an element.
[[nodiscard]] inline double determinant(const Column<Vec<2>>& p, const SimplexVertices<2>& s) {
    return det(p[s[1]] - p[s[0]], p[s[2]] - p[s[0]]);
}
[[nodiscard]] inline double determinant(const Column<Vec<3>>& p, const SimplexVertices<3>& s) {
    return det(p[s[1]] - p[s[0]], p[s[2]] - p[s[0]], p[s[3]] - p[s[0]]);
}

}  // namespace camber
