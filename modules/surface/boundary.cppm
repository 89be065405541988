module;
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
export module camber.surface:boundary;
import camber.core;
import camber.bezier;
import :features;
import :geometry;

export namespace camber {

/// The mid node of an edge of the boundary: where the geometry has the edge's middle. Where the ends are off the
/// geometry by more than `off_limit` of the chord (on the average, as vectors), the edge would have cusps at its ends:
/// the node is then within that limit of the curve parallel to the geometry through the ends, and within a quarter of
/// the chord from its middle, so that the edge turns by at most 90 degrees. An edge never leaves an end backwards.
template <int D>
[[nodiscard]] Vec<D> node_without_cusp(const GeometryModel<D>& geometry, const EdgeSite<D>& edge);

/// New mid nodes of all edges: those of boundary edges on the geometry, those of volume edges as they are.
///
/// Surrogate: the middle of the edge's own curve where the surrogate was made from this mesh, else the chord's middle
/// projected (ridges: onto the ridge curves). Analytic: the chord's middle projected onto the surface of the edge's
/// facets, or onto the curve where two surfaces meet; a facet without a surface counts as a part of its own plane
/// beside a curved one. Mixed: each edge as its facets' references say; where a surface meets a flat patch of the
/// surrogate, onto the curve of both, and where it meets a curved one, the node of the surrogate's ridge projected onto
/// the surface. Straight: chord middles. Edges of flat patches and ridges between two planes keep the chord's
/// middle to the last bit; edges that are required or belong to required facets or elements keep the mesh's node, which
/// is that middle where the mesh was elevated. Errors: `features` is not of this mesh (ErrorKind::internal), stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> boundary_nodes(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                              const Geometry<D>& geometry, const Execution& execution);

/// 1 for surface edges within planes (of the geometry, or flat patches of a surrogate), whose nodes may slide there at
/// no cost to the geometry. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<std::uint8_t>> edges_in_planes(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                            const Geometry<D>& geometry, const Execution& execution);

/// The same nodes with those of edges within planes moved by the part of `shifts` (one row an edge) that lies in the
/// plane. Others keep theirs: on a curved surface a node off the middle of its curve costs the geometry an order of
/// approximation, and curves (ridges; in 2D all edges of the boundary) leave only slides along themselves; so do
/// required edges. Errors: as boundary_nodes; rows that do not fit the mesh (ErrorKind::internal).
template <int D>
[[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> slid_nodes(const QuadraticMesh<D>& mesh,
                                                          const Column<LagrangeNode<D>>& nodes,
                                                          std::span<const Vec<D>> shifts, const Features<D>& features,
                                                          const Geometry<D>& geometry, const Execution& execution);

/// How far the curved boundary is from the geometry, in model units. `mean` is weighted by the straight facets' areas.
struct BoundaryDistance {
    double largest = 0, mean = 0;
    FacetId worst = {};
};

/// Each curved facet is sampled on the lattice of tenths (66 points; 11 in 2D) and projected. Facets that lie in a flat
/// patch of the surrogate count 0 within that plane's tolerance. In a mixed geometry the reference tells whether it is
/// the surface or the surrogate. Without either (straight geometry, or a reference that has none) the distance is that
/// to the facet's own plane. Errors: as boundary_nodes.
template <int D>
[[nodiscard]] Outcome<BoundaryDistance> boundary_distance(const QuadraticMesh<D>& mesh,
                                                          std::span<const LagrangeNode<D>> mid_nodes,
                                                          const Features<D>& features, const Geometry<D>& geometry,
                                                          const Execution& execution);

/// Largest distances from the geometry at which boundary nodes and vertices count as being on it, as shares of the
/// local boundary edge length.
struct BoundaryTolerance {
    double nodes = 1e-5;     ///< of a mid node, by the chord of its edge
    double vertices = 0.05;  ///< of a vertex, by the longest boundary edge at it: input meshes are not exact

    [[nodiscard]] static constexpr auto options() {
        using S = BoundaryTolerance;
        return std::tuple(
            option("nodes", &S::nodes, "largest distance of the node of a boundary edge from its geometry")
                .unit("shares of the edge's length")
                .at_least(0),
            option("vertices", &S::vertices, "largest distance of a boundary vertex from its geometry")
                .unit("shares of the longest boundary edge at the vertex")
                .at_least(0));
    }
    friend bool operator==(const BoundaryTolerance&, const BoundaryTolerance&) = default;
};

/// Boundary entities of one kind that are off the geometry.
template <class Id>
struct OffGeometry {
    std::size_t measured = 0;  ///< number of entities that have a geometry
    std::size_t off = 0;       ///< number of those farther from it than the tolerance
    double largest = 0;        ///< largest distance (model units)
    double share = 0;          ///< largest distance as a share of the local edge length
    Id worst = {};             ///< entity with the largest share; invalid: all shares are 0
};

/// Distances of the boundary's nodes and vertices from the geometry, counted against a tolerance.
struct BoundaryDeviation {
    OffGeometry<EdgeId> nodes;
    OffGeometry<VertexId> vertices;
};

/// Measures the distance of each boundary node and vertex of a mesh from its geometry. Distances within the rounding of
/// the coordinates do not count as off.
///
/// `kinds`: one an edge; nodes of kind `surface` and `ridge` are measured. Those of kind `fixed` and required vertices
/// stay by request and are not.
/// `own_nodes`: one an edge where the input mesh was curved, else empty; the input's node is then the geometry of each
/// edge for which `geometry` prescribes no surface. Errors: rows that do not fit the mesh (ErrorKind::internal),
/// stopped.
template <int D>
[[nodiscard]] Outcome<BoundaryDeviation> boundary_deviation(
    const QuadraticMesh<D>& mesh, std::span<const EdgeKind> kinds, const Geometry<D>& geometry,
    std::span<const LagrangeNode<D>> own_nodes, const BoundaryTolerance& tolerance, const Execution& execution);

/// The largest distance of boundary_distance alone. Points that are known to be nearer than another one are not
/// projected, and a facet is left out if 21 points of it (2D: 6) are all within 0.8 of the largest distance of another:
/// where the distance is as smooth as between a facet and its surface, the result is the same up to rounding.
/// Errors: as boundary_nodes.
template <int D>
[[nodiscard]] Outcome<LargestDistance> largest_boundary_distance(const QuadraticMesh<D>& mesh,
                                                                 std::span<const LagrangeNode<D>> mid_nodes,
                                                                 const Features<D>& features,
                                                                 const Geometry<D>& geometry,
                                                                 const Execution& execution);

/// Other nodes of the same mesh, whose largest distance from the geometry is known.
template <int D>
struct NearBoundary {
    const QuadraticMesh<D>& mesh;
    std::span<const LagrangeNode<D>> mid_nodes;
    double largest = 0;
};

/// The same largest distance, by the nodes of a boundary that is near the geometry: a facet whose nodes are not far
/// from those is left out. Errors: as boundary_nodes.
template <int D>
[[nodiscard]] Outcome<LargestDistance> largest_boundary_distance(
    const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> mid_nodes, const Features<D>& features,
    const Geometry<D>& geometry, const NearBoundary<D>& near, const Execution& execution);

}  // namespace camber
