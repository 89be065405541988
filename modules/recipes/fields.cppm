module;
#include <algorithm>
#include <array>
#include <concepts>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>
export module camber.recipes:fields;
import camber.core;
import camber.interpolation;
import camber.crossing;

/// Descriptions of report fields. The static function `fields(s, f)` of a report struct calls f(key, value, meaning,
/// traits...) for each field of s. JSON reports, full tables and the reference of keys use it.
export namespace camber::run {

enum class Presence : unsigned char {
    always,
    conditional,   ///< if a condition holds
    unless_empty,  ///< unless the value is 0, false, an empty list or an empty text
    or_null,       ///< an empty optional value is null; for other fields its key is absent
    of_volume,     ///< not in reports of standalone surface meshes
};

/// A report field: key, meaning as a noun phrase, and unit (empty: none). An empty key merges the fields of the value,
/// or the items of a map, into the struct.
struct Field {
    std::string_view key, meaning = {}, unit_name = {};
    Presence presence = Presence::always;
    bool is_shown = true;
    std::array<std::string_view, 3> omitted = {};  ///< keys of a merged struct that are left out

    [[nodiscard]] constexpr bool has(std::string_view inner) const {
        return inner.empty() || std::ranges::find(omitted, inner) == omitted.end();
    }
};

/// Traits: functions that change the description of a field.
[[nodiscard]] constexpr auto unit(std::string_view name) {
    return [=](Field& f) { f.unit_name = name; };
}
[[nodiscard]] constexpr auto shown_if(bool holds) {
    return [=](Field& f) {
        f.presence = Presence::conditional;
        f.is_shown = holds;
    };
}
[[nodiscard]] constexpr auto without(std::array<std::string_view, 3> keys) {
    return [=](Field& f) { f.omitted = keys; };
}
constexpr void unless_empty(Field& f) { f.presence = Presence::unless_empty; }
constexpr void or_null(Field& f) { f.presence = Presence::or_null; }
constexpr void of_volume(Field& f) { f.presence = Presence::of_volume; }

template <class T>
[[nodiscard]] std::optional<T> only_if(bool holds, T value) {
    return holds ? std::optional<T>(std::move(value)) : std::nullopt;
}

/// The argument `f` of `fields`: calls visit(field, value).
template <class Visit>
struct FieldVisitor {
    const Visit& visit;

