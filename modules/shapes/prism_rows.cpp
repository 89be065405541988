module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
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

/// Points of some levels, by the numbers of vertices in the whole.
template <int D>
struct PointsOfLevels {
    std::vector<std::size_t> levels;  ///< rising
    std::size_t count = 0;            ///< vertices a level
    Buffer<Vec<D>> points;

    [[nodiscard]] std::span<const Vec<D>> of(std::size_t level) const {
        const auto k = static_cast<std::size_t>(std::ranges::lower_bound(levels, level) - levels.begin());
        return std::span(points).subspan(k * count, count);
    }
};

/// Errors: usage (an element of the row without positive volume, the number of its first being given); stopped.
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
        auto made = this->points(points.levels, execution);
        if (!made) return fail(made.error());
        points.points = std::move(*made);
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

template class PrismRows<2>;
template class PrismRows<3>;

}  // namespace camber
