module;
#include <array>
#include <optional>
export module camber.surface:seams;
import camber.core;
import :geometry;
import :geometry_places;

export namespace camber {

/// Where the corners of a facet lie on its surface, all on one side of the surface's seams: the coordinates of one
/// vertex may differ by a period from facet to facet. A corner at a pole, where a coordinate says nothing, has the mean
/// of the others' there. On a surface of pieces each corner is in a piece of its own. Nothing where the facet has no
/// surface, or one without parameters.
template <int D>
[[nodiscard]] std::optional<std::array<GeometryParameters, D>> parameters_at_corners(const Geometry<D>& geometry,
                                                                                     const FacetSite<D>& facet);

}  // namespace camber
