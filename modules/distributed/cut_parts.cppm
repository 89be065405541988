module;
#include <cstddef>
#include <cstdint>
#include <vector>
export module camber.distributed:cut_parts;
import camber.core;
import :adaptation_rows;
import :block_weights;
import :ranks;
import :shared_rows;

export namespace camber {

/// A mesh cut into parts, of which each rank has a run.
template <int D>
struct CutMesh {
    std::vector<AdaptationRows<D>> parts;     ///< this rank's
    AdaptationRows<D> aside;                  ///< of the last rank: what is of no element, which is nobody's work
    std::vector<std::size_t> first_vertices;  ///< of the mesh that was cut (SharedRows)
};

/// Into parts that are to become about `elements` each, by their weights: runs of the elements along the Morton curve
/// of their first vertices there, in a grid that begins `shift` of the mesh's extent before it. Vertices of a part
/// follow that curve, too. Two grids whose shifts differ by thirds (2D) or fifths (3D) have no wall in common (T. M.
/// Chan, 1998), which two runs of one curve would: however far they are shifted along it, both end at the first plane
/// that halves the mesh. Facets are frozen where they are between two parts. All ranks call it, with their shares: the
/// parts, in their order over the ranks, are the same whoever has what. Errors: stopped, memory; of any rank.
template <int D>
[[nodiscard]] Outcome<CutMesh<D>> cut_into_parts(SharedRows<D> shared, const ElementWeights& weights,
                                                 std::size_t elements, double shift, Ranks& ranks,
                                                 const Execution& execution);

/// The whole again: vertices, elements, facets and lines of one part after the other, each in the first that has it,
/// and on its rank; new numbers are counted on from part to part. Errors: memory, of any rank.
template <int D>
[[nodiscard]] Outcome<SharedRows<D>> joined(CutMesh<D> cut, Ranks& ranks);

}  // namespace camber
