module;
#include <cstddef>
#include <cstdint>
#include <vector>
export module camber.cavity:star;
import camber.core;
import camber.validity;
import camber.programmes;
import camber.repair;

export namespace camber {

/// The entities around each vertex that a cavity may hold.
template <int D>
struct CavityTopology {
    Incidence<ElementId> balls;
    Incidence<FacetId> facet_balls;
    Incidence<EdgeId> ridge_balls;  ///< of the feature edges, by their index in LinearMesh::edges (3D)
    Incidence<ElementId> shells;    ///< elements around each unique edge
};

/// Errors: those of `balls` and `shells`; stopped.
template <int D>
[[nodiscard]] Outcome<CavityTopology<D>> cavity_topology(const QuadraticMesh<D>& mesh, const Execution& execution);

/// What the cavity operator takes (paper §1.3): entities of the mesh to be removed, and the vertex that is joined to
/// what is left around them.
template <int D>
struct Cavity {
    VertexId point;
    std::vector<ElementId> elements;
    std::vector<FacetId> facets;
    std::vector<EdgeId> ridges;  ///< indices in LinearMesh::edges
};

/// The cavity of a reinsertion (paper §1.3): all that touches the vertex.
template <int D>
[[nodiscard]] Cavity<D> vertex_ball(const CavityTopology<D>& topology, VertexId vertex);

/// A face of a removed simplex, by the local vertex opposite.
struct OpenFace {
    std::uint32_t simplex = 0;
    std::uint32_t opposite = 0;
    friend bool operator==(const OpenFace&, const OpenFace&) = default;
};

/// The boundary of an emptied cavity: the faces of its elements that no two of them share; the same of its facets and
/// of its ridges, reference by reference, so that surfaces and curves that meet inside a cavity stay apart.
template <int D>
struct CavityBoundary {
    std::vector<OpenFace> of_elements, of_facets, of_ridges;
};

/// Takes the cavity out of the mesh (paper §1.3): what is left open around it. Nothing of the mesh is changed.
template <int D>
[[nodiscard]] CavityBoundary<D> empty(const LinearMesh<D>& mesh, const Cavity<D>& cavity);

/// The new entities of a cavity, a small mesh of its own.
template <int D>
struct StarMesh {
    LinearMesh<D> mesh;
    std::vector<VertexId> vertices;   ///< of the mesh that the cavity is in, rising: those of `mesh`, in its order
    std::vector<ElementId> replaces;  ///< the removed element that each new one has its outer face from
    VertexId point;                   ///< the cavity's point in `mesh`
};

/// Joins every open face to the point: ridges, then facets, then elements (paper §1.3). A face that holds the point
/// already is its own boundary and gives nothing. Each new simplex keeps the orientation, the reference, and, at the
/// outer face, the place of the vertices of the one that it replaces. Nothing is said about validity: on P2 meshes only
/// the Jacobian decides (paper §3.2).
template <int D>
[[nodiscard]] StarMesh<D> star(const LinearMesh<D>& mesh, const Cavity<D>& cavity, const CavityBoundary<D>& boundary);

}  // namespace camber
