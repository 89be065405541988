// Computes rows of prisms, and rows of shells.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.shapes;
import camber.core;
import :prism_rows;

namespace camber {

namespace {

double volume(const std::array<Vec<2>, 3>& p) { return det(p[1] - p[0], p[2] - p[0]); }
double volume(const std::array<Vec<3>, 4>& p) { return det(p[1] - p[0], p[2] - p[0], p[3] - p[0]); }

template <int D>
struct PointsOfLevels {
    std::vector<std::size_t> levels;
    std::size_t count = 0;
    Buffer<Vec<D>> points;

    [[nodiscard]] std::span<const Vec<D>> of(std::size_t level) const {
        const auto k = static_cast<std::size_t>(std::ranges::lower_bound(levels, level) - levels.begin());
        return std::span(points).subspan(k * count, count);
    }
};

template <int D>
Outcome<Done> check_volumes(const PointsOfLevels<D>& points, const PrismRow& row,
                            std::span<const SimplexVertices<D>> elements, std::size_t first,
                            const Execution& execution) {
    const auto bottom = points.of(row.bottom), top = points.of(row.top);
    const std::size_t begin = row.bottom * points.count, begin_of_top = row.top * points.count;
    const auto at = [&](VertexId v) {
        const std::size_t k = v.index() - begin;
        return k < points.count ? bottom[k] : top[v.index() - begin_of_top];
    };
    const std::size_t none = elements.size();
    const auto found = reduce_each(
        execution, none, none,
        [&](std::size_t& least, std::size_t e) {
            std::array<Vec<D>, D + 1> p;
            for (int i = 0; i <= D; ++i) p[i] = at(elements[e][i]);
            if (least == none && !(volume(p) > 0)) least = e;
        },
        [](std::size_t a, std::size_t b) { return std::min(a, b); });
    if (!found) return fail(found.error());
    if (*found == none) return Done{};
    return no_positive_volume<D>(first + *found);
}

}  // namespace

template <int D>
ShapeCounts PrismRows<D>::counts() const {
    std::size_t facets = 0;
    for (std::size_t k = 0; k < rows_.size(); ++k) facets += facets_of_row(k);
    return {(rows_.size() + 1) * base_.count, rows_.size() * D * base_.simplices.size(), facets, edges()};
}

template <int D>
void PrismRows<D>::add_facets(const PrismRow& row, std::span<const SimplexVertices<D>> elements,
                              ShapeRun<D>& run) const {
    for (const auto& element : elements) {
        std::array<bool, D + 1> may{};
        for (int i = 0; i <= D; ++i) may[i] = may_have_facets(element[i]);
        for (int opposite = 0; opposite <= D; ++opposite) {
            if (std::count(may.begin(), may.end(), true) - (may[opposite] ? 1 : 0) < D) continue;
            SimplexVertices<D - 1> face;
            const auto local = face_opposite<D>(opposite);
            for (int i = 0; i < D; ++i) face[i] = element[local[i]];
            if (const auto reference = facet_reference(row, face)) {
                run.facets.push_back(face);
                run.facet_references.push_back(*reference);
            }
        }
    }
}

template <int D>
Outcome<ShapeRun<D>> PrismRows<D>::run(std::size_t first, std::size_t last, const Execution& execution) const {
    return guarded([&]() -> Outcome<ShapeRun<D>> {
        ShapeRun<D> run;
        if (first >= last) return run;
        const std::size_t of_row = D * base_.simplices.size(), count = base_.count;
        const Levels own{level_before(first), level_before(last)};
        PointsOfLevels<D> points{{}, count, {}};
        for (std::size_t l = own.first; l < own.last; ++l) points.levels.push_back(l);
        for (std::size_t k = first; k < last; ++k)
            points.levels.insert(points.levels.end(), {rows_[k].bottom, rows_[k].top});
        std::ranges::sort(points.levels);
        points.levels.erase(std::ranges::unique(points.levels).begin(), points.levels.end());
        auto result = this->points(points.levels, execution);
        if (!result) return fail(result.error());
        points.points = std::move(*result);
        run.first_vertex = own.first * count;
        run.first_element = first * of_row;
        for (std::size_t k = 0; k < first; ++k) run.first_facet += facets_of_row(k);
        std::size_t facets = 0;
        for (std::size_t k = first; k < last; ++k) facets += facets_of_row(k);
        run.facets.reserve(facets);
        run.facet_references.reserve(facets);
        run.elements.resize((last - first) * of_row);
        for (std::size_t k = first; k < last; ++k) {
            const auto elements = std::span(run.elements).subspan((k - first) * of_row, of_row);
            auto done = cut_row<D>(base_, rows_[k], 0, elements, execution);
            if (done) done = check_volumes<D>(points, rows_[k], elements, k * of_row, execution);
            if (!done) return fail(done.error());
            run.materials.resize(run.materials.size() + of_row, rows_[k].material);
            if (facets_of_row(k) > 0) add_facets(rows_[k], elements, run);
        }
        run.points.reserve((own.last - own.first) * count);
        for (std::size_t l = own.first; l < own.last; ++l) {
            const auto of_level = points.of(l);
            run.points.insert(run.points.end(), of_level.begin(), of_level.end());
        }
        auto references = map_each(execution, run.points.size(),
                                   [&](std::size_t v) { return point_reference(VertexId(run.first_vertex + v)); });
        if (!references) return fail(references.error());
        run.point_references = std::move(*references);
        return run;
    });
}

namespace {

/// A level that has facets: a boundary of the shell or a material interface.
struct Wall {
    std::size_t level = 0;
    std::size_t row = 0;
    Reference reference = 0;
};

/// Rows of a shell. The order of levels is: core, inner layers from core to wall, outer layers from core to wall.
struct ShellRowsPlan {
    std::vector<PrismRow> rows;
    std::vector<Wall> walls;
};

template <int D>
class ShellPlanner {
  public:
    ShellPlanner(const ShellOptions<D>& options, std::size_t core, std::size_t count)
        : options_(options), core_(core), count_(count), noise_(Noise{options.seed}) {}

