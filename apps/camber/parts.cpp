// The parts of this build, and their text.
#include "parts.hpp"

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace camber::app {

namespace {

constexpr Part found_parts[] = {
#include "parts.inc"
};

}  // namespace

std::string version_text(std::string_view version, std::span<const Part> parts) {
    std::size_t width = 0;
    for (const Part& part : parts) width = std::max(width, part.name.size());
    std::string text(version);
    for (const Part& part : parts) {
        text += "\n" + std::string(part.name) + std::string(width + 2 - part.name.size(), ' ');
        text += part.libraries.empty() ? "missing; " + std::string(part.command) : std::string(part.libraries);
    }
    const auto missing = std::ranges::count(parts, std::string_view(), &Part::libraries);
    return text + (missing == 0 ? "\nNothing is missing." : "\nMissing parts: " + std::to_string(missing));
}

std::span<const Part> parts_of_build() { return found_parts; }

}  // namespace camber::app
