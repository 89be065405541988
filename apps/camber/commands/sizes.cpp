module;
#include <algorithm>
#include <charconv>
#include <cstddef>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>
module camber.commands;
import camber.core;
import camber.config;
import camber.solution_metric;

namespace camber::app {

namespace {

template <class T>
bool is_number(std::string_view text, T& into) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), into);
    return error == std::errc{} && end == text.data() + text.size() && !text.empty();
}

bool is_kind(std::string_view text, ReferencesOf& into) {
    for (const auto& word : words(into))
        if (text == word.word) return into = word.value, true;
    return false;
}

/// "3=0.01": facets of reference 3; "elements:1,2=0.1": elements of two.
Outcome<ReferenceSize> size_of(const std::string& text) {
    ReferenceSize out;
    const std::string_view whole = text;
    const auto equals = whole.find('='), colon = whole.find(':');
    const bool has_kind = colon < equals;
    bool is_sound = equals != std::string_view::npos && is_number(whole.substr(equals + 1), out.size) && out.size > 0;
    if (is_sound && has_kind) is_sound = is_kind(whole.substr(0, colon), out.of);
    const std::size_t begin = has_kind ? colon + 1 : 0;
    for (std::size_t at = begin; is_sound && at <= equals;) {
        const std::size_t end = std::min(whole.find(',', at), equals);
        out.references.emplace_back();
        is_sound = is_number(whole.substr(at, end - at), out.references.back());
        at = end + 1;
    }
    if (is_sound) return out;
    std::string kinds;
    for (const std::string& word : all_words<ReferencesOf>()) kinds += (kinds.empty() ? "" : ", ") + word;
    return fail(ErrorKind::usage, "is no size by reference", "--size " + shortened(text), {},
                "write REFERENCE=SIZE, as 3=0.01, or KIND:REFERENCE,REFERENCE=SIZE with one of " + kinds);
}

}  // namespace

Outcome<config::SizesMetric> read_sizes(const std::vector<std::string>& texts) {
    config::SizesMetric out;
    for (const std::string& text : texts) {
        auto size = size_of(text);
        if (!size) return fail(size.error());
        out.sizes.push_back(std::move(*size));
    }
    return out;
}

}  // namespace camber::app
