module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>
module camber.recipes;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.metric;
import camber.validity;
import camber.distributed;
import camber.stages;

namespace camber::run {

namespace {

double mean_of(const std::vector<double>& values) {
    return values.empty() ? 0 : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

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
        if (is_standalone_surface(mesh))
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
    UnitMeshReport report{{.edges = lengths.size()}, std::move(metric)};
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

static UnitMesh measured(std::string metric, const Buffer<double>& lengths, const Buffer<double>& qualities) {
    UnitMesh out{{}, {lengths.begin(), lengths.end()}, {qualities.begin(), qualities.end()}};
    out.report = unit_mesh_report(std::move(metric), out.lengths, out.qualities);
    return out;
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
    return measured(std::move(metric), *lengths, *qualities);
}

template <int D>
Outcome<UnitMesh> measure_unit_mesh(const QuadraticMesh<D>& mesh, const Column<LogMetric<D>>& log_metrics,
                                    std::string metric, const Execution& execution) {
    const auto lengths = quadratic_edge_lengths(mesh, log_metrics.view(), part_of(execution, 0, 0.5));
    if (!lengths) return fail(lengths.error());
    const auto qualities = map_each(part_of(execution, 0.5, 1), mesh.linear.elements.size(), [&](std::size_t e) {
        const auto element = element_in_metric<D>(mesh, log_metrics.view(), ElementId(e));
        return curved_quality<D>(element.nodes, element_metric<D>(element.metrics)).mean;
    });
    if (!qualities) return fail(qualities.error());
    return measured(std::move(metric), *lengths, *qualities);
}

namespace {

Histogram histogram(Quantity quantity, const std::vector<double>& values, const std::string& series) {
    auto limits = limits_of(quantity);
    Series counts = counted(series, limits, values);
    return {quantity, std::move(limits), {std::move(counts)}};
}

}  // namespace

std::vector<Histogram> histograms_of(const UnitMesh& measured, const std::string& series) {
    return {histogram(Quantity::edge_length, measured.lengths, series),
            histogram(Quantity::metric_quality, measured.qualities, series)};
}
std::vector<Histogram> histograms_of(const CurvedUnitMesh& measured, const std::string& series) {
    return {histogram(Quantity::curved_edge_length, measured.lengths, series),
            histogram(Quantity::curved_metric_quality, measured.qualities, series)};
}

namespace {

/// Numbers of one rank, without pointers.
struct OfRank : UnitMeshNumbers {
    std::size_t elements = 0;
};

double mean(double a, std::size_t of_a, double b, std::size_t of_b) {
    if (of_a + of_b == 0) return 0;
    return (a * static_cast<double>(of_a) + b * static_cast<double>(of_b)) / static_cast<double>(of_a + of_b);
}

void add(OfRank& all, const OfRank& next) {
    if (next.edges > 0) {
        all.shortest = all.edges == 0 ? next.shortest : std::min(all.shortest, next.shortest);
        all.longest = std::max(all.longest, next.longest);
    }
    if (next.elements > 0 && (all.elements == 0 || next.worst_quality < all.worst_quality)) {
        all.worst_quality = next.worst_quality;
        all.worst_element = all.elements + next.worst_element;
    }
    all.mean_length = mean(all.mean_length, all.edges, next.mean_length, next.edges);
    all.mean_quality = mean(all.mean_quality, all.elements, next.mean_quality, next.elements);
    all.edges += next.edges;
    all.short_edges += next.short_edges;
    all.long_edges += next.long_edges;
    all.unit_edges += next.unit_edges;
    all.elements += next.elements;
}

struct SeriesOfRank {
    double mean = 0, least = 0, greatest = 0;
    std::size_t values = 0, not_numbers = 0;
    bool has_extremes = false;
};

Outcome<Done> add_up(Series& series, Ranks& ranks) {
    const auto counts = gather_all(ranks, Outcome<std::vector<std::size_t>>(series.counts));
    if (!counts) return fail(counts.error());
    SeriesOfRank own{.mean = series.mean, .not_numbers = series.not_numbers};
    for (const std::size_t n : series.counts) own.values += n;
    if (series.extremes) own.least = series.extremes->least, own.greatest = series.extremes->greatest;
    own.has_extremes = series.extremes.has_value();
    const auto all = gather_all(ranks, Outcome<std::vector<SeriesOfRank>>({own}));
    if (!all) return fail(all.error());
    const std::size_t bins = series.counts.size();
    series.counts.assign(bins, 0);
    for (std::size_t i = 0; i < counts->size(); ++i) series.counts[i % bins] += (*counts)[i];
    std::size_t values = 0;
    series.mean = 0, series.not_numbers = 0, series.extremes.reset();
    for (const SeriesOfRank& next : *all) {
        series.mean = mean(series.mean, values, next.mean, next.values);
        values += next.values;
        series.not_numbers += next.not_numbers;
        if (!next.has_extremes) continue;
        if (!series.extremes) series.extremes = Extremes{next.least, next.greatest};
        series.extremes->least = std::min(series.extremes->least, next.least);
        series.extremes->greatest = std::max(series.extremes->greatest, next.greatest);
    }
    return Done{};
}

}  // namespace

Outcome<UnitMeshOfRanks> unit_mesh_of_ranks(std::string metric, const MeasuredRows& own, Ranks& ranks) {
    const UnitMesh here{unit_mesh_report(metric, own.lengths, own.qualities), own.lengths, own.qualities};
    const UnitMeshNumbers& numbers = here.report;
    const auto of_all = gather_all(ranks, Outcome<std::vector<OfRank>>({OfRank{numbers, own.qualities.size()}}));
    if (!of_all) return fail(of_all.error());
    OfRank all;
    for (const OfRank& next : *of_all) add(all, next);
    UnitMeshOfRanks result{{static_cast<const UnitMeshNumbers&>(all), std::move(metric)},
                           histograms_of(here, "remeshed")};
    for (Histogram& histogram : result.histograms)
        if (auto added = add_up(histogram.series.front(), ranks); !added) return fail(added.error());
    return result;
}

namespace {

using Element = CurvedUnitMeshReport::Element;

/// Maximum number of bisections for an element whose bound might be the lowest.
constexpr int bisections_of_all = 64;

std::vector<std::uint32_t> find_worst(const std::vector<double>& qualities, std::size_t n) {
    std::vector<std::uint32_t> order(qualities.size());
    std::iota(order.begin(), order.end(), 0U);
    const auto end = order.begin() + static_cast<std::ptrdiff_t>(std::min(n, order.size()));
    std::partial_sort(order.begin(), end, order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::tuple(qualities[a], a) < std::tuple(qualities[b], b);
    });
    order.erase(end, order.end());
    return order;
}

Element element_at(std::size_t e, const std::vector<double>& qualities, const QualityBound& least) {
    return {e + 1, qualities[e], least.attained, least.bound};
}

}  // namespace

template <int D>
Outcome<CurvedUnitMesh> measure_curved_unit_mesh(const QuadraticMesh<D>& mesh, const Column<LogMetric<D>>& log_metrics,
                                                 std::string metric, std::size_t worst, const Execution& execution) {
    const auto measured = measure_curved(mesh, log_metrics.view(), bisections_of_all, part_of(execution, 0, 0.95));
    if (!measured) return fail(measured.error());
    CurvedUnitMesh out{{},
                       {measured->lengths.begin(), measured->lengths.end()},
                       {measured->qualities.begin(), measured->qualities.end()}};
    out.report.unit_mesh = unit_mesh_report(std::move(metric), out.lengths, out.qualities);
    const auto& least = measured->least;
    const auto lowest = std::min_element(least.begin(), least.end(), [](const QualityBound& a, const QualityBound& b) {
        return a.attained < b.attained;
    });
    if (lowest != least.end()) {
        out.report.lowest = element_at(static_cast<std::size_t>(lowest - least.begin()), out.qualities, *lowest);
        out.report.bound = lowest->bound;
        for (const QualityBound& found : least) out.report.bound = std::min(out.report.bound, found.bound);
    }
    const auto chosen = find_worst(out.qualities, worst);
    const auto described = map_each(
        part_of(execution, 0.95, 1), chosen.size(),
        [&](std::size_t i) {
            const ElementInMetric<D> element = element_in_metric<D>(mesh, log_metrics.view(), ElementId(chosen[i]));
            QualityBound found = least[chosen[i]];
            const auto closer =
                bound_quality<D>(element.nodes, element.metrics, {.enough = 1, .bisections = max_bisections});
            found.attained = std::min(found.attained, closer.attained);
            found.bound = std::min(found.attained, std::max(found.bound, closer.bound));
            return element_at(chosen[i], out.qualities, found);
        },
        16);
    if (!described) return fail(described.error());
    out.report.worst.assign(described->begin(), described->end());
    return out;
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template Outcome<CurvedUnitMesh> measure_curved_unit_mesh<D>(const QuadraticMesh<D>&, const Column<LogMetric<D>>&, \
                                                                 std::string, std::size_t, const Execution&);          \
    template Outcome<UnitMesh> measure_unit_mesh<D>(const LinearMesh<D>&, const EdgeSet<D>&,                           \
                                                    const Column<LogMetric<D>>&, std::string, const Execution&);       \
    template Outcome<UnitMesh> measure_unit_mesh<D>(const QuadraticMesh<D>&, const Column<LogMetric<D>>&, std::string, \
                                                    const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
