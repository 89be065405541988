#pragma once
#include <string>
#include <string_view>
#include <CLI/CLI.hpp>
import camber.core;

namespace camber::app {

/// Returns the explanation of a topic of configs, an option (`--geometry-error` or `geometry-error`) or a word of the
/// tables, such as `scaled Jacobian`. Errors: usage, an unknown word.
[[nodiscard]] camber::Outcome<std::string> explanation_of(const CLI::App& app, std::string_view word);

/// Returns all words that `explanation_of` knows, by group.
[[nodiscard]] std::string list_explained_words(const CLI::App& app);

/// Returns the help of the program (an empty name) or of a command, or the explanation of a word. Errors: usage.
[[nodiscard]] camber::Outcome<std::string> help_text_of(const CLI::App& app, const std::string& name);

}  // namespace camber::app
