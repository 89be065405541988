module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.cavity;
import camber.ordering;

namespace camber {

namespace {

template <int D>
struct PartByPositions {
    std::vector<SentSimplex<D>> elements;
    std::vector<SentSimplex<D - 1>> facets;
    std::vector<SentSimplex<1>> lines;
};

template <int D>
class RowReceiver {
  public:
    RowReceiver(const PointBox<D>& grid, PartNumber first, PartNumber last)
        : grid_(grid), first_(first), parts_(last - first) {}

    Outcome<std::vector<AdaptationRows<D>>> parts(std::vector<SentRows<D>> sent, const Execution& execution) {
        take_vertices(sent);
        sort_vertices();
        reserve(sent);
        std::size_t offset = 0;
        for (SentRows<D>& rows : sent) {
            const std::size_t vertices = counts_[static_cast<std::size_t>(&rows - sent.data())];
            put_sent(rows.elements, offset, &PartByPositions<D>::elements);
            put_sent(rows.facets, offset, &PartByPositions<D>::facets);
            put_sent(rows.lines, offset, &PartByPositions<D>::lines);
            put_by_number(rows.facets_by_number, &PartByPositions<D>::facets);
            put_by_number(rows.lines_by_number, &PartByPositions<D>::lines);
            offset += vertices;
            rows = {};
        }
        std::vector<AdaptationRows<D>> result;
        result.reserve(parts_.size());
        ids_.assign(positions_.size(), VertexId{});
        for (PartByPositions<D>& part : parts_) {
            auto rows = part_of(std::exchange(part, {}), execution);
            if (!rows) return fail(rows.error());
            result.push_back(std::move(*rows));
        }
        return result;
    }

  private:
    void take_vertices(std::vector<SentRows<D>>& sent) {
        std::size_t all = 0;
        for (const SentRows<D>& rows : sent) all += rows.vertices.size();
        vertices_.reserve(all);
        for (SentRows<D>& rows : sent) {
            counts_.push_back(rows.vertices.size());
            const Buffer<AdaptedVertex<D>> some = std::exchange(rows.vertices, {});
            vertices_.insert(vertices_.end(), some.begin(), some.end());
        }
    }
    void reserve(const std::vector<SentRows<D>>& sent) {
        std::vector<std::size_t> elements(parts_.size(), 0);
        for (const SentRows<D>& rows : sent)
            for (const SentSimplex<D>& element : rows.elements) ++elements[element.part - first_];
        for (std::size_t p = 0; p < parts_.size(); ++p) parts_[p].elements.reserve(elements[p]);
    }
    void sort_vertices() {
        struct Turn {
            std::uint64_t key = 0;
            VertexId number;
            std::uint32_t at = 0;
            auto operator<=>(const Turn&) const = default;
        };
        Buffer<Turn> sorted(vertices_.size());
        for (std::size_t v = 0; v < sorted.size(); ++v)
            sorted[v] = {morton_key(vertices_[v].point, grid_), vertices_[v].number, static_cast<std::uint32_t>(v)};
        std::ranges::sort(sorted);
        position_of_.resize(vertices_.size());
        for (std::size_t i = 0; i < sorted.size(); ++i) {
            if (i == 0 || sorted[i].number != sorted[i - 1].number) positions_.push_back(sorted[i].at);
            position_of_[sorted[i].at] = static_cast<std::uint32_t>(positions_.size() - 1);
        }
    }
    template <int K>
    void put_sent(const Buffer<SentSimplex<K>>& some, std::size_t offset,
                  std::vector<SentSimplex<K>> PartByPositions<D>::* list) {
        for (SentSimplex<K> one : some) {
            for (VertexId& v : one.simplex.vertices) v = VertexId(std::size_t{position_of_[offset + v.index()]});
            (parts_[one.part - first_].*list).push_back(one);
        }
    }
    template <int K>
    void put_by_number(const Buffer<SentSimplex<K>>& some, std::vector<SentSimplex<K>> PartByPositions<D>::* list) {
        if (!some.empty() && by_number_.empty()) {
            by_number_.resize(positions_.size());
            std::iota(by_number_.begin(), by_number_.end(), 0U);
            std::ranges::sort(by_number_, {}, [&](std::uint32_t turn) { return number_at(turn); });
        }
        for (SentSimplex<K> one : some) {
            bool is_local = true;
            for (VertexId& v : one.simplex.vertices) {
                const auto found =
                    std::ranges::lower_bound(by_number_, v, {}, [&](std::uint32_t turn) { return number_at(turn); });
                is_local = is_local && found != by_number_.end() && number_at(*found) == v;
                if (is_local) v = VertexId(std::size_t{*found});
            }
            if (is_local) (parts_[one.part - first_].*list).push_back(one);
        }
    }
    [[nodiscard]] VertexId number_at(std::uint32_t turn) const { return vertices_[positions_[turn]].number; }

