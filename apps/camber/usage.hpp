#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>
#include <CLI/CLI.hpp>

#include "arguments.hpp"
import camber.core;

namespace camber::app {

/// The parser of the program's arguments, which stores them in `verb`.
[[nodiscard]] std::unique_ptr<CLI::App> program_of(Verb& verb);

/// Finds a word that the parser would misread: an option with one dash and several letters, such as `-hmax`, is one of
/// another program. In `camber explain --WORD` it takes the dashes off: there the option is the word to explain.
[[nodiscard]] std::optional<camber::Error> check_words(const CLI::App& app, std::vector<std::string>& words);

/// What is wrong with arguments that are not understood: a word that is misspelt explains also what is missing
/// elsewhere.
[[nodiscard]] camber::Error usage_error(const CLI::App& app, const CLI::ParseError& error);

}  // namespace camber::app
