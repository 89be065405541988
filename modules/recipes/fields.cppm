module;
#include <concepts>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>
export module camber.recipes:fields;

/// Descriptions of report fields. A struct of a report describes its members once, by a static function `fields()` that
/// returns a tuple of `Field`; the JSON reports, the full tables and the reference of keys are derived from it.
export namespace camber::run {

/// When a field appears in a report.
enum class Presence : unsigned char {
    always,
    unless_empty,    ///< not where its value is the default one of its type: 0, false, an empty list or text
    unless_default,  ///< not where its value, a number or an enumeration, is that of S{}
    or_null,         ///< an optional value that is not there is null; of other fields the key is absent
    of_volume,       ///< not of a standalone surface mesh
};

/// One field of a report of type S: its key, its meaning as a noun phrase, and its unit (empty: none). `get` is a data
/// member, or a function of S. An empty key merges the fields of its value into those of S.
template <class S, class Get>
struct Field {
    std::string_view key;
    Get get;
    std::string_view meaning = {}, unit_name = {};
    Presence presence = Presence::always;

    [[nodiscard]] constexpr Field unit(std::string_view name) const {
        Field f = *this;
        f.unit_name = name;
        return f;
    }
    [[nodiscard]] constexpr Field unless_empty() const { return with(Presence::unless_empty); }
    [[nodiscard]] constexpr Field unless_default() const { return with(Presence::unless_default); }
    [[nodiscard]] constexpr Field or_null() const { return with(Presence::or_null); }
    [[nodiscard]] constexpr Field of_volume() const { return with(Presence::of_volume); }

  private:
    [[nodiscard]] constexpr Field with(Presence when) const {
        Field f = *this;
        f.presence = when;
        return f;
    }
};

template <class S>
struct Fields {
    template <class Get>
    [[nodiscard]] constexpr Field<S, Get> operator()(std::string_view key, Get get, std::string_view meaning) const {
        return {key, get, meaning};
    }
    /// Fields of a value of S that stand among those of S.
    template <class Get>
    [[nodiscard]] constexpr Field<S, Get> merged(Get get) const {
        return {{}, get};
    }
};

/// A struct that describes its fields.
template <class S>
concept HasFields = requires { std::tuple_size<decltype(S::fields())>::value; };

/// f(field) for each field of S, in the order in which S lists them.
template <HasFields S, class F>
constexpr void each_field(F&& f) {
    std::apply([&](const auto&... fields) { (f(fields), ...); }, S::fields());
}

/// The kind of mesh that a report is of: some fields are left out of reports of standalone surface meshes.
enum class Reported : unsigned char { volume, surface };

template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;
/// A list of named values.
template <class T>
inline constexpr bool is_map = false;
template <class T>
inline constexpr bool is_map<std::vector<std::pair<std::string, T>>> = true;

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

/// visit(field, value) for each field that the report shows, those of merged structs in their place.
template <HasFields S, class Visit>
void each_shown_field(const S& report, Reported of, const Visit& visit) {
    each_field<S>([&](const auto& field) {
        const auto& value = std::invoke(field.get, report);
        using T = std::remove_cvref_t<decltype(value)>;
        if (field.presence == Presence::of_volume && of == Reported::surface) return;
        if (field.presence == Presence::unless_empty && is_empty(value)) return;
        if constexpr ((std::is_arithmetic_v<T> || std::is_enum_v<T>) && std::default_initializable<S>)
            if (field.presence == Presence::unless_default && value == std::invoke(field.get, S{})) return;
        if constexpr (is_optional<T>) {
            if (!value && field.presence != Presence::or_null) return;
            if constexpr (HasFields<typename T::value_type>)
                if (field.key.empty()) return each_shown_field(*value, of, visit);
        } else if constexpr (HasFields<T>) {
            if (field.key.empty()) return each_shown_field(value, of, visit);
        }
        visit(field, value);
    });
}

}  // namespace camber::run