    Outcome<AdaptationRows<D>> part_of(PartByPositions<D> part, const Execution& execution) {
        AdaptationRows<D> rows;
        put_vertices(part, rows);
        put_elements(std::move(part.elements), rows);
        const auto around = elements_around(rows, execution);
        if (!around) return fail(around.error());
        std::ranges::sort(part.facets, {}, &SentSimplex<D - 1>::number);
        for (SentSimplex<D - 1>& facet : part.facets) {
            const int beside = elements_with(facet.simplex, rows, *around);
            if (beside == 0) continue;
            if (beside < facet.simplex.sides) facet.simplex.marks |= Mark::frozen;
            rows.facets.push_back(facet.simplex);
        }
        std::ranges::sort(part.lines, {}, &SentSimplex<1>::number);
        for (SentSimplex<1>& line : part.lines)
            if (elements_with(line.simplex, rows, *around) > 0) rows.lines.push_back(line.simplex);
        for (const std::uint32_t turn : named_) ids_[turn] = {};
        return rows;
    }
    void put_vertices(const PartByPositions<D>& part, AdaptationRows<D>& rows) {
        named_.clear();
        for (const SentSimplex<D>& element : part.elements)
            for (const VertexId v : element.simplex.vertices)
                if (!std::exchange(ids_[v.index()], v).valid()) named_.push_back(v.value);
        std::ranges::sort(named_);
        rows.vertices.reserve(named_.size());
        for (const std::uint32_t turn : named_) {
            ids_[turn] = VertexId(rows.vertices.size());
            rows.vertices.push_back(vertices_[positions_[turn]]);
        }
    }
    void put_elements(std::vector<SentSimplex<D>> elements, AdaptationRows<D>& rows) const {
        const auto place = [](const SentSimplex<D>& e) {
            return std::pair(std::ranges::min(e.simplex.vertices), e.number);
        };
        if (!std::ranges::is_sorted(elements, {}, place)) std::ranges::sort(elements, {}, place);
        rows.elements.reserve(elements.size());
        for (SentSimplex<D>& element : elements) {
            for (VertexId& v : element.simplex.vertices) v = ids_[v.index()];
            rows.elements.push_back(element.simplex);
        }
    }
    template <int K>
    [[nodiscard]] int elements_with(AdaptedSimplex<K>& simplex, const AdaptationRows<D>& rows,
                                    const Incidence<ElementId>& around) const {
        for (VertexId& v : simplex.vertices) v = ids_[v.index()];
        if (!std::ranges::all_of(simplex.vertices, [](VertexId v) { return v.valid(); })) return 0;
        return static_cast<int>(std::ranges::count_if(around[simplex.vertices[0]], [&](ElementId e) {
            return std::ranges::all_of(
                simplex.vertices, [&](VertexId v) { return local_vertex(rows.elements[e.index()].vertices, v) >= 0; });
        }));
    }

    const PointBox<D>& grid_;
    PartNumber first_;
    std::vector<PartByPositions<D>> parts_;
    Buffer<AdaptedVertex<D>> vertices_;
    std::vector<std::size_t> counts_;
    Buffer<std::uint32_t> position_of_;
    std::vector<std::uint32_t> positions_;
    std::vector<std::uint32_t> by_number_;
    std::vector<std::uint32_t> named_;
    Buffer<VertexId> ids_;
};

}  // namespace

template <int D>
Outcome<Incidence<ElementId>> elements_around(const AdaptationRows<D>& rows, const Execution& execution) {
    LinearMesh<D> mesh;
    mesh.points = Buffer<Vec<D>>(rows.vertices.size(), Vec<D>{});
    Buffer<SimplexVertices<D>> vertices(rows.elements.size());
    for (std::size_t e = 0; e < vertices.size(); ++e) vertices[e] = rows.elements[e].vertices;
    mesh.elements.vertices = std::move(vertices);
    return balls(mesh, execution);
}

template <int D>
Outcome<std::vector<AdaptationRows<D>>> parts_of_sent(std::vector<SentRows<D>> sent, const PointBox<D>& grid,
                                                      PartNumber first, PartNumber last, const Execution& execution) {
    return guarded([&]() -> Outcome<std::vector<AdaptationRows<D>>> {
        return RowReceiver<D>(grid, first, last).parts(std::move(sent), execution);
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                       \
    template Outcome<Incidence<ElementId>> elements_around<D>(const AdaptationRows<D>&, const Execution&);          \
    template Outcome<std::vector<AdaptationRows<D>>> parts_of_sent<D>(std::vector<SentRows<D>>, const PointBox<D>&, \
                                                                      PartNumber, PartNumber, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
