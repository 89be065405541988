module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.shapes;
import camber.core;
import :box_places;
import :prism_rows;

namespace camber {

namespace {

/// Segments along the edges of a box in space, with a number for each two sides that meet, in rising order.
void add_edges(const Lattice<3>& lattice, LinearMesh<3>& mesh) {
    struct Segment {
        std::array<VertexId, 2> ends;
        Reference number;
    };
    const auto vertex = [&](const std::array<int, 3>& at) {
        const std::size_t x = lattice.cells[0] + std::size_t{1}, y = lattice.cells[1] + std::size_t{1};
        return VertexId(static_cast<std::size_t>(at[0]) + x * (at[1] + y * at[2]));
    };
    constexpr std::array<std::array<int, 2>, 3> sides_along{{{1, 2}, {0, 2}, {0, 1}}};
    // Pairs rise: (1, 3), (1, 4), (1, 5), (1, 6), (2, 3) … (4, 6).
    constexpr std::array<int, 3> first_number{9, 3, 1}, numbers_a_side{2, 4, 4};
    std::vector<Segment> segments;
    for (int axis = 0; axis < 3; ++axis) {
        const auto [i, j] = sides_along[axis];
        for (int ends = 0; ends < 4; ++ends)
            for (int k = 0; k < lattice.cells[axis]; ++k) {
                std::array<int, 3> low{};
                low[i] = ends / 2 * lattice.cells[i];
                low[j] = ends % 2 * lattice.cells[j];
                low[axis] = k;
                std::array<int, 3> high = low;
                ++high[axis];
                segments.push_back(
                    {{vertex(low), vertex(high)}, first_number[axis] + numbers_a_side[axis] * (ends / 2) + ends % 2});
            }
    }
    std::ranges::sort(segments, {}, &Segment::ends);
    Buffer<SimplexVertices<1>> edges;
    Buffer<Reference> references;
    Buffer<std::uint32_t> ridges;
    for (const Segment& s : segments) {
        ridges.push_back(static_cast<std::uint32_t>(edges.size()));
        edges.push_back(s.ends);
        references.push_back(s.number);
    }
    mesh.edges = {std::move(edges), std::move(references), {}};
    mesh.ridges = std::move(ridges);
}

template <int D>
class BoxRows final : public PrismRows<D> {
  public:
    BoxRows(const BoxOptions<D>& options, PrismBase<D> base, std::vector<PrismRow> rows, std::size_t rows_between)
        : PrismRows<D>(std::move(base), std::move(rows), rows_between), places_(options) {}

    [[nodiscard]] Outcome<LinearMesh<D>> lists() const override {
        return guarded([&]() -> Outcome<LinearMesh<D>> {
            LinearMesh<D> lists;
            Buffer<VertexId> corners;
            for (unsigned corner = 0; corner < 1U << D; ++corner) {
                std::size_t v = 0, step = 1;
                for (int i = 0; i < D; ++i) {
                    const auto cells = static_cast<std::size_t>(lattice().cells[i]);
                    v += (corner >> i & 1U) * cells * step;
                    step *= cells + 1;
                }
                corners.push_back(VertexId(v));
            }
            lists.corners = std::move(corners);
            if constexpr (D == 3) add_edges(lattice(), lists);
            return lists;
        });
    }

  private:
    [[nodiscard]] const Lattice<D>& lattice() const { return places_.lattice(); }
    [[nodiscard]] std::size_t count() const { return this->base().count; }

