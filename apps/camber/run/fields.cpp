module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.run;
import camber.core;
import camber.bezier;
import camber.io;
import camber.metric;
import camber.surface;
import camber.validity;
import camber.optimisation;
import camber.curving;
import :fields;
import :measures;
import :state;

namespace camber::run {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

template <int D>
MeshField element_field(const LinearMesh<D>& mesh, std::string name, const auto& values, auto rest) {
    using T = decltype(rest);
    Buffer<T> column(mesh.elements.size() + mesh.facets.size() + mesh.edges.size());
    for (std::size_t c = 0; c < column.size(); ++c) column[c] = c < values.size() ? static_cast<T>(values[c]) : rest;
    return {std::move(name), Centring::cell, FieldKind::scalar, Column<T>(std::move(column))};
}

/// A value an edge, and at each vertex the mean of the edges that count.
template <int D>
MeshField edge_field_with_means(const QuadraticMesh<D>& mesh, std::string name, std::span<const double> values,
                                const auto& counts) {
    const std::size_t vertices = mesh.linear.points.size();
    Buffer<double> column(vertices + values.size());
    std::fill(column.begin(), column.begin() + static_cast<std::ptrdiff_t>(vertices), 0.0);
    std::vector<std::uint32_t> around(vertices);
    for (std::size_t e = 0; e < values.size(); ++e) {
        column[vertices + e] = values[e];
        if (!counts(e)) continue;
        for (const VertexId v : mesh.edges.vertices[e]) {
            column[v.index()] += values[e];
            ++around[v.index()];
        }
    }
    for (std::size_t v = 0; v < vertices; ++v)
        if (around[v] > 0) column[v] /= around[v];
    return {std::move(name), Centring::node, FieldKind::scalar, Column<double>(std::move(column))};
}

template <int D>
MeshField node_kinds(const QuadraticMesh<D>& mesh, const Features<D>& features) {
    const std::size_t vertices = mesh.linear.points.size();
    Buffer<std::int32_t> column(vertices + mesh.edges.size());
    for (std::size_t v = 0; v < vertices; ++v) column[v] = static_cast<std::int32_t>(features.vertex_kinds[v]);
    for (std::size_t e = 0; e < mesh.edges.size(); ++e)
        column[vertices + e] = static_cast<std::int32_t>(features.edge_kinds[e]);
    return {"node_kind", Centring::node, FieldKind::scalar, Column<std::int32_t>(std::move(column))};
}

template <int D>
MeshField edge_changes(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal) {
    const std::size_t vertices = mesh.linear.points.size();
    Buffer<std::int32_t> column(vertices + mesh.edges.size());
    for (std::size_t n = 0; n < column.size(); ++n)
        column[n] = n < vertices ? -1 : static_cast<std::int32_t>(proposal.changes[n - vertices]);
    return {"edge_change", Centring::node, FieldKind::scalar, Column<std::int32_t>(std::move(column))};
}

template <int D>
double distance_from(const Geometry<D>& geometry, const LinearMesh<D>& mesh, std::span<const FacetId> facets,
                     const Vec<D>& p) {
    return facets.empty() ? nan : geometry->distance_where(facet_sites(mesh, facets), p);
}

template <int D>
Outcome<MeshField> distances(const QuadraticMesh<D>& mesh, const Geometry<D>& geometry, const Execution& execution) {
    const Execution quiet = without_progress(execution);
    auto at_vertices = facet_balls(mesh.linear, quiet);
    if (!at_vertices) return fail(std::move(at_vertices.error()));
    auto at_edges = facet_shells(mesh.edges, quiet);
    if (!at_edges) return fail(std::move(at_edges.error()));
    const std::size_t vertices = mesh.linear.points.size();
    auto column = map_each(
        execution, vertices + mesh.edges.size(),
        [&](std::size_t n) {
            const bool vertex = n < vertices;
            return distance_from(geometry, mesh.linear, vertex ? (*at_vertices)[n] : (*at_edges)[n - vertices],
                                 vertex ? mesh.linear.points[n] : mesh.mid_nodes[n - vertices].point);
        },
        64);
    if (!column) return fail(std::move(column.error()));
    return MeshField{"distance_to_geometry", Centring::node, FieldKind::scalar, Column<double>(std::move(*column))};
}

template <int D>
Outcome<MeshField> metrics(const QuadraticMesh<D>& mesh, const BackMesh<D>& back, const Incidence<ElementId>& shells,
                           const Execution& execution) {
    const std::size_t vertices = mesh.linear.points.size();
    Buffer<double> column((vertices + mesh.edges.size()) * sym_size<D>);
    auto done = each(execution, vertices + mesh.edges.size(), [&](std::size_t n) {
        LogMetric<D> log_metric;
        if (n < vertices) {
            log_metric = back->vertex(VertexId(n)).log_metric;
        } else {
            const std::size_t e = n - vertices;
            const auto& [a, b] = mesh.edges.vertices[e];
            // An edge that no element holds lies in no field: its ends' mean.
            log_metric = shells[e].empty()
                             ? LogMetric<D>{0.5 * (back->vertex(a).log_metric.l + back->vertex(b).log_metric.l)}
                             : sample_value(back, mesh.mid_nodes[e].point, shells[e][0]).log_metric;
        }
        const Sym<D> m = exp(log_metric).m;
        std::copy(m.c.begin(), m.c.end(), column.begin() + static_cast<std::ptrdiff_t>(n * sym_size<D>));
    });
    if (!done) return fail(std::move(done.error()));
    return MeshField{"metric", Centring::node, FieldKind::symmetric_tensor, Column<double>(std::move(column))};
}

}  // namespace

