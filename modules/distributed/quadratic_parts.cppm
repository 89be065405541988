module;
#include <cstddef>
#include <span>
#include <vector>
export module camber.distributed:quadratic_parts;
import camber.core;
import camber.io;
import :ringed_parts;
import :curve_blocks;
import :halo;
import :ranks;
import :rows;

export namespace camber {

/// A curved mesh in blocks as the rows of its file, as they are in that of the straight one: each rank has a run of
/// each kind, and makes it in pieces, so that little is held at a time. All is asked for by all
/// ranks, in the same turn.
template <int D>
class QuadraticParts {
  public:
    /// All must outlive it. Errors: of any rank.
    [[nodiscard]] static Outcome<QuadraticParts> make(const MeshRows<D>& rows, const CurvedBlocks<D>& mesh,
                                                      Ranks& ranks);

    [[nodiscard]] PartTotals totals() const;
    [[nodiscard]] std::size_t pieces() const { return pieces_; }  ///< as many on each rank
    /// Errors: those of the rows, of any rank.
    [[nodiscard]] Outcome<FilePart<D, 2>> piece(std::size_t piece) const;

  private:
    QuadraticParts(const MeshRows<D>& rows, const CurvedBlocks<D>& mesh, Ranks& ranks)
        : rows_(&rows), mesh_(&mesh), ranks_(&ranks) {}

    /// The nodes of simplices of the file, from the parts that own them: number(part, row) → numbers of its edges.
    template <int K>
    [[nodiscard]] Outcome<SimplexRun<K, 2>> simplices(std::size_t begin, SimplexRows<K> given) const;

    const MeshRows<D>* rows_;
    const CurvedBlocks<D>* mesh_;
    Ranks* ranks_;
    std::size_t pieces_ = 1, pieces_of_part_ = 1;
    std::vector<Buffer<GlobalNumber>> edge_numbers_;  ///< of each part here, one an edge
};

/// The whole of a mesh that one rank has, in the order of its rows; `linear`: the straight one. Errors: memory,
/// stopped.
template <int D>
[[nodiscard]] Outcome<QuadraticMesh<D>> joined(const CurvedBlocks<D>& of, LinearMesh<D> linear,
                                               const Execution& execution);

}  // namespace camber
