#pragma once
#include <string>

#include <CLI/CLI.hpp>

namespace camber::app {

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

}  // namespace camber::app
