module;
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <fmt/format.h>
module camber.commands;
import :suggestion;

namespace camber::app {

namespace {

/// What is left of two words without their common ends says it.
bool one_slip_apart(std::string_view a, std::string_view b) {
    while (!a.empty() && !b.empty() && a.front() == b.front()) a.remove_prefix(1), b.remove_prefix(1);
    while (!a.empty() && !b.empty() && a.back() == b.back()) a.remove_suffix(1), b.remove_suffix(1);
    if (a.size() == 2 && b.size() == 2) return a[0] == b[1] && a[1] == b[0];
    return a.size() <= 1 && b.size() <= 1;
}

bool is_beginning(std::string_view word, std::string_view whole) { return word.size() >= 4 && whole.starts_with(word); }

}  // namespace

std::string suggested_file(const std::string& path) {
    namespace fs = std::filesystem;
    constexpr std::size_t most = 10000;  // of a folder's files that are looked at
    const fs::path given(path);
    std::vector<std::string> same_stem, near;
    std::error_code error;
    if (fs::exists(given, error)) return {};
    std::size_t n = 0;
    const fs::path folder = given.parent_path().empty() ? fs::path(".") : given.parent_path();
    for (auto at = fs::directory_iterator(folder, error); !error && at != fs::directory_iterator() && n < most;
         at.increment(error), ++n) {
        const fs::path name = at->path().filename();
        if (name.stem() == given.stem()) same_stem.push_back(name.string());
        if (one_slip_apart(name.string(), given.filename().string())) near.push_back(name.string());
    }
    auto& found = near.empty() ? same_stem : near;
    if (found.empty()) return {};
    const std::string best = *std::ranges::min_element(found);
    return fmt::format("did you mean \"{}\"?", (given.parent_path() / best).string());
}

std::string suggestion(std::string_view word, const std::vector<std::string>& known) {
    const auto near = std::find_if(known.begin(), known.end(), [&](const std::string& candidate) {
        return one_slip_apart(word, candidate) || is_beginning(word, candidate);
    });
    if (near != known.end()) return fmt::format("did you mean \"{}\"?", *near);
    return fmt::format("known: {}", fmt::join(known, ", "));
}

}  // namespace camber::app
