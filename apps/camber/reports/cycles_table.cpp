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
module camber.reports;
import camber.core;
import camber.recipes;

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

}  // namespace camber::run
