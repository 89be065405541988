module;
#include <algorithm>
#include <array>
#include <concepts>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>
export module camber.recipes:fields;
import camber.core;
import camber.interpolation;
import camber.crossing;

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
/// member, or a function of S. An empty key merges the fields of its value, or the items of a map, into those of S.
template <class S, class Get>
struct Field {
    std::string_view key;
    Get get;
    std::string_view meaning = {}, unit_name = {};
    Presence presence = Presence::always;
    bool (S::*condition)() const = nullptr;        ///< the field is absent where it is false
    std::array<std::string_view, 3> omitted = {};  ///< keys of a merged struct that are left out

    [[nodiscard]] constexpr Field unit(std::string_view name) const {
        Field f = *this;
        f.unit_name = name;
        return f;
    }
    [[nodiscard]] constexpr Field where(bool (S::*holds)() const) const {
        Field f = *this;
        f.condition = holds;
        return f;
    }
    [[nodiscard]] constexpr Field without(std::array<std::string_view, 3> keys) const {
        Field f = *this;
        f.omitted = keys;
        return f;
    }
    [[nodiscard]] constexpr bool has(std::string_view inner) const {
        return inner.empty() || std::ranges::find(omitted, inner) == omitted.end();
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

/// Fields of a struct of a lower module, which does not describe itself: a specialisation has `fields()`.
template <class S>
struct FieldsOf;

template <class S>
concept DescribesItself = requires { std::tuple_size<decltype(S::fields())>::value; };

/// A struct whose fields are described.
template <class S>
concept HasFields = DescribesItself<S> || requires { std::tuple_size<decltype(FieldsOf<S>::fields())>::value; };

/// f(field) for each field of S, in the order in which S lists them.
template <HasFields S, class F>
constexpr void each_field(F&& f) {
    const auto each = [&](const auto&... fields) { (f(fields), ...); };
    if constexpr (DescribesItself<S>)
        std::apply(each, S::fields());
    else
        std::apply(each, FieldsOf<S>::fields());
}

/// A function that returns `get` of `member` of a struct.
template <class Member, class Get>
[[nodiscard]] constexpr auto through(Member member, Get get) {
    return [=](const auto& s) { return std::invoke(get, std::invoke(member, s)); };
}

/// The kind of mesh that a report is of: some fields are left out of reports of standalone surface meshes.
enum class Reported : unsigned char { volume, surface };

template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;
/// Values by names or by numbers.
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

/// visit(field, value) for each field that the report shows, merged ones in their place.
template <HasFields S, class Visit>
void each_shown_field(const S& report, Reported of, const Visit& visit) {
    each_field<S>([&](const auto& field) {
        if (field.condition && !std::invoke(field.condition, report)) return;
        const auto& value = std::invoke(field.get, report);
        using T = std::remove_cvref_t<decltype(value)>;
        if (field.presence == Presence::of_volume && of == Reported::surface) return;
        if (field.presence == Presence::unless_empty && is_empty(value)) return;
        if constexpr ((std::is_arithmetic_v<T> || std::is_enum_v<T>) && std::default_initializable<S>)
            if (field.presence == Presence::unless_default && value == std::invoke(field.get, S{})) return;
        const auto visit_kept = [&](const auto& inner, const auto& item) {
            if (field.has(inner.key)) visit(inner, item);
        };
        if constexpr (is_optional<T>) {
            if (!value && field.presence != Presence::or_null) return;
            if constexpr (HasFields<typename T::value_type>)
                if (field.key.empty()) return each_shown_field(*value, of, visit_kept);
        } else if constexpr (HasFields<T>) {
            if (field.key.empty()) return each_shown_field(value, of, visit_kept);
        } else if constexpr (is_map<T>) {
            if (field.key.empty()) {
                for (const auto& [key, item] : value) visit(Fields<S>{}(key_text(key), field.get, field.meaning), item);
                return;
            }
        }
        visit(field, value);
    });
}

}  // namespace camber::run

/// Descriptions of structs of lower modules.
export namespace camber::run {

template <>
struct FieldsOf<Group> {
    static constexpr auto fields(Fields<Group> f = {}) {
        return std::tuple(f("dimension", &Group::dimension, "dimension of the group"),
                          f("reference", &Group::reference, "its reference"), f("name", &Group::name, "its name"));
    }
};

template <>
struct FieldsOf<Crossings> {
    static constexpr auto fields(Fields<Crossings> f = {}) {
        return std::tuple(
            f("pairs", &Crossings::pairs, "number of pairs of facets whose boxes meet"),
            f("crossing", &Crossings::crossing,
              "pairs that pass through each other ([crossing.md](algorithms/crossing.md))"),
            f("touching", &Crossings::touching, "pairs that touch"),
            f("undecided", &Crossings::undecided, "pairs that are too near to each other for a decision"),
            f("truncated", &Crossings::cut_short, "number of the undecided for which the limit of work was reached"),
            f("steps", &Crossings::steps, "work: number of pairs of parts of facets that were examined"));
    }
};

template <>
struct FieldsOf<ErrorNorm> {
    static constexpr auto fields(Fields<ErrorNorm> f = {}) {
        return std::tuple(
            f("value", &ErrorNorm::value, "the norm of the error").unit("field length^(D/2), by length"),
            f("uncertainty", &ErrorNorm::uncertainty, "relative error of that value").unit("1"),
            f("rounding", &ErrorNorm::rounding, "value that rounding alone may cause").unit("that of the value"));
    }
};
template <>
struct FieldsOf<InterpolantError> {
    static constexpr auto fields(Fields<InterpolantError> f = {}) {
        return std::tuple(f("l2", &InterpolantError::l2, "L2 norm"), f("h1", &InterpolantError::h1, "H1 seminorm"));
    }
};
template <>
struct FieldsOf<Volumes> {
    static constexpr auto fields(Fields<Volumes> f = {}) {
        return std::tuple(f("straight", &Volumes::straight, "volume (2D: area) of the straight mesh").unit("length^D"),
                          f("curved", &Volumes::curved, "volume of the mesh as it is").unit("length^D"));
    }
};

/// Errors of the compared mesh by those of the mesh as it is; none where one of them is 0 to rounding.
struct ErrorRatios {
    std::optional<double> l2, h1;

