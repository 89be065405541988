module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>
export module camber.curving:parts;
import camber.core;

/// What runs over a whole mesh, written for parts of it: each does what belongs to its own vertices, on a mesh with two
/// rings of elements around them, and hears of others what is theirs. A mesh by itself is one part.
export namespace camber {

/// What belongs to a part: its own vertices are [first, last), and all of which they are the lowest vertex.
struct OwnVertices {
    VertexId first, last;

    [[nodiscard]] bool owns(VertexId v) const { return v >= first && v < last; }
    template <std::size_t N>
    [[nodiscard]] bool owns(const std::array<VertexId, N>& simplex) const {
        return owns(std::ranges::min(simplex));
    }
};
template <int D>
[[nodiscard]] OwnVertices whole(const LinearMesh<D>& mesh) {
    return {VertexId(0), VertexId(mesh.points.size())};
}

/// Some edges of each part.
using EdgesOfParts = std::vector<std::vector<EdgeId>>;

/// What goes between the parts of a mesh, wherever they are.
template <int D>
class BetweenParts {
  public:
    virtual ~BetweenParts() = default;
    /// What parts here found, in their order, made what all parts found, in theirs. Errors: of any.
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
