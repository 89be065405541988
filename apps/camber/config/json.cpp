module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
#include <nlohmann/json.hpp>
module camber.config;
import camber.core;
import camber.recipes;
import camber.validity;
import :codec;

namespace camber::config {

namespace {

/// Maximum number of keys of an object. The parser searches keys linearly.
constexpr std::size_t most_keys = 1000;

class Keys {
  public:
    struct ErrorPosition {
        std::string pointer, what;
    };

    /// Returns false after an error, so that the parser discards the value.
    [[nodiscard]] bool handle(nlohmann::detail::parse_event_t event, const Json& parsed) {
        using Event = nlohmann::detail::parse_event_t;
        if (error_position_) return false;
        if (event == Event::key) {
            key(parsed.get<std::string>());
        } else if (event == Event::object_start || event == Event::array_start) {
            frames_.push_back({event == Event::array_start, {}, {}, 0});
        } else {
            if (event != Event::value) frames_.pop_back();
            if (!frames_.empty() && frames_.back().is_array) ++frames_.back().index;
        }
        return !error_position_;
    }
    [[nodiscard]] const std::optional<ErrorPosition>& error_position() const { return error_position_; }

  private:
    struct Frame {
        bool is_array;
        std::set<std::string> keys;
        std::string current;
        std::size_t index;
    };
    void key(std::string name) {
        Frame& object = frames_.back();
        object.current = name;
        const bool is_new = object.keys.insert(std::move(name)).second;
        if (is_new && object.keys.size() <= most_keys) return;
        Place place;
        for (const Frame& f : frames_)
            if (!is_new || &f != &object) place = f.is_array ? place.at(f.index) : place.at(f.current);
        error_position_ =
            ErrorPosition{place.pointer, is_new ? "the object has more than " + std::to_string(most_keys) + " keys"
                                                : "the key appears twice"};
    }
    std::vector<Frame> frames_;
    std::optional<ErrorPosition> error_position_;
};

/// Line and column of a byte. All count from 1; columns count bytes.
std::string line_and_column(std::string_view text, std::size_t byte) {
    const std::string_view before = text.substr(0, std::min(byte > 0 ? byte - 1 : 0, text.size()));
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    const auto start = before.rfind('\n');
    const std::size_t column = before.size() - (start == std::string_view::npos ? 0 : start + 1) + 1;
    return "line " + std::to_string(line) + ", column " + std::to_string(column);
}

std::string without_last_read(std::string message) {
    const auto begin = message.find("; last read: ");
    if (begin == std::string::npos) return message;
    const auto end = message.rfind("; expected ");
    return message.erase(begin, end == std::string::npos || end < begin ? std::string::npos : end - begin);
}

std::string reason(const std::string& whole) {
    const std::string message = without_last_read(whole);
    constexpr std::size_t longest = 200;
    for (const std::string_view mark : {"syntax error", "number overflow", "invalid string"})
        if (const auto at = message.find(mark); at != std::string::npos) return shortened(message.substr(at), longest);
    const auto at = message.find("] ");
    return shortened(at == std::string::npos ? message : message.substr(at + 2), longest);
}

/// Optimal string alignment: counts inserted, deleted, replaced and swapped letters.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
    for (std::size_t i = 0; i <= a.size(); ++i)
        for (std::size_t j = 0; j <= b.size(); ++j) {
            if (i == 0 || j == 0) {
                d[i][j] = i + j;
                continue;
            }
            d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0U : 1U)});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
        }
    return d[a.size()][b.size()];
}

/// Follows one step of an override's path; null: it does not exist.
Json* step(Json& at, const std::string& token, bool last) {
    if (at.is_array()) {
        if (!token.empty() && std::all_of(token.begin(), token.end(), [](char c) { return c >= '0' && c <= '9'; })) {
            const std::size_t index = token.size() > 6 ? at.size() : std::stoul(token);
            return index < at.size() ? &at[index] : nullptr;
        }
        for (Json& item : at) {
            if (item == token) item = Json{{token, Json::object()}};
            if (item.is_object() && item.contains(token)) return &item[token];
        }
        return nullptr;
    }
    if (!at.is_object()) {
        // A bare word is equivalent to an object without options: "natural" to {"natural": {}}.
        at = at.is_string() && at == token ? Json{{token, Json::object()}} : Json::object();
    }
    if (!at.contains(token)) at[token] = last ? Json() : Json::object();
    return &at[token];
}

