// Plan of a run and the table of its cycles
module;
#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
module camber.reports;
import camber.core;
import camber.recipes;
import camber.repair;
import camber.solution_metric;
import :json;

namespace camber::run {

namespace {

constexpr double seconds_of_work = 3.3e-5;  ///< time that one thread needs for a unit of RepairOptions::effort

std::string repair_limit(const config::Stage& stage, int threads) {
    const auto* relax = std::get_if<config::Relax>(&stage);
    if (!relax || !needs_models(relax->method)) return {};
    const auto seconds = [&](std::size_t elements) {
        return allowed_work(elements, relax->effort) * seconds_of_work / (threads > 0 ? threads : 1);
    };
    return fmt::format("about {:.2g} s and {:.2g} s for each element below the bound", seconds(0),
                       seconds(1) - seconds(0));
}

bool has_element_target(const config::Stage& stage) {
    return std::visit(
        []<class S>(const S&) { return std::is_same_v<S, config::Remesh> || std::is_same_v<S, config::Split>; }, stage);
}

/// Removes the option `min_scaled_jacobian` from a stage's line if an earlier stage has the same value.
std::string without_said(const std::string& stage, std::set<std::string, std::less<>>& said) {
    constexpr std::string_view bound = " min_scaled_jacobian=";
    const auto begin = stage.find(bound);
    if (begin == std::string::npos) return stage;
    const auto end = std::min(stage.find(' ', begin + 1), stage.size());
    if (said.insert(stage.substr(begin, end - begin)).second) return stage;
    return stage.substr(0, begin) + stage.substr(end);
}

/// Returns the size for the time estimate. Its number of edges is increased if the passes are expected to refine the
/// mesh.
PlanSize with_growth(PlanSize size, const std::optional<Growth>& growth) {
    const double edges_of_an_element = size.dimension == 2 ? 1.5 : 1.2;
    if (growth) size.edges = std::max(size.edges, static_cast<std::size_t>(edges_of_an_element * growth->elements));
    return size;
}

/// Fraction of the repair work that a probe (a short run that predicts the time) may do.
constexpr double probed_share = 0.02;

config::Relax* repair_by_optimisation(config::Stage& stage) {
    auto* const relax = std::get_if<config::Relax>(&stage);
    return relax != nullptr && needs_models(relax->method) ? relax : nullptr;
}

std::string seconds_text(double seconds) {
    if (seconds < 1.5) return "about a second";
    if (seconds < 100) return fmt::format("about {:.2g} s", seconds);
    return fmt::format("about {:.2g} minutes", seconds / 60);
}

/// Returns "seconds", "minutes" or "hours", for 5 000 to 30 000 edges per second and thread.
std::string time_class(const PlanSize& size, int threads) {
    constexpr double slow = 5000, fast = 30000;  // edges per second and thread, for all stages together
    const double edges = static_cast<double>(size.edges) / (threads > 0 ? threads : 1);
    const double mean = edges / (size.dimension == 2 ? fast : 0.5 * (slow + fast));
    if (mean < 1) return "about a second";
    if (mean < 60) return "seconds";
    return mean < 3600 ? "minutes" : "hours";
}

}  // namespace

std::optional<config::Pipeline> probe_of(const config::Pipeline& pipeline, const PlanSize& size, int threads) {
    constexpr double most_edges = 2e5;  // number of edges per thread above which even a probe takes too long
    if (static_cast<double>(size.edges) > most_edges * threads) return std::nullopt;
    config::Pipeline probe = pipeline;
    probe.output = {};
    bool repairs = false;
    for (config::Stage& stage : probe.stages) {
        if (std::visit([]<class S>(const S&) { return changes_topology<S>(); }, stage)) return std::nullopt;
        if (config::Relax* const relax = repair_by_optimisation(stage)) {
            relax->effort *= probed_share;
            repairs = true;
        }
    }
    return repairs ? std::optional(std::move(probe)) : std::nullopt;
}

double expected_seconds(const config::Pipeline& pipeline, const Report& probe, double seconds, int threads) {
    if (!probe.relax || probe.relax->unresolved == 0 || !probe.validity_before) return seconds;
    const ValidityReport& v = *probe.validity_before;
    double work = 0;
    for (config::Stage stage : pipeline.stages)
        if (const config::Relax* const relax = repair_by_optimisation(stage))
            work += (1 - probed_share) * allowed_work(v.invalid + v.undecided + v.below_bound, relax->effort);
    return seconds + work * seconds_of_work / (threads > 0 ? threads : 1);
}

std::string plan_text(const config::Pipeline& pipeline, const PipelineTexts& parts, const PlanSize& size,
                      const std::optional<Growth>& growth, std::optional<double> seconds, int threads) {
    std::string text =
        short_row("input", parts.input) +
        short_row("dimension, degree", fmt::format("{}D, P{}", size.dimension, size.degree)) +
        short_row("vertices", fmt::format("{}", size.vertices)) +
        short_row(size.dimension == 2 ? "triangles" : "tetrahedra", fmt::format("{}", size.elements)) +
        short_row(size.dimension == 2 ? "boundary edges" : "boundary triangles", fmt::format("{}", size.facets)) +
        short_row("edges", fmt::format("{}{}", size.degree == 1 ? "about " : "", size.edges)) +
        short_row("metric", parts.metric);
    for (const std::string& operation : parts.metric_operations) text += short_row("then", operation);
    text += short_row("geometry", parts.geometry);
    std::set<std::string, std::less<>> said;
    for (std::size_t i = 0; i < parts.stages.size(); ++i) {
        text += short_row(fmt::format("stage {}", i + 1), without_said(parts.stages[i], said));
        if (const auto limit = repair_limit(pipeline.stages[i], threads); !limit.empty())
            text += short_row("  repair ends after", limit);
        if (has_element_target(pipeline.stages[i]))
            text += growth
                        ? short_row("  metric requires", fmt::format("about {:.2g} {}", growth->elements,
                                                                     size.dimension == 2 ? "triangles" : "tetrahedra"))
                        : short_row("  not counted below", "result of this stage: known after the previous stages");
    }
    const std::size_t peak = std::max(size.peak_bytes, growth ? growth->peak_bytes : 0);
    return text + short_row("threads", fmt::format("{}", threads)) +
           short_row("peak memory", fmt::format("about {:.0f} MiB", static_cast<double>(peak) / 1048576)) +
           short_row("time", seconds ? seconds_text(*seconds) : time_class(with_growth(size, growth), threads));
}

namespace {

std::string cell(bool there, std::string text) { return there ? std::move(text) : "-"; }
std::string percent(double share) { return fmt::format("{:.1f}", 100 * share); }
std::string error_cells(const std::optional<CycleError>& error) {
    return fmt::format(" {:>9} {:>9}", cell(error.has_value(), error ? fmt::format("{:.2e}", error->l2) : ""),
                       cell(error.has_value(), error ? fmt::format("{:.2e}", error->h1) : ""));
}

/// Distance and its bound. A distance far below the bound is the rounding error of a plane boundary.
std::string distance_cell(const BoundaryDistance& boundary) {
    constexpr double least_share = 1e-9;
    if (boundary.reached < least_share * boundary.bound) return fmt::format("0, {:.2e}", boundary.bound);
    return fmt::format("{:.2e}, {:.2e}", boundary.reached, boundary.bound);
}

template <class Read>
auto read_list(const std::string& text, const char* key, const Read& read, Error not_one)
    -> Outcome<std::vector<std::invoke_result_t<Read, const Json&>>> {
    try {
        const Json all = Json::parse(text);
        std::vector<std::invoke_result_t<Read, const Json&>> list;
        for (const Json& item : all.at(key)) list.push_back(read(item));
        return list;
    } catch (const nlohmann::json::exception&) {
        return fail(std::move(not_one));
    }
}

/// True if the table has a column for the expected error. It has none if the exact solution is known and no solver
/// runs.
bool shows_expected(const config::Adaptation& adapt) { return adapt.exact.empty() || !adapt.solve.empty(); }

}  // namespace

std::string cycles_head(const config::Adaptation& adapt) {
    std::string text = fmt::format("{:>7} {:>9} {:>9} {:>19} {:>13} {:>12} {:>8}", "cycle", "unknowns", "elements",
                                   "complexity, target", "unit edges, %", "quality", "min J");
    text += fmt::format(" {:>18}", "distance, bound");
    if (shows_expected(adapt)) text += fmt::format(" {:>9}", "expected");
    if (!adapt.exact.empty()) text += fmt::format(" {:>19}", "interpolated L2, H1");
    if (!adapt.exact.empty() && !adapt.solve.empty()) text += fmt::format(" {:>19}", "solved L2, H1");
    text += fmt::format(" {:>8}", "seconds");
    if (!adapt.solve.empty()) text += fmt::format(" {:>8}", "solver's");
    return text + "\n";
}

std::string cycles_line(const CycleRow& row, const config::Adaptation& adapt) {
    const bool result = row.unit_edges > 0;
    const std::string complexity =
        cell(row.complexity > 0, row.complexity_target > 0
                                     ? fmt::format("{:.0f}, {:.0f}", row.complexity, row.complexity_target)
                                     : fmt::format("{:.0f}", row.complexity));
    std::string text = fmt::format(
        "{:>7} {:>9} {:>9} {:>19} {:>13} {:>12} {:>8.3f}", row.cycle, grouped(row.unknowns), grouped(row.elements),
        complexity, cell(result, percent(row.unit_before) + " > " + percent(row.unit_edges)),
        cell(result, fmt::format("{:.3f}, {:.3f}", row.worst_quality, row.mean_quality)), row.smallest_jacobian);
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
    return Json{{"cycles", json_of(std::vector(rows.begin(), rows.end()))}}.dump(2) + "\n";
}

Outcome<std::vector<CycleRow>> read_cycles(const std::string& text, const std::string& path) {
    if (text.find("\"complexity_wanted\"") != std::string::npos)
        return fail(ErrorKind::input,
                    "is of an earlier version: \"complexity_wanted\" was renamed to \"complexity_target\"", path, {},
                    "start again without --from, in another folder");
    return read_list(text, "cycles", value_of_json<CycleRow>,
                     {ErrorKind::input, "is not a table of cycles", path, {}, "use another folder"});
}

std::string groups_json(const Groups& groups) {
    Json all{{"groups", Json::array()}};
    for (const Group& group : groups)
        all["groups"].push_back({{"dimension", group.dimension}, {"reference", group.reference}, {"name", group.name}});
    return all.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Outcome<Groups> read_groups(const std::string& text, const std::string& path) {
    const auto group = [](const Json& j) {
        return Group{j.at("dimension").get<int>(), j.at("reference").get<Reference>(), j.at("name").get<std::string>()};
    };
    return read_list(text, "groups", group,
                     {ErrorKind::input, "is not a list of names of references", path, {}, "use another folder"});
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

}  // namespace camber::run
