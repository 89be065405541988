module;
#include <cstddef>
#include <functional>
#include <span>
#include <utility>
export module camber.shapes:boundary;
import camber.core;

export namespace camber {

/// The reference of a boundary facet, from its vertices.
template <int D>
using FacetReference = std::function<Reference(const SimplexVertices<D - 1>&)>;

/// Whether a vertex may have facets: true at all that have, asked from any thread. Where it is false nothing is looked
/// for, which makes large meshes fast. None: nothing is known.
using MayHaveFacets = std::function<bool(VertexId)>;

/// A whole mesh from its points and elements: facets on the boundary, outwards oriented, and between elements of
/// different materials, out of the one of lower number; vertices with the least reference of their facets, inner ones
/// with 0; where references meet, corners (2D) or ridges and corners (3D: where ridges end or more than two meet).
/// Errors: an element without positive volume (usage: the sizes do not fit together); stopped.
template <int D>
[[nodiscard]] Outcome<LinearMesh<D>> bounded_mesh(Buffer<Vec<D>> points, Buffer<SimplexVertices<D>> elements,
                                                  Buffer<Reference> materials, const FacetReference<D>& facet_reference,
                                                  const MayHaveFacets& may_have_facets = {},
                                                  const Execution& execution = {});

/// The same of one material: reference 1.
template <int D>
[[nodiscard]] Outcome<LinearMesh<D>> bounded_mesh(Buffer<Vec<D>> points, Buffer<SimplexVertices<D>> elements,
                                                  const FacetReference<D>& facet_reference,
                                                  const MayHaveFacets& may_have_facets = {},
                                                  const Execution& execution = {}) {
    Buffer<Reference> materials(elements.size(), Reference{1});
    return bounded_mesh<D>(std::move(points), std::move(elements), std::move(materials), facet_reference,
                           may_have_facets, execution);
}

/// The error of the element of that number.
template <int D>
[[nodiscard]] auto no_positive_volume(std::size_t element) {
    return fail(ErrorKind::usage, "the generator made an element without positive volume", {},
                Entity{simplex_name<D>, element + 1}, "the sizes do not fit together");
}

/// D! times the volume (area in 2D) of an element.
[[nodiscard]] inline double determinant(const Column<Vec<2>>& p, const SimplexVertices<2>& s) {
    return det(p[s[1]] - p[s[0]], p[s[2]] - p[s[0]]);
}
[[nodiscard]] inline double determinant(const Column<Vec<3>>& p, const SimplexVertices<3>& s) {
    return det(p[s[1]] - p[s[0]], p[s[2]] - p[s[0]], p[s[3]] - p[s[0]]);
}

}  // namespace camber
