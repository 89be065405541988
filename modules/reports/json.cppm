module;
#include <concepts>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>
#include <nlohmann/json.hpp>
/// Converts report structs to JSON by their fields.
module camber.reports:json;
import camber.core;
import camber.recipes;

namespace camber::run {

using Json = nlohmann::ordered_json;

template <class T>
inline constexpr bool is_list = false;
template <class T>
inline constexpr bool is_list<std::vector<T>> = true;

template <class S>
void add_fields(Json& object, const S& report, Reported of);

[[nodiscard]] Json json_of_histograms(const std::vector<Histogram>& histograms);

/// Converts a struct with fields to an object. Lists of named values and numbered lists become objects with these keys,
/// other lists arrays, and enumerators words.
template <class T>
[[nodiscard]] Json json_of(const T& value, Reported of = Reported::volume) {
    if constexpr (std::same_as<T, Json>) {
        return value;
    } else if constexpr (std::same_as<T, std::vector<Histogram>>) {
        return json_of_histograms(value);
    } else if constexpr (HasFields<T>) {
        Json object = Json::object();
        add_fields(object, value, of);
        return object;
    } else if constexpr (is_optional<T>) {
        return value ? json_of(*value, of) : Json(nullptr);
    } else if constexpr (is_map<T>) {
        Json object = Json::object();
        for (const auto& [key, item] : value) object[key_text(key)] = json_of(item, of);
        return object;
    } else if constexpr (is_list<T>) {
        Json array = Json::array();
        for (const auto& item : value) array.push_back(json_of(item, of));
        return array;
    } else if constexpr (std::is_enum_v<T>) {
        return Json(word_of(value));
    } else {
        return Json(value);
    }
}

template <class S>
void add_fields(Json& object, const S& report, Reported of) {
    each_shown_field(
        report, of, [&](const auto& field, const auto& value) { object[std::string(field.key)] = json_of(value, of); });
}

/// Reads a report value. Conditional fields may be absent and then have their default. Throws nlohmann::json::exception
/// (missing key, wrong type).
template <class T>
[[nodiscard]] T value_of_json(const Json& json) {
    T value{};
    if constexpr (HasFields<T>) {
        each_field(value, [&](const Field& field, auto& member) {
            using Member = std::remove_reference_t<decltype(member)>;
            const std::string key(field.key);
            const bool may_be_absent = is_optional<Member> || field.presence != Presence::always;
            if (!may_be_absent || json.contains(key)) member = value_of_json<Member>(json.at(key));
        });
    } else if constexpr (is_optional<T>) {
        value = value_of_json<typename T::value_type>(json);
    } else if constexpr (std::is_enum_v<T>) {
        for (const auto& [enumerator, word] : words(T{}))
            if (json.get<std::string>() == word) value = enumerator;
    } else {
        json.get_to(value);
    }
    return value;
}

/// Reads the fields of a struct. Members without a key in the object are unchanged. Throws exceptions of the JSON
/// library for values of another type.
template <class AnyJson, class T>
void read_json(const AnyJson& json, T& value) {
    if constexpr (HasFields<T>) {
        each_field(value, [&](const Field& field, auto&& member) {
            if constexpr (std::is_lvalue_reference_v<decltype(member)>)
                if (const auto at = json.find(std::string(field.key)); at != json.end()) read_json(*at, member);
        });
    } else if constexpr (requires { requires HasFields<typename T::value_type>; }) {
        for (const AnyJson& item : json) read_json(item, value.emplace_back());
    } else {
        json.get_to(value);
    }
}

}  // namespace camber::run
