module;
#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <utility>
module camber.solution_metric;
import camber.core;
import camber.metric;

namespace camber {

namespace {

bool is_length(double size) { return size >= min_length && size <= max_length; }

/// visit(v) for the vertices of all simplices with the reference; how many simplices there are.
std::size_t each_vertex_of(const auto& simplices, Reference reference, const auto& visit) {
    std::size_t found = 0;
    for (std::size_t s = 0; s < simplices.size(); ++s) {
        if (simplices.references[s] != reference) continue;
        ++found;
        for (const VertexId v : simplices.vertices[s]) visit(v);
    }
    return found;
}

template <int D>
std::size_t each_vertex_of(const LinearMesh<D>& mesh, ReferencesOf of, Reference reference, const auto& visit) {
    if (of == ReferencesOf::elements) return each_vertex_of(mesh.elements, reference, visit);
    // Of a plane mesh the boundary's edges are its facets.
    if (of == ReferencesOf::facets || (D == 2 && of == ReferencesOf::edges))
        return each_vertex_of(mesh.facets, reference, visit);
    if (of == ReferencesOf::edges) return each_vertex_of(mesh.edges, reference, visit);
    std::size_t found = 0;
    for (std::size_t v = 0; v < mesh.point_references.size(); ++v)
        if (mesh.point_references[v] == reference) {
            ++found;
            visit(VertexId(v));
        }
    return found;
}

template <int D>
Outcome<Done> check(const LinearMesh<D>& mesh, std::span<const MetricsAtVertices<D>> at_some,
                    std::span<const Column<LogMetric<D>>> at_all, double largest, const Execution& execution) {
    if (!is_length(largest)) return fail(ErrorKind::usage, "the largest size must be positive and finite");
    for (const auto& metrics : at_some) {
        const bool fits = metrics.vertices.size() == metrics.log_metrics.size() &&
                          std::all_of(metrics.vertices.begin(), metrics.vertices.end(),
                                      [&](VertexId v) { return v.index() < mesh.points.size(); });
        if (!fits) return fail(ErrorKind::usage, "metrics at vertices are of another mesh");
        if (auto sound = check_sizes(metrics.log_metrics, execution); !sound) return sound;
    }
    for (const auto& metric : at_all) {
        if (metric.size() != mesh.points.size()) return fail(ErrorKind::usage, "the metric is of another mesh");
        if (auto sound = check_sizes(metric, execution); !sound) return sound;
    }
    return Done{};
}

}  // namespace

template <int D>
Outcome<MetricsAtVertices<D>> sizes_by_reference(const LinearMesh<D>& mesh, std::span<const ReferenceSize> sizes) {
    return guarded([&]() -> Outcome<MetricsAtVertices<D>> {
        constexpr double none = std::numeric_limits<double>::infinity();
        Buffer<double> least(mesh.points.size(), none);
        for (const ReferenceSize& asked : sizes) {
            if (!is_length(asked.size))
                return fail(ErrorKind::usage,
                            "a size of " + std::to_string(asked.size) + " by reference is not between 1e-60 and 1e60");
            const auto lower = [&](VertexId v) { least[v.index()] = std::min(least[v.index()], asked.size); };
            for (const Reference reference : asked.references)
                if (each_vertex_of(mesh, asked.of, reference, lower) == 0)
                    return fail(ErrorKind::usage,
                                "none of the mesh's " + std::string(word_of(asked.of)) + " has the reference " +
                                    std::to_string(reference),
                                {}, {}, "see which references the mesh has: camber info");
        }
        Buffer<VertexId> vertices;
        Buffer<LogMetric<D>> logs;
        for (std::size_t v = 0; v < least.size(); ++v) {
            if (least[v] == none) continue;
            vertices.push_back(VertexId(v));
            logs.push_back({-2 * log(least[v]) * Sym<D>::identity()});
        }
        return MetricsAtVertices<D>{std::move(vertices), std::move(logs)};
    });
}

template <int D>
Outcome<Column<LogMetric<D>>> fixed_metric(const LinearMesh<D>& mesh, std::span<const MetricsAtVertices<D>> at_some,
                                           std::span<const Column<LogMetric<D>>> at_all, double largest,
                                           const Execution& execution) {
    if (auto sound = check(mesh, at_some, at_all, largest, without_progress(execution)); !sound)
        return fail(sound.error());
    return guarded([&]() -> Outcome<Column<LogMetric<D>>> {
        Buffer<LogMetric<D>> whole(mesh.points.size(), LogMetric<D>{-2 * log(largest) * Sym<D>::identity()});
        for (const auto& metrics : at_some)
            for (std::size_t i = 0; i < metrics.vertices.size(); ++i) {
                LogMetric<D>& here = whole[metrics.vertices[i].index()];
                here = intersection(here, metrics.log_metrics[i]);
            }
        Column<LogMetric<D>> out(std::move(whole));
        for (const auto& metric : at_all) {
            auto both = intersection(out, metric, execution);
            if (!both) return fail(both.error());
            out = std::move(*both);
        }
        return out;
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                       \
    template Outcome<MetricsAtVertices<D>> sizes_by_reference<D>(const LinearMesh<D>&,                              \
                                                                 std::span<const ReferenceSize>);                   \
    template Outcome<Column<LogMetric<D>>> fixed_metric<D>(                                                         \
        const LinearMesh<D>&, std::span<const MetricsAtVertices<D>>, std::span<const Column<LogMetric<D>>>, double, \
        const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
