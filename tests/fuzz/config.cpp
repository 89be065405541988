#include "targets.hpp"

#include <algorithm>
#include <string>
#include <vector>

import camber.core;
import camber.config;
import camber.recipes;

namespace fuzz {

namespace {

using namespace camber;

std::string text_of(Bytes bytes) {
    std::string text(bytes.size(), '\0');
    std::transform(bytes.begin(), bytes.end(), text.begin(), [](std::byte b) { return static_cast<char>(b); });
    return text;
}

/// Removes the lines before the first line that begins with `{` from the text and returns them.
std::vector<std::string> settings_of(std::string& text) {
    std::vector<std::string> settings;
    while (!text.empty() && text[0] != '{') {
        const std::size_t end = text.find('\n');
        if (end == std::string::npos) break;
        settings.push_back(text.substr(0, end));
        text.erase(0, end + 1);
    }
    return settings;
}

template <class T>
void expect_reason(const Outcome<T>& outcome) {
    if (outcome) return;
    expect(outcome.error().kind == ErrorKind::usage, "a bad config is a usage error");
    expect(!outcome.error().what.empty(), "an error has a description");
}

}  // namespace

void config(Bytes bytes) {
    std::string text = text_of(bytes);
    expect_reason(camber::config::read_metric(text, "--metric"));
    expect_reason(camber::config::read_geometry(text, "--geometry"));
    expect_reason(camber::config::explain(text));
    const auto settings = settings_of(text);
    const auto pipeline = camber::config::read_pipeline(text, "file", settings);
    expect_reason(pipeline);
    if (!pipeline) return;
    const std::string written = camber::config::write_pipeline(*pipeline);
    const auto again = camber::config::read_pipeline(written, "again");
    expect(again.has_value(), "encoded output can be decoded");
    expect(camber::config::write_pipeline(*again) == written, "the pipeline is the same");
    static_cast<void>(camber::config::parts_of(*pipeline));
    static_cast<void>(camber::config::with_inputs_below(*pipeline, "folder"));
}

}  // namespace fuzz
