module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
module camber.run;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;
import :histogram;
import :report;
import :rows;
import :unit_mesh;

namespace camber::run {

namespace {

double mean_of(const std::vector<double>& values) {
    return values.empty() ? 0 : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Of elements in the metrics `of(vertex)`; of a surface alone of its triangles.
template <int D>
Outcome<Buffer<double>> straight_qualities(const LinearMesh<D>& mesh, const auto& of, const Execution& execution) {
    const auto quality = [&](const auto& vertices, auto&& measure) {
        std::array<Vec<D>, std::tuple_size_v<std::remove_cvref_t<decltype(vertices)>>> corners;
        std::array<const MeasuringMetric<D>*, corners.size()> at{};
        for (std::size_t i = 0; i < corners.size(); ++i) {
            corners[i] = mesh.points[vertices[i]];
            at[i] = &of(vertices[i]);
        }
        return measure(corners, at);
    };
    if constexpr (D == 3)
        if (is_surface_alone(mesh))
            return map_each(execution, mesh.facets.size(), [&](std::size_t f) {
                return quality(mesh.facets.vertices[f], [](const auto& corners, const auto& at) {
                    return quality_of_shape(triangle_shape(corners, at), 3);
                });
            });
    return map_each(execution, mesh.elements.size(), [&](std::size_t e) {
        return quality(mesh.elements.vertices[e],
                       [](const auto& corners, const auto& at) { return metric_quality<D>(corners, at); });
    });
}

}  // namespace

UnitMeshReport unit_mesh_report(std::string metric, const std::vector<double>& lengths,
                                const std::vector<double>& qualities) {
    UnitMeshReport report{.metric = std::move(metric), .edges = lengths.size()};
    const auto count = [&](auto&& chosen) {
        return static_cast<std::size_t>(std::count_if(lengths.begin(), lengths.end(), chosen));
    };
    report.short_edges = count([](double l) { return l < shortest_unit_edge; });
    report.long_edges = count([](double l) { return l > longest_unit_edge; });
    report.unit_edges = count([](double l) { return l >= shortest_unit_edge && l <= longest_unit_edge; });
    if (!lengths.empty()) {
        const auto [least, greatest] = std::minmax_element(lengths.begin(), lengths.end());
        report.shortest = *least;
        report.longest = *greatest;
    }
    report.mean_length = mean_of(lengths);
    report.mean_quality = mean_of(qualities);
    if (!qualities.empty()) {
        const auto worst = std::min_element(qualities.begin(), qualities.end());
        report.worst_quality = *worst;
        report.worst_element = static_cast<std::size_t>(worst - qualities.begin()) + 1;
    }
    return report;
}

template <int D>
Outcome<UnitMesh> measure_unit_mesh(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                    const Column<LogMetric<D>>& log_metrics, std::string metric,
                                    const Execution& execution) {
    const auto metrics = map_each(part_of(execution, 0, 0.3), mesh.points.size(),
                                  [&](std::size_t v) { return MeasuringMetric<D>(log_metrics[v]); });
    if (!metrics) return fail(metrics.error());
    const auto of = [&](VertexId v) -> const MeasuringMetric<D>& { return (*metrics)[v.index()]; };
    const auto lengths = map_each(part_of(execution, 0.3, 0.6), edges.size(), [&](std::size_t e) {
        const auto& [a, b] = edges.vertices[e];
        return edge_length(of(a), of(b), mesh.points[b] - mesh.points[a]);
    });
    if (!lengths) return fail(lengths.error());
    const auto qualities = straight_qualities(mesh, of, part_of(execution, 0.6, 0.9));
    if (!qualities) return fail(qualities.error());
    UnitMesh out{{}, {lengths->begin(), lengths->end()}, {qualities->begin(), qualities->end()}};
    out.report = unit_mesh_report(std::move(metric), out.lengths, out.qualities);
    return out;
}

template <int D>
Outcome<UnitMesh> measure_unit_mesh(const QuadraticMesh<D>& mesh, const Column<LogMetric<D>>& log_metrics,
                                    std::string metric, const Execution& execution) {
    const auto lengths = bent_lengths(mesh, log_metrics.view(), part_of(execution, 0, 0.5));
    if (!lengths) return fail(lengths.error());
    const auto qualities = map_each(part_of(execution, 0.5, 1), mesh.linear.elements.size(), [&](std::size_t e) {
        const auto element = element_in_metric<D>(mesh, log_metrics.view(), ElementId(e));
        return curved_quality<D>(element.nodes, element_metric<D>(element.metrics)).mean;
    });
    if (!qualities) return fail(qualities.error());
    UnitMesh out{{}, {lengths->begin(), lengths->end()}, {qualities->begin(), qualities->end()}};
    out.report = unit_mesh_report(std::move(metric), out.lengths, out.qualities);
    return out;
}

std::vector<Histogram> histograms_of(const UnitMesh& measured, const std::string& series) {
    const auto histogram = [&](Quantity quantity, const std::vector<double>& values) {
        auto limits = limits_of(quantity);
        Series counts = counted(series, limits, values);
        return Histogram{quantity, std::move(limits), {std::move(counts)}};
    };
    return {histogram(Quantity::edge_length, measured.lengths),
            histogram(Quantity::metric_quality, measured.qualities)};
}

std::string unit_mesh_rows(const UnitMeshReport& r) {
    const auto share = [&](std::size_t n) {
        return r.edges == 0 ? 0.0 : 100 * static_cast<double>(n) / static_cast<double>(r.edges);
    };
    std::string text =
        table_row("edges of unit length",
                  fmt::format("{:.2f} % of {} (1/sqrt(2) to sqrt(2)); {:.2f} % shorter, {:.2f} % longer",
                              share(r.unit_edges), grouped(r.edges), share(r.short_edges), share(r.long_edges)));
    text +=
        table_row("edge lengths", fmt::format("{:.4g} to {:.4g}, mean {:.4g}", r.shortest, r.longest, r.mean_length));
    if (r.worst_element > 0)
        text += table_row("quality in the metric", fmt::format("mean {:.4g}, smallest {:.4g}, of element {}",
                                                               r.mean_quality, r.worst_quality, r.worst_element));
    return text;
}

std::string unit_mesh_json(const UnitMeshReport& r) {
    const nlohmann::ordered_json j{{"metric", r.metric},
                                   {"edges", r.edges},
                                   {"unit_edges", r.unit_edges},
                                   {"short_edges", r.short_edges},
                                   {"long_edges", r.long_edges},
                                   {"shortest", r.shortest},
                                   {"longest", r.longest},
                                   {"mean_length", r.mean_length},
                                   {"min_quality", r.worst_quality},
                                   {"mean_quality", r.mean_quality},
                                   {"worst_element", r.worst_element}};
    return j.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template Outcome<UnitMesh> measure_unit_mesh<D>(const LinearMesh<D>&, const EdgeSet<D>&,                           \
                                                    const Column<LogMetric<D>>&, std::string, const Execution&);       \
    template Outcome<UnitMesh> measure_unit_mesh<D>(const QuadraticMesh<D>&, const Column<LogMetric<D>>&, std::string, \
                                                    const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
