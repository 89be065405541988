module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <span>
#include <utility>
#include <vector>
export module camber.curving:parts;
import camber.core;

/// What runs over a whole mesh, written for parts of it: each does what belongs to its own vertices, on a mesh with two
/// rings of elements around them, and hears of others what is theirs. A mesh by itself is one part.
export namespace camber {

/// What belongs to a part: its own vertices are [first, last), and all of which they are the lowest vertex. Over some
/// runs of them sums are taken by themselves, so that these are the same however many runs are in a part.
struct OwnVertices {
    VertexId first, last;
    std::vector<VertexId> later_runs = {};  ///< where all runs but the first begin

    [[nodiscard]] bool owns(VertexId v) const { return v >= first && v < last; }
    template <std::size_t N>
    [[nodiscard]] bool owns(const std::array<VertexId, N>& simplex) const {
        return owns(std::ranges::min(simplex));
    }
    [[nodiscard]] std::size_t runs() const { return later_runs.size() + 1; }
    [[nodiscard]] std::size_t run_of(VertexId v) const {
        return static_cast<std::size_t>(std::ranges::upper_bound(later_runs, v) - later_runs.begin());
    }
};
template <int D>
[[nodiscard]] OwnVertices whole(const LinearMesh<D>& mesh) {
    return {VertexId(0), VertexId(mesh.points.size())};
}

/// A sum over the elements of each run, as `reduce_each`: accumulate(value, element).
template <class T, int D>
[[nodiscard]] Outcome<std::vector<T>> reduce_own(const Execution& execution, const LinearMesh<D>& mesh,
                                                 const OwnVertices& own, const T& init, const auto& accumulate,
                                                 const auto& join) {
    return guarded([&]() -> Outcome<std::vector<T>> {
        // Chunks are those of a run's elements, which a mesh by itself need not list.
        const bool is_whole = own.runs() == 1 && own.first.index() == 0 && own.last.index() == mesh.points.size();
        std::vector<std::size_t> begin(own.runs() + 1, 0);
        Buffer<ElementId> listed;
        if (!is_whole) {
            const auto lowest = [&](std::size_t e) { return std::ranges::min(mesh.elements.vertices[e]); };
            for (std::size_t e = 0; e < mesh.elements.size(); ++e)
                if (own.owns(lowest(e))) ++begin[own.run_of(lowest(e)) + 1];
            std::partial_sum(begin.begin(), begin.end(), begin.begin());
            listed = Buffer<ElementId>(begin.back());
            std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
            for (std::size_t e = 0; e < mesh.elements.size(); ++e)
                if (own.owns(lowest(e))) listed[next[own.run_of(lowest(e))]++] = ElementId(e);
        } else
            begin.back() = mesh.elements.size();
        std::vector<T> sums;
        for (std::size_t r = 0; r < own.runs(); ++r) {
            auto sum = reduce_each(
                execution, begin[r + 1] - begin[r], init,
                [&](T& value, std::size_t i) { accumulate(value, is_whole ? ElementId(i) : listed[begin[r] + i]); },
                join);
            if (!sum) return fail(sum.error());
            sums.push_back(std::move(*sum));
        }
        return sums;
    });
}

/// Some edges of each part.
using EdgesOfParts = std::vector<std::vector<EdgeId>>;

/// What goes between the parts of a mesh, wherever they are.
template <int D>
class BetweenParts {
  public:
    virtual ~BetweenParts() = default;
    /// What parts here found of each of their runs, in their order, made what all found, in theirs. Errors: of any.
    [[nodiscard]] virtual Outcome<std::vector<double>> gather(Outcome<std::vector<double>> of_parts) = 0;
    /// Of a part's own edges those that other parts have too.
    [[nodiscard]] virtual std::vector<EdgeId> shared(std::size_t part, std::vector<EdgeId> edges) const = 0;
    /// `rows` has a row an edge for each part here: brings those of these edges, which are `shared`, to all other parts
    /// that have them. The edges that were brought to each part here, rising. Errors: of any.
    [[nodiscard]] virtual Outcome<EdgesOfParts> bring(std::span<const std::span<Vec<D>>> rows,
                                                      const EdgesOfParts& edges) = 0;

  protected:
    BetweenParts() = default;
    BetweenParts(const BetweenParts&) = default;
    BetweenParts(BetweenParts&&) = default;
    BetweenParts& operator=(const BetweenParts&) = default;
    BetweenParts& operator=(BetweenParts&&) = default;
};

/// Of a mesh by itself.
template <int D>
class OnePart final : public BetweenParts<D> {
  public:
    [[nodiscard]] Outcome<std::vector<double>> gather(Outcome<std::vector<double>> of_parts) override {
        return of_parts;
    }
    [[nodiscard]] std::vector<EdgeId> shared(std::size_t, std::vector<EdgeId>) const override { return {}; }
    [[nodiscard]] Outcome<EdgesOfParts> bring(std::span<const std::span<Vec<D>>> rows, const EdgesOfParts&) override {
        return EdgesOfParts(rows.size());
    }
};

}  // namespace camber
