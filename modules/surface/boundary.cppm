module;
#include <cstdint>
#include <span>
export module camber.surface:boundary;
import camber.core;
import camber.bezier;
import :features;
import :geometry;

export namespace camber {

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

}  // namespace camber
