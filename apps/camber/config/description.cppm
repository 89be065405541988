module;
#include <algorithm>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
#include <nlohmann/json.hpp>
module camber.config:description;
import camber.core;
import camber.shapes;
import camber.fields;
import :codec;
import :values;

namespace camber::config {

/// Each has its description in one of describe_*.cpp.
#define CAMBER_DESCRIBED(...)                         \
    template <>                                       \
    struct Described<__VA_ARGS__> {                   \
        static const CAMBER_KIND<__VA_ARGS__>& get(); \
    };
#define CAMBER_KIND Description
CAMBER_DESCRIBED(BoundaryLayer)
CAMBER_DESCRIBED(ShellOptions<3>)
CAMBER_DESCRIBED(ShellOptions<2>)
CAMBER_DESCRIBED(BoxOptions<3>)
CAMBER_DESCRIBED(BoxOptions<2>)
CAMBER_DESCRIBED(BumpOptions)
CAMBER_DESCRIBED(NaturalMetric)
CAMBER_DESCRIBED(ConstantMetric)
CAMBER_DESCRIBED(SurfaceMetric)
CAMBER_DESCRIBED(ReferenceSize)
CAMBER_DESCRIBED(GeometryMetric)
CAMBER_DESCRIBED(SolutionMetric)
CAMBER_DESCRIBED(LinearField)
CAMBER_DESCRIBED(PolarOneField)
CAMBER_DESCRIBED(PolarTwoField)
CAMBER_DESCRIBED(PlanarShock)
CAMBER_DESCRIBED(SphericalShock)
CAMBER_DESCRIBED(RotatingField)
CAMBER_DESCRIBED(Gradation)
CAMBER_DESCRIBED(Bound)
CAMBER_DESCRIBED(Complexity)
CAMBER_DESCRIBED(Surrogate)
CAMBER_DESCRIBED(Straight)
CAMBER_DESCRIBED(Plane)
CAMBER_DESCRIBED(Sphere)
CAMBER_DESCRIBED(Cylinder)
CAMBER_DESCRIBED(Torus)
CAMBER_DESCRIBED(AnalyticSurface)
CAMBER_DESCRIBED(Cad)
CAMBER_DESCRIBED(Input)
CAMBER_DESCRIBED(GivenSolution)
CAMBER_DESCRIBED(Features)
CAMBER_DESCRIBED(BoundaryTolerance)
CAMBER_DESCRIBED(Elevate)
CAMBER_DESCRIBED(Curve)
CAMBER_DESCRIBED(Validate)
CAMBER_DESCRIBED(Relax)
CAMBER_DESCRIBED(Commit)
CAMBER_DESCRIBED(Reinsert)
CAMBER_DESCRIBED(Collapse)
CAMBER_DESCRIBED(Split)
CAMBER_DESCRIBED(Swap)
CAMBER_DESCRIBED(Smooth)
CAMBER_DESCRIBED(Mend)
CAMBER_DESCRIBED(Remesh)
CAMBER_DESCRIBED(Adaptation)
CAMBER_DESCRIBED(Output)
CAMBER_DESCRIBED(Pipeline)
#undef CAMBER_KIND
#define CAMBER_KIND Choice
CAMBER_DESCRIBED(Shape)
CAMBER_DESCRIBED(MeshSource)
CAMBER_DESCRIBED(Metric)
CAMBER_DESCRIBED(FieldMetric)
CAMBER_DESCRIBED(MetricExpression)
CAMBER_DESCRIBED(MetricOperation)
CAMBER_DESCRIBED(Surface)
CAMBER_DESCRIBED(Geometry)
CAMBER_DESCRIBED(Stage)
#undef CAMBER_KIND
#undef CAMBER_DESCRIBED

/// An expression alone: a string, or an array of strings.
template <>
struct Codec<SizeExpression> {
    static Outcome<SizeExpression> read(const Json& json, const Place& place, const Limits&);
    static Json write(const SizeExpression& e) { return e.size; }
    static Json schema(const Limits&);
    static std::string type(const Limits&);
};
template <>
struct Codec<SizesExpression> {
    static Outcome<SizesExpression> read(const Json& json, const Place& place, const Limits&);
    static Json write(const SizesExpression& e) { return e.sizes; }
    static Json schema(const Limits&);
    static std::string type(const Limits&);
};
template <>
struct Codec<TensorExpression> {
    static Outcome<TensorExpression> read(const Json& json, const Place& place, const Limits&);
    static Json write(const TensorExpression& e) { return e.tensor; }
    static Json schema(const Limits&);
    static std::string type(const Limits&);
};
/// A metric in a metric's place.
template <>
struct Codec<Intersect> {
    static Outcome<Intersect> read(const Json& json, const Place& place, const Limits&);
    static Json write(const Intersect& intersect);
    static Json schema(const Limits&);
    static std::string type(const Limits&);
};

template <>
struct Codec<SizesMetric> {
    using Items = Codec<std::vector<ReferenceSize>>;
    static Outcome<SizesMetric> read(const Json& json, const Place& place, const Limits&);
    static Json write(const SizesMetric& metric);
    static Json schema(const Limits&);
    static std::string type(const Limits&);
};
template <>
struct Codec<Analytic> {
    using Items = Codec<std::vector<AnalyticSurface>>;
    static Outcome<Analytic> read(const Json& json, const Place& place, const Limits&);
    static Json write(const Analytic& analytic);
    static Json schema(const Limits&);
    static std::string type(const Limits&);
};

template <Struct S>
struct Codec<S> {
    static const Description<S>& description() { return Described<S>::get(); }

