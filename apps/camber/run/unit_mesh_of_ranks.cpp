module;
#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>
module camber.run;
import camber.core;
import camber.distributed;
import :histogram;
import :report;
import :unit_mesh;
import :unit_mesh_of_ranks;

namespace camber::run {

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

}  // namespace camber::run
