module;
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
#include <nlohmann/json.hpp>
module camber.config:codec;
import camber.core;
import camber.validity;
import :values;

namespace camber::config {

using Json = nlohmann::ordered_json;

/// Where in a config: the file's name and a JSON pointer.
struct Place {
    std::string file, pointer;

    [[nodiscard]] Place at(std::string_view key) const { return {file, pointer + "/" + shortened(key)}; }
    [[nodiscard]] Place at(std::size_t index) const { return at(std::to_string(index)); }
    [[nodiscard]] std::string text() const {
        if (pointer.empty()) return file.empty() ? "/" : file;
        return file.empty() ? pointer : file + ": " + pointer;
    }
};

[[nodiscard]] inline auto bad(const Place& place, std::string what, std::string remedy = {}) {
    return fail(ErrorKind::usage, std::move(what), place.text(), {}, std::move(remedy));
}

/// "a string", "a number" …
[[nodiscard]] std::string kind_of(const Json& json);

/// Syntax errors with line and column; duplicate keys with their path.
[[nodiscard]] Outcome<Json> parse_json(std::string_view text, std::string_view name);

/// Sets what `path=value` says in a config. Errors (usage): a path that leads nowhere.
[[nodiscard]] Outcome<Done> override_value(Json& json, std::string_view assignment);

/// The candidate nearest to a misspelt word, or nothing when none is near.
[[nodiscard]] std::string nearest(std::string_view word, const std::vector<std::string>& candidates);

/// `did you mean "…"?`, else the candidates.
[[nodiscard]] std::string suggestion(std::string_view word, const std::vector<std::string>& candidates);

/// Puts the limits of a number into its schema.
void add_limits(const Limits& limits, Json& schema);

/// One field of a struct S: the single description from which it is read, written, explained and put into the schema.
template <class S>
struct Field {
    std::string name, doc, unit_name;
    Limits limits;
    bool is_required = false;
    /// The keys that it takes in the struct's object: its name, or those of an inlined choice, of which exactly one.
    std::vector<std::string> keys;
    std::function<Outcome<Done>(const Json& object, const std::string& key, const Place&, const Limits&, S&)> read;
    std::function<void(const S&, Json& object)> write;
    std::function<Json(const std::string& key, const Limits&)> schema;
    std::function<std::string(const Limits&)> type;

