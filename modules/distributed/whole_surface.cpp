module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.bezier;
import camber.recipes;
import :ringed_parts;
import :curve_blocks;
import :rows;
import :whole_surface;

namespace camber {

namespace {

/// Vertices that the boundary has, as they are numbered in the whole mesh, and their places in the surface.
class SurfaceVertices {
  public:
    explicit SurfaceVertices(std::vector<GlobalNumber> all) : all_(std::move(all)) {
        std::ranges::sort(all_);
        all_.erase(std::ranges::unique(all_).begin(), all_.end());
    }
    [[nodiscard]] const std::vector<GlobalNumber>& all() const { return all_; }
    [[nodiscard]] std::optional<VertexId> find(GlobalNumber v) const {
        const auto at = std::ranges::lower_bound(all_, v);
        if (at == all_.end() || *at != v) return std::nullopt;
        return VertexId(at - all_.begin());
    }
    template <std::size_t N>
    [[nodiscard]] std::array<VertexId, N> of(std::array<VertexId, N> simplex) const {
        for (VertexId& v : simplex) v = *find(v.value);
        return simplex;
    }
    /// Rows about vertices that are here: vertex_of(row) is its vertex.
    template <class Row>
    [[nodiscard]] Column<Row> kept(const Column<Row>& rows, VertexId Row::* vertex) const {
        Buffer<Row> out;
        for (Row row : rows)
            if (const auto v = find((row.*vertex).value)) row.*vertex = *v, out.push_back(row);
        return out;
    }
    [[nodiscard]] Column<VertexId> kept(const Column<VertexId>& vertices) const {
        Buffer<VertexId> out;
        for (const VertexId v : vertices)
            if (const auto at = find(v.value)) out.push_back(*at);
        return out;
    }

  private:
    std::vector<GlobalNumber> all_;
};

template <std::size_t N>
void add_vertices(std::span<const std::array<VertexId, N>> simplices, std::vector<GlobalNumber>& vertices) {
    for (const auto& simplex : simplices)
        for (const VertexId v : simplex) vertices.push_back(v.value);
}

template <int K>
Simplices<K> with_places(SimplexRows<K> rows, const Simplices<K>& lists, const SurfaceVertices& vertices) {
    for (auto& simplex : rows.vertices) simplex = vertices.of(simplex);
    return {std::move(rows.vertices), std::move(rows.references), lists.required, lists.entities};
}

/// The points, read a chunk at a time: they are few among all.
template <int D>
Outcome<Done> read_points(const MeshRows<D>& rows, std::span<const GlobalNumber> vertices, LinearMesh<D>& mesh) {
    constexpr std::size_t chunk = std::size_t{1} << 18U;
    Buffer<Vec<D>> points(vertices.size());
    Buffer<Reference> references(vertices.size());
    const std::size_t n = rows.counts().points;
    std::size_t next = 0;
    for (std::size_t begin = 0; begin < n && next < vertices.size(); begin += chunk) {
        const std::size_t end = std::min(begin + chunk, n);
        if (vertices[next] >= end) continue;
        const auto some = rows.points(begin, end);
        if (!some) return fail(some.error());
        for (; next < vertices.size() && vertices[next] < end; ++next) {
            points[next] = some->points[vertices[next] - begin];
            references[next] = some->references[vertices[next] - begin];
        }
    }
    mesh.points = std::move(points);
    mesh.point_references = std::move(references);
    return Done{};
}

template <int D>
GivenGeometry<D> kept_geometry(const GivenGeometry<D>& given, const SurfaceVertices& vertices) {
    return {{given.normals.table, vertices.kept(given.normals.at, &DirectionRow::vertex)},
            {given.tangents.table, vertices.kept(given.tangents.at, &DirectionRow::vertex)},
            vertices.kept(given.on_points, &Association<0>::item),
            vertices.kept(given.on_curves, &Association<1>::item),
            vertices.kept(given.on_surfaces, &Association<2>::item)};
}

/// Facets, feature edges and what is listed, without elements.
template <int D>
Outcome<std::pair<LinearMesh<D>, std::vector<GlobalNumber>>> boundary_of(const MeshRows<D>& rows) {
    const RowCounts counts = rows.counts();
    auto lists = rows.lists();
    if (!lists) return fail(lists.error());
    if (!lists->elements.required.empty())
        return fail(ErrorKind::unsupported, "the mesh has required elements, which are not known by blocks", {}, {},
                    "take it as a whole, or require the facets and edges themselves");
    auto facets = rows.facets(0, counts.facets);
    if (!facets) return fail(facets.error());
    auto edges = rows.edges(0, counts.edges);
    if (!edges) return fail(edges.error());
    std::vector<GlobalNumber> all;
    add_vertices<D>(facets->vertices, all);
    add_vertices<2>(edges->vertices, all);
    const SurfaceVertices vertices(std::move(all));
    LinearMesh<D> mesh;
    mesh.facets = with_places<D - 1>(std::move(*facets), lists->facets, vertices);
    mesh.edges = with_places<1>(std::move(*edges), lists->edges, vertices);
    mesh.corners = vertices.kept(lists->corners);
    mesh.required_vertices = vertices.kept(lists->required_vertices);
    mesh.ridges = lists->ridges;
    mesh.geometry = kept_geometry(lists->geometry, vertices);
    mesh.groups = lists->groups;
    if (auto read = read_points(rows, vertices.all(), mesh); !read) return fail(read.error());
    return std::pair(std::move(mesh), vertices.all());
}

}  // namespace

template <int D>
std::vector<VertexId> WholeSurface<D>::places_of(std::span<const GlobalNumber> numbers) const {
    std::vector<VertexId> places(numbers.size());
    auto at = numbers.empty() ? vertices.begin() : std::ranges::lower_bound(vertices, numbers.front());
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        while (at != vertices.end() && *at < numbers[i]) ++at;
        if (at != vertices.end() && *at == numbers[i]) places[i] = VertexId(at - vertices.begin());
    }
    return places;
}