    static std::vector<std::string> keys() {
        std::vector<std::string> all;
        for (const auto& field : description().fields) all.insert(all.end(), field.keys.begin(), field.keys.end());
        return all;
    }
    /// Whether {} says it all.
    static bool may_be_empty() {
        for (const auto& field : description().fields)
            if (field.is_required) return false;
        return true;
    }

    static Outcome<S> read(const Json& json, const Place& place, const Limits&) {
        const auto known = keys();
        if (!json.is_object())
            return bad(place, "expected an object, got " + kind_of(json),
                       known.empty() ? std::string() : suggestion("", known));
        for (const auto& [key, value] : json.items())
            if (std::find(known.begin(), known.end(), key) == known.end() &&
                !(place.pointer.empty() && key == "$schema"))
                return bad(place.at(key), "unknown key", suggestion(key, known));
        S value{};
        for (const auto& field : description().fields)
            if (auto done = read_field(json, place, field, value); !done) return fail(done.error());
        if (description().check)
            if (std::string wrong = description().check(value); !wrong.empty()) return bad(place, std::move(wrong));
        return value;
    }
    static Json write(const S& value) {
        Json object = Json::object();
        for (const auto& field : description().fields) field.write(value, object);
        return object;
    }
    static Json schema(const Limits&) {
        Json schema{{"type", "object"}, {"description", description().doc}, {"properties", Json::object()}};
        const Json defaults = write(S{});
        Json required = Json::array(), exactly_one = Json::array();
        for (const auto& field : description().fields) {
            for (const auto& key : field.keys) {
                Json property = field.schema(key, field.limits);
                const std::string unit = field.unit_name.empty() ? "" : " (" + field.unit_name + ")";
                if (!field.doc.empty()) property["description"] = field.doc + unit;
                if (!field.is_required && defaults.contains(key)) property["default"] = defaults[key];
                schema["properties"][key] = std::move(property);
                if (field.keys.size() > 1) exactly_one.push_back({{"required", Json::array({key})}});
            }
            if (field.is_required && field.keys.size() == 1) required.push_back(field.keys[0]);
        }
        if (!required.empty()) schema["required"] = std::move(required);
        if (!exactly_one.empty()) schema["oneOf"] = std::move(exactly_one);
        schema["additionalProperties"] = false;
        return schema;
    }
    static std::string type(const Limits&) { return "object, see " + description().name; }

