module;
#include <cstddef>
#include <span>
export module camber.cavity:make;
import camber.core;
import :mesh;

export namespace camber {

/// Where the boundary and interfaces break, beyond what the mesh lists: edges of kind `ridge` (3D), one a unique edge,
/// and vertices that are corners. camber.surface finds them (`find_features`); none: an empty span.
struct BreaksOfMesh {
    std::span<const EdgeKind> edge_kinds;
    std::span<const VertexId> corners;
};

/// The mesh with all that changes of it need. Lines are the edges that the mesh lists, those of kind `ridge`, and
/// those with other than two facets or with facets of two references or entities (3D); embedded are those that `breaks`
/// tells to be of another kind than `ridge`. Vertices are corners by the
/// mesh's word, by `breaks`, where an association with a point or a group of vertices names them, and where they have
/// other than two lines, or lines that differ in reference, entity or kind, or where a line of the volume meets a
/// facet; in 2D where they have other than two facets, or facets that do. What cannot be changed soundly is frozen:
/// vertices of no element, of facets or listed edges on no element, and where the mesh touches itself in a vertex or an
/// edge only. Errors: a face of the boundary, or between two references, that has no facet (camber.soundness prepares
/// meshes so that there is none), two facets or more than two elements on a face (input); `edges` or `breaks` of
/// another mesh (internal); more than 2^31 − 2 elements (unsupported); stopped, memory.
template <int D>
[[nodiscard]] Outcome<DynamicMesh<D>> make_dynamic(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                   const BreaksOfMesh& breaks, const Execution& execution);

/// The same of a mesh of degree 2, with its nodes.
template <int D>
[[nodiscard]] Outcome<DynamicMesh<D>> make_dynamic(const QuadraticMesh<D>& mesh, const BreaksOfMesh& breaks,
                                                   const Execution& execution);

/// A surface alone (triangles in space, no tetrahedra) as what bounds a mesh: each triangle is joined to a vertex at
/// infinity, the last of its element, so that operations on surfaces, ridges and corners are those of any mesh (as
/// with the infinite vertex of CGAL's triangulations). Elements stand for their triangles; where the surface ends, the
/// faces between its edges and infinity are facets of a reference of their own; `compacted` leaves all of that out.
/// Lines are also the edges where the surface ends, or more than two triangles meet: these stay as they are. Errors: as
/// of make_dynamic; a mesh that is no surface alone (internal).
[[nodiscard]] Outcome<DynamicMesh<3>> make_dynamic_surface(const LinearMesh<3>& mesh, const EdgeSet<3>& edges,
                                                           const BreaksOfMesh& breaks, const Execution& execution);

}  // namespace camber

namespace camber {

/// The same, with vertices that are at infinity.
template <int D>
[[nodiscard]] Outcome<DynamicMesh<D>> make_dynamic_with(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                        const BreaksOfMesh& breaks,
                                                        std::span<const VertexId> at_infinity,
                                                        const Execution& execution);

}  // namespace camber
