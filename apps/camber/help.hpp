#pragma once
// Help, explanations of words, and errors for unknown arguments.
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>
#include <CLI/CLI.hpp>

import camber.core;

namespace camber::app {

/// Formats help for the width of the terminal, with one line for each verb.
class Help : public CLI::Formatter {
  public:
    Help();
    std::string make_description(const CLI::App* app) const override;
    std::string make_footer(const CLI::App* app) const override;
    std::string make_subcommand(const CLI::App* verb) const override;
    std::string make_option(const CLI::Option* option, bool is_positional) const override;
    /// Only common options, unless the mode is `All`.
    std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override;
};

/// Assigns options to the groups Input, Geometry, Metric, Quality, Output, Run.
void set_groups(CLI::App& app);

/// An optional part of the build.
struct Part {
    std::string_view name;
    std::string_view libraries;  ///< with versions; empty: missing
    std::string_view command;    ///< adds the part
};

[[nodiscard]] std::string version_text(std::string_view version, std::span<const Part> parts);

[[nodiscard]] std::span<const Part> parts_of_build();

/// Explains a topic of configs, an option (with or without dashes), or a word of the tables. Errors: usage.
[[nodiscard]] Outcome<std::string> explanation_of(const CLI::App& app, std::string_view word);

/// Words that `explanation_of` accepts, by group.
[[nodiscard]] std::string list_explained_words(const CLI::App& app);

/// Help of a verb or, for an empty name, of the program; otherwise explains the word. Errors: usage.
[[nodiscard]] Outcome<std::string> help_text_of(const CLI::App& app, const std::string& name);

/// Rejects words that the parser would misread, such as `-hmax`. In `camber explain --WORD` it removes the dashes.
[[nodiscard]] std::optional<Error> check_words(const CLI::App& app, std::vector<std::string>& words);

/// Converts an error of the parser. A misspelt word has priority, because it can cause missing arguments.
[[nodiscard]] Error usage_error(const CLI::App& app, const CLI::ParseError& error);

/// A name of another program, and Camber's equivalent.
struct ForeignName {
    std::string program;  ///< empty: several
    std::string remedy;
};

/// Accepts dashes and a value: `-hausd`, `--hausd=0.01`.
[[nodiscard]] std::optional<ForeignName> find_foreign_option(std::string_view option);

[[nodiscard]] Error unknown_verb(const std::string& word);

}  // namespace camber::app
