module;
#include <array>
#include <cstdint>
module camber.surface:junctions;
import camber.core;
import :fans;
import :features;
import :geometry;

namespace camber {

/// Where facets whose surface another geometry prescribes (a CAD model, analytic surfaces) end and the surrogate
/// begins: what that geometry tells of the vertices that both share. Whether the boundary is smooth there, the mesh
/// decides: it is if the prescribed direction is near that which is fitted to the mesh, by `junction_share` of the
/// turns around (Beyond, and curve_tangents along curves). So a crease stays one, but for less than about a quarter of
/// these.
template <int D>
struct Junctions {
    Column<std::uint8_t> prescribed;  ///< one a facet; none at all where nothing is prescribed
    Column<FacetId> facets;           ///< rising: the prescribed ones with a vertex that others have too
    /// The surface's unit normals at their vertices. Zero where no others are, or where the file says that the boundary
    /// breaks: at ends of its ridges between both (2D: at its corners).
    Column<std::array<Vec<D>, D>> normals;

    [[nodiscard]] bool is_prescribed(FacetId f) const { return !prescribed.empty() && prescribed[f] != 0; }
    /// The normal of a facet's surface at a vertex of it, or the zero vector.
    [[nodiscard]] Vec<D> normal(const LinearMesh<D>& mesh, FacetId f, VertexId v) const;
};

inline constexpr double junction_share = 0.25;

/// Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Junctions<D>> find_junctions(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                   const Incidence<FacetId>& shells, const GeometryModel<D>& prescribed,
                                                   const Execution& execution);

/// What is prescribed beyond the edges of a fan at its vertex.
struct Beyond {
    FacetId facet;         ///< whose surface it is; invalid: there is none
    Vec<3> normal;         ///< of that surface at the vertex; of several surfaces the nearest to what was fitted
    double tolerance = 0;  ///< by how much (radians) what is fitted may be off it where the boundary is smooth
};
[[nodiscard]] Beyond beyond_fan(const Junctions<3>& junctions, const LinearMesh<3>& mesh, const EdgeSet<3>& edges,
                                const Features<3>& features, const Incidence<FacetId>& shells, const Fans& fans,
                                std::uint32_t fan, const Vec<3>& fitted);

}  // namespace camber
