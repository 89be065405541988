module;
#include <concepts>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>
#include <nlohmann/json.hpp>
/// JSON of report structs, by their fields.
module camber.run:json;
import camber.core;
import :fields;
import :measurements;

namespace camber::run {

using Json = nlohmann::ordered_json;

/// The kind of mesh that a report is of: some fields are left out of reports of standalone surface meshes.
enum class Reported : unsigned char { volume, surface };

template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;
template <class T>
inline constexpr bool is_map = false;
template <class T>
inline constexpr bool is_map<std::vector<std::pair<std::string, T>>> = true;
template <class T>
inline constexpr bool is_list = false;
template <class T>
inline constexpr bool is_list<std::vector<T>> = true;

template <class T>
[[nodiscard]] bool is_empty(const T& value) {
    if constexpr (is_optional<T>)
        return !value.has_value();
    else if constexpr (requires { value.empty(); })
        return value.empty();
    else if constexpr (std::equality_comparable<T> && std::default_initializable<T>)
        return value == T{};
    else
        return false;
}

template <class S>
void add_fields(Json& object, const S& report, Reported of);

/// The histograms by their keys.
[[nodiscard]] Json json_of_histograms(const std::vector<Histogram>& histograms);

/// A struct with fields is an object, a list of named values an object with these names as keys, any other list an
/// array, a value of an enumeration its word.
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
        for (const auto& [key, item] : value) object[key] = json_of(item, of);
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
    each_field<S>([&](const auto& field) {
        const auto& value = std::invoke(field.get, report);
        using T = std::remove_cvref_t<decltype(value)>;
        if (field.presence == Presence::of_volume && of == Reported::surface) return;
        if (field.presence == Presence::unless_empty && is_empty(value)) return;
        if constexpr (is_optional<T>)
            if (!value && field.presence != Presence::or_null) return;
        if (!field.key.empty()) {
            object[std::string(field.key)] = json_of(value, of);
        } else if constexpr (is_optional<T>) {
            if constexpr (HasFields<typename T::value_type>) add_fields(object, *value, of);
        } else if constexpr (HasFields<T>) {
            add_fields(object, value, of);
        }
    });
}

}  // namespace camber::run