std::vector<std::string> words_of(const Json& array) {
    std::vector<std::string> words;
    for (const Json& item : array) {
        if (item.is_string()) words.push_back(item.get<std::string>());
        if (item.is_object())
            for (const auto& [key, value] : item.items()) words.push_back(key);
    }
    return words;
}

}  // namespace

std::string kind_of(const Json& json) {
    switch (json.type()) {
        case Json::value_t::null: return "null";
        case Json::value_t::object: return "an object";
        case Json::value_t::array: return "an array";
        case Json::value_t::string:
            return "the string " + shortened(json.dump(-1, ' ', false, Json::error_handler_t::replace));
        case Json::value_t::boolean: return json.dump();
        default: return json.dump();
    }
}

Outcome<Json> parse_json(std::string_view text, std::string_view name) {
    Keys keys;
    try {
        Json json = Json::parse(
            text.begin(), text.end(),
            [&](int, nlohmann::detail::parse_event_t event, Json& parsed) { return keys.handle(event, parsed); });
        if (keys.error_position())
            return bad({std::string(name), keys.error_position()->pointer}, keys.error_position()->what);
        return json;
    } catch (const nlohmann::json::parse_error& e) {
        return fail(ErrorKind::usage, reason(e.what()), std::string(name) + ": " + line_and_column(text, e.byte), {},
                    "check quotes, commas and brackets near this position");
    } catch (const nlohmann::json::exception& e) {
        return fail(ErrorKind::usage, reason(e.what()), std::string(name));
    }
}

Outcome<Done> override_value(Json& json, std::string_view assignment) {
    const auto equals = assignment.find('=');
    if (equals == std::string_view::npos || equals == 0)
        return fail(ErrorKind::usage, "expected PATH=VALUE, for example stages/curve/objective=length",
                    shortened(assignment));
    std::vector<std::string> path(1);
    for (const char letter : assignment.substr(0, equals)) {
        if (letter == '/')
            path.emplace_back();
        else
            path.back() += letter;
    }
    std::erase(path, std::string{});
    Json* at = &json;
    for (std::size_t k = 0; k < path.size(); ++k) {
        const Json* const before = at;
        at = step(*at, path[k], k + 1 == path.size());
        if (at == nullptr)
            return fail(unknown_word(NameKind::key, path[k], words_of(*before), {{}, shortened(assignment)},
                                     "invalid path: there is no " + in_quotes(path[k])));
    }
    const std::string value(assignment.substr(equals + 1));
    auto parsed = Json::parse(value, nullptr, false);
    *at = parsed.is_discarded() ? Json(value) : std::move(parsed);
    return Done{};
}

std::string nearest(std::string_view word, const std::vector<std::string>& candidates) {
    std::string best;
    std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
    for (const std::string& candidate : candidates) {
        // The distance is at least the difference in length. Skipping such candidates avoids work for very long words.
        const std::size_t gap = std::max(word.size(), candidate.size()) - std::min(word.size(), candidate.size());
        if (gap >= least) continue;
        const std::size_t d = edit_distance(word, candidate);
        if (d >= least || d >= std::max(word.size(), candidate.size())) continue;
        least = d;
        best = candidate;
    }
    return best;
}

std::vector<std::string> nearest_words(std::string_view word, const std::vector<std::string>& candidates,
                                       std::size_t most) {
    constexpr std::size_t shortest_part = 4;  // letters of a word that is searched for in candidates
    constexpr std::size_t more_edits = 1;     // more edits than the best candidate has
    const std::size_t most_edits = std::max<std::size_t>(1, word.size() / 3);
    std::vector<std::pair<std::size_t, std::string>> near;
    for (const std::string& candidate : candidates) {
        const bool is_part = word.size() >= shortest_part && candidate.find(word) != std::string::npos;
        const std::size_t gap = std::max(word.size(), candidate.size()) - std::min(word.size(), candidate.size());
        if (!is_part && gap > most_edits) continue;  // the number of edits is at least `gap`
        const std::size_t edits = is_part ? (candidate.starts_with(word) ? 0 : 1) : edit_distance(word, candidate);
        if (edits <= most_edits && edits < candidate.size()) near.emplace_back(edits, candidate);
    }
    std::ranges::stable_sort(near, {}, [](const auto& one) { return std::pair(one.first, one.second.size()); });
    std::vector<std::string> words;
    for (const auto& [edits, candidate] : near)
        if (words.size() < most && edits <= near.front().first + more_edits) words.push_back(candidate);
    return words;
}

