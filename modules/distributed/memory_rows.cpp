module;
#include <cstddef>
#include <memory>
#include <utility>
module camber.distributed;
import camber.core;
import :rows;

namespace camber {

namespace {

template <class T>
Buffer<T> run_of(const Column<T>& column, std::size_t begin, std::size_t end) {
    return Buffer<T>(column.begin() + begin, column.begin() + end);
}
template <int K>
SimplexRows<K> run_of(const Simplices<K>& simplices, std::size_t begin, std::size_t end) {
    return {run_of(simplices.vertices, begin, end), run_of(simplices.references, begin, end)};
}

template <int D>
class MemoryRows final : public MeshRows<D> {
  public:
    explicit MemoryRows(LinearMesh<D> mesh) : mesh_(std::move(mesh)) {}

    [[nodiscard]] RowCounts counts() const override {
        return {mesh_.points.size(), mesh_.elements.size(), mesh_.facets.size(), mesh_.edges.size()};
    }
    [[nodiscard]] Outcome<PointRows<D>> points(std::size_t begin, std::size_t end) const override {
        return PointRows<D>{run_of(mesh_.points, begin, end), run_of(mesh_.point_references, begin, end)};
    }
    [[nodiscard]] Outcome<SimplexRows<D>> elements(std::size_t begin, std::size_t end) const override {
        return run_of(mesh_.elements, begin, end);
    }
    [[nodiscard]] Outcome<SimplexRows<D - 1>> facets(std::size_t begin, std::size_t end) const override {
        return run_of(mesh_.facets, begin, end);
    }
    [[nodiscard]] Outcome<SimplexRows<1>> edges(std::size_t begin, std::size_t end) const override {
        return run_of(mesh_.edges, begin, end);
    }
    [[nodiscard]] Outcome<LinearMesh<D>> lists() const override {
        LinearMesh<D> lists;
        lists.corners = mesh_.corners;
        lists.required_vertices = mesh_.required_vertices;
        lists.elements.required = mesh_.elements.required;
        lists.facets.required = mesh_.facets.required;
        lists.facets.entities = mesh_.facets.entities;
        lists.edges.required = mesh_.edges.required;
        lists.ridges = mesh_.ridges;
        lists.geometry = mesh_.geometry;
        lists.groups = mesh_.groups;
        return lists;
    }

  private:
    LinearMesh<D> mesh_;
};

}  // namespace

template <int D>
std::unique_ptr<MeshRows<D>> rows_of(LinearMesh<D> mesh) {
    return std::make_unique<MemoryRows<D>>(std::move(mesh));
}
template std::unique_ptr<MeshRows<2>> rows_of<2>(LinearMesh<2>);
template std::unique_ptr<MeshRows<3>> rows_of<3>(LinearMesh<3>);

}  // namespace camber