    [[nodiscard]] static constexpr auto fields() {
        using S = ErrorRatios;
        constexpr Fields<S> f;
        return std::tuple(f("l2", &S::l2, "of the L2 norms; null: one of them is 0 to rounding").unit("1").or_null(),
                          f("h1", &S::h1, "of the H1 seminorms; null: likewise").unit("1").or_null());
    }
};
[[nodiscard]] ErrorRatios ratios_of(const InterpolationError& errors);

template <>
struct FieldsOf<InterpolationError> {
    static constexpr auto fields(Fields<InterpolationError> f = {}) {
        return std::tuple(
            f("linear", &InterpolationError::linear, "error of the interpolant of degree 1"),
            f("straight", &InterpolationError::straight, "of degree 2 with straight edges"),
            f("same_boundary", &InterpolationError::same_boundary,
              "of degree 2, facets of the boundary and of interfaces with the mesh's nodes, all other edges straight; "
              "if those facets are flat the same as `straight`"),
            f("curved", &InterpolationError::curved,
              "of degree 2 with the mesh's nodes (a mesh of degree 1: straight ones)"),
            f("compared_with", &InterpolationError::compared_with,
              "numerator of `ratio`: `straight`, or `same_boundary` if walls are curved"),
            f("ratio", ratios_of, "error of `compared_with` by `curved`: above 1 curved inner edges pay"),
            f("straight_inverted", &InterpolationError::straight_turned,
              "elements of `straight` with det J ≤ 0 at a point of the quadrature"),
            f("same_boundary_inverted", &InterpolationError::same_boundary_turned,
              "the same of `same_boundary`, at nodes too"),
            f("curved_inverted", &InterpolationError::curved_turned, "the same of `curved`"),
            f("volume", &InterpolationError::volume, "volumes of the meshes"),
            f("unresolved", &InterpolationError::unresolved, "number of elements whose quadrature did not converge"),
            f("evaluations", &InterpolationError::evaluations, "number of evaluations of the field"));
    }
};

}  // namespace camber::run
