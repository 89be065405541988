module;
#include <cstddef>
#include <cstdint>
export module camber.partition:parts;
import camber.core;
import :graph;

namespace camber {

/// By the library that is there. Errors: unsupported (there is none), memory, internal.
[[nodiscard]] Outcome<Buffer<std::int32_t>> parts_of_graph(const DualGraph& graph, std::size_t parts);

}  // namespace camber

export namespace camber {

/// The part of each cell, from 0.
struct CellParts {
    Column<std::int32_t> elements, facets, edges;
};

/// Parts of about as many elements each, by Scotch: the same for any number of threads. A facet, and a feature edge, is
/// of the part of the lowest element that it belongs to (of part 0 if of none). The elements of a surface alone are its
/// facets. Errors: usage (no parts, or more than
/// elements), unsupported (Camber was built without Scotch), memory, stopped.
template <int D>
[[nodiscard]] Outcome<CellParts> partition(const LinearMesh<D>& mesh, std::size_t parts, const Execution& execution);

/// The same of facets and edges where the parts of the elements (of a surface alone of its facets) are known.
template <int D>
[[nodiscard]] Outcome<CellParts> parts_of_cells(const LinearMesh<D>& mesh, Column<std::int32_t> elements,
                                                const Execution& execution);

}  // namespace camber
