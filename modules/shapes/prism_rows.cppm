// Lattices and rows of prisms; generators compute them as a whole or by ranges of rows.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.shapes:prism_rows;
import camber.core;
import :box;
import :delaunay;

namespace camber {

/// Errors: usage (the options are not valid for `generate`).
template <int D>
[[nodiscard]] Outcome<Done> check_box(const BoxOptions<D>& options);

/// Simplices of a lattice: those of dimension D − 1 are extruded along the next axis. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<SimplexVertices<D>>> lattice_simplices(std::span<const int, D> cells, const Noise& noise,
                                                                    const Execution& execution);

/// Positions from 0 to 1 of the planes between cells. They are exact quotients for grading 1.
[[nodiscard]] inline std::vector<double> lattice_planes(int cells, double grading) {
    std::vector<double> at(static_cast<std::size_t>(cells) + 1);
    if (grading == 1 || cells == 1) {
        for (int k = 0; k <= cells; ++k) at[k] = static_cast<double>(k) / cells;
        return at;
    }
    const double log_ratio = log(grading) / (cells - 1);
    for (int k = 0; k <= cells; ++k) at[k] = expm1(k * log_ratio) / expm1(cells * log_ratio);
    at.back() = 1;
    return at;
}

/// Minimum ratio of an element's volume after warping to its volume before.
inline constexpr double min_warped_volume_ratio = 0.05;

/// Regular, warped and jittered positions of the vertices of a box.
template <int D>
class BoxPlaces {
  public:
    explicit BoxPlaces(const BoxOptions<D>& options)
        : options_(options), noise_(Noise{options.seed}.stream(100)), lattice_{options.cells, {}, {}} {
        for (int i = 0; i < D; ++i) axes_[i] = lattice_planes(options.cells[i], options.grading[i]);
    }

    [[nodiscard]] const Lattice<D>& lattice() const { return lattice_; }
    [[nodiscard]] bool bends() const { return options_.warp != 0; }
    [[nodiscard]] Vec<D> regular(std::size_t v) const {
        const auto place = lattice_.place(v);
        Vec<D> p;
        // std::lerp is exact at both ends, so the vertices of a side lie exactly in its plane.
        for (int i = 0; i < D; ++i) p[i] = std::lerp(options_.low[i], options_.high[i], axes_[i][place[i]]);
        return p;
    }
    /// Position p of vertex v after warping, which moves only inner vertices.
    [[nodiscard]] Vec<D> bent(std::size_t v, const Vec<D>& p) const {
        if (lattice_.on_boundary(v)) return p;
        const auto place = lattice_.place(v);
        double move = options_.warp;
        for (int i = 0; i < D; ++i) move *= sin(2 * std::numbers::pi * axes_[i][place[i]]);
        return p + move * (options_.high - options_.low);
    }
    /// Position p of vertex v after jitter. Vertices on a side stay on it.
    [[nodiscard]] Vec<D> jittered(std::size_t v, Vec<D> p) const {
        const auto place = lattice_.place(v);
        const Vec<D> shift = options_.jitter * noise_.template vector<D>(v);
        for (int i = 0; i < D; ++i) {
            const bool free = place[i] > 0 && place[i] < options_.cells[i];
            p[i] += free ? shift[i] * cell_length(i, place[i]) : 0.0;
        }
        return p;
    }

  private:
    /// Length along `axis` of the shorter of the two cells at inner plane k.
    [[nodiscard]] double cell_length(int axis, int k) const {
        const std::vector<double>& planes = axes_[axis];
        const double length = options_.high[axis] - options_.low[axis];
        if (options_.grading[axis] == 1) return length / static_cast<double>(planes.size() - 1);
        return length * std::min(planes[k + 1] - planes[k], planes[k] - planes[k - 1]);
    }

    BoxOptions<D> options_;
    Noise noise_;
    Lattice<D> lattice_;
    std::array<std::vector<double>, D> axes_;  ///< positions of the planes on each axis of the unit box
};

template <int D>
[[nodiscard]] Outcome<Done> check_shell(const ShellOptions<D>& options);

/// Returns the radii of the layers' sides in order from the core to the wall, without the side at the core.
/// `from_wall`: radii of the layers' outer sides in order from the wall; `wall`: radius of the wall.
[[nodiscard]] inline std::vector<double> layer_radii(std::vector<double> from_wall, double wall) {
    if (from_wall.empty()) return from_wall;
    from_wall.pop_back();
    std::ranges::reverse(from_wall);
    from_wall.push_back(wall);
    return from_wall;
}
template <int D>
[[nodiscard]] std::vector<double> inner_layer_radii(const ShellOptions<D>& o) {
    std::vector<double> radii = layer_distances(o.inner_layer);
    for (double& r : radii) r = o.inner_radius + r;
    return layer_radii(std::move(radii), o.inner_radius);
}
template <int D>
[[nodiscard]] std::vector<double> outer_layer_radii(const ShellOptions<D>& o) {
    std::vector<double> radii = layer_distances(o.outer_layer);
    for (double& r : radii) r = o.outer_radius - r;
    return layer_radii(std::move(radii), o.outer_radius);
}

