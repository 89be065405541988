module;
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>
module camber.config:json;
import camber.core;

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

}  // namespace camber::config