template <int D>
EdgeId WholeSurface<D>::find(GlobalNumber a, GlobalNumber b) const {
    const auto first = std::ranges::lower_bound(vertices, a), second = std::ranges::lower_bound(vertices, b);
    if (first == vertices.end() || *first != a || second == vertices.end() || *second != b) return EdgeId{};
    return find_edge(mesh.edges, VertexId(first - vertices.begin()), VertexId(second - vertices.begin()));
}

template <int D>
Outcome<WholeSurface<D>> whole_surface(const MeshRows<D>& rows, const BlocksGoal<D>& goal, const Execution& execution) {
    return guarded([&]() -> Outcome<WholeSurface<D>> {
        auto linear = boundary_of(rows);
        if (!linear) return fail(linear.error());
        auto mesh = elevate(std::move(linear->first), part_of(execution, 0, 0.1));
        if (!mesh) return fail(mesh.error());
        const Execution of_boundary = part_of(execution, 0.1, 0.8);
        auto boundary = goal.boundary ? goal.boundary(mesh->linear, mesh->edges, of_boundary)
                                      : find_boundary<D>(mesh->linear, mesh->edges, {}, {}, of_boundary);
        if (!boundary) return fail(boundary.error());
        auto input = curve_input(CurvedFrom<D>{*mesh, NodesOf::elevation, *boundary}, part_of(execution, 0.8, 1));
        if (!input) return fail(input.error());
        return WholeSurface<D>{std::move(*mesh), std::move(linear->second), std::move(*boundary), std::move(*input)};
    });
}

#define CAMBER_INSTANTIATE(D)        \
    template struct WholeSurface<D>; \
    template Outcome<WholeSurface<D>> whole_surface<D>(const MeshRows<D>&, const BlocksGoal<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
