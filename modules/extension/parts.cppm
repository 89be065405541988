module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <span>
#include <utility>
#include <vector>
export module camber.extension:parts;
import camber.core;

/// Algorithms on parts of a mesh. A part computes the data of the vertices that it owns. Its mesh also contains two
/// rings of elements around these vertices; it receives their data from other parts. On one process the whole mesh can
/// be one part.
export namespace camber {

/// Vertices that a part owns: the range [first, last), divided into subranges (runs). The part also owns each simplex
/// whose lowest vertex it owns. Sums are computed by run, so that they do not depend on the number of runs in a part.
struct OwnVertices {
    VertexId first, last;
    std::vector<VertexId> later_runs = {};  ///< first vertex of each later run

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

/// All simplices of a part's mesh, of which the part owns some. `vertices`: number of vertices of this mesh.
template <std::size_t N>
struct OwnSimplices {
    std::span<const std::array<VertexId, N>> all;
    std::size_t vertices = 0;
    const OwnVertices& own;
};

/// Returns one sum per run, over the simplices whose lowest vertex is in the run. accumulate(value, simplex) adds a
/// simplex, as in `reduce_each`.
template <class T, std::size_t N>
[[nodiscard]] Outcome<std::vector<T>> reduce_own(const Execution& execution, const OwnSimplices<N>& of, const T& init,
                                                 const auto& accumulate, const auto& join) {
    return guarded([&]() -> Outcome<std::vector<T>> {
        const OwnVertices& own = of.own;
        const auto& simplices = of.all;
        // `listed` contains the simplices of the first run, then of the second, and so on. A mesh that is one run needs
        // no list.
        const bool is_whole = own.runs() == 1 && own.first.index() == 0 && own.last.index() == of.vertices;
        std::vector<std::size_t> begin(own.runs() + 1, 0);
        Buffer<ElementId> listed;
        if (!is_whole) {
            const auto lowest = [&](std::size_t e) { return std::ranges::min(simplices[e]); };
            for (std::size_t e = 0; e < simplices.size(); ++e)
                if (own.owns(lowest(e))) ++begin[own.run_of(lowest(e)) + 1];
            std::partial_sum(begin.begin(), begin.end(), begin.begin());
            listed = Buffer<ElementId>(begin.back());
            std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
            for (std::size_t e = 0; e < simplices.size(); ++e)
                if (own.owns(lowest(e))) listed[next[own.run_of(lowest(e))]++] = ElementId(e);
        } else
            begin.back() = simplices.size();
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

using EdgesOfParts = std::vector<std::vector<EdgeId>>;

template <int D>
class PartCommunication {
  public:
    virtual ~PartCommunication() = default;
    /// Returns the values of all runs of the mesh, in the order of runs. `of_parts`: values of the runs of this
    /// process. Errors: an error on any process.
    [[nodiscard]] virtual Outcome<std::vector<double>> gather(Outcome<std::vector<double>> of_parts) = 0;
    [[nodiscard]] virtual std::vector<EdgeId> shared(std::size_t part, std::vector<EdgeId> edges) const = 0;
    /// Sends rows to all other parts that contain the same edges. `rows`: one array per part of this process, with one
    /// row per edge; received rows overwrite it. `edges`: for each part, the edges to send. Returns the edges that each
    /// part received, ascending. Errors: an error on any process.
    [[nodiscard]] virtual Outcome<EdgesOfParts> exchange_rows(std::span<const std::span<Vec<D>>> rows,
                                                              const EdgesOfParts& edges) = 0;

  protected:
    PartCommunication() = default;
    PartCommunication(const PartCommunication&) = default;
    PartCommunication(PartCommunication&&) = default;
    PartCommunication& operator=(const PartCommunication&) = default;
    PartCommunication& operator=(PartCommunication&&) = default;
};

template <int D>
class OnePart final : public PartCommunication<D> {
  public:
    [[nodiscard]] Outcome<std::vector<double>> gather(Outcome<std::vector<double>> of_parts) override {
        return of_parts;
    }
    [[nodiscard]] std::vector<EdgeId> shared(std::size_t, std::vector<EdgeId>) const override { return {}; }
    [[nodiscard]] Outcome<EdgesOfParts> exchange_rows(std::span<const std::span<Vec<D>>> rows,
                                                      const EdgesOfParts&) override {
        return EdgesOfParts(rows.size());
    }
};

}  // namespace camber
