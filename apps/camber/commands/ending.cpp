module;
#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

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

std::optional<Error>& not_said() {
    static std::optional<Error> error;
    return error;
}

}  // namespace

void tell(const std::string& line) {
    if (voice() != Voice::none) std::fputs(("camber: " + line + "\n").c_str(), stderr);
}

void tell_note(const std::string& note) {
    if (voice() == Voice::usual) tell("note: " + note);
}

std::optional<Error> error_not_said() { return not_said(); }

int report_error(const Error& error) {
    if (voice() == Voice::none) not_said() = error;
    tell(describe(error));
    return exit_code(error.kind);
}

std::string result_row(std::string_view name, std::string_view value) {
    return fmt::format("  {:<26}{}\n", name, value);
}

std::string wrote_rows(const std::vector<std::string>& paths) {
    std::string text;
    for (const std::string& path : paths)
        if (!path.empty()) text += "  wrote " + called_output(path) + "\n";
    return text;
}

int end_with(std::string_view text) {
    StandardOutput out;
    out.print(text);
    const auto said = out.finish();
    return said ? 0 : report_error(said.error());
}

int end_with(std::string_view text, const Written& written) {
    if (voice() != Voice::usual) return 0;
    StandardOutput out = written.takes_standard_output() ? StandardOutput::beside_a_file() : StandardOutput();
    out.print(text);
    const auto said = out.finish();
    return said ? 0 : report_error(written.told(said.error()));
}

bool Written::takes_standard_output() const { return std::ranges::find(paths_, standard_stream) != paths_.end(); }

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