    [[nodiscard]] Field unit(std::string text) && { return unit_name = std::move(text), std::move(*this); }
    [[nodiscard]] Field at_least(double x) && { return limits.low = x, std::move(*this); }
    [[nodiscard]] Field above(double x) && { return limits.low = x, limits.low_open = true, std::move(*this); }
    [[nodiscard]] Field at_most(double x) && { return limits.high = x, std::move(*this); }
    [[nodiscard]] Field below(double x) && { return limits.high = x, limits.high_open = true, std::move(*this); }
    [[nodiscard]] Field count(std::size_t least, std::size_t most) && {
        return limits.min_count = least, limits.max_count = most, std::move(*this);
    }
    [[nodiscard]] Field required() && { return is_required = true, std::move(*this); }
};

/// A struct of options: an object in JSON.
template <class S>
struct Description {
    std::string name, doc;
    std::vector<Field<S>> fields;
    /// What is wrong with a value whose fields are right one by one; empty when nothing is.
    std::function<std::string(const S&)> check;
};

/// One of several: an object with one key, or the bare key where the alternative needs no options.
struct Alternative {
    std::string key, doc;
};
template <class V>
struct Choice {
    std::string name, doc;
    std::vector<Alternative> alternatives;  ///< in the variant's order
};

/// Specialised for each struct and variant in describe_*.cpp, and declared in description.cppm.
template <class T>
struct Described;  // static const Description<T> / Choice<T>& get()

template <class T>
using DescriptionOf = std::remove_cvref_t<decltype(Described<T>::get())>;
template <class T>
concept Struct = std::same_as<DescriptionOf<T>, Description<T>>;
template <class T>
concept OneOf = std::same_as<DescriptionOf<T>, Choice<T>>;

/// How a type is read from JSON, written to it, put into the schema, and called.
template <class T>
struct Codec;

template <>
struct Codec<double> {
    static Outcome<double> read(const Json&, const Place&, const Limits&);
    static Json write(double x) { return x; }
    static Json schema(const Limits&);
    static std::string type(const Limits&);
};
/// A number, or null where it is only recommended.
template <>
struct Codec<JacobianBound> {
    static Outcome<JacobianBound> read(const Json& json, const Place& place, const Limits& limits) {
        if (json.is_null()) return JacobianBound{};
        return Codec<double>::read(json, place, limits).map([](double asked) { return JacobianBound(asked); });
    }
    static Json write(const JacobianBound& bound) { return bound.is_asked ? Json(bound.value) : Json(nullptr); }
    static Json schema(const Limits& limits) {
        Json schema = Codec<double>::schema(limits);
        schema["type"] = {"number", "null"};
        return schema;
    }
    static std::string type(const Limits& limits) { return Codec<double>::type(limits) + ", or null"; }
};
template <std::integral T>
    requires(!std::same_as<T, bool>)
struct Codec<T> {
    static Outcome<T> read(const Json& json, const Place& place, const Limits& limits) {
        if (!json.is_number_integer()) return bad(place, "expected a whole number, got " + kind_of(json));
        const bool fits = json.is_number_unsigned() ? std::in_range<T>(json.get<std::uint64_t>())
                                                    : std::in_range<T>(json.get<std::int64_t>());
        if (!fits || !limits.hold(json.get<double>()))
            return bad(place, limits.text().empty() ? "must be a smaller number, got " + json.dump()
                                                    : out_of_limits(limits, json.dump()));
        return json.get<T>();
    }
    static Json write(T x) { return x; }
    static Json schema(const Limits& limits) {
        Json schema{{"type", "integer"}};
        add_limits(limits, schema);
        if (std::is_unsigned_v<T> && !schema.contains("minimum")) schema["minimum"] = 0;
        return schema;
    }
    static std::string type(const Limits& limits) {
        return limits.text().empty() ? "whole number" : "whole number, " + limits.text();
    }
};
template <>
struct Codec<std::string> {
    static Outcome<std::string> read(const Json&, const Place&, const Limits&);
    static Json write(const std::string& text) { return text; }
    static Json schema(const Limits&) { return {{"type", "string"}}; }
    static std::string type(const Limits&) { return "string"; }
};
template <>
struct Codec<FilePath> {
    static Outcome<FilePath> read(const Json&, const Place&, const Limits&);
    static Json write(const FilePath& file) { return file.path; }
    static Json schema(const Limits&) { return {{"type", "string"}, {"minLength", 1}}; }
    static std::string type(const Limits&) { return "path of a file"; }
};

/// Arrays, whatever holds them: `Make` takes the items.
[[nodiscard]] Outcome<Done> check_array(const Json& json, const Place& place, const Limits& limits);
[[nodiscard]] std::string array_type(const std::string& item, const Limits& limits);
[[nodiscard]] Json array_schema(Json items, const Limits& limits);

template <class T>
struct Codec<std::vector<T>> {
    static Outcome<std::vector<T>> read(const Json& json, const Place& place, const Limits& limits) {
        if (auto checked = check_array(json, place, limits); !checked) return fail(checked.error());
        std::vector<T> items;
        for (std::size_t i = 0; i < json.size(); ++i) {
            auto item = Codec<T>::read(json[i], place.at(i), limits);
            if (!item) return fail(item.error());
            items.push_back(std::move(*item));
        }
        return items;
    }
    static Json write(const std::vector<T>& items) {
        Json json = Json::array();
        for (const T& item : items) json.push_back(Codec<T>::write(item));
        return json;
    }
    static Json schema(const Limits& limits) { return array_schema(Codec<T>::schema(limits), limits); }
    static std::string type(const Limits& limits) { return array_type(Codec<T>::type(limits), limits); }
};

template <std::size_t N>
[[nodiscard]] Limits exactly(Limits limits) {
    limits.min_count = limits.max_count = N;
    return limits;
}
template <class T, std::size_t N>
struct Codec<std::array<T, N>> {
    using Items = Codec<std::vector<T>>;
    static Outcome<std::array<T, N>> read(const Json& json, const Place& place, const Limits& limits) {
        return Items::read(json, place, exactly<N>(limits)).map([](const std::vector<T>& items) {
            std::array<T, N> all{};
            for (std::size_t i = 0; i < N; ++i) all[i] = items[i];
            return all;
        });
    }
    static Json write(const std::array<T, N>& items) { return Items::write({items.begin(), items.end()}); }
    static Json schema(const Limits& limits) { return Items::schema(exactly<N>(limits)); }
    static std::string type(const Limits& limits) { return Items::type(exactly<N>(limits)); }
};
template <int D>
struct Codec<Vec<D>> {
    using Items = Codec<std::array<double, D>>;
    static Outcome<Vec<D>> read(const Json& json, const Place& place, const Limits& limits) {
        return Items::read(json, place, limits).map([](const std::array<double, D>& c) { return Vec<D>{c}; });
    }
    static Json write(const Vec<D>& v) { return Items::write(v.c); }
    static Json schema(const Limits& limits) { return Items::schema(limits); }
    static std::string type(const Limits& limits) { return Items::type(limits); }
};

template <HasWords T>
struct Codec<T> {
    static Outcome<T> read(const Json& json, const Place& place, const Limits&) {
        for (const auto& w : words(T{}))
            if (json == w.word) return w.value;
        const std::string word = json.is_string() ? json.get<std::string>() : std::string{};
        return bad(place, "expected " + type({}) + ", got " + kind_of(json),
                   nearest(word, all_words<T>()).empty() ? "" : suggestion(word, all_words<T>()));
    }
    static Json write(T x) { return word_of(x); }
    static Json schema(const Limits&) { return {{"enum", all_words<T>()}}; }
    static std::string type(const Limits&) {
        std::string text;
        for (const auto& word : all_words<T>()) text += (text.empty() ? "\"" : " or \"") + word + "\"";
        return text;
    }
};

}  // namespace camber::config
