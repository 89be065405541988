// Reports of runs, checks and boundaries as JSON; columns of elements as JSON and CSV
module;
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
module camber.reports;
import camber.core;
import camber.recipes;
import camber.transfer;
import camber.validity;
import :json;

namespace camber::run {

namespace {

/// The keys that stand first in all reports.
Json head(std::string_view version) {
    return {{"format", report_format}, {"program", {{"name", "camber"}, {"version", version}}}};
}

Json head(const OriginReport& o) {
    Json j = head(o.version);
    j["input"] = json_of(o);
    j["config"] = Json::parse(o.config);
    j["units"] = {{"lengths", "those of the input mesh"},
                  {"metric", "1/length^2"},
                  {"angles", "degrees"},
                  {"times", "seconds"},
                  {"memory", "bytes"}};
    return j;
}

template <class S>
Json json_of_file(const S& report, std::string_view name, std::string_view version) {
    Json j = head(version);
    j["file"] = name;
    add_fields(j, report, Reported::volume);
    return j;
}

std::string text_of(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace); }

}  // namespace

std::string to_json(const Report& report) {
    Json j = report.origin ? head(*report.origin) : Json::object();
    add_fields(j, report, report.mesh.is_surface_alone() ? Reported::surface : Reported::volume);
    return text_of(j) + "\n";
}

std::string check_json_head(const CheckReport& report, std::string_view name, std::string_view version) {
    std::string text = text_of(json_of_file(report, name, version));
    text.resize(text.size() - 2);  // "\n}"
    return text;
}

std::string inspect_json(const GeometryReport& report, std::string_view name, std::string_view version) {
    return text_of(json_of_file(report, name, version)) + "\n";
}

namespace {

enum class Cells : std::uint8_t { json, csv };

/// A lower bound in few digits: read back in doubles too it is not above the float.
std::string digits_below(float x) {
    std::string text = fmt::format("{}", x);
    if (std::isfinite(x) && std::strtod(text.c_str(), nullptr) > static_cast<double>(x))
        text = fmt::format("{}", std::nextafter(x, -std::numeric_limits<float>::infinity()));
    return text;
}

/// The value of one element. JSON has text in quotes, and null for numbers that are not finite.
template <class T>
void put(std::string& text, std::string_view column, T value, Cells cells) {
    const auto out = std::back_inserter(text);
    if constexpr (std::same_as<T, Verdict>)
        fmt::format_to(out, "{0}{1}{0}", cells == Cells::json ? "\"" : "", word(value));
    else if constexpr (std::same_as<T, std::uint8_t>)
        fmt::format_to(out, "{}", value == 1);
    else if constexpr (std::integral<T>)
        fmt::format_to(out, "{}", value);
    else if (cells == Cells::json && !std::isfinite(value))
        text += "null";
    else if (column == "min_scaled_jacobian")
        text += digits_below(static_cast<float>(value));
    else
        fmt::format_to(out, "{}", value);
}

/// visit(name, column) for each column of the mesh's degree.
void each_column(const CheckReport& report, auto&& visit) {
    each_shown_field(report.elements, Reported::volume,
                     [&](const auto& field, const auto& column) { visit(field.key, column); });
}

}  // namespace

std::vector<std::string> column_names(const CheckReport& report) {
    std::vector<std::string> names;
    each_column(report, [&](std::string_view name, const auto&) { names.emplace_back(name); });
    return names;
}

std::string column_items(const CheckReport& report, std::string_view column, std::size_t begin, std::size_t end) {
    std::string text;
    each_column(report, [&](std::string_view name, const auto& values) {
        for (std::size_t e = begin; e < end && name == column; ++e) {
            if (e > 0) text += ", ";
            put(text, name, values[e], Cells::json);
        }
    });
    return text;
}

std::string csv_titles(const CheckReport& report) {
    return fmt::format("element,{}\n", fmt::join(column_names(report), ","));
}

std::string csv_lines(const CheckReport& report, std::size_t begin, std::size_t end) {
    std::string text;
    for (std::size_t e = begin; e < end; ++e) {
        fmt::format_to(std::back_inserter(text), "{}", e + 1);
        each_column(report, [&](std::string_view name, const auto& values) {
            text += ',';
            put(text, name, values[e], Cells::csv);
        });
        text += '\n';
    }
    return text;
}

}  // namespace camber::run
