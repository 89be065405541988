// JSON of reports, and their schemas
module;
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <optional>
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

Json head(std::string_view version) {
    return {{"format", report_format}, {"program", {{"name", "camber"}, {"version", version}}}};
}

Json head(const OriginReport& o) {
    Json j = head(o.version);
    j["input"] = json_of(o);
    j["config"] = Json::parse(o.config);
    j["units"] = {{"lengths", "units of the input mesh"},
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
    add_fields(j, report, report.mesh.is_standalone_surface() ? Reported::surface : Reported::volume);
    return text_of(j) + "\n";
}

std::string check_json_head(const CheckReport& report, std::string_view name, std::string_view version) {
    std::string text = text_of(json_of_file(report, name, version));
    text.resize(text.size() - 2);  // removes the last two characters, "\n}"
    return text;
}

std::string inspect_json(const GeometryReport& report, std::string_view name, std::string_view version) {
    return text_of(json_of_file(report, name, version)) + "\n";
}

namespace {

enum class Cells : std::uint8_t { json, csv };

/// Formats a lower bound with few digits. Read as a double, the result is at most the float.
std::string digits_below(float x) {
    std::string text = fmt::format("{}", x);
    if (std::isfinite(x) && std::strtod(text.c_str(), nullptr) > static_cast<double>(x))
        text = fmt::format("{}", std::nextafter(x, -std::numeric_limits<float>::infinity()));
    return text;
}

/// Appends the value of one element. In JSON, text is quoted and nonfinite numbers are null.
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

/// Calls visit(name, column) for each column that the mesh's degree has.
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

namespace {

template <class T>
[[nodiscard]] Json schema_of();

template <class T>
struct WithoutOptional {
    using type = T;
};
template <class T>
struct WithoutOptional<std::optional<T>> {
    using type = T;
};
template <class T>
using Unwrapped = typename WithoutOptional<T>::type;

/// JSON Schema of the object for a struct S. `named`: schemas of the keys that are known; `other`: schema of values
/// whose keys are arbitrary names.
struct Properties {
    Json named = Json::object(), other;
};

template <class S>
[[nodiscard]] Properties properties_of() {
    Properties all;
    each_field_of<S>([&](const Field& field, const auto& value) {
        using T = std::remove_cvref_t<decltype(value)>;
        if (!field.key.empty()) {
            Json property = schema_of<T>();
            property["description"] = field.meaning;
            if (!field.unit_name.empty()) property["unit"] = field.unit_name;
            if (field.presence == Presence::or_null) property["type"] = {property["type"], "null"};
            all.named[std::string(field.key)] = std::move(property);
        } else if constexpr (is_map<T>) {
            all.other = schema_of<typename T::value_type::second_type>();
            all.other["description"] = field.meaning;
        } else if constexpr (HasFields<Unwrapped<T>>) {
            const Properties merged = properties_of<Unwrapped<T>>();
            for (const auto& [key, property] : merged.named.items())
                if (field.has(key)) all.named[key] = property;
        }
    });
    return all;
}

template <class T>
Json schema_of() {
    if constexpr (HasFields<T>) {
        auto [named, other] = properties_of<T>();
        Json object{{"type", "object"}, {"properties", std::move(named)}};
        if (!other.is_null()) object["additionalProperties"] = std::move(other);
        return object;
    } else if constexpr (std::same_as<T, std::vector<Histogram>>) {
        return {{"type", "object"}};
    } else if constexpr (is_optional<T>) {
        return schema_of<typename T::value_type>();
    } else if constexpr (is_map<T>) {
        return {{"type", "object"}, {"additionalProperties", schema_of<typename T::value_type::second_type>()}};
    } else if constexpr (std::same_as<T, bool> || std::same_as<T, std::uint8_t>) {
        return {{"type", "boolean"}};
    } else if constexpr (std::integral<T>) {
        return {{"type", "integer"}};
    } else if constexpr (std::floating_point<T>) {
        return {{"type", "number"}};
    } else if constexpr (std::is_enum_v<T> || std::convertible_to<T, std::string_view>) {
        return {{"type", "string"}};
    } else {
        return {{"type", "array"}, {"items", schema_of<typename T::value_type>()}};
    }
}

Json described(std::string_view type, std::string_view meaning) { return {{"type", type}, {"description", meaning}}; }

Json head() {
    Json format = described("integer",
                            "number of the format version: it increases if a key is removed or changes its "
                            "meaning");
    format["const"] = report_format;
    Json program = described("object", "the program that wrote the report");
    program["properties"] = {{"name", described("string", "`camber`")},
                             {"version", described("string", "its version")}};
    return {{"format", std::move(format)}, {"program", std::move(program)}};
}

Json head_of_run() {
    Json properties = head();
    properties["input"] = schema_of<OriginReport>();
    properties["input"]["description"] = "the mesh that was read or generated";
    properties["config"] = described("object", "the pipeline with every default, as `--print-config` prints it");
    properties["units"] = described("object", "the units, in words");
    for (const char* const key : {"lengths", "metric", "angles", "times", "memory"})
        properties["units"]["properties"][key] = described("string", "unit");
    return properties;
}

Json head_of_file() {
    Json properties = head();
    properties["file"] = described("string", "path of the file");
    return properties;
}

template <class S>
Json schema_with(std::string_view title, Json first) {
    first.update(properties_of<S>().named);
    return {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
            {"title", title},
            {"type", "object"},
            {"properties", std::move(first)}};
}

template <class T>
void add_keys(const std::string& path, std::vector<ReportKey>& keys) {
    if constexpr (HasFields<T>)
        each_field_of<T>([&](const Field& field, const auto& value) {
            using Value = std::remove_cvref_t<decltype(value)>;
            const std::string key =
                field.key.empty() ? path : path + (path.empty() ? "" : ".") + std::string(field.key);
            if (!field.key.empty()) keys.push_back({key, field.meaning, field.unit_name});
            add_keys<Value>(key, keys);
        });
    else if constexpr (requires { typename T::value_type; } && !std::convertible_to<T, std::string_view>)
        add_keys<typename T::value_type>(path, keys);
}

}  // namespace

std::vector<ReportKey> report_keys() {
    std::vector<ReportKey> keys;
    add_keys<Report>({}, keys);
    return keys;
}

std::optional<std::string> report_schema(std::string_view of) {
    Json schema;
    if (of == "report") {
        schema = schema_with<Report>("Report of a run of Camber", head_of_run());
    } else if (of == "check") {
        schema = schema_with<CheckReport>("Report of camber check --json", head_of_file());
        schema["properties"]["element_verdicts"] = schema_of<ElementColumns>();
        schema["properties"]["element_verdicts"]["description"] =
            "with `--elements`: columns with one entry per "
            "element";
    } else if (of == "geometry") {
        schema = schema_with<GeometryReport>("Report of camber geometry --json", head_of_file());
    } else {
        return {};
    }
    return schema.dump(2) + "\n";
}

}  // namespace camber::run
