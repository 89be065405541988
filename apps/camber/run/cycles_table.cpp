// Tables of cycles and of unit edges
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <string_view>
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
import camber.distributed;
import camber.config;

namespace camber::run {

namespace {

using Json = nlohmann::ordered_json;

Json json(const CycleRow& row) {
    Json j{{"cycle", row.cycle},
           {"unknowns", row.unknowns},
           {"elements", row.elements},
           {"problem", row.problem},
           {"complexity_target", row.wanted},
           {"complexity", row.complexity},
           {"unit_edges_before", row.unit_before},
           {"unit_edges", row.unit_edges},
           {"min_quality", row.worst_quality},
           {"mean_quality", row.mean_quality},
           {"min_scaled_jacobian", row.smallest_jacobian}};
    if (row.expected) j["expected_error"] = *row.expected;
    if (row.interpolated) j["interpolation_error"] = {{"l2", row.interpolated->l2}, {"h1", row.interpolated->h1}};
    if (row.solved) j["solution_error"] = {{"l2", row.solved->l2}, {"h1", row.solved->h1}};
    if (row.boundary)
        j["boundary_distance"] = {{"bound", row.boundary->bound},
                                  {"reached", row.boundary->reached},
                                  {"origin", row.boundary->is_required ? "config" : "expected_error"}};
    j["seconds"] = row.seconds;
    j["solve_seconds"] = row.solve_seconds;
    if (row.is_of_gradients) j["error_of"] = "gradients";
    if (!row.is_valid) j["valid"] = false;
    if (!row.misses.empty()) j["misses"] = row.misses;
    return j;
}

std::optional<CycleError> error_of(const Json& j, const char* key) {
    if (!j.contains(key)) return std::nullopt;
    return CycleError{j.at(key).at("l2").get<double>(), j.at(key).at("h1").get<double>()};
}

CycleRow row_of(const Json& j) {
    CycleRow row{.cycle = j.at("cycle").get<int>(),
                 .unknowns = j.at("unknowns").get<std::size_t>(),
                 .elements = j.at("elements").get<std::size_t>(),
                 .problem = j.value("problem", ""),
                 .wanted = j.at("complexity_target").get<double>(),
                 .complexity = j.at("complexity").get<double>(),
                 .unit_before = j.at("unit_edges_before").get<double>(),
                 .unit_edges = j.at("unit_edges").get<double>(),
                 .worst_quality = j.at("min_quality").get<double>(),
                 .mean_quality = j.at("mean_quality").get<double>(),
                 .smallest_jacobian = j.at("min_scaled_jacobian").get<double>(),
                 .interpolated = error_of(j, "interpolation_error"),
                 .solved = error_of(j, "solution_error"),
                 .seconds = j.at("seconds").get<double>(),
                 .solve_seconds = j.at("solve_seconds").get<double>()};
    row.is_of_gradients = j.contains("error_of");
    row.is_valid = j.value("valid", true);
    if (j.contains("misses")) row.misses = j.at("misses").get<std::vector<std::string>>();
    if (j.contains("boundary_distance")) {
        const Json& distance = j.at("boundary_distance");
        row.boundary = {distance.at("bound").get<double>(), distance.at("reached").get<double>(),
                        distance.at("origin").get<std::string>() == "config"};
    }
    if (j.contains("expected_error")) row.expected = j.at("expected_error").get<double>();
    return row;
}

/// A number, or nothing where there is none.
std::string cell(bool there, std::string text) { return there ? std::move(text) : "-"; }
std::string percent(double share) { return fmt::format("{:.1f}", 100 * share); }
std::string error_cells(const std::optional<CycleError>& error) {
    return fmt::format(" {:>9} {:>9}", cell(error.has_value(), error ? fmt::format("{:.2e}", error->l2) : ""),
                       cell(error.has_value(), error ? fmt::format("{:.2e}", error->h1) : ""));
}

/// The distance and its bound. A distance far below the bound is the rounding of a plane boundary.
std::string distance_cell(const BoundaryDistance& boundary) {
    constexpr double least_share = 1e-9;
    if (boundary.reached < least_share * boundary.bound) return fmt::format("0, {:.2e}", boundary.bound);
    return fmt::format("{:.2e}, {:.2e}", boundary.reached, boundary.bound);
}

/// Where the exact solution is known its interpolant's error stands in its place.
bool shows_expected(const config::Adaptation& adapt) { return adapt.exact.empty() || !adapt.solve.empty(); }

}  // namespace

std::string cycles_head(const config::Adaptation& adapt) {
    std::string text = fmt::format("{:>7} {:>9} {:>9} {:>19} {:>13} {:>12} {:>8}", "cycle", "unknowns", "elements",
                                   "complexity, target", "unit edges, %", "quality", "least J");
    text += fmt::format(" {:>18}", "distance, bound");
    if (shows_expected(adapt)) text += fmt::format(" {:>9}", "expected");
    if (!adapt.exact.empty()) text += fmt::format(" {:>19}", "interpolated L2, H1");
    if (!adapt.exact.empty() && !adapt.solve.empty()) text += fmt::format(" {:>19}", "solved L2, H1");
    text += fmt::format(" {:>8}", "seconds");
    if (!adapt.solve.empty()) text += fmt::format(" {:>8}", "solver's");
    return text + "\n";
}

std::string cycles_line(const CycleRow& row, const config::Adaptation& adapt) {
    const bool made = row.unit_edges > 0;
    const std::string complexity =
        cell(row.complexity > 0, row.wanted > 0 ? fmt::format("{:.0f}, {:.0f}", row.complexity, row.wanted)
                                                : fmt::format("{:.0f}", row.complexity));
    std::string text = fmt::format(
        "{:>7} {:>9} {:>9} {:>19} {:>13} {:>12} {:>8.3f}", row.cycle, grouped(row.unknowns), grouped(row.elements),
        complexity, cell(made, percent(row.unit_before) + " > " + percent(row.unit_edges)),
        cell(made, fmt::format("{:.3f}, {:.3f}", row.worst_quality, row.mean_quality)), row.smallest_jacobian);
    text += fmt::format(" {:>18}", row.boundary ? distance_cell(*row.boundary) : "-");
    if (shows_expected(adapt))
        text += fmt::format(" {:>9}", cell(row.expected.has_value(), fmt::format("{:.2e}", row.expected.value_or(0))));
    if (!adapt.exact.empty()) text += error_cells(row.interpolated);
    if (!adapt.exact.empty() && !adapt.solve.empty()) text += error_cells(row.solved);
    text += fmt::format(" {:>8.2f}", row.seconds);
    if (!adapt.solve.empty()) text += fmt::format(" {:>8.2f}", row.solve_seconds);
    return text + "\n";
}

std::string cycles_json(std::span<const CycleRow> rows) {
    Json all{{"cycles", Json::array()}};
    for (const CycleRow& row : rows) all["cycles"].push_back(json(row));
    return all.dump(2) + "\n";
}

Outcome<std::vector<CycleRow>> read_cycles(const std::string& text, const std::string& path) {
    try {
        const Json table = Json::parse(text);
        std::vector<CycleRow> rows;
        for (const Json& j : table.at("cycles")) {
            if (j.contains("complexity_wanted"))
                return fail(ErrorKind::input,
                            "is of an earlier version: \"complexity_wanted\" was renamed to \"complexity_target\"",
                            path, {}, "start again without --from, in another folder");
            rows.push_back(row_of(j));
        }
        return rows;
    } catch (const nlohmann::json::exception&) {
        return fail(ErrorKind::input, "is no table of cycles", path, {}, "give another folder");
    }
}

std::string groups_json(const Groups& groups) {
    Json all{{"groups", Json::array()}};
    for (const Group& group : groups)
        all["groups"].push_back({{"dimension", group.dimension}, {"reference", group.reference}, {"name", group.name}});
    return all.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Outcome<Groups> read_groups(const std::string& text, const std::string& path) {
    try {
        const Json table = Json::parse(text);
        Groups groups;
        for (const Json& j : table.at("groups"))
            groups.push_back(
                {j.at("dimension").get<int>(), j.at("reference").get<Reference>(), j.at("name").get<std::string>()});
        return groups;
    } catch (const nlohmann::json::exception&) {
        return fail(ErrorKind::input, "is no list of names of references", path, {}, "give another folder");
    }
}

std::string series_of(std::span<const CycleRow> rows, const std::string& view) {
    std::string text =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
        "  <Collection>\n";
    for (const CycleRow& row : rows)
        text += fmt::format("    <DataSet timestep=\"{}\" part=\"0\" file=\"{}/{}\"/>\n", row.cycle,
                            name_of_cycle(row.cycle), view);
    return text + "  </Collection>\n</VTKFile>\n";
}

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

namespace {

/// What a rank has, as a plain value.
struct OfRank {
    std::size_t edges = 0, short_edges = 0, long_edges = 0, unit_edges = 0, elements = 0, worst_element = 0;
    double shortest = 0, longest = 0, mean_length = 0, worst_quality = 0, mean_quality = 0;
};
OfRank of_rank(const UnitMeshReport& r, std::size_t elements) {
    return {r.edges,    r.short_edges, r.long_edges,  r.unit_edges,    elements,      r.worst_element,
            r.shortest, r.longest,     r.mean_length, r.worst_quality, r.mean_quality};
}

double mean(double a, std::size_t of_a, double b, std::size_t of_b) {
    if (of_a + of_b == 0) return 0;
    return (a * static_cast<double>(of_a) + b * static_cast<double>(of_b)) / static_cast<double>(of_a + of_b);
}

/// The elements of `next` follow those of `all`.
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

UnitMeshReport report_of(std::string metric, const OfRank& all) {
    UnitMeshReport report{.metric = std::move(metric), .edges = all.edges};
    report.short_edges = all.short_edges;
    report.long_edges = all.long_edges;
    report.unit_edges = all.unit_edges;
    report.shortest = all.shortest;
    report.longest = all.longest;
    report.mean_length = all.mean_length;
    report.worst_quality = all.worst_quality;
    report.mean_quality = all.mean_quality;
    report.worst_element = all.worst_element;
    return report;
}

/// A series but for its name and its counts.
struct SeriesOfRank {
    double mean = 0, least = 0, greatest = 0;
    std::size_t values = 0, not_numbers = 0;
    bool has_extremes = false;
};

/// The counts of all ranks added up.
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
    const auto of_all = gather_all(ranks, Outcome<std::vector<OfRank>>({of_rank(here.report, own.qualities.size())}));
    if (!of_all) return fail(of_all.error());
    OfRank all;
    for (const OfRank& next : *of_all) add(all, next);
    UnitMeshOfRanks made{report_of(std::move(metric), all), histograms_of(here, "remeshed")};
    for (Histogram& histogram : made.histograms)
        if (auto added = add_up(histogram.series.front(), ranks); !added) return fail(added.error());
    return made;
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