std::string alternatives_text(const std::vector<std::string>& words) {
    std::string text;
    for (std::size_t i = 0; i < words.size(); ++i)
        text += (i == 0 ? "\"" : i + 1 == words.size() ? " or \"" : ", \"") + words[i] + "\"";
    return text;
}

std::string suggestion(std::string_view word, const std::vector<std::string>& candidates) {
    if (const std::string near = nearest(word, candidates); !near.empty()) return "did you mean \"" + near + "\"?";
    std::string all = candidates.empty() ? "no names are known here" : "known: ";
    for (std::size_t i = 0; i < candidates.size(); ++i) all += (i > 0 ? ", " : "") + candidates[i];
    return all;
}

Error unknown_word(NameKind kind, const std::string& word, const std::vector<std::string>& candidates,
                   const Place& place, std::string what) {
    if (const std::string now = new_name(kind, word, candidates); !now.empty())
        return {ErrorKind::usage,
                in_quotes(word) + " was renamed to " + in_quotes(now),
                place.text(),
                {},
                "write " + in_quotes(now)};
    return {ErrorKind::usage, std::move(what), place.text(), {}, suggestion(word, candidates)};
}

namespace {

void add_limits(const Limits& limits, Json& schema) {
    if (std::isfinite(limits.low)) schema[limits.low_open ? "exclusiveMinimum" : "minimum"] = limits.low;
    if (std::isfinite(limits.high)) schema[limits.high_open ? "exclusiveMaximum" : "maximum"] = limits.high;
}

struct NumberCodec : Codec {
    Outcome<Done> read(const Json& json, const Place& place, const Limits& limits, void* into) const override {
        if (!json.is_number()) return bad(place, "expected a number, got " + kind_of(json));
        const auto x = json.get<double>();
        if (!std::isfinite(x)) return bad(place, "the number is too large");
        if (!limits.permit(x)) return bad(place, out_of_limits(limits, json.dump()));
        *static_cast<double*>(into) = x;
        return Done{};
    }
    Json write(const void* value) const override { return *static_cast<const double*>(value); }
    Json schema(const Limits& limits) const override {
        Json schema{{"type", "number"}};
        add_limits(limits, schema);
        return schema;
    }
    std::string type(const Limits& limits) const override {
        return limits.text().empty() ? "number" : "number, " + limits.text();
    }
};

struct BoundCodec : Codec {
    Outcome<Done> read(const Json& json, const Place& place, const Limits& limits, void* into) const override {
        double requested = 0;
        auto done = json.is_null() ? Done{} : codec_of<double>().read(json, place, limits, &requested);
        if (done) *static_cast<JacobianBound*>(into) = json.is_null() ? JacobianBound{} : JacobianBound(requested);
        return done;
    }
    Json write(const void* value) const override {
        const auto& bound = *static_cast<const JacobianBound*>(value);
        return bound.is_explicit ? Json(bound.value) : Json(nullptr);
    }
    Json schema(const Limits& limits) const override {
        Json schema = codec_of<double>().schema(limits);
        schema["type"] = {"number", "null"};
        return schema;
    }
    std::string type(const Limits& limits) const override { return codec_of<double>().type(limits) + ", or null"; }
};

struct StringCodec : Codec {
    Outcome<Done> read(const Json& json, const Place& place, const Limits&, void* into) const override {
        if (!json.is_string()) return bad(place, "expected a string, got " + kind_of(json));
        *static_cast<std::string*>(into) = json.get<std::string>();
        return Done{};
    }
    Json write(const void* value) const override { return *static_cast<const std::string*>(value); }
    Json schema(const Limits&) const override { return {{"type", "string"}}; }
    std::string type(const Limits&) const override { return "string"; }
};

struct PathCodec : Codec {
    Outcome<Done> read(const Json& json, const Place& place, const Limits&, void* into) const override {
        if (!json.is_string()) return bad(place, "expected a file's path, got " + kind_of(json));
        if (json.get<std::string>().empty()) return bad(place, "the path is empty");
        *static_cast<FilePath*>(into) = FilePath{json.get<std::string>()};
        return Done{};
    }
    Json write(const void* value) const override { return static_cast<const FilePath*>(value)->path; }
    Json schema(const Limits&) const override { return {{"type", "string"}, {"minLength", 1}}; }
    std::string type(const Limits&) const override { return "path of a file"; }
};

}  // namespace

