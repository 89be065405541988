module;
#include <cstddef>
#include <vector>
module camber.cavity:with_faces;
import camber.core;
import :mesh;

/// What meshes that change are made of, whole or a part of one.
namespace camber {

inline constexpr const char* prepare_it = "prepare the mesh first";

/// The mesh with neighbours, edges and facets; faces may have neither a facet nor an element beyond. Lines and states
/// of vertices are still to be made. Errors: two facets or more than two elements on a face (input); stopped, memory.
template <int D>
[[nodiscard]] Outcome<DynamicMesh<D>> with_faces(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                 const Incidence<ElementId>& balls, const Execution& execution);

/// Whether the walk from face to face misses some of the `around` elements of a vertex, or of the shells of its lines.
template <int D>
[[nodiscard]] bool is_pinched(const DynamicMesh<D>& mesh, std::size_t around, VertexId v,
                              const Incidence<ElementId>& shells, std::vector<ElementId>& found);

}  // namespace camber
