#pragma once
// Texts about the program: help, explanations of words, and answers to arguments that are not understood.
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>
#include <CLI/CLI.hpp>

import camber.core;

namespace camber::app {

// ---------------------------------------------------------------- help

/// Help in lines that fit the terminal; of the verbs only the first line in the list of all.
class Help : public CLI::Formatter {
  public:
    Help();
    std::string make_description(const CLI::App* app) const override;
    std::string make_footer(const CLI::App* app) const override;
    std::string make_subcommand(const CLI::App* verb) const override;
    std::string make_option(const CLI::Option* option, bool is_positional) const override;
    /// Common options by group; in the mode `All` every option.
    std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override;
};

/// Puts each option of the verbs into its group of the help: Input, Geometry, Metric, Quality, Output, Run.
void set_groups(CLI::App& app);

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

// ---------------------------------------------------------------- explanations

/// Returns the explanation of a topic of configs, an option (`--geometry-error` or `geometry-error`) or a word of the
/// tables, such as `scaled Jacobian`. Errors: usage, an unknown word.
[[nodiscard]] Outcome<std::string> explanation_of(const CLI::App& app, std::string_view word);

/// Returns all words that `explanation_of` knows, by group.
[[nodiscard]] std::string list_explained_words(const CLI::App& app);

/// Returns the help of the program (an empty name) or of a verb, or the explanation of a word. Errors: usage.
[[nodiscard]] Outcome<std::string> help_text_of(const CLI::App& app, const std::string& name);

// ---------------------------------------------------------------- mistakes

/// Finds a word that the parser would misread: an option with one dash and several letters, such as `-hmax`, is one of
/// another program. In `camber explain --WORD` it takes the dashes off: there the option is the word to explain.
[[nodiscard]] std::optional<Error> check_words(const CLI::App& app, std::vector<std::string>& words);

/// The error of arguments that the parser rejects. A misspelt word is reported first: it also explains missing ones.
[[nodiscard]] Error usage_error(const CLI::App& app, const CLI::ParseError& error);

/// An option or a verb of another program, and the equivalent of Camber.
struct ForeignName {
    std::string program;  ///< "Mmg"; empty: several have it
    std::string remedy;
};

/// Looks an option up, with or without dashes and a value: `-hausd`, `--hausd=0.01`.
[[nodiscard]] std::optional<ForeignName> find_foreign_option(std::string_view option);

/// The error of a word that is no verb: a verb of another program, or a misspelt one.
[[nodiscard]] Error unknown_verb(const std::string& word);

}  // namespace camber::app
