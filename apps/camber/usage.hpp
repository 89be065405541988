#pragma once
#include <memory>
#include <CLI/CLI.hpp>

#include "arguments.hpp"
import camber.core;

namespace camber::app {

/// The parser of the program's arguments, which stores them in `verb`.
[[nodiscard]] std::unique_ptr<CLI::App> program_of(Verb& verb);

/// What is wrong with arguments that are not understood: a word that is misspelt explains also what is missing
/// elsewhere.
[[nodiscard]] camber::Error usage_error(const CLI::App& app, const CLI::ParseError& error);

}  // namespace camber::app
