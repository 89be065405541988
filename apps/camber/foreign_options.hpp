#pragma once
#include <optional>
#include <string>
#include <string_view>

namespace camber::app {

/// An option or a command of another program, and what Camber has for it.
struct ForeignName {
    std::string program;  ///< "Mmg"; empty: several have it
    std::string remedy;
};

/// Looks an option up, with or without dashes and a value: `-hausd`, `--hausd=0.01`.
[[nodiscard]] std::optional<ForeignName> find_foreign_option(std::string_view option);

/// Looks a command up, such as "optimize".
[[nodiscard]] std::optional<ForeignName> find_foreign_command(std::string_view command);

}  // namespace camber::app