/// Radii of all levels of prisms, in a geometric series.
[[nodiscard]] inline std::vector<double> row_radii(const ShellSizes& sizes, std::size_t rows) {
    const double step = pow(sizes.outer_radius / sizes.inner_radius, 1.0 / static_cast<double>(rows));
    std::vector<double> radii{sizes.inner_radius};
    while (radii.size() <= rows) radii.push_back(radii.back() * step);
    radii.back() = sizes.outer_radius;
    return radii;
}

/// Vertices of prism rows. They are sorted by sphere from the inside outwards, and on each sphere in the order of
/// `directions`.
template <int D>
struct PrismPlaces {
    ShellSizes sizes{};
    std::vector<double> radii;
    Buffer<Vec<D>> directions;
    Noise noise;

    [[nodiscard]] std::size_t size() const { return radii.size() * directions.size(); }
    [[nodiscard]] ShellSide side(std::size_t v) const {
        const std::size_t k = v / directions.size();
        return k == 0 ? ShellSide::inner : k + 1 == radii.size() ? ShellSide::outer : ShellSide::between;
    }
    [[nodiscard]] Vec<D> regular(std::size_t v) const {
        return radii[v / directions.size()] * directions[v % directions.size()];
    }
    [[nodiscard]] Vec<D> moved(std::size_t v) const {
        const double radius = radii[v / directions.size()];
        const double shift = sizes.jitter * sizes.inner_size * radius / sizes.inner_radius;
        const Vec<D> away = regular(v) + shift * noise.template vector<D>(v);
        return side(v) == ShellSide::between ? away : radius * normalised(away);
    }
    /// Projects a boundary vertex onto its sphere after its move.
    [[nodiscard]] Vec<D> settled(std::size_t v, const Vec<D>& p) const {
        switch (side(v)) {
            case ShellSide::inner: return sizes.inner_radius * normalised(p);
            case ShellSide::outer: return sizes.outer_radius * normalised(p);
            default: return p;
        }
    }
};

/// A row of prisms between two levels. A level is a copy of the base vertices.
struct PrismRow {
    std::size_t bottom = 0, top = 0;  ///< numbers of the two levels
    Noise noise;                      ///< generator of the ranks by which prisms are cut
    std::size_t drawn_for = 0;        ///< the rank of base vertex v is random number `drawn_for` + v
    Reference material = 1;
};

struct Levels {
    std::size_t first = 0, last = 0;
};

template <int D>
struct PrismBase {
    Buffer<SimplexVertices<D - 1>> simplices;
    std::size_t count = 0;
};

/// Computes the elements of a row. The vertex numbers are those of the whole mesh minus `less`. Errors: stopped,
/// memory.
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

template <int D>
struct MovedLevels {
    std::size_t first = 0;
    Buffer<Vec<D>> points;
};

/// Levels of prisms; rows[k] is between levels k and k + 1.
template <int D>
struct PrismLevels {
    const PrismBase<D>& base;
    std::span<const PrismRow> rows;
};

/// Returns the positions of the vertices of the levels `requested` after their random move. `move_points` needs some
/// more levels on both sides, because neighbouring elements limit the moves. make_rows(levels): positions before the
/// move; moved(v, point): target of vertex v.
template <int D, class MakeRows, class MovedTo>
[[nodiscard]] Outcome<MovedLevels<D>> moved_levels(const PrismLevels<D>& all, Levels requested, double least,
                                                   const MakeRows& make_rows, const MovedTo& moved,
                                                   const Execution& execution) {
    const auto& [base, rows] = all;
    const Levels around{requested.first - std::min<std::size_t>(requested.first, rings_of_move),
                        std::min(requested.last + rings_of_move, rows.size() + 1)};
    Outcome<MovedLevels<D>> levels = make_rows(around);
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
    points.erase(at(requested.last), points.end());
    points.erase(points.begin(), at(requested.first));
    levels->first = requested.first;
    return levels;
}

/// Rows of prisms over one base with `count` vertices. Vertex v of level l has the number l · count + v, and elements
/// are in the order of rows. Each level of vertices belongs to one row:
/// - Row k owns level k if k < `between`, else level k + 1.
/// - Row `between` − 1 also owns level `between`.
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
    /// Returns the points of the levels, in their order. Precondition: `levels` are ascending.
    [[nodiscard]] virtual Outcome<Buffer<Vec<D>>> points(std::span<const std::size_t> levels,
                                                         const Execution& execution) const = 0;
    /// Returns the reference of an element's face if the face is a facet and this row owns it, else none. Precondition:
    /// `may_have_facets` is true for all vertices of the face.
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
