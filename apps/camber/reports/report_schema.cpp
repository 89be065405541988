// The JSON Schema of report.json, from the descriptions of its fields.
module;
#include <concepts>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>
#include <nlohmann/json.hpp>
module camber.reports;
import camber.core;
import camber.recipes;
import camber.transfer;
import :json;

namespace camber::run {

namespace {

template <class T>
[[nodiscard]] Json schema_of();

template <class S>
void add_properties(Json& properties) {
    each_field<S>([&](const auto& field) {
        using T = std::remove_cvref_t<decltype(std::invoke(field.get, std::declval<const S&>()))>;
        if (!field.key.empty()) {
            Json property = schema_of<T>();
            property["description"] = field.meaning;
            if (!field.unit_name.empty()) property["unit"] = field.unit_name;
            if (field.presence == Presence::or_null) property["type"] = {property["type"], "null"};
            properties[std::string(field.key)] = std::move(property);
        } else if constexpr (is_optional<T>) {
            if constexpr (HasFields<typename T::value_type>) add_properties<typename T::value_type>(properties);
        } else if constexpr (HasFields<T>) {
            add_properties<T>(properties);
        }
    });
}

template <class T>
Json schema_of() {
    if constexpr (HasFields<T>) {
        Json properties = Json::object();
        add_properties<T>(properties);
        return {{"type", "object"}, {"properties", std::move(properties)}};
    } else if constexpr (std::same_as<T, std::vector<Histogram>>) {
        return {{"type", "object"}};
    } else if constexpr (is_optional<T>) {
        return schema_of<typename T::value_type>();
    } else if constexpr (is_map<T>) {
        return {{"type", "object"}, {"additionalProperties", schema_of<typename T::value_type::second_type>()}};
    } else if constexpr (std::same_as<T, bool>) {
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

/// The properties that stand before those of `Report`.
Json head() {
    Json format = described("integer", "number of this layout: it rises when a key goes or changes its meaning");
    format["const"] = report_format;
    Json program = described("object", "the program that wrote the report");
    program["properties"] = {{"name", described("string", "`camber`")},
                             {"version", described("string", "its version")}};
    Json input = schema_of<OriginReport>();
    input["description"] = "the mesh that was read or generated";
    Json units = described("object", "the units, in words");
    for (const char* const key : {"lengths", "metric", "angles", "times", "memory"})
        units["properties"][key] = described("string", "unit");
    return {{"format", std::move(format)},
            {"program", std::move(program)},
            {"input", std::move(input)},
            {"config", described("object", "the pipeline with every default, as `--print-config` prints it")},
            {"units", std::move(units)}};
}

template <class T>
void add_keys(const std::string& path, std::vector<ReportKey>& keys) {
    if constexpr (HasFields<T>)
        each_field<T>([&](const auto& field) {
            using Value = std::remove_cvref_t<decltype(std::invoke(field.get, std::declval<const T&>()))>;
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

std::string report_schema() {
    Json properties = head();
    add_properties<Report>(properties);
    const Json schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                      {"title", "Report of a run of Camber"},
                      {"type", "object"},
                      {"properties", std::move(properties)}};
    return schema.dump(2) + "\n";
}

}  // namespace camber::run
