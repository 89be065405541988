module;
#include <cstddef>
#include <cstdint>
#include <vector>
export module camber.distributed:cut_parts;
import camber.core;
import :adaptation_rows;
import :block_weights;

export namespace camber {

/// A mesh cut into parts, and back.
template <int D>
struct CutMesh {
    std::vector<AdaptationRows<D>> parts;
    AdaptationRows<D> aside;  ///< what is of no element, which is nobody's work
};

/// Into parts that are to become about `elements` each, by their weights: runs of the elements along the Morton curve
/// of their first vertices there, in a grid that begins `shift` of the mesh's extent before it. Vertices of a part
/// follow that curve, too. Two grids whose shifts differ by thirds (2D) or fifths (3D) have no wall in common (T. M.
/// Chan, 1998), which two runs of one curve would: however far they are shifted along it, both end at the first plane
/// that halves the mesh. Facets are frozen where they are between two parts. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<CutMesh<D>> cut_into_parts(const AdaptationRows<D>& whole, const ElementWeights& weights,
                                                 std::size_t elements, double shift, const Execution& execution);

template <int D>
struct JoinedMesh {
    AdaptationRows<D> rows;
    Buffer<std::uint8_t> on_rim;  ///< of each vertex: whether several parts may have had it, or it is of no element
};

/// The whole again: vertices, elements, facets and lines of one part after the other, each in the first that has it;
/// new ids are counted on from part to part. Errors: memory.
template <int D>
[[nodiscard]] Outcome<JoinedMesh<D>> joined(const CutMesh<D>& cut);

}  // namespace camber