    [[nodiscard]] ShellRowsPlan plan() {
        for (std::size_t k = 0; k < core_; ++k) plan_.rows.push_back({k, k + 1, noise_.stream(300 + k)});
        const Noise of_layers = noise_.stream(400);
        add_inner(of_layers.stream(1));
        add_outer(of_layers.stream(2));
        return std::move(plan_);
    }

  private:
    void add_inner(const Noise& noise) {
        const BoundaryLayer& layer = options_.inner_layer;
        std::size_t last = 0;
        for (int k = 0; k < layer.count; ++k) {
            const std::size_t next = plan_.rows.size() + 1;
            plan_.rows.push_back({next, last, noise.stream(k), 0, layer.material});
            last = next;
        }
        add_walls(layer, 0, 0, core_, last, options_.inner_reference);
    }
    void add_outer(const Noise& noise) {
        const BoundaryLayer& layer = options_.outer_layer;
        const std::size_t first = plan_.rows.size();
        std::size_t last = core_;
        for (int k = 0; k < layer.count; ++k) {
            const std::size_t next = plan_.rows.size() + 1;
            plan_.rows.push_back({last, next, noise.stream(k), core_ * count_, layer.material});
            last = next;
        }
        add_walls(layer, core_, core_ - 1, first, last, options_.outer_reference);
    }
    /// Adds the outer side of the layers (level `wall`). If layers and core have different materials, adds the
    /// interface between them (level `level`). `of_core`, `of_layer`: the rows on the two sides of the interface.
    void add_walls(const BoundaryLayer& layer, std::size_t level, std::size_t of_core, std::size_t of_layer,
                   std::size_t wall, Reference reference) {
        constexpr Reference core = 1;
        if (layer.count == 0) return plan_.walls.push_back({level, of_core, reference});
        if (layer.material != core)
            plan_.walls.push_back({level, layer.material < core ? of_layer : of_core, layer.interface});
        plan_.walls.push_back({wall, plan_.rows.size() - 1, reference});
    }

    const ShellOptions<D>& options_;
    std::size_t core_, count_;
    Noise noise_;
    ShellRowsPlan plan_;
};

template <int D>
class ShellRows final : public PrismRows<D> {
  public:
    ShellRows(const ShellOptions<D>& options, PrismPlaces<D> places, PrismBase<D> base, ShellRowsPlan plan)
        : PrismRows<D>(std::move(base), std::move(plan.rows), places.radii.size() - 1),
          centre_(options.centre),
          places_(std::move(places)),
          walls_(std::move(plan.walls)),
          inner_(inner_layer_radii(options)),
          outer_(outer_layer_radii(options)) {}

    [[nodiscard]] Outcome<LinearMesh<D>> lists() const override { return LinearMesh<D>{}; }

  private:
    [[nodiscard]] std::size_t count() const { return this->base().count; }
    [[nodiscard]] std::size_t core_levels() const { return places_.radii.size(); }

