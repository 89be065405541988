module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
module camber.run;
import camber.core;
import camber.transfer;
import :rows;
import :solution_report;

namespace camber::run {

namespace {

using Json = nlohmann::ordered_json;

/// Of a field, all materials and components: by how much an integral changed, and how large one is.
struct Change {
    double change = 0, size = 0;
};
Change change_of(const std::vector<MaterialIntegrals>& integrals) {
    Change out;
    for (const MaterialIntegrals& of : integrals)
        for (std::size_t c = 0; c < of.before.size(); ++c) {
            out.change = std::max(out.change, std::abs(of.after[c] - of.before[c]));
            out.size = std::max(out.size, std::abs(of.before[c]));
        }
    return out;
}

std::string integral_rows(const TransferReport& r) {
    std::string text;
    for (std::size_t f = 0; f < r.fields.size() && f < r.statistics.integrals.size(); ++f) {
        const auto [change, size] = change_of(r.statistics.integrals[f]);
        text += table_row("integral of " + r.fields[f], fmt::format("changed by {:.2g}, of {:.6g}", change, size));
    }
    return text;
}

}  // namespace

std::string solution_metric_row(const SolutionMetricReport& r) {
    return table_row("metric of the solution",
                     fmt::format("for degree {}, complexity {:.6g} of {:.6g} asked", r.degree, r.complexity, r.asked));
}

std::string carried_rows(const TransferReport& r) {
    const TransferStatistics& s = r.statistics;
    return table_row("fields brought along", fmt::format("{}", fmt::join(r.fields, ", "))) +
           table_row("their nodes: kept, other, outside",
                     fmt::format("{}, {}, {}", grouped(s.kept), grouped(s.interpolated), grouped(s.outside))) +
           (r.method == TransferMethod::conserve ? integral_rows(r) : std::string());
}

std::string solution_metric_rows(const SolutionMetricReport& r) {
    std::string text = table_row("complexity asked", fmt::format("{:.6g}", r.asked));
    text += table_row("complexity",
                      fmt::format("{:.6g} ({} evaluations, {} gradations)", r.complexity, r.evaluations, r.gradations));
    text += table_row("elements expected", fmt::format("{:.0f}", r.elements));
    if (r.of_fixed > 0) text += table_row("of what is fixed", fmt::format("{:.6g}", r.of_fixed));
    text += table_row("largest anisotropy", fmt::format("{:.4g}", r.largest_anisotropy));
    text += table_row("vertices at bounds", fmt::format("{:.1f} % at the smallest size, {:.1f} % at the largest",
                                                        100 * r.at_min, 100 * r.at_max));
    text += table_row("derivatives", fmt::format("{} rows: {} of the boundary from inner ones, {} of a lower degree",
                                                 r.rows, r.from_inner_fits, r.lower_degree));
    text += table_row("models", fmt::format("degree {}; {} without derivatives, {} bounded to an anisotropy of {:.3g}",
                                            r.degree, r.zero_models, r.floored_models, r.models_max_anisotropy));
    return text;
}

std::vector<std::string> solution_metric_notices(const SolutionMetricReport& r) {
    std::vector<std::string> notices;
    if (r.is_fixed_alone)
        notices.push_back(
            fmt::format("sizes by reference, geometry, bounds and gradation alone have the complexity {:.6g}: the "
                        "solution has no say (ask for more, or for less of them)",
                        r.of_fixed));
    else if (!r.is_reached)
        notices.emplace_back("the complexity is another than was asked for: bounds or gradation stand in the way");
    for (const std::string& field : r.fields_in_doubt)
        notices.push_back(fmt::format(
            "the values of {} at neighbouring nodes are as unrelated as in a random order: the mesh does not "
            "resolve the field, or its rows are in another order than the nodes (docs/formats.md, Fields of "
            "degree 2)",
            field));
    if (!r.is_graded) notices.emplace_back("the gradation ended before its time: somewhere sizes still grow faster");
    return notices;
}

std::string solution_metric_json(const SolutionMetricReport& r) {
    return Json{{"degree", r.degree},
                {"asked", r.asked},
                {"complexity", r.complexity},
                {"elements_expected", r.elements},
                {"of_fixed", r.of_fixed},
                {"is_fixed_alone", r.is_fixed_alone},
                {"is_reached", r.is_reached},
                {"is_graded", r.is_graded},
                {"evaluations", r.evaluations},
                {"gradations", r.gradations},
                {"largest_anisotropy", r.largest_anisotropy},
                {"at_min_size", r.at_min},
                {"at_max_size", r.at_max},
                {"rows", r.rows},
                {"from_inner_fits", r.from_inner_fits},
                {"lower_degree", r.lower_degree},
                {"zero_models", r.zero_models},
                {"bounded_models", r.floored_models}}
        .dump();
}

std::string transfer_rows(const TransferReport& r) {
    const TransferStatistics& s = r.statistics;
    std::string text = table_row("nodes kept", fmt::format("{}, to the bit", s.kept));
    text += table_row("nodes interpolated", s.interpolated);
    if (s.outside > 0)
        text += table_row("nodes outside", fmt::format("{}, by up to {:.3g}: the nearest point of the boundary",
                                                       s.outside, s.largest_distance));
    if (r.method == TransferMethod::interpolate) return text;
    text += table_row("projected",
                      fmt::format("{} nodes of {} elements in {} patches", s.projected, s.changed_elements, s.patches));
    if (s.unkept > 0)
        text += table_row("materials without a free node", fmt::format("{}: their integrals are not kept", s.unkept));
    return text + integral_rows(r);
}

std::string transfer_json(const TransferReport& r) {
    const TransferStatistics& s = r.statistics;
    Json integrals = Json::object();
    for (std::size_t f = 0; f < r.fields.size() && f < s.integrals.size(); ++f) {
        const auto [change, size] = change_of(s.integrals[f]);
        integrals[r.fields[f]] = {{"largest", size}, {"largest_change", change}};
    }
    return Json{{"method", word_of(r.method)},
                {"fields", r.fields},
                {"kept", s.kept},
                {"interpolated", s.interpolated},
                {"outside", s.outside},
                {"largest_distance", s.largest_distance},
                {"projected", s.projected},
                {"changed_elements", s.changed_elements},
                {"patches", s.patches},
                {"spread", s.spread},
                {"unkept_materials", s.unkept},
                {"integrals", std::move(integrals)}}
        .dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace camber::run