  private:
    static Outcome<Done> read_field(const Json& json, const Place& place, const Field<S>& field, S& value) {
        std::string found;
        for (const auto& key : field.keys) {
            if (!json.contains(key)) continue;
            if (!found.empty())
                return bad(place.at(key),
                           "only one of " + in_quotes(found) + " and " + in_quotes(key) + " may be given");
            found = key;
        }
        if (!found.empty()) return field.read(json, found, place, field.limits, value);
        if (!field.is_required) return Done{};
        std::string names;
        for (const auto& key : field.keys) names += (names.empty() ? "\"" : " or \"") + key + "\"";
        return bad(place, names + " is missing");
    }
};

/// f(index, default value of the alternative) for each alternative of a variant.
template <class V, class F>
void each_alternative(F&& f) {
    [&]<std::size_t... I>(std::index_sequence<I...>) {
        (f(std::integral_constant<std::size_t, I>{}, std::variant_alternative_t<I, V>{}), ...);
    }(std::make_index_sequence<std::variant_size_v<V>>{});
}

/// Whether an alternative may be given by its bare key.
template <class T>
[[nodiscard]] bool may_be_bare() {
    if constexpr (Struct<T>)
        return Codec<T>::may_be_empty();
    else
        return false;
}

template <OneOf V>
struct Codec<V> {
    static const Choice<V>& choice() { return Described<V>::get(); }
    static std::vector<std::string> keys() {
        std::vector<std::string> all;
        for (const auto& a : choice().alternatives) all.push_back(a.key);
        return all;
    }

