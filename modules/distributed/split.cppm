export module camber.distributed:split;
import camber.core;
import :ringed_parts;
import :ranks;
import :rows;

export namespace camber {

/// A mesh cut into blocks, runs of its vertices with about as many elements as the options say, where a vertex has a
/// share of each around it; they depend on the mesh and on that number alone. Each rank reads its share of the rows and
/// gets a run of blocks, in parts with two rings of elements around each. Vertices are numbered as in the rows, which
/// are to be in an order in which what is near is near (camber.ordering). What elements, facets and edges the mesh
/// lists as required comes along, and its names of references; what it says of its geometry does not. Errors: those of
/// the rows, memory, stopped; of any rank.
template <int D>
[[nodiscard]] Outcome<RingedParts<D>> split(const MeshRows<D>& rows, const BlockOptions& options, Ranks& ranks,
                                            const Execution& execution);

}  // namespace camber
