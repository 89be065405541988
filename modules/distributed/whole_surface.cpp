// Reads the whole boundary on each rank, and extends its displacement into the blocks.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.bezier;
import camber.extension;
import camber.metric;
import camber.edge_optimisation;
import camber.validity;
import camber.surface;
import camber.curving;
import camber.repair;
import camber.stages;

namespace camber {

namespace {

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
    template <class Row>
    [[nodiscard]] Column<Row> selected(const Column<Row>& rows, VertexId Row::* vertex) const {
        Buffer<Row> out;
        for (Row row : rows)
            if (const auto v = find((row.*vertex).value)) row.*vertex = *v, out.push_back(row);
        return out;
    }
    [[nodiscard]] Column<VertexId> selected(const Column<VertexId>& vertices) const {
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
InputGeometry<D> selected_geometry(const InputGeometry<D>& original, const SurfaceVertices& vertices) {
    return {{original.normals.table, vertices.selected(original.normals.at, &DirectionRow::vertex)},
            {original.tangents.table, vertices.selected(original.tangents.at, &DirectionRow::vertex)},
            vertices.selected(original.on_points, &Association<0>::item),
            vertices.selected(original.on_curves, &Association<1>::item),
            vertices.selected(original.on_surfaces, &Association<2>::item)};
}

template <int D>
Outcome<std::pair<LinearMesh<D>, std::vector<GlobalNumber>>> boundary_of(const MeshRows<D>& rows) {
    const RowCounts counts = rows.counts();
    auto lists = rows.lists();
    if (!lists) return fail(lists.error());
    if (!lists->elements.required.empty())
        return fail(ErrorKind::unsupported, "the mesh has required elements, which blocks do not support", {}, {},
                    "process the mesh as a whole, or make the facets and edges of these elements required");
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
    mesh.corners = vertices.selected(lists->corners);
    mesh.required_vertices = vertices.selected(lists->required_vertices);
    mesh.ridges = lists->ridges;
    mesh.geometry = selected_geometry(lists->geometry, vertices);
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

namespace {

template <int D>
CurveOptions edges_by(const BlockRun<D>& run) {
    CurveOptions edges = edge_options(run.options.curving.curve);
    static_cast<EdgeAccuracyOptions&>(edges) =
        accuracy_for(run.goal.metric ? MetricOrigin::specified : MetricOrigin::natural, edges);
    return edges;
}

template <int D>
Outcome<Done> take_boundary(const BlockRun<D>& run, PartState<D>& state, const RingedPart<D>& part) {
    const WholeSurface<D>& surface = run.by->surface;
    const auto& ends = state.mesh.edges.vertices;
    Buffer<EdgeKind> kinds(ends.size(), EdgeKind::volume);
    Buffer<EdgeId> on_surface(ends.size(), EdgeId{});
    state.base = straight_nodes(state.mesh);
    const std::vector<VertexId> vertices = surface.places_of(part.vertices.view());
    for (std::size_t e = 0; e < ends.size(); ++e) {
        const VertexId a = vertices[ends[e][0].index()], b = vertices[ends[e][1].index()];
        if (!a.valid() || !b.valid()) continue;
        const EdgeId at = find_edge(surface.mesh.edges, a, b);
        if (!at.valid()) continue;
        on_surface[e] = at;
        kinds[e] = surface.input.kinds[at];
        state.base[e] = surface.input.base[at];
    }
    state.kinds = std::move(kinds);
    state.on_surface = std::move(on_surface);
    return Done{};
}

template <int D>
Outcome<std::vector<Buffer<LagrangeNode<D>>>> extended_nodes(BlockRun<D>& run, Column<EdgeKind> PartState<D>::* kinds,
                                                             const Execution& execution) {
    std::vector<ExtensionPart<D, D>> parts;
    auto started =
        run.each_resident_part(without_progress(execution), [&](PartState<D>& state, RingedPart<D>&) -> Outcome<Done> {
            auto part = ExtensionPart<D, D>::make(elements_of(state.mesh), state.*kinds, state.base, state.shells,
                                                  state.owned, without_progress(execution));
            if (!part) return fail(part.error());
            parts.push_back(std::move(*part));
            return Done{};
        });
    if (!started) return fail(started.error());
    const auto solved = solve_extension(std::span(parts), *run.between, {}, execution);
    if (!solved) return fail(solved.error());
    run.out.iterations = std::max(run.out.iterations, static_cast<std::size_t>(solved->iterations));
    std::vector<Buffer<LagrangeNode<D>>> nodes;
    for (ExtensionPart<D, D>& part : parts) {
        auto of_part = std::move(part).nodes(without_progress(execution));
        if (!of_part) return fail(of_part.error());
        nodes.push_back(std::move(*of_part));
    }
    return nodes;
}

template <int D>
void take_base(const BlockRun<D>& run, PartState<D>& state) {
    for (std::size_t e = 0; e < state.base.size(); ++e)
        if (const EdgeId at = state.on_surface[e]; at.valid()) state.base[e] = run.by->surface.input.base[at];
}

template <int D>
Outcome<Done> take_base_on_all(BlockRun<D>& run, const Execution& execution) {
    return run.each_part(without_progress(execution), [&](PartState<D>& state, RingedPart<D>&) -> Outcome<Done> {
        take_base(run, state);
        return Done{};
    });
}

/// Moves the nodes of boundary parts without geometry together with the volume; see kinds_with_following.
template <int D>
Outcome<Done> follow_volume(BlockRun<D>& run, const Column<EdgeKind>& kinds, const Execution& execution) {
    WholeSurface<D>& surface = run.by->surface;
    const auto follows = [&](EdgeId at) { return at.valid() && kinds[at] != surface.input.kinds[at]; };
    for (PartState<D>& state : run.states) {
        Buffer<EdgeKind> of_part(state.kinds.begin(), state.kinds.end());
        for (std::size_t e = 0; e < of_part.size(); ++e)
            if (follows(state.on_surface[e])) of_part[e] = EdgeKind::volume;
        state.kinds_with_following = std::move(of_part);
    }
    const auto nodes = extended_nodes(run, &PartState<D>::kinds_with_following, execution);
    if (!nodes) return fail(nodes.error());
    Buffer<Vec<D>> places(surface.mesh.edges.size(), Vec<D>{});
    auto gathered = run.gather_on_surface(places, [&](std::size_t b, EdgeId e, EdgeId at) -> std::optional<Vec<D>> {
        return follows(at) ? std::optional((*nodes)[b][e.index()].point) : std::nullopt;
    });
    if (!gathered) return gathered;
    Buffer<LagrangeNode<D>> base = take(std::move(surface.input.base));
    for (std::size_t e = 0; e < base.size(); ++e)
        if (follows(EdgeId(e))) base[e] = {places[e]};
    surface.input.base = std::move(base);
    for (PartState<D>& state : run.states) state.kinds_with_following = {};
    return Done{};
}

template <int D>
Outcome<Done> extend_on_surface(BlockRun<D>& run, const Execution& execution) {
    WholeSurface<D>& surface = run.by->surface;
    const auto& [features, required, geometry] = surface.boundary;
    auto nodes = extend_over_faces(surface.mesh, surface.input.kinds, surface.input.base, features, geometry,
                                   part_of(execution, 0, 0.5));
    if (!nodes) return fail(nodes.error());
    surface.input.base = std::move(*nodes);
    if (auto taken = take_base_on_all(run, execution); !taken) return taken;
    const auto kinds =
        kinds_with_following(surface.mesh, surface.input.kinds, features, geometry, without_progress(execution));
    if (!kinds) return fail(kinds.error());
    if (*kinds == surface.input.kinds) return Done{};
    if (auto done = follow_volume(run, *kinds, part_of(execution, 0.5, 1)); !done) return done;
    return take_base_on_all(run, execution);
}

}  // namespace

template <int D>
Outcome<Done> find_surface(BlockRun<D>& run, const Execution& execution) {
    auto surface = whole_surface(run.rows, run.goal, part_of(execution, 0, 0.8));
    if (!surface) return fail(surface.error());
    run.by.emplace(CurvingContext<D>{std::move(*surface), edges_by(run)});
    return run.each_part(part_of(execution, 0.8, 1),
                         [&](PartState<D>& state, RingedPart<D>& part) { return take_boundary(run, state, part); });
}

template <int D>
Outcome<Done> extend_blocks(BlockRun<D>& run, const Execution& execution) {
    const auto straight = [&]() {
        const WholeSurface<D>& s = run.by->surface;
        for (std::size_t e = 0; e < s.mesh.edges.size(); ++e)
            if (s.input.kinds[e] != EdgeKind::volume && s.input.base[e] != s.mesh.mid_nodes[e]) return false;
        return true;
    };
    const auto release_base = [&] {
        for (PartState<D>& state : run.states) state.base = {};
    };
    if (straight()) return release_base(), Done{};
    if (auto done = extend_on_surface(run, part_of(execution, 0, 0.2)); !done) return done;
    if (run.options.curving.curve.back_mesh != BackMeshKind::curved) return release_base(), Done{};
    run.is_displaced = true;
    auto nodes = extended_nodes(run, &PartState<D>::kinds, part_of(execution, 0.2, 1));
    if (!nodes) return fail(nodes.error());
    std::vector<std::span<LagrangeNode<D>>> columns(nodes->begin(), nodes->end());
    if (auto updated = update_ghost_rows<LagrangeNode<D>>(run.edges, run.ranks, columns); !updated) return updated;
    for (std::size_t p = 0; p < run.states.size(); ++p) {
        run.states[p].extended = {run.states[p].mesh, (*nodes)[p]};
        (*nodes)[p] = {};
    }
    return release_base(), Done{};
}

#define CAMBER_INSTANTIATE(D)                                                                                       \
    template struct WholeSurface<D>;                                                                                \
    template Outcome<WholeSurface<D>> whole_surface<D>(const MeshRows<D>&, const BlocksGoal<D>&, const Execution&); \
    template Outcome<Done> find_surface<D>(BlockRun<D>&, const Execution&);                                         \
    template Outcome<Done> extend_blocks<D>(BlockRun<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
