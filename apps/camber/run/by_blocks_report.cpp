module;
#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
module camber.run;
import camber.core;
import camber.crossing;
import camber.distributed;
import camber.surface;
import :by_blocks;
import :measures;
import :parts;
import :report;
import :rows;

namespace camber::run {

namespace {

template <class T>
T most(const std::vector<T>& of_ranks) {
    return of_ranks.empty() ? T{} : *std::ranges::max_element(of_ranks);
}

nlohmann::ordered_json verdicts(const BlocksValidation& v) {
    return {{"invalid", v.invalid},
            {"undecided", v.undecided},
            {"not_certified", v.not_positive},
            {"min_scaled_jacobian", v.smallest}};
}

}  // namespace

template <int D>
WallsReport walls_report(const WallsOfBlocks<D>& walls) {
    const auto& found = walls.crossings.found;
    const auto pair = std::ranges::find(found, Crossing::crossing, &FacetCrossing::verdict);
    WallsReport report =
        walls_report<D>(walls.crossings, [&](FacetId f) { return walls.first_crossing[f == pair->first ? 0 : 1]; });
    report.crossing_before = walls.crossing_before;
    if (walls.moved.nodes > 0) report.relaxed = relaxed_walls_report(walls.moved);
    return report;
}
template WallsReport walls_report<2>(const WallsOfBlocks<2>&);
template WallsReport walls_report<3>(const WallsOfBlocks<3>&);

template <int D>
void add(ByBlocksReport& report, const DeviationOfBlocks<D>& deviation, const BoundaryTolerance& tolerance) {
    const auto& [nodes, vertices] = deviation.found;
    report.nodes =
        deviation_report(nodes, tolerance.nodes, {deviation.edge[0] + 1, deviation.edge[1] + 1}, deviation.node);
    report.boundary_vertices =
        deviation_report(vertices, tolerance.vertices, {deviation.vertex + 1, 0}, deviation.point);
}
template void add<2>(ByBlocksReport&, const DeviationOfBlocks<2>&, const BoundaryTolerance&);
template void add<3>(ByBlocksReport&, const DeviationOfBlocks<3>&, const BoundaryTolerance&);

std::string table(const ByBlocksReport& r) {
    const std::size_t in_all = r.before.invalid + r.before.undecided;
    std::string text = table_row("dimension, degree", fmt::format("{}, 2", r.dimension)) +
                       table_row("vertices", r.vertices) + table_row("elements", r.elements) +
                       table_row("edges", r.edges) +
                       table_row("blocks, of about so many elements",
                                 fmt::format("{}, {}", grouped(r.blocks), grouped(r.elements_of_block))) +
                       table_row("ranks", r.ranks) +
                       table_row("volume edges that are curved",
                                 fmt::format("{} of {}", grouped(r.curved_edges), grouped(r.volume_edges))) +
                       table_row("elements not valid before repair", in_all);
    if (in_all > 0)
        text += table_row("repaired elements", r.repair.corrected_elements) +
                table_row("elements not valid now", r.after.invalid + r.after.undecided);
    text += deviation_row("nodes off the geometry", r.nodes);
    text += deviation_row("vertices off the geometry", r.boundary_vertices);
    text += walls_rows(r.walls);
    text += table_row("smallest scaled Jacobian", fmt::format("{:.4g}", r.after.smallest));
    for (const StageTime& step : r.times) text += table_row(step.stage, fmt::format("{:.2f} s", step.seconds));
    text += table_row("peak memory of a rank", fmt::format("{} MB", grouped(most(r.peak_bytes) / 1000000)));
    if (r.ranks > 1)
        text +=
            table_row("sent by a rank, at most",
                      fmt::format("{:.1f} MB in {} rounds", static_cast<double>(most(r.sent_bytes)) / 1e6, r.rounds));
    return text;
}

std::string to_json(const ByBlocksReport& r) {
    nlohmann::ordered_json times = nlohmann::ordered_json::array();
    for (const StageTime& step : r.times)
        times.push_back({{"stage", step.stage}, {"seconds", step.seconds}, {"peak_bytes", step.peak_bytes}});
    auto boundary = nlohmann::ordered_json::parse(walls_json(r.walls));
    boundary["node_deviation"] = nlohmann::ordered_json::parse(deviation_json(r.nodes));
    boundary["vertex_deviation"] = nlohmann::ordered_json::parse(deviation_json(r.boundary_vertices));
    const nlohmann::ordered_json j{{"format", report_format},
                                   {"mesh",
                                    {{"dimension", r.dimension},
                                     {"degree", 2},
                                     {"vertices", r.vertices},
                                     {"elements", r.elements},
                                     {"facets", r.facets},
                                     {"edges", r.edges}}},
                                   {"blocks", {{"number", r.blocks}, {"elements", r.elements_of_block}}},
                                   {"curve",
                                    {{"volume_edges", r.volume_edges},
                                     {"curved_edges", r.curved_edges},
                                     {"extension_iterations", r.extension_iterations}}},
                                   {"boundary", std::move(boundary)},
                                   {"bound", r.bound},
                                   {"before_repair", verdicts(r.before)},
                                   {"validity", verdicts(r.after)},
                                   {"ranks",
                                    {{"number", r.ranks},
                                     {"rounds", r.rounds},
                                     {"peak_bytes", r.peak_bytes},
                                     {"processor_seconds", r.processor_seconds},
                                     {"sent_bytes", r.sent_bytes}}},
                                   {"misses", misses(r)},
                                   {"stages", std::move(times)}};
    return j.dump(2) + "\n";
}

}  // namespace camber::run
