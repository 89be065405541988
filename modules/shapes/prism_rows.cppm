module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.shapes:prism_rows;
import camber.core;
import :extrude;
import :jitter;
import :random;
import :shape_rows;

namespace camber {

/// A row of prisms between two levels, each a copy of the base's vertices.
struct PrismRow {
    std::size_t bottom = 0, top = 0;  ///< levels
    Noise noise;                      ///< of its cuts
    std::size_t drawn_for = 0;        ///< of the base's vertex v it is drawn for v and this
    Reference material = 1;
};

/// Levels [first, last).
struct Levels {
    std::size_t first = 0, last = 0;
};

/// A base of simplices of dimension D − 1 with `count` vertices.
template <int D>
struct PrismBase {
    Buffer<SimplexVertices<D - 1>> simplices;
    std::size_t count = 0;
};

/// The elements of a row, by the numbers of the vertices in the whole, less `less`. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<Done> cut_row(const PrismBase<D>& base, const PrismRow& row, std::size_t less,
                                    std::span<SimplexVertices<D>> elements, const Execution& execution) {
    auto ranks = map_each(execution, base.count, [&](std::size_t v) { return row.noise.bits(row.drawn_for + v); });
    if (!ranks) return fail(ranks.error());
    const std::size_t bottom = row.bottom * base.count - less, top = row.top * base.count - less;
    return extrude<D>(
        base.simplices, *ranks, [&](VertexId v) { return VertexId(bottom + v.index()); },
        [&](VertexId v) { return VertexId(top + v.index()); }, elements, execution);
}

/// Levels that follow each other, whose vertices move at random: from `first` on, the rows between them one on the
/// other.
template <int D>
struct MovedLevels {
    std::size_t first = 0;
    Buffer<Vec<D>> points;
};

/// Of levels whose rows are rows[k] from level k to k + 1: where `move_points` puts the vertices of `wanted`, from
/// their places on so many levels around them: made(levels) → MovedLevels of those before the move, moved(v, point).
template <int D, class Made, class MovedTo>
[[nodiscard]] Outcome<MovedLevels<D>> moved_levels(const PrismBase<D>& base, std::span<const PrismRow> rows,
                                                   Levels wanted, double least, const Made& made, const MovedTo& moved,
                                                   const Execution& execution) {
    const Levels around{wanted.first - std::min<std::size_t>(wanted.first, rings_of_move),
                        std::min(wanted.last + rings_of_move, rows.size() + 1)};
    Outcome<MovedLevels<D>> levels = made(around);
    if (!levels) return levels;
    const std::size_t first = around.first * base.count;
    Buffer<SimplexVertices<D>> elements(D * base.simplices.size());
    const auto has_moved = [&](std::span<const std::uint8_t> just_moved, std::size_t row) {
        const auto of_row = just_moved.subspan(rows[row].bottom * base.count - first, 2 * base.count);
        return std::ranges::find(of_row, 1) != of_row.end();
    };
    const ElementRuns<D> row_by_row = [&](std::span<const std::uint8_t> just_moved, const auto& look) -> Outcome<Done> {
        for (std::size_t k = around.first; k + 1 < around.last; ++k) {
            if (!has_moved(just_moved, k)) continue;
            auto done = cut_row<D>(base, rows[k], first, elements, execution);
            if (done) done = look(elements);
            if (!done) return done;
        }
        return Done{};
    };
    const Moved<D> to = [&](std::size_t v) { return moved(first + v, levels->points[v]); };
    auto done = move_points<D>(levels->points, to, row_by_row, least, execution);
    if (!done) return fail(done.error());
    auto& points = levels->points;
    const auto at = [&](std::size_t level) {
        return points.begin() + static_cast<std::ptrdiff_t>((level - around.first) * base.count);
    };
    points.erase(at(wanted.last), points.end());
    points.erase(points.begin(), at(wanted.first));
    levels->first = wanted.first;
    return levels;
}

/// What all shapes of rows of prisms share. Vertex v of the base on level l is l count + v; rows come in the order of
/// their elements, each with the vertices of one more level: row k with level k up to `between`, of which the last has
/// two, then with level k + 1.
template <int D>
class PrismRows : public ShapeRows<D> {
  public:
    [[nodiscard]] ShapeCounts counts() const final;
    [[nodiscard]] std::size_t rows() const final { return rows_.size(); }
    [[nodiscard]] Outcome<ShapeRun<D>> run(std::size_t first, std::size_t last, const Execution& execution) const final;

  protected:
    PrismRows(PrismBase<D> base, std::vector<PrismRow> rows, std::size_t between)
        : base_(std::move(base)), rows_(std::move(rows)), between_(between) {}

    [[nodiscard]] const PrismBase<D>& base() const { return base_; }
    [[nodiscard]] std::span<const PrismRow> all_rows() const { return rows_; }

  private:
    /// The points of some levels, which rise: one level's after the other's.
    [[nodiscard]] virtual Outcome<Buffer<Vec<D>>> points(std::span<const std::size_t> levels,
                                                         const Execution& execution) const = 0;
    /// Of an element's face in that row, with vertices that all may have facets: none where it is no facet of its own.
    [[nodiscard]] virtual std::optional<Reference> facet_reference(const PrismRow& row,
                                                                   const SimplexVertices<D - 1>& face) const = 0;
    [[nodiscard]] virtual bool may_have_facets(VertexId v) const = 0;
    [[nodiscard]] virtual Reference point_reference(VertexId v) const = 0;
    [[nodiscard]] virtual std::size_t facets_of_row(std::size_t row) const = 0;
    [[nodiscard]] virtual std::size_t edges() const = 0;

    [[nodiscard]] std::size_t level_before(std::size_t row) const { return row < between_ ? row : row + 1; }
    void add_facets(const PrismRow& row, std::span<const SimplexVertices<D>> elements, ShapeRun<D>& run) const;

    PrismBase<D> base_;
    std::vector<PrismRow> rows_;
    std::size_t between_;
};

}  // namespace camber