    static Outcome<V> read(const Json& json, const Place& place, const Limits& limits) {
        if (json.is_string()) return read_key(json.get<std::string>(), Json(), place, limits);
        if (!json.is_object() || json.size() != 1) {
            const std::string got = json.is_object() ? std::to_string(json.size()) + " keys" : kind_of(json);
            return bad(place, "expected an object with one key, got " + got, suggestion("", keys()));
        }
        return read_key(json.begin().key(), json.begin().value(), place.at(json.begin().key()), limits);
    }
    /// The alternative of this key; null stands for the bare key.
    static Outcome<V> read_key(const std::string& key, const Json& options, const Place& place, const Limits& limits) {
        Outcome<V> result =
            bad(place, options.is_null() ? "unknown word " + in_quotes(key) : "unknown key", suggestion(key, keys()));
        each_alternative<V>([&](auto index, auto sample) {
            using T = decltype(sample);
            if (key != choice().alternatives[index].key) return;
            if (options.is_null() && !may_be_bare<T>()) {
                result =
                    bad(place, "\"" + key + "\" needs its options: {\"" + key + "\": …}", "see: camber explain " + key);
                return;
            }
            auto value = Codec<T>::read(options.is_null() ? Json::object() : options, place, limits);
            if (value)
                result = V(std::in_place_index<index>, std::move(*value));
            else
                result = fail(std::move(value.error()));
        });
        return result;
    }
    static std::string key(const V& value) { return choice().alternatives[value.index()].key; }
    static Json options(const V& value) {
        return std::visit([](const auto& v) { return Codec<std::remove_cvref_t<decltype(v)>>::write(v); }, value);
    }
    static Json write(const V& value) {
        Json written = options(value);
        // Without options the bare word reads best.
        if (written.is_object() && written.empty()) return key(value);
        return Json{{key(value), std::move(written)}};
    }
    static Json schema_of(const std::string& wanted, const Limits& limits) {
        Json schema;
        each_alternative<V>([&](auto index, auto sample) {
            if (choice().alternatives[index].key == wanted) schema = Codec<decltype(sample)>::schema(limits);
        });
        return schema;
    }
    static Json schema(const Limits& limits) {
        Json any = Json::array(), bare = Json::array();
        each_alternative<V>([&](auto index, auto sample) {
            const Alternative& a = choice().alternatives[index];
            any.push_back({{"type", "object"},
                           {"description", a.doc},
                           {"properties", {{a.key, schema_of(a.key, limits)}}},
                           {"required", Json::array({a.key})},
                           {"additionalProperties", false}});
            if (may_be_bare<decltype(sample)>()) bare.push_back(a.key);
        });
        if (!bare.empty()) any.push_back({{"enum", std::move(bare)}});
        return {{"description", choice().doc}, {"oneOf", std::move(any)}};
    }
    static std::string type(const Limits&) {
        std::string text;
        each_alternative<V>([&](auto index, auto sample) {
            const std::string& k = choice().alternatives[index].key;
            text += (text.empty() ? "" : " or ") +
                    (may_be_bare<decltype(sample)>() ? "\"" + k + "\"" : "{\"" + k + "\": …}");
        });
        return text;
    }
};

/// A field of any type that has a codec.
template <class S, class T>
[[nodiscard]] Field<S> field(std::string name, T S::* member, std::string doc) {
    Field<S> f;
    f.keys = {name};
    f.doc = std::move(doc);
    f.read = [member](const Json& object, const std::string& key, const Place& place, const Limits& limits,
                      S& into) -> Outcome<Done> {
        auto value = Codec<T>::read(object[key], place.at(key), limits);
        if (!value) return fail(std::move(value.error()));
        into.*member = std::move(*value);
        return Done{};
    };
    f.write = [member, name](const S& from, Json& object) { object[name] = Codec<T>::write(from.*member); };
    f.schema = [](const std::string&, const Limits& limits) { return Codec<T>::schema(limits); };
    f.type = [](const Limits& limits) { return Codec<T>::type(limits); };
    f.name = std::move(name);
    return f;
}

/// The key of one alternative of a choice.
template <class T>
struct Key {
    Alternative alternative;
};
template <class T>
[[nodiscard]] Key<T> key(std::string name, std::string doc) {
    return {{std::move(name), std::move(doc)}};
}

/// A choice with a key for each alternative of the variant.
template <class V, class... T>
[[nodiscard]] Choice<V> choice_of(std::string name, std::string doc, Key<T>... keys) {
    static_assert(std::is_same_v<V, std::variant<T...>>, "one key for each alternative, in the variant's order");
    return {std::move(name), std::move(doc), {std::move(keys.alternative)...}};
}

/// An option as its struct, or one that S is derived from, describes it.
template <class S, class B, class T>
[[nodiscard]] Field<S> field(const Option<B, T>& option) {
    T S::* member = option.member;
    Field<S> f = field<S>(std::string(option.name), member, std::string(option.sentence));
    f.unit_name = option.unit_name;
    f.limits = option.limits;
    f.is_required = option.is_required;
    return f;
}

/// All options that a struct lists.
template <HasOptions S>
[[nodiscard]] std::vector<Field<S>> listed() {
    std::vector<Field<S>> fields;
    each_option<S>([&](const auto& option) { fields.push_back(field<S>(option)); });
    return fields;
}

/// A choice whose keys stand in the struct's own object, beside its other fields.
template <class S, OneOf V>
[[nodiscard]] Field<S> inlined(V S::* member) {
    Field<S> f;
    f.keys = Codec<V>::keys();
    for (const auto& key : f.keys) f.name += (f.name.empty() ? "" : " | ") + key;
    f.doc = Described<V>::get().doc;
    f.read = [member](const Json& object, const std::string& key, const Place& place, const Limits& limits,
                      S& into) -> Outcome<Done> {
        auto value = Codec<V>::read_key(key, object[key], place.at(key), limits);
        if (!value) return fail(std::move(value.error()));
        into.*member = std::move(*value);
        return Done{};
    };
    f.write = [member](const S& from, Json& object) {
        object[Codec<V>::key(from.*member)] = Codec<V>::options(from.*member);
    };
    f.schema = [](const std::string& key, const Limits& limits) { return Codec<V>::schema_of(key, limits); };
    f.type = [](const Limits& limits) { return Codec<V>::type(limits); };
    return f;
}

}  // namespace camber::config
