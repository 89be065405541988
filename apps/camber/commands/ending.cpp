module;
#include <cstdio>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>
module camber.commands;
import camber.core;
import camber.app_shell;
import :ending;

namespace camber::app {

namespace {

int exit_code(ErrorKind kind) {
    switch (kind) {
        case ErrorKind::usage: return 2;
        case ErrorKind::input:
        case ErrorKind::unsupported:
        case ErrorKind::write: return 3;
        case ErrorKind::stopped: return 130;
        case ErrorKind::memory:
        case ErrorKind::internal: return 4;
    }
    return 4;
}

}  // namespace

void tell(const std::string& line) { std::fputs(("camber: " + line + "\n").c_str(), stderr); }

int report_error(const Error& error) {
    tell(describe(error));
    return exit_code(error.kind);
}

std::string result_row(std::string_view name, std::string_view value) {
    return fmt::format("  {:<26}{}\n", name, value);
}

int end_with(std::string_view text) { return end_with(text, {}); }

int end_with(std::string_view text, const Written& written) {
    StandardOutput out;
    out.print(text);
    const auto said = out.finish();
    return said ? 0 : report_error(written.told(said.error()));
}

Outcome<Done> Written::add(const std::string& path, Outcome<Done> outcome) {
    if (!outcome) return fail(told(std::move(outcome.error())));
    paths_.push_back(path);
    return Done{};
}

Error Written::told(Error error) const {
    if (!paths_.empty()) error.what += fmt::format("; written before: {}", fmt::join(paths_, ", "));
    return error;
}

}  // namespace camber::app
