#pragma once
#include <span>
#include <string>
#include <string_view>

namespace camber::app {

/// A part of the program that needs libraries of its own.
struct Part {
    std::string_view name;
    std::string_view libraries;  ///< with their versions; empty if the build lacks the part
    std::string_view command;    ///< adds the part to the build if it is missing
};

/// Text of `--version --verbose`: the version, one line a part, and the number of missing parts.
[[nodiscard]] std::string version_text(std::string_view version, std::span<const Part> parts);

/// Parts of this build, as CMake found their libraries.
[[nodiscard]] std::span<const Part> parts_of_build();

}  // namespace camber::app