template <>
const Codec& codec_of<double>() {
    static const NumberCodec codec;
    return codec;
}
template <>
const Codec& codec_of<JacobianBound>() {
    static const BoundCodec codec;
    return codec;
}
template <>
const Codec& codec_of<std::string>() {
    static const StringCodec codec;
    return codec;
}
template <>
const Codec& codec_of<FilePath>() {
    static const PathCodec codec;
    return codec;
}

Outcome<Done> check_integer(const Json& json, const Place& place, const Limits& limits, bool fits) {
    if (!json.is_number_integer()) return bad(place, "expected a whole number, got " + kind_of(json));
    if (fits && limits.permit(json.get<double>())) return Done{};
    return bad(place, limits.text().empty() ? "must be a smaller number, got " + json.dump()
                                            : out_of_limits(limits, json.dump()));
}

Json integer_schema(const Limits& limits, bool is_unsigned) {
    Json schema{{"type", "integer"}};
    add_limits(limits, schema);
    if (is_unsigned && !schema.contains("minimum")) schema["minimum"] = 0;
    return schema;
}

std::string integer_type(const Limits& limits) {
    return limits.text().empty() ? "whole number" : "whole number, " + limits.text();
}

Outcome<Done> WordCodec::read(const Json& json, const Place& place, const Limits&, void* into) const {
    for (std::size_t i = 0; i < words_.size(); ++i)
        if (json == words_[i]) {
            *static_cast<unsigned char*>(into) = values_[i];
            return Done{};
        }
    const std::string word = json.is_string() ? json.get<std::string>() : std::string{};
    std::string what = "expected " + type({}) + ", got " + kind_of(json);
    if (nearest(word, words_).empty() && new_name(NameKind::value, word, words_).empty())
        return bad(place, std::move(what));
    return fail(unknown_word(NameKind::value, word, words_, place, std::move(what)));
}

Json WordCodec::write(const void* value) const {
    const auto found = std::ranges::find(values_, *static_cast<const unsigned char*>(value));
    return found == values_.end() ? Json("") : Json(words_[static_cast<std::size_t>(found - values_.begin())]);
}

Json WordCodec::schema(const Limits&) const { return {{"enum", words_}}; }

std::string WordCodec::type(const Limits&) const {
    std::string text;
    for (const std::string& word : words_) text += (text.empty() ? "\"" : " or \"") + word + "\"";
    return text;
}

Outcome<Done> ListCodec::read(const Json& json, const Place& place, const Limits& limits, void* into) const {
    if (!json.is_array()) return bad(place, "expected an array, got " + kind_of(json));
    const auto [least, most] = std::pair(counted(limits).min_count, counted(limits).max_count);
    if (json.size() < least || json.size() > most) {
        std::string expected = std::to_string(least);
        if (least != most)
            expected = most == std::numeric_limits<std::size_t>::max() ? "at least " + expected
                                                                       : expected + " to " + std::to_string(most);
        return bad(place, "expected " + expected + " items, got " + std::to_string(json.size()));
    }
    renew(into, json.size());
    for (std::size_t i = 0; i < json.size(); ++i)
        if (auto done = items_->read(json[i], place.at(i), counted(limits), item(into, i)); !done) return done;
    return Done{};
}

Json ListCodec::write(const void* list) const {
    Json json = Json::array();
    for (std::size_t i = 0; i < size(list); ++i) json.push_back(items_->write(item(const_cast<void*>(list), i)));
    return json;
}

Json ListCodec::schema(const Limits& limits) const {
    const Limits all = counted(limits);
    Json schema{{"type", "array"}, {"items", items_->schema(all)}};
    if (all.min_count > 0) schema["minItems"] = all.min_count;
    if (all.max_count != std::numeric_limits<std::size_t>::max()) schema["maxItems"] = all.max_count;
    return schema;
}

std::string ListCodec::type(const Limits& limits) const {
    return list_type(items_->type(counted(limits)), counted(limits));
}

std::string list_type(const std::string& item, const Limits& limits) {
    const bool open = limits.max_count == std::numeric_limits<std::size_t>::max();
    std::string count = std::to_string(limits.min_count);
    if (open)
        count = limits.min_count == 0 ? "" : "at least " + count;
    else if (limits.min_count != limits.max_count)
        count += " to " + std::to_string(limits.max_count);
    return "array of " + (count.empty() ? "" : count + " × ") + item;
}

}  // namespace camber::config