    [[nodiscard]] Outcome<Buffer<Vec<D>>> core_points(Levels levels, const Execution& execution) const {
        const auto regular = [&](Levels around) -> Outcome<MovedLevels<D>> {
            const std::size_t first = around.first * count();
            auto points = map_each(execution, (around.last - around.first) * count(),
                                   [&](std::size_t v) { return places_.regular(first + v); });
            if (!points) return fail(points.error());
            return MovedLevels<D>{around.first, std::move(*points)};
        };
        auto moved = moved_levels<D>(
            {this->base(), this->all_rows().first(core_levels() - 1)}, levels, min_jittered_volume_ratio, regular,
            [&](std::size_t v, const Vec<D>&) { return places_.moved(v); }, execution);
        if (!moved) return fail(moved.error());
        const std::size_t first = levels.first * count();
        auto& points = moved->points;
        auto done =
            each(execution, points.size(), [&](std::size_t v) { points[v] = places_.settled(first + v, points[v]); });
        if (!done) return fail(done.error());
        return std::move(points);
    }
    [[nodiscard]] Outcome<Done> place_layer(std::size_t level, std::span<const Vec<D>> wall, std::span<Vec<D>> to,
                                            const Execution& execution) const {
        const std::size_t k = level - core_levels();
        const double radius = k < inner_.size() ? inner_[k] : outer_[k - inner_.size()];
        return each(execution, to.size(), [&](std::size_t v) { to[v] = radius * normalised(wall[v]); });
    }
    [[nodiscard]] Outcome<Buffer<Vec<D>>> points(std::span<const std::size_t> levels,
                                                 const Execution& execution) const override {
        Buffer<Vec<D>> all;
        all.reserve(levels.size() * count());
        const auto begin_of_layers =
            static_cast<std::size_t>(std::ranges::lower_bound(levels, core_levels()) - levels.begin());
        for (std::size_t k = 0; k < begin_of_layers;) {  // iterates over runs of consecutive levels
            std::size_t end = k + 1;
            while (end < begin_of_layers && levels[end] == levels[end - 1] + 1) ++end;
            const auto some = core_points({levels[k], levels[end - 1] + 1}, execution);
            if (!some) return some;
            all.insert(all.end(), some->begin(), some->end());
            k = end;
        }
        const std::size_t first_outer = core_levels() + inner_.size();
        Buffer<Vec<D>> inner_wall, outer_wall;
        for (std::size_t k = begin_of_layers; k < levels.size(); ++k) {
            const bool is_inner = levels[k] < first_outer;
            Buffer<Vec<D>>& wall = is_inner ? inner_wall : outer_wall;
            const std::size_t level = is_inner ? 0 : core_levels() - 1;
            if (wall.empty()) {
                auto some = core_points({level, level + 1}, execution);
                if (!some) return some;
                wall = std::move(*some);
            }
            all.resize(all.size() + count());
            auto done = place_layer(levels[k], wall, std::span(all).last(count()), execution);
            if (!done) return fail(done.error());
        }
        auto done = each(execution, all.size(), [&](std::size_t v) { all[v] += centre_; });
        if (!done) return fail(done.error());
        return all;
    }
    [[nodiscard]] const Wall* wall_at(std::size_t level) const {
        const auto found = std::ranges::find(walls_, level, &Wall::level);
        return found == walls_.end() ? nullptr : &*found;
    }
    [[nodiscard]] std::optional<Reference> facet_reference(const PrismRow& row,
                                                           const SimplexVertices<D - 1>& face) const override {
        const std::size_t level = face[0].index() / count();
        for (const VertexId v : face)
            if (v.index() / count() != level) return std::nullopt;
        const Wall* const wall = wall_at(level);
        const auto of_row = static_cast<std::size_t>(&row - this->all_rows().data());
        return wall != nullptr && wall->row == of_row ? std::optional(wall->reference) : std::nullopt;
    }
    [[nodiscard]] bool may_have_facets(VertexId v) const override { return wall_at(v.index() / count()) != nullptr; }
    [[nodiscard]] Reference point_reference(VertexId v) const override {
        const Wall* const wall = wall_at(v.index() / count());
        return wall != nullptr ? wall->reference : 0;
    }
    [[nodiscard]] std::size_t facets_of_row(std::size_t row) const override {
        return static_cast<std::size_t>(std::ranges::count(walls_, row, &Wall::row)) * this->base().simplices.size();
    }
    [[nodiscard]] std::size_t edges() const override { return 0; }

    Vec<D> centre_;
    PrismPlaces<D> places_;
    std::vector<Wall> walls_;
    std::vector<double> inner_, outer_;
};

}  // namespace

template <int D>
Outcome<std::unique_ptr<const ShapeRows<D>>> rows_of_shape(const ShellOptions<D>& options,
                                                           const Execution& /*execution*/) {
    return guarded([&]() -> Outcome<std::unique_ptr<const ShapeRows<D>>> {
        if (auto checked = check_shell(options); !checked) return fail(checked.error());
        if (options.structure != ShellStructure::prisms)
            return fail(ErrorKind::unsupported, "an unstructured shell cannot be generated in parts", {}, {},
                        "use --structure prisms");
        const ShellSizes sizes = core_sizes(options);
        const PrismCounts counts = prism_counts<D>(sizes);
        auto sphere = icosphere<D>(static_cast<int>(counts.cuts));
        const auto rows = static_cast<std::size_t>(counts.rows);
        PrismBase<D> base{std::move(sphere.facets), sphere.points.size()};
        PrismPlaces<D> places{sizes, row_radii(sizes, rows), std::move(sphere.points), Noise{options.seed}};
        auto plan = ShellPlanner<D>(options, rows, base.count).plan();
        return std::make_unique<const ShellRows<D>>(options, std::move(places), std::move(base), std::move(plan));
    });
}

template Outcome<std::unique_ptr<const ShapeRows<2>>> rows_of_shape<2>(const ShellOptions<2>&, const Execution&);
template Outcome<std::unique_ptr<const ShapeRows<3>>> rows_of_shape<3>(const ShellOptions<3>&, const Execution&);

template class PrismRows<2>;
template class PrismRows<3>;

}  // namespace camber
