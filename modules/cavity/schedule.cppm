module;
#include <cstdint>
#include <span>
export module camber.cavity:schedule;
import camber.core;
import camber.validity;

export namespace camber {

/// The vertices among `pending` whose balls overlap no ball of another pending one that comes before it: by the hash of
/// its number, which does not depend on threads (after Luby). In the order of `pending`. `is_pending` has one byte a
/// vertex of the mesh, 1 for those of `pending`. Never empty when `pending` is not.
template <int D>
[[nodiscard]] Outcome<Buffer<VertexId>> independent_vertices(const LinearMesh<D>& mesh,
                                                             const Incidence<ElementId>& balls,
                                                             std::span<const VertexId> pending,
                                                             std::span<const std::uint8_t> is_pending,
                                                             const Execution& execution);

}  // namespace camber
