module;
#include <vector>
module camber.repair:local_extension;
import camber.core;
import camber.bezier;
import camber.validity;
import :moved_mesh;

namespace camber {

/// Nodes of edges, and the work that it took to find them, in the units of `RepairOptions::effort`.
template <int D>
struct LocalExtension {
    SparseMap<EdgeId, LagrangeNode<D>> nodes;
    double work = 0;
};

/// The boundary's displacement extended (`extend_boundary`) around some elements alone: nodes of the volume edges of
/// the `seeds` and of so many rings of elements around them, while all nodes around these are given where they are.
/// Its cost goes with these elements. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<LocalExtension<D>> extend_around(const MovedMesh<D>& moved, const Column<EdgeKind>& kinds,
                                                       const Incidence<ElementId>& shells,
                                                       const std::vector<ElementId>& seeds, int rings,
                                                       const Execution& execution);

}  // namespace camber
