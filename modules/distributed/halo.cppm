module;
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>
export module camber.distributed:halo;
import camber.core;
import camber.curving;
import :ringed_parts;
import :ranks;

export namespace camber {

/// Which rows of parts others have in their rings: a star forest, each owner's row its root.
struct Halo {
    struct Row {
        std::uint32_t part = 0;  ///< of this rank's, from 0
        std::uint32_t row = 0;
    };
    std::vector<Buffer<Row>> give;  ///< to each rank, in the order in which it has them in `get`
    std::vector<Buffer<Row>> get;   ///< from each rank
};

/// Of vertices. Errors: of any rank.
template <int D>
[[nodiscard]] Outcome<Halo> vertex_halo(const RingedParts<D>& parts, Ranks& ranks);

/// Of unique edges, of which each part has its own set.
template <int D>
[[nodiscard]] Outcome<Halo> edge_halo(const RingedParts<D>& parts, std::span<const EdgeSet<D>> edges, Ranks& ranks);

/// Rows of owners brought into the rings of others; `columns`: one row a vertex, or an edge, of each part here.
/// Errors: of any rank.
template <class T>
    requires std::is_trivially_copyable_v<T>
[[nodiscard]] Outcome<Done> bring_all(const Halo& halo, Ranks& ranks, std::span<const std::span<T>> columns) {
    std::vector<Bytes> to(ranks.size());
    for (std::size_t r = 0; r < to.size(); ++r) {
        if (r == ranks.rank()) continue;
        Buffer<T> rows(halo.give[r].size());
        for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = columns[halo.give[r][i].part][halo.give[r][i].row];
        to[r] = bytes_of<T>({rows.data(), rows.size()});
    }
    const auto from = ranks.exchange(std::move(to));
    if (!from) return fail(from.error());
    for (std::size_t r = 0; r < ranks.size(); ++r) {
        std::vector<T> rows;
        if (r != ranks.rank()) append_values((*from)[r], rows);
        for (std::size_t i = 0; i < halo.get[r].size(); ++i) {
            const Halo::Row& into = halo.get[r][i];
            if (r != ranks.rank())
                columns[into.part][into.row] = rows[i];
            else
                columns[into.part][into.row] = columns[halo.give[r][i].part][halo.give[r][i].row];
        }
    }
    return Done{};
}

/// The parts of a mesh that this rank has, and those that others have.
template <int D>
class BetweenRingedParts final : public BetweenParts<D> {
  public:
    /// Both must outlive it. The parts here are so many parts.
    BetweenRingedParts(Ranks& ranks, const Halo& halo, std::size_t parts);

    [[nodiscard]] Outcome<std::vector<double>> gather(Outcome<std::vector<double>> of_parts) override;
    [[nodiscard]] std::vector<EdgeId> shared(std::size_t part, std::vector<EdgeId> edges) const override;
    [[nodiscard]] Outcome<EdgesOfParts> bring(std::span<const std::span<Vec<D>>> rows,
                                              const EdgesOfParts& edges) override;

  private:
    /// A row that a rank gets: as the at-th of its `get`.
    struct Given {
        std::uint32_t row = 0, rank = 0, at = 0;
    };
    Ranks& ranks_;
    const Halo& halo_;
    std::vector<Buffer<Given>> given_;  ///< of each part, by rising rows
};

}  // namespace camber
