module;
#include <array>
#include <cstddef>
#include <cstdint>
module camber.surface:tangents;
import camber.core;
import :features;
import :junctions;

namespace camber {

/// The unit tangents of curve edges at both their ends, along the edge from its lower vertex to its higher.
template <int D>
struct CurveTangents {
    Column<EdgeId> edges;  ///< rising: ridges in 3D, all facets in 2D
    Column<std::array<Vec<D>, 2>> tangents;
    Column<std::array<std::uint8_t, 2>> supports;  ///< neighbours that each tangent was fitted to; 4 for given ones

    /// The row of an edge, or size() when it is not on a curve.
    [[nodiscard]] std::size_t row(EdgeId e) const;
};

/// At each vertex of a curve the polynomial through up to four neighbours along it, as heights over the tangent (found
/// again until it stays), two a side where the curve goes on, one-sided at corners: error O(h⁴). Both edges at a vertex
/// that is no corner get the same line. Tangents of the file's notes take precedence where they agree within
/// `max_degrees`; at junctions those of the prescribed curve that the curve goes on in (see Junctions).
template <int D>
[[nodiscard]] Outcome<CurveTangents<D>> curve_tangents(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                       const Features<D>& features, const Incidence<FacetId>& shells,
                                                       const Junctions<D>& junctions, double max_degrees,
                                                       const Execution& execution);

}  // namespace camber
