module camber.distributed:kept_part;
import camber.core;
import :ringed_parts;
import :row_runs;
import :rows;
import :simplex_row;

namespace camber {

/// What a part is made of: rows of the file.
template <int D>
struct PartRows {
    Buffer<SimplexRow<D>> elements;
    Buffer<SimplexRow<D - 1>> facets;
    Buffer<SimplexRow<1>> edges;
};

/// A part of rows in any order, some of them twice: all but the points of others. Errors: those of the rows, stopped.
template <int D>
[[nodiscard]] Outcome<RingedPart<D>> kept_part(PartRows<D> of, Run own, const MeshRows<D>& rows,
                                               const LinearMesh<D>& lists, const PartMemory& memory,
                                               const Execution& execution);

}  // namespace camber
