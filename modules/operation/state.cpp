// Start and end of an adaptation, and statistics of a unit mesh.
module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>
module camber.operation;
import camber.core;
import camber.cavity;
import camber.metric;
import camber.validity;
import camber.crossing;
import camber.surface;

namespace camber {

namespace {

struct Placed {
    GeometryPosition place;
    bool off_geometry = false;
};
template <int D>
Placed placed(const AdaptationGoal<D>& goal, const DynamicMesh<D>& mesh, VertexId v, Cavity<D>& ball) {
    if (mesh.states[v].place == VertexPlace::inside || mesh.is_at_infinity(v) || mesh.is_free(v)) return {};
    cavity_of_vertex(mesh, v, ball);
    if (ball.facets.empty() && ball.lines.empty()) return {};
    if (mesh.states[v].place == VertexPlace::corner) {
        if (ball.facets.empty()) return {};
        std::vector<FacetSite<D>> sites;
        sites.reserve(ball.facets.size());
        for (const FacetId f : ball.facets)
            if (!mesh.is_at_infinity(f)) sites.push_back(site_of(mesh, f));
        return {{(*goal.geometry)->entity_at_vertex(sites)}};
    }
    const auto foot = foot_of(goal, mesh, ball, v, {});
    if (!foot) return {};
    const bool off_geometry = !is_at_foot(mesh, ball, mesh.points[v], foot->point);
    return {off_geometry ? GeometryPosition{foot->entity} : place_of(*foot), off_geometry};
}

template <int D>
Outcome<Done> place_boundary(Adaptation<D>& r, const AdaptationGoal<D>& goal, const Execution& execution) {
    Buffer<GeometryPosition> places(r.mesh.points.size());
    Buffer<std::uint8_t> is_off(places.size(), 0);
    auto done = each_chunk(execution, places.size(), [&](std::size_t begin, std::size_t end) {
        Cavity<D> ball;
        for (std::size_t v = begin; v < end; ++v) {
            const Placed found = placed(goal, r.mesh, VertexId(v), ball);
            places[v] = found.place;
            is_off[v] = found.off_geometry ? 1 : 0;
        }
    });
    if (!done) return done;
    Buffer<VertexId> off_geometry;
    for (std::size_t v = 0; v < is_off.size(); ++v)
        if (is_off[v] != 0) off_geometry.push_back(VertexId(v));
    r.vertices.places = std::move(places);
    r.off_geometry = std::move(off_geometry);
    return Done{};
}

template <int D>
Outcome<Done> sample_at_vertices(Adaptation<D>& r, const AdaptationGoal<D>& goal, const Execution& execution) {
    const std::size_t n = r.mesh.points.size();
    Buffer<VertexMetric<D>> metrics(n);
    Buffer<LogGradient<D>> gradients(r.mesh.is_curved() ? n : 0);
    // If the field's mesh is this mesh, each search starts at an element of the vertex. Otherwise, it starts at the
    // last element found.
    auto sampled = each_chunk(execution, n, [&](std::size_t begin, std::size_t end) {
        ElementId hint;
        bool is_on_mesh = true;
        for (std::size_t v = begin; v < end; ++v) {
            const Vec<D>& p = r.mesh.points[v];
            if (is_on_mesh && r.mesh.element_of[v].valid()) hint = r.mesh.element_of[v];
            const FieldSample<D> sample = gradients.empty() ? sample_value(goal.field, p, hint)
                                                            : sample_with_recovered_gradient(goal.field, p, hint);
            hint = sample.location.element;
            is_on_mesh = is_on_mesh && std::ranges::max(sample.location.xi) == 1;
            metrics[v] = VertexMetric<D>(sample.log_metric, hint);
            if (!gradients.empty()) gradients[v] = sample.gradient;
        }
    });
    r.vertices.metrics = std::move(metrics);
    r.vertices.gradients = std::move(gradients);
    return sampled;
}

template <int D, class Make>
Outcome<Adaptation<D>> start_adaptation(const LinearMesh<D>& mesh, const AdaptationGoal<D>& goal,
                                        const Execution& execution, Make&& make) {
    if (mesh.elements.size() == 0 && !is_standalone_surface(mesh))
        return fail(ErrorKind::input, std::string("the mesh has no ") +
                                          (D == 2 ? "triangles" : "tetrahedra or triangles") +
                                          ": there is nothing to remesh");
    auto result = make();
    if (!result) return fail(result.error());
    return guarded([&]() -> Outcome<Adaptation<D>> {
        Adaptation<D> r;
        r.mesh = std::move(*result);
        r.walls = facet_grid_of(r.mesh);
        if (auto sampled = sample_at_vertices(r, goal, execution); !sampled) return fail(sampled.error());
        if (auto done = measure_lengths(r, without_progress(execution)); !done) return fail(done.error());
        if (goal.geometry)
            if (auto done = place_boundary(r, goal, without_progress(execution)); !done) return fail(done.error());
        return r;
    });
}

}  // namespace

template <int D>
Outcome<Done> measure_lengths(Adaptation<D>& r, const Execution& execution) {
    if (!r.mesh.is_curved()) return Done{};
    return guarded([&] {
        Buffer<double> lengths(r.mesh.edges.size());
        auto done = each(execution, lengths.size(), [&](std::size_t e) {
            lengths[e] = r.mesh.is_free(EdgeId(e)) ? 0 : measured_length(r, EdgeId(e));
        });
        r.lengths = std::move(lengths);
        return done;
    });
}

template <int D>
Outcome<Adaptation<D>> begin_adaptation(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const BreaksOfMesh& breaks,
                                        const AdaptationGoal<D>& goal, const Execution& execution) {
    return start_adaptation<D>(mesh, goal, execution, [&] {
        if constexpr (D == 3)
            if (is_standalone_surface(mesh)) return make_dynamic_surface(mesh, edges, breaks, execution);
        return make_dynamic(mesh, edges, breaks, execution);
    });
}

template <int D>
Outcome<Adaptation<D>> begin_adaptation(const QuadraticMesh<D>& mesh, const BreaksOfMesh& breaks,
                                        const AdaptationGoal<D>& goal, const Execution& execution) {
    if (is_standalone_surface(mesh.linear))
        return fail(ErrorKind::unsupported, "a curved standalone surface mesh cannot be remeshed directly", {}, {},
                    "straighten it (camber convert --straighten), remesh the straight mesh with the curved one as the "
                    "geometry (--geometry '{\"mesh\": \"CURVED\"}'), and curve the result");
    return start_adaptation<D>(mesh.linear, goal, execution, [&] { return make_dynamic(mesh, breaks, execution); });
}

template <int D>
Outcome<UnitMeshStatistics> unit_mesh_statistics(const Adaptation<D>& r, const Execution& execution) {
    const auto add = [](UnitMeshStatistics a, const UnitMeshStatistics& b) {
        if (b.edges > 0) {
            a.shortest = a.edges > 0 ? std::min(a.shortest, b.shortest) : b.shortest;
            a.longest = std::max(a.longest, b.longest);
        }
        a.edges += b.edges;
        a.unit_edges += b.unit_edges;
        a.elements += b.elements;
        a.mean_length += b.mean_length;
        a.worst_quality = std::min(a.worst_quality, b.worst_quality);
        a.mean_quality += b.mean_quality;
        return a;
    };
    const auto edges = reduce_each(
        execution, r.mesh.edges.size(), UnitMeshStatistics{},
        [&](UnitMeshStatistics& s, std::size_t e) {
            if (r.mesh.is_free(EdgeId(e)) || r.mesh.is_at_infinity(EdgeId(e))) return;
            const double length = length_of(r, EdgeId(e));
            s.shortest = s.edges > 0 ? std::min(s.shortest, length) : length;
            s.longest = std::max(s.longest, length);
            ++s.edges;
            s.unit_edges += length >= shortest_unit_edge && length <= longest_unit_edge ? 1 : 0;
            s.mean_length += length;
        },
        add);
    if (!edges) return fail(edges.error());
    const auto elements = reduce_each(
        execution, r.mesh.elements.size(), UnitMeshStatistics{},
        [&](UnitMeshStatistics& s, std::size_t e) {
            if (r.mesh.is_free(ElementId(e))) return;
            const double quality = quality_of_shape(cached_shape_of(r, ElementId(e)), D);
            ++s.elements;
            s.worst_quality = std::min(s.worst_quality, quality);
            s.mean_quality += quality;
        },
        add);
    if (!elements) return fail(elements.error());
    UnitMeshStatistics all = add(*edges, *elements);
    if (all.edges > 0) all.mean_length /= static_cast<double>(all.edges);
    if (all.elements > 0) all.mean_quality /= static_cast<double>(all.elements);
    return all;
}

namespace {

template <int D>
DynamicMesh<D> with_breaks_listed(DynamicMesh<D> mesh) {
    Buffer<Marks> lines = take(std::move(mesh.line_marks));
    for (Marks& marks : lines)
        if (!marks.has(Mark::embedded))
            marks = marks.has(Mark::required) ? Mark::ridge | Marks(Mark::required) : Mark::ridge;
    mesh.line_marks = std::move(lines);
    Buffer<VertexState> states = take(std::move(mesh.states));
    for (VertexState& state : states)
        if (state.place == VertexPlace::corner) state.marks |= Mark::corner;
    mesh.states = std::move(states);
    return mesh;
}

}  // namespace

template <int D>
Outcome<FinishedMesh<D>> finished(const Adaptation<D>& r, const Execution& execution) {
    return guarded([&]() -> Outcome<FinishedMesh<D>> {
        auto compact = compacted(with_breaks_listed(r.mesh), execution);
        if (!compact) return fail(compact.error());
        Buffer<LogMetric<D>> logs(compact->mesh.points.size());
        Buffer<GeometryPosition> places(r.vertices.places.empty() ? 0 : logs.size());
        const auto& map = compact->maps.vertices;
        for (std::size_t v = 0; v < r.vertices.metrics.size(); ++v)
            if (const VertexId to = map[VertexId(v)]; to.valid()) {
                logs[to.index()] = r.vertices.metrics[v].log_metric;
                if (!places.empty()) places[to.index()] = r.vertices.places[v];
            }
        return FinishedMesh<D>{std::move(*compact), std::move(logs), std::move(places)};
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template Outcome<Adaptation<D>> begin_adaptation<D>(const LinearMesh<D>&, const EdgeSet<D>&, const BreaksOfMesh&, \
                                                        const AdaptationGoal<D>&, const Execution&);                  \
    template Outcome<Adaptation<D>> begin_adaptation<D>(const QuadraticMesh<D>&, const BreaksOfMesh&,                 \
                                                        const AdaptationGoal<D>&, const Execution&);                  \
    template Outcome<Done> measure_lengths<D>(Adaptation<D>&, const Execution&);                                      \
    template Outcome<UnitMeshStatistics> unit_mesh_statistics<D>(const Adaptation<D>&, const Execution&);             \
    template Outcome<FinishedMesh<D>> finished<D>(const Adaptation<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
