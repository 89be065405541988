module;
#include <cstddef>
export module camber.cavity:compact;
import camber.core;
import :mesh;

export namespace camber {

/// A mesh without free places, and where its entities went from those of the mesh that changes.
template <int D>
struct CompactMesh {
    LinearMesh<D> mesh;
    EdgeSet<D> edges;
    Column<LagrangeNode<D>> nodes;  ///< one an edge; no rows: a straight mesh
    MeshMaps maps;
};

/// The mesh as it is: entities keep their order. Lines are edges of the mesh but for those that it did not list when it
/// was made. Directions and associations are those of vertices that have not gone or moved; one that has moved keeps
/// that with the surface (2D: the curve) that it is on, without its place there. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<CompactMesh<D>> compacted(const DynamicMesh<D>& mesh, const Execution& execution);

}  // namespace camber
