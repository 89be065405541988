module;
#include <cstddef>
#include <functional>
#include <memory>
#include <string_view>
#include <utility>
module camber.distributed;
import camber.core;
import camber.io;
import :gmf_rows;
import :rows;

namespace camber {

namespace {

template <int D>
class GmfRows final : public MeshRows<D> {
  public:
    GmfRows(Column<std::byte> bytes, GmfRuns<D> runs, std::function<void()> after_rows)
        : bytes_(std::move(bytes)), runs_(std::move(runs)), after_rows_(std::move(after_rows)) {}

    [[nodiscard]] RowCounts counts() const override {
        const auto [points, elements, facets, edges] = runs_.counts();
        return {points, elements, facets, edges};
    }
    [[nodiscard]] Outcome<PointRows<D>> points(std::size_t begin, std::size_t end) const override {
        return guarded([&]() -> Outcome<PointRows<D>> {
            PointRows<D> rows{Buffer<Vec<D>>(end - begin), Buffer<Reference>(end - begin)};
            const auto done = runs_.points(begin, rows.points, rows.references);
            return read(done, std::move(rows));
        });
    }
    [[nodiscard]] Outcome<SimplexRows<D>> elements(std::size_t begin, std::size_t end) const override {
        return simplices<D>(begin, end);
    }
    [[nodiscard]] Outcome<SimplexRows<D - 1>> facets(std::size_t begin, std::size_t end) const override {
        return simplices<D - 1>(begin, end);
    }
    [[nodiscard]] Outcome<SimplexRows<1>> edges(std::size_t begin, std::size_t end) const override {
        if constexpr (D == 3)
            return simplices<1>(begin, end);
        else
            return SimplexRows<1>{};
    }
    [[nodiscard]] Outcome<LinearMesh<D>> lists() const override { return runs_.lists(); }

  private:
    template <int K>
    [[nodiscard]] Outcome<SimplexRows<K>> simplices(std::size_t begin, std::size_t end) const {
        return guarded([&]() -> Outcome<SimplexRows<K>> {
            SimplexRows<K> rows{Buffer<SimplexVertices<K>>(end - begin), Buffer<Reference>(end - begin)};
            const auto done = runs_.template simplices<K>(begin, rows.vertices, rows.references);
            return read(done, std::move(rows));
        });
    }
    template <class Rows>
    [[nodiscard]] Outcome<Rows> read(const Outcome<Done>& done, Rows rows) const {
        if (after_rows_) after_rows_();
        if (!done) return fail(done.error());
        return rows;
    }

    Column<std::byte> bytes_;
    GmfRuns<D> runs_;  ///< over those
    std::function<void()> after_rows_;
};

template <int D>
class MemoryRows final : public MeshRows<D> {
  public:
    explicit MemoryRows(LinearMesh<D> mesh) : mesh_(std::move(mesh)) {}

    [[nodiscard]] RowCounts counts() const override {
        return {mesh_.points.size(), mesh_.elements.size(), mesh_.facets.size(), mesh_.edges.size()};
    }
    [[nodiscard]] Outcome<PointRows<D>> points(std::size_t begin, std::size_t end) const override {
        return guarded([&]() -> Outcome<PointRows<D>> {
            return PointRows<D>{run(mesh_.points, begin, end), run(mesh_.point_references, begin, end)};
        });
    }
    [[nodiscard]] Outcome<SimplexRows<D>> elements(std::size_t begin, std::size_t end) const override {
        return simplices(mesh_.elements, begin, end);
    }
    [[nodiscard]] Outcome<SimplexRows<D - 1>> facets(std::size_t begin, std::size_t end) const override {
        return simplices(mesh_.facets, begin, end);
    }
    [[nodiscard]] Outcome<SimplexRows<1>> edges(std::size_t begin, std::size_t end) const override {
        return simplices(mesh_.edges, begin, end);
    }
    [[nodiscard]] Outcome<LinearMesh<D>> lists() const override {
        LinearMesh<D> lists;
        lists.corners = mesh_.corners;
        lists.required_vertices = mesh_.required_vertices;
        lists.ridges = mesh_.ridges;
        lists.elements.required = mesh_.elements.required;
        lists.facets.required = mesh_.facets.required;
        lists.edges.required = mesh_.edges.required;
        lists.facets.entities = mesh_.facets.entities;
        lists.geometry = mesh_.geometry;
        lists.groups = mesh_.groups;
        return lists;
    }

  private:
    template <class T>
    [[nodiscard]] static Buffer<T> run(const Column<T>& column, std::size_t begin, std::size_t end) {
        const auto items = column.view().subspan(begin, end - begin);
        return Buffer<T>(items.begin(), items.end());
    }
    template <int K>
    [[nodiscard]] static Outcome<SimplexRows<K>> simplices(const Simplices<K>& kind, std::size_t begin,
                                                           std::size_t end) {
        return guarded([&]() -> Outcome<SimplexRows<K>> {
            return SimplexRows<K>{run(kind.vertices, begin, end), run(kind.references, begin, end)};
        });
    }

    LinearMesh<D> mesh_;
};

}  // namespace

template <int D>
Outcome<std::unique_ptr<MeshRows<D>>> rows_of_gmf(Column<std::byte> bytes, std::string_view name,
                                                  std::function<void()> after_rows) {
    auto runs = gmf_runs<D>(bytes.view(), name);
    if (!runs) return fail(std::move(runs.error()));
    return std::make_unique<GmfRows<D>>(std::move(bytes), std::move(*runs), std::move(after_rows));
}

template <int D>
std::unique_ptr<MeshRows<D>> rows_of(LinearMesh<D> mesh) {
    return std::make_unique<MemoryRows<D>>(std::move(mesh));
}

#define CAMBER_INSTANTIATE(D)                                                                          \
    template Outcome<std::unique_ptr<MeshRows<D>>> rows_of_gmf<D>(Column<std::byte>, std::string_view, \
                                                                  std::function<void()>);              \
    template std::unique_ptr<MeshRows<D>> rows_of<D>(LinearMesh<D>);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
