module;
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>
module camber.config;
import camber.core;
import :codec;
import :json;

namespace camber::config {

void add_limits(const Limits& limits, Json& schema) {
    if (std::isfinite(limits.low)) schema[limits.low_open ? "exclusiveMinimum" : "minimum"] = limits.low;
    if (std::isfinite(limits.high)) schema[limits.high_open ? "exclusiveMaximum" : "maximum"] = limits.high;
}

Outcome<double> Codec<double>::read(const Json& json, const Place& place, const Limits& limits) {
    if (!json.is_number()) return bad(place, "expected a number, got " + kind_of(json));
    const auto x = json.get<double>();
    if (!std::isfinite(x)) return bad(place, "the number is too large");
    if (!limits.hold(x)) return bad(place, out_of_limits(limits, json.dump()));
    return x;
}

Json Codec<double>::schema(const Limits& limits) {
    Json schema{{"type", "number"}};
    add_limits(limits, schema);
    return schema;
}

std::string Codec<double>::type(const Limits& limits) {
    return limits.text().empty() ? "number" : "number, " + limits.text();
}

Outcome<std::string> Codec<std::string>::read(const Json& json, const Place& place, const Limits&) {
    if (!json.is_string()) return bad(place, "expected a string, got " + kind_of(json));
    return json.get<std::string>();
}

Outcome<FilePath> Codec<FilePath>::read(const Json& json, const Place& place, const Limits&) {
    if (!json.is_string()) return bad(place, "expected a file's path, got " + kind_of(json));
    if (json.get<std::string>().empty()) return bad(place, "the path is empty");
    return FilePath{json.get<std::string>()};
}

Outcome<Done> check_array(const Json& json, const Place& place, const Limits& limits) {
    if (!json.is_array()) return bad(place, "expected an array, got " + kind_of(json));
    if (json.size() >= limits.min_count && json.size() <= limits.max_count) return Done{};
    const bool exact = limits.min_count == limits.max_count;
    std::string wanted = std::to_string(limits.min_count);
    if (!exact)
        wanted = limits.max_count == std::numeric_limits<std::size_t>::max()
                     ? "at least " + wanted
                     : wanted + " to " + std::to_string(limits.max_count);
    return bad(place, "expected " + wanted + " items, got " + std::to_string(json.size()));
}

std::string array_type(const std::string& item, const Limits& limits) {
    const bool open = limits.max_count == std::numeric_limits<std::size_t>::max();
    std::string count = std::to_string(limits.min_count);
    if (open)
        count = limits.min_count == 0 ? "" : "at least " + count;
    else if (limits.min_count != limits.max_count)
        count += " to " + std::to_string(limits.max_count);
    return "array of " + (count.empty() ? "" : count + " × ") + item;
}

Json array_schema(Json items, const Limits& limits) {
    Json schema{{"type", "array"}, {"items", std::move(items)}};
    if (limits.min_count > 0) schema["minItems"] = limits.min_count;
    if (limits.max_count != std::numeric_limits<std::size_t>::max()) schema["maxItems"] = limits.max_count;
    return schema;
}

}  // namespace camber::config