    [[nodiscard]] Outcome<MovedLevels<D>> regular(Levels levels, const Execution& execution) const {
        const std::size_t first = levels.first * count();
        auto points = map_each(execution, (levels.last - levels.first) * count(),
                               [&](std::size_t v) { return places_.regular(first + v); });
        if (!points) return fail(points.error());
        return MovedLevels<D>{levels.first, std::move(*points)};
    }
    [[nodiscard]] Outcome<MovedLevels<D>> bent(Levels levels, const Execution& execution) const {
        if (!places_.bends()) return regular(levels, execution);
        return moved_levels<D>(
            this->base(), this->all_rows(), levels, least_bent, [&](Levels l) { return regular(l, execution); },
            [&](std::size_t v, const Vec<D>& p) { return places_.bent(v, p); }, execution);
    }
    [[nodiscard]] Outcome<Buffer<Vec<D>>> points(std::span<const std::size_t> levels,
                                                 const Execution& execution) const override {
        auto moved = moved_levels<D>(
            this->base(), this->all_rows(), {levels.front(), levels.back() + 1}, least_jittered,
            [&](Levels l) { return bent(l, execution); },
            [&](std::size_t v, const Vec<D>& p) { return places_.jittered(v, p); }, execution);
        if (!moved) return fail(moved.error());
        return std::move(moved->points);
    }
    [[nodiscard]] std::optional<Reference> facet_reference(const PrismRow& /*row*/,
                                                           const SimplexVertices<D - 1>& face) const override {
        const Reference side = lattice().side(face);
        return side != 0 ? std::optional(side) : std::nullopt;
    }
    [[nodiscard]] bool may_have_facets(VertexId v) const override { return lattice().on_boundary(v.index()); }
    /// That of the first side that it lies on.
    [[nodiscard]] Reference point_reference(VertexId v) const override {
        const auto place = lattice().place(v.index());
        for (int i = 0; i < D; ++i) {
            if (place[i] == 0) return 2 * i + 1;
            if (place[i] == lattice().cells[i]) return 2 * i + 2;
        }
        return 0;
    }
    [[nodiscard]] std::size_t facets_of_row(std::size_t row) const override {
        const std::size_t ends = (row == 0 ? 1U : 0U) + (row + 1 == this->rows() ? 1U : 0U);
        return (D - 1) * rim() + ends * this->base().simplices.size();
    }
    /// Faces of the base on its boundary.
    [[nodiscard]] std::size_t rim() const {
        std::size_t faces = 1;
        if constexpr (D == 3) faces = static_cast<std::size_t>(lattice().cells[0]) + lattice().cells[1];
        return 2 * faces;
    }
    [[nodiscard]] std::size_t edges() const override {
        std::size_t sum = 0;
        if constexpr (D == 3)
            for (const int n : lattice().cells) sum += 4 * static_cast<std::size_t>(n);
        return sum;
    }

    BoxPlaces<D> places_;
};

}  // namespace

template <int D>
Outcome<std::unique_ptr<const ShapeRows<D>>> rows_of_shape(const BoxOptions<D>& options, const Execution& execution) {
    return guarded([&]() -> Outcome<std::unique_ptr<const ShapeRows<D>>> {
        if (auto checked = check_box(options); !checked) return fail(checked.error());
        const Noise noise{options.seed};
        auto simplices = lattice_simplices<D - 1>(std::span(options.cells).template first<D - 1>(), noise, execution);
        if (!simplices) return fail(simplices.error());
        PrismBase<D> base{std::move(*simplices), 1};
        for (int i = 0; i + 1 < D; ++i) base.count *= static_cast<std::size_t>(options.cells[i]) + 1;
        std::vector<PrismRow> rows;
        const auto number = static_cast<std::size_t>(options.cells[D - 1]);
        rows.reserve(number);
        for (std::size_t k = 0; k < number; ++k) rows.push_back({k, k + 1, noise.stream(D).stream(k)});
        return std::make_unique<const BoxRows<D>>(options, std::move(base), std::move(rows), number);
    });
}

template Outcome<std::unique_ptr<const ShapeRows<2>>> rows_of_shape<2>(const BoxOptions<2>&, const Execution&);
template Outcome<std::unique_ptr<const ShapeRows<3>>> rows_of_shape<3>(const BoxOptions<3>&, const Execution&);

}  // namespace camber
