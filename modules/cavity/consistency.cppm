module;
#include <cstddef>
export module camber.cavity:consistency;
import camber.core;
import :mesh;

export namespace camber {

/// Whether all that a DynamicMesh says of itself agrees: simplices name vertices that are there; what is across a face
/// shares it and says the same of this side; edges are those between the elements' vertices, one id a pair; every face
/// between two references or of the boundary is a facet; lines are edges; free lists are the free places. The cost is
/// that of the whole mesh. Errors (internal): the first that does not, with its entity; stopped, memory.
template <int D>
[[nodiscard]] Outcome<Done> check_consistency(const DynamicMesh<D>& mesh, const Execution& execution);

}  // namespace camber