    template <class T, class... Traits>
    void operator()(std::string_view key, T&& value, std::string_view meaning, Traits... traits) const {
        Field field{key, meaning};
        (traits(field), ...);
        visit(field, std::forward<T>(value));
    }
    template <class T, class... Traits>
    void merged(T&& value, Traits... traits) const {
        (*this)({}, std::forward<T>(value), {}, traits...);
    }
};

/// Describes a struct of a lower module by a specialisation with `fields`.
template <class S>
struct FieldsOf;

template <class S>
concept DescribesItself = requires(S& s, const FieldVisitor<int>& f) { S::fields(s, f); };

template <class S>
concept HasFields = DescribesItself<S> || requires(S& s, const FieldVisitor<int>& f) { FieldsOf<S>::fields(s, f); };

/// Visits the fields of a struct in order; the visitor may change members.
template <class S, class Visit>
    requires HasFields<std::remove_const_t<S>>
void each_field(S& s, const Visit& visit) {
    const FieldVisitor<Visit> f{visit};
    if constexpr (DescribesItself<std::remove_const_t<S>>)
        S::fields(s, f);
    else
        FieldsOf<std::remove_const_t<S>>::fields(s, f);
}

/// Visits the fields of a struct with default values.
template <HasFields S, class Visit>
void each_field_of(const Visit& visit) {
    const S s{};
    each_field(s, visit);
}

/// Reports of standalone surface meshes omit some fields.
enum class Reported : unsigned char { volume, surface };

template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;
template <class T>
inline constexpr bool is_map = false;
template <class T>
inline constexpr bool is_map<std::vector<std::pair<std::string, T>>> = true;
template <class Number, class T>
inline constexpr bool is_map<std::map<Number, T>> = true;
[[nodiscard]] inline std::string key_text(const std::string& name) { return name; }
[[nodiscard]] inline std::string key_text(std::integral auto number) { return std::to_string(number); }

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

/// Visits the fields that the report shows, including merged ones.
template <HasFields S, class Visit>
void each_shown_field(const S& report, Reported of, const Visit& visit) {
    each_field(report, [&](const Field& field, const auto& value) {
        using T = std::remove_cvref_t<decltype(value)>;
        if (!field.is_shown || (field.presence == Presence::of_volume && of == Reported::surface)) return;
        if (field.presence == Presence::unless_empty && is_empty(value)) return;
        const auto visit_stored = [&](const Field& inner, const auto& item) {
            if (field.has(inner.key)) visit(inner, item);
        };
        if constexpr (is_optional<T>) {
            if (!value && field.presence != Presence::or_null) return;
            if constexpr (HasFields<typename T::value_type>)
                if (field.key.empty()) return each_shown_field(*value, of, visit_stored);
        } else if constexpr (HasFields<T>) {
            if (field.key.empty()) return each_shown_field(value, of, visit_stored);
        } else if constexpr (is_map<T>) {
            if (field.key.empty()) {
                for (const auto& [key, item] : value) {
                    const std::string text = key_text(key);
                    visit(Field{text, field.meaning}, item);
                }
                return;
            }
        }
        visit(field, value);
    });
}

template <>
struct FieldsOf<Group> {
    static void fields(auto& s, auto& f) {
        f("dimension", s.dimension, "dimension of the group");
        f("reference", s.reference, "its reference");
        f("name", s.name, "its name");
    }
};

template <>
struct FieldsOf<Crossings> {
    static void fields(auto& s, auto& f) {
        f("pairs", s.pairs, "number of pairs of facets with overlapping bounding boxes");
        f("crossing", s.crossing,
          "number of pairs that pass through each other ([crossing.md](algorithms/crossing.md))");
        f("touching", s.touching, "number of pairs that touch");
        f("undecided", s.undecided, "number of pairs that are too close for a certified answer");
        f("truncated", s.cut_short, "number of undecided pairs for which the limit of work was reached");
        f("steps", s.steps, "work: number of examined pairs of parts of facets");
    }
};

template <>
struct FieldsOf<ErrorNorm> {
    static void fields(auto& s, auto& f) {
        f("value", s.value, "norm of the error", unit("field length^(D/2), by length"));
        f("uncertainty", s.uncertainty, "relative error of that value", unit("1"));
        f("rounding", s.rounding, "value that rounding alone may cause", unit("that of the value"));
    }
};
template <>
struct FieldsOf<InterpolantError> {
    static void fields(auto& s, auto& f) {
        f("l2", s.l2, "L2 norm");
        f("h1", s.h1, "H1 seminorm");
    }
};
template <>
struct FieldsOf<Volumes> {
    static void fields(auto& s, auto& f) {
        f("straight", s.straight, "volume (2D: area) of the straight mesh", unit("length^D"));
        f("curved", s.curved, "volume (2D: area) of the mesh with its curves", unit("length^D"));
    }
};

/// Ratios of the errors of the compared mesh to those of the curved mesh; none where one of them is 0 to rounding.
struct ErrorRatios {
    std::optional<double> l2, h1;

    static void fields(auto& s, auto& f) {
        f("l2", s.l2, "ratio of the L2 norms; null: one of them is 0 to rounding", unit("1"), or_null);
        f("h1", s.h1, "ratio of the H1 seminorms; null: one of them is 0 to rounding", unit("1"), or_null);
    }
};
[[nodiscard]] ErrorRatios ratios_of(const InterpolationError& errors);

template <>
struct FieldsOf<InterpolationError> {
    static void fields(auto& s, auto& f) {
        f("linear", s.linear, "error of the interpolant of degree 1");
        f("straight", s.straight, "error of the interpolant of degree 2 with straight edges");
        f("same_boundary", s.same_boundary,
          "error of the interpolant of degree 2 with the mesh's nodes on facets of the boundary and of interfaces; all "
          "other edges are straight. If those facets are flat, equal to `straight`");
        f("curved", s.curved,
          "error of the interpolant of degree 2 with the mesh's nodes (mesh of degree 1: straight "
          "edges)");
        f("compared_with", s.compared_with,
          "numerator of `ratio`: `straight`, or `same_boundary` if boundary facets "
          "are curved");
        f("ratio", ratios_of(s),
          "error of `compared_with` divided by that of `curved`; above 1, curved inner edges "
          "reduce the error");
        f("straight_inverted", s.straight_inverted,
          "number of elements of `straight` with det J ≤ 0 at a quadrature point");
        f("same_boundary_inverted", s.same_boundary_inverted,
          "number of elements of `same_boundary` with det J ≤ 0 at "
          "a quadrature point or node");
        f("curved_inverted", s.curved_inverted,
          "number of elements of `curved` with det J ≤ 0 at a quadrature point "
          "or node");
        f("volume", s.volume, "volumes of the meshes");
        f("unresolved", s.unresolved, "number of elements whose quadrature did not converge");
        f("evaluations", s.evaluations, "number of evaluations of the field");
    }
};

}  // namespace camber::run
