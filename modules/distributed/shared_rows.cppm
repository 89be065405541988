module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>
export module camber.distributed:shared_rows;
import camber.core;
import :adaptation_rows;
import :ranks;

export namespace camber {

/// A mesh that is brought to a metric between two turns, shared among ranks. Each element, facet and line is on one of
/// them; what follows in its order goes over the ranks one after the other, as do the numbers of vertices.
template <int D>
struct SharedRows {
    AdaptationRows<D> rows;                   ///< vertices: this rank's in their order, then others that simplices name
    Buffer<std::uint8_t> on_rim;              ///< of each vertex: whether other ranks may name it
    std::vector<std::size_t> first_vertices;  ///< the first number of each rank's vertices; then how many there are
    AdaptationRows<D>
        aside;  ///< of the last rank: what is of no element, which stays; without number: of the rest none

    [[nodiscard]] std::size_t vertices() const { return first_vertices.back(); }
    [[nodiscard]] std::size_t own_vertices(const Ranks& ranks) const {
        return first_vertices[ranks.rank() + 1] - first_vertices[ranks.rank()];
    }
};

/// Which rank has a number, of those of which each begins with one of `firsts`; the last of these is the end.
[[nodiscard]] inline std::size_t rank_with(const std::vector<std::size_t>& firsts, std::size_t number) {
    return static_cast<std::size_t>(std::ranges::upper_bound(firsts, number) - firsts.begin()) - 1;
}

/// This rank's share of a mesh that all have as a whole: runs of its rows. Errors: memory.
template <int D>
[[nodiscard]] Outcome<SharedRows<D>> share_of(const AdaptationRows<D>& whole, const Ranks& ranks);

/// What is this rank's alone, simplices by the numbers of their vertices; of the last rank what is of no element, too.
template <int D>
[[nodiscard]] AdaptationRows<D> numbered_rows(SharedRows<D> shared, const Ranks& ranks);

/// The whole mesh on all ranks. Errors: of any rank.
template <int D>
[[nodiscard]] Outcome<AdaptationRows<D>> gathered(SharedRows<D> shared, Ranks& ranks);

/// A number of each rank added up, and where this rank's begins if they are counted on from rank to rank. Errors: of
/// any rank.
struct Counted {
    std::size_t all = 0, before = 0;
};
[[nodiscard]] Outcome<Counted> counted(Ranks& ranks, std::size_t own);

}  // namespace camber