template <int D>
Outcome<MeshFields> mesh_fields(const Quadratic<D>& end, const BackMesh<D>* field,
                                const std::optional<EdgeLengths>& lengths, const Execution& execution) {
    const QuadraticMesh<D>& mesh = end.mesh;
    const Plan<D>* const plan = end.planned();
    MeshFields fields;
    if (const Validation<D>* validation = end.validation())
        fields = std::move(fields)
                     .with(element_field(mesh.linear, "scaled_jacobian", validation->min_scaled_jacobian, nan))
                     .with(element_field(mesh.linear, "verdict", validation->verdicts, std::int32_t{-1}));
    if (plan) fields = std::move(fields).with(node_kinds(mesh, plan->features()));
    fields = std::move(fields).with(edge_field_with_means(mesh, "curvature", curvatures<D>(mesh, mesh.mid_nodes.view()),
                                                          [](std::size_t) { return true; }));
    if (plan) fields = std::move(fields).with(edge_changes(mesh, plan->proposal()));
    if (plan && lengths && !is_surface_alone(mesh.linear))
        fields = std::move(fields).with(
            edge_field_with_means(mesh, "length_reduction", length_reductions(lengths->straight, lengths->curved),
                                  [&](std::size_t e) { return plan->proposal().kinds[e] == EdgeKind::volume; }));
    const Wanted<D>* const wanted = plan ? plan->wanted() : nullptr;
    if (wanted) {
        auto made = distances(mesh, wanted->boundary.geometry, part_of(execution, 0, 0.1));
        if (!made) return fail(std::move(made.error()));
        fields = std::move(fields).with(std::move(*made));
    }
    if (wanted && field) {
        auto made = metrics(mesh, *field, wanted->shells, part_of(execution, 0.1, 1));
        if (!made) return fail(std::move(made.error()));
        fields = std::move(fields).with(std::move(*made));
    }
    return fields;
}

template <int D>
Outcome<Solution> metric_solution(const Column<LogMetric<D>>& log_metrics, const Execution& execution) {
    constexpr std::size_t width = D * (D + 1) / 2;
    const std::size_t vertices = log_metrics.size();
    Buffer<double> values(vertices * width);
    auto done = each(execution, vertices, [&](std::size_t v) {
        const Sym<D> m = exp(log_metrics[v]).m;
        std::copy(m.c.begin(), m.c.end(), values.begin() + static_cast<std::ptrdiff_t>(v * width));
    });
    if (!done) return fail(std::move(done.error()));
    return Solution{D, {FieldKind::symmetric_tensor}, vertices, std::move(values)};
}

template <int D>
Outcome<Solution> metric_solution(const BackMesh<D>& field, const Execution& execution) {
    auto logs = map_each(execution, field->vertex_count(),
                         [&](std::size_t v) { return field->vertex(VertexId(v)).log_metric; });
    if (!logs) return fail(std::move(logs.error()));
    return metric_solution<D>(Column<LogMetric<D>>(std::move(*logs)), execution);
}

template <int D>
Outcome<Solution> metric_solution(const BackMesh<D>& field, const QuadraticMesh<D>& mesh, const Execution& execution) {
    const std::size_t vertices = mesh.linear.points.size();
    return guarded([&]() -> Outcome<Solution> {
        Buffer<LogMetric<D>> logs(vertices + mesh.edges.size());
        auto done = each_chunk(execution, logs.size(), [&](std::size_t begin, std::size_t end) {
            ElementId hint;
            for (std::size_t n = begin; n < end; ++n) {
                const Vec<D>& p = n < vertices ? mesh.linear.points[n] : mesh.mid_nodes[n - vertices].point;
                const FieldSample<D> sample = sample_value(field, p, hint);
                hint = sample.location.element;
                logs[n] = sample.log_metric;
            }
        });
        if (!done) return fail(std::move(done.error()));
        return metric_solution<D>(Column<LogMetric<D>>(std::move(logs)), execution);
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                     \
    template Outcome<Solution> metric_solution<D>(const BackMesh<D>&, const QuadraticMesh<D>&, const Execution&); \
    template Outcome<Solution> metric_solution<D>(const BackMesh<D>&, const Execution&);                          \
    template Outcome<Solution> metric_solution<D>(const Column<LogMetric<D>>&, const Execution&);                 \
    template Outcome<MeshFields> mesh_fields<D>(const Quadratic<D>&, const BackMesh<D>*,                          \
                                                const std::optional<EdgeLengths>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
