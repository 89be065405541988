module;
#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
#include <nlohmann/json.hpp>
module camber.config;
import camber.core;
import camber.recipes;
import :codec;
import :description;

namespace camber::config {

Outcome<Done> Field::read(const std::string& key, const Json& json, const Place& place, void* into) const {
    if (inlined != nullptr) return inlined->read_key(key, json, place, limits, member.of(into));
    return codec->read(json, place, limits, member.of(into));
}

void Field::write(const void* from, Json& object) const {
    const void* const value = member.of(from);
    if (inlined != nullptr)
        object[inlined->key(value)] = inlined->options(value);
    else
        object[name] = codec->write(value);
}

Json Field::schema(const std::string& key) const {
    return (inlined != nullptr ? inlined->find(key)->codec : codec)->schema(limits);
}

namespace {

Outcome<Done> read_field(const Json& json, const Place& place, const Field& field, void* into) {
    std::string found;
    for (const auto& key : field.keys) {
        if (!json.contains(key)) continue;
        if (!found.empty())
            return bad(place.at(key), "only one of " + in_quotes(found) + " and " + in_quotes(key) + " is allowed");
        found = key;
    }
    if (!found.empty()) return field.read(found, json[found], place.at(found), into);
    if (!field.is_required) return Done{};
    std::string names;
    for (const auto& key : field.keys) names += (names.empty() ? "\"" : " or \"") + key + "\"";
    return bad(place, names + " is missing");
}

}  // namespace

Outcome<Done> Description::read(const Json& json, const Place& place, const Limits&, void* into) const {
    std::vector<std::string> known;
    for (const Field& field : fields) known.insert(known.end(), field.keys.begin(), field.keys.end());
    if (!json.is_object())
        return bad(place, "expected an object, got " + kind_of(json),
                   known.empty() ? std::string() : suggestion("", known));
    for (const auto& [key, value] : json.items())
        if (std::find(known.begin(), known.end(), key) == known.end() && !(place.pointer.empty() && key == "$schema"))
            return fail(unknown_word(NameKind::key, key, known, place.at(key), "unknown key"));
    for (const Field& field : fields)
        if (auto done = read_field(json, place, field, into); !done) return done;
    if (check)
        if (std::string wrong = check(into); !wrong.empty()) return bad(place, std::move(wrong));
    return Done{};
}

Json Description::write(const void* value) const {
    Json object = Json::object();
    for (const Field& field : fields) field.write(value, object);
    return object;
}

Json Description::schema(const Limits&) const {
    Json schema{{"type", "object"}, {"description", doc}, {"properties", Json::object()}};
    const Json all_defaults = defaults();
    Json required = Json::array(), exactly_one = Json::array();
    for (const Field& field : fields) {
        for (const auto& key : field.keys) {
            Json property = field.schema(key);
            const std::string unit = field.unit_name.empty() ? "" : " (" + field.unit_name + ")";
            if (!field.doc.empty()) property["description"] = field.doc + unit;
            if (!field.is_required && all_defaults.contains(key)) property["default"] = all_defaults[key];
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

bool Description::may_be_bare() const { return std::ranges::none_of(fields, &Field::is_required); }

std::vector<std::string> Choice::keys() const {
    std::vector<std::string> all(alternatives.size());
    std::ranges::transform(alternatives, all.begin(), &Alternative::key);
    return all;
}

const Alternative* Choice::find(std::string_view key) const {
    const auto found = std::ranges::find(alternatives, key, &Alternative::key);
    return found == alternatives.end() ? nullptr : &*found;
}

Json Choice::options(const void* variant) const {
    const auto [position, value] = alternative_of(variant);
    return alternatives[position].codec->write(value);
}

Outcome<Done> Choice::read(const Json& json, const Place& place, const Limits& limits, void* into) const {
    if (json.is_string()) return read_key(json.get<std::string>(), Json(), place, limits, into);
    if (!json.is_object() || json.size() != 1) {
        const std::string got = json.is_object() ? std::to_string(json.size()) + " keys" : kind_of(json);
        return bad(place, "expected an object with one key, got " + got, suggestion("", keys()));
    }
    return read_key(json.begin().key(), json.begin().value(), place.at(json.begin().key()), limits, into);
}

Outcome<Done> Choice::read_key(const std::string& key, const Json& options, const Place& place, const Limits& limits,
                               void* into) const {
    const Alternative* const alternative = find(key);
    if (alternative == nullptr)
        return fail(unknown_word(NameKind::key, key, keys(), place,
                                 options.is_null() ? "unknown word " + in_quotes(key) : "unknown key"));
    if (options.is_null() && !alternative->codec->may_be_bare())
        return bad(place, "\"" + key + "\" needs its options: {\"" + key + "\": …}", "see: camber explain " + key);
    return alternative->codec->read(options.is_null() ? Json::object() : options, place, limits,
                                    alternative->emplace(into));
}

Json Choice::write(const void* variant) const {
    Json written = options(variant);
    // Without options, the bare word is written.
    if (written.is_object() && written.empty()) return key(variant);
    return Json{{key(variant), std::move(written)}};
}

Json Choice::schema(const Limits& limits) const {
    Json any = Json::array(), bare = Json::array();
    for (const Alternative& a : alternatives) {
        any.push_back({{"type", "object"},
                       {"description", a.doc},
                       {"properties", {{a.key, a.codec->schema(limits)}}},
                       {"required", Json::array({a.key})},
                       {"additionalProperties", false}});
        if (a.codec->may_be_bare()) bare.push_back(a.key);
    }
    if (!bare.empty()) any.push_back({{"enum", std::move(bare)}});
    return {{"description", doc}, {"oneOf", std::move(any)}};
}

std::string Choice::type(const Limits&) const {
    std::string text;
    for (const Alternative& a : alternatives)
        text +=
            (text.empty() ? "" : " or ") + (a.codec->may_be_bare() ? "\"" + a.key + "\"" : "{\"" + a.key + "\": …}");
    return text;
}

}  // namespace camber::config
