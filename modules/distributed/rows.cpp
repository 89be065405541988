// Reads mesh rows from GMF files of degree 1 and 2 and from memory.
module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.io;

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
    GmfRuns<D> runs_;
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

template <int D>
Outcome<std::unique_ptr<QuadraticRows<D>>> QuadraticRows<D>::make(Column<std::byte> bytes, std::string_view name,
                                                                  std::function<void()> after_rows, Ranks& ranks) {
    auto runs = agreed(ranks, gmf_runs<D, 2>(bytes.view(), name));
    if (!runs) return fail(std::move(runs.error()));
    auto rows = std::make_unique<QuadraticRows>(std::move(bytes), std::move(*runs), std::move(after_rows));
    if (auto found = rows->find_vertices(name, ranks); !found) return fail(std::move(found.error()));
    return rows;
}

template <int D>
RowCounts QuadraticRows<D>::counts() const {
    const GmfCounts counts = runs_.counts();
    return {vertices_, counts.elements, counts.facets, counts.edges};
}

template <int D>
Outcome<PointRows<D>> QuadraticRows<D>::rows_of_points(std::size_t begin, std::size_t end) const {
    return guarded([&]() -> Outcome<PointRows<D>> {
        PointRows<D> rows{Buffer<Vec<D>>(end - begin), Buffer<Reference>(end - begin)};
        const auto done = runs_.points(begin, rows.points, rows.references);
        if (after_rows_) after_rows_();
        if (!done) return fail(done.error());
        return rows;
    });
}
template <int D>
Outcome<PointRows<D>> QuadraticRows<D>::points(std::size_t begin, std::size_t end) const {
    return rows_of_points(begin, end);
}
template <int D>
Outcome<PointRows<D>> QuadraticRows<D>::mid_nodes(std::size_t begin, std::size_t end) const {
    return rows_of_points(vertices_ + begin, vertices_ + end);
}

template <int D>
template <int K>
Outcome<typename QuadraticRows<D>::template Curved<K>> QuadraticRows<D>::curved(std::size_t begin,
                                                                                std::size_t end) const {
    return guarded([&]() -> Outcome<Curved<K>> {
        Curved<K> rows{Buffer<typename GmfRuns<D, 2>::template Nodes<K>>(end - begin), Buffer<Reference>(end - begin)};
        const auto done = runs_.template simplices<K>(begin, rows.nodes, rows.references);
        if (after_rows_) after_rows_();
        if (!done) return fail(done.error());
        return rows;
    });
}
template <int D>
template <int K>
Outcome<SimplexRows<K>> QuadraticRows<D>::corners(std::size_t begin, std::size_t end) const {
    auto rows = curved<K>(begin, end);
    if (!rows) return fail(rows.error());
    return guarded([&]() -> Outcome<SimplexRows<K>> {
        Buffer<SimplexVertices<K>> vertices(end - begin);
        for (std::size_t i = 0; i < vertices.size(); ++i)
            std::copy_n(rows->nodes[i].begin(), K + 1, vertices[i].begin());
        return SimplexRows<K>{std::move(vertices), std::move(rows->references)};
    });
}
template <int D>
Outcome<SimplexRows<D>> QuadraticRows<D>::elements(std::size_t begin, std::size_t end) const {
    return corners<D>(begin, end);
}
template <int D>
Outcome<SimplexRows<D - 1>> QuadraticRows<D>::facets(std::size_t begin, std::size_t end) const {
    return corners<D - 1>(begin, end);
}
template <int D>
Outcome<SimplexRows<1>> QuadraticRows<D>::edges(std::size_t begin, std::size_t end) const {
    if constexpr (D == 3)
        return corners<1>(begin, end);
    else
        return SimplexRows<1>{};
}

template <int D>
template <int K>
Outcome<EdgeNodeRows<K>> QuadraticRows<D>::nodes_of(std::size_t begin, std::size_t end) const {
    const auto rows = curved<K>(begin, end);
    if (!rows) return fail(rows.error());
    return guarded([&]() -> Outcome<EdgeNodeRows<K>> {
        EdgeNodeRows<K> nodes(end - begin);
        for (std::size_t i = 0; i < nodes.size(); ++i)
            for (std::size_t k = 0; k < nodes[i].size(); ++k)
                nodes[i][k] = rows->nodes[i][K + 1 + k].index() - vertices_;
        return nodes;
    });
}

template <int D>
template <int K>
Outcome<Done> QuadraticRows<D>::look_through(std::size_t count, const Ranks& ranks, Ends& ends) const {
    const Run own = part_of({0, count}, ranks.rank(), ranks.size());
    const std::size_t chunks = own.size() / chunk_rows + 1;
    for (std::size_t c = 0; c < chunks; ++c) {
        const Run run = part_of(own, c, chunks);
        const auto rows = curved<K>(run.begin, run.end);
        if (!rows) return fail(rows.error());
        for (const auto& nodes : rows->nodes)
            for (std::size_t n = 0; n < nodes.size(); ++n) {
                const std::uint64_t number = nodes[n].index();
                if (n <= K)
                    ends.of_vertices = std::max(ends.of_vertices, number + 1);
                else
                    ends.of_nodes = std::min(ends.of_nodes, number);
            }
    }
    return Done{};
}

template <int D>
Outcome<Done> QuadraticRows<D>::find_vertices(std::string_view name, Ranks& ranks) {
    const GmfCounts counts = runs_.counts();
    Ends own{0, counts.points};
    auto looked = look_through<D>(counts.elements, ranks, own);
    if (looked) looked = look_through<D - 1>(counts.facets, ranks, own);
    if constexpr (D == 3)
        if (looked) looked = look_through<1>(counts.edges, ranks, own);
    Outcome<std::vector<Ends>> contribution = std::vector<Ends>{own};
    if (!looked) contribution = fail(looked.error());
    const auto all = gather_all(ranks, contribution);
    if (!all) return fail(all.error());
    for (const Ends& ends : *all) {
        own.of_vertices = std::max(own.of_vertices, ends.of_vertices);
        own.of_nodes = std::min(own.of_nodes, ends.of_nodes);
    }
    if (own.of_vertices > own.of_nodes)
        return fail(ErrorKind::unsupported,
                    "several ranks can read a mesh of degree 2 only if its vertices come before the nodes of its edges",
                    std::string(name), {}, "reorder it with camber convert on one rank");
    vertices_ = own.of_nodes;
    return Done{};
}

#define CAMBER_INSTANTIATE(D)                                                                        \
    template class QuadraticRows<D>;                                                                 \
    template Outcome<EdgeNodeRows<D>> QuadraticRows<D>::nodes_of<D>(std::size_t, std::size_t) const; \
    template Outcome<EdgeNodeRows<D - 1>> QuadraticRows<D>::nodes_of<D - 1>(std::size_t, std::size_t) const;

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
template Outcome<EdgeNodeRows<1>> QuadraticRows<3>::nodes_of<1>(std::size_t, std::size_t) const;
#undef CAMBER_INSTANTIATE

#define CAMBER_INSTANTIATE(D)                                                                          \
    template Outcome<std::unique_ptr<MeshRows<D>>> rows_of_gmf<D>(Column<std::byte>, std::string_view, \
                                                                  std::function<void()>);              \
    template std::unique_ptr<MeshRows<D>> rows_of<D>(LinearMesh<D>);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
