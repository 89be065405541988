module;
#include <cstddef>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
module camber.run;
import :page;
import :rows;

namespace camber::run {

namespace {

/// Sorted: keys are found at once, however many a file has.
using Json = nlohmann::json;

/// A number of the report; none: null.
Json at(const Json& report, const char* path) {
    const Json::json_pointer pointer(path);
    return report.is_object() && report.contains(pointer) && report[pointer].is_number() ? report[pointer] : Json();
}

std::string text_of(const Json& number) {
    return number.is_number_integer() ? grouped(number.get<std::size_t>())
                                      : fmt::format("{:.4g}", number.get<double>());
}

std::string row(const Json& report, std::string_view name, const char* before, const char* after) {
    const Json first = at(report, before), last = at(report, after);
    if (first.is_null() || last.is_null()) return {};
    return table_row(name, text_of(first) + " -> " + text_of(last));
}

}  // namespace

std::string before_and_after(std::string_view report_json) {
    const Json report = Json::parse(report_json, nullptr, false);
    return row(report, "invalid elements", "/validity_before_correction/invalid", "/validity/invalid") +
           row(report, "undecided elements", "/validity_before_correction/undecided", "/validity/undecided") +
           row(report, "smallest scaled Jacobian", "/validity_before_correction/min_scaled_jacobian",
               "/validity/min_scaled_jacobian") +
           row(report, "largest distance to the geometry", "/boundary/largest_distance_straight",
               "/boundary/largest_distance") +
           row(report, "mean length reduction", "/curve/before_correction/mean_length_reduction",
               "/curve/after_correction/mean_length_reduction") +
           row(report, "mean curvature", "/curve/before_correction/mean_curvature",
               "/curve/after_correction/mean_curvature");
}

std::string mesh_of_report(std::string_view report_json) {
    const Json report = Json::parse(report_json, nullptr, false);
    const Json::json_pointer pointer("/config/output/mesh");
    if (!report.is_object() || !report.contains(pointer) || !report[pointer].is_string()) return {};
    return report[pointer].get<std::string>();
}

}  // namespace camber::run
