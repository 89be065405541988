// Tables of cycles and of unit edges
module;
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
module camber.reports;
import camber.core;
import camber.solution_metric;
import camber.recipes;
import :json;

namespace camber::run {

namespace {

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

/// Reads the items of the list with this key.
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
    return Json{{"cycles", json_of(std::vector(rows.begin(), rows.end()))}}.dump(2) + "\n";
}

Outcome<std::vector<CycleRow>> read_cycles(const std::string& text, const std::string& path) {
    if (text.find("\"complexity_wanted\"") != std::string::npos)
        return fail(ErrorKind::input,
                    "is of an earlier version: \"complexity_wanted\" was renamed to \"complexity_target\"", path, {},
                    "start again without --from, in another folder");
    return read_list(text, "cycles", value_of_json<CycleRow>,
                     {ErrorKind::input, "is no table of cycles", path, {}, "give another folder"});
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
                     {ErrorKind::input, "is no list of names of references", path, {}, "give another folder"});
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
