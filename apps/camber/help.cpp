#include "help.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "option_groups.hpp"
import camber.app_shell;

namespace camber::app {

namespace {

constexpr std::size_t width_before_text = 30;

std::string entry(const std::string& name, const std::string& text) {
    std::ostringstream out;
    CLI::detail::format_help(out, name, wrapped(text, text_width() - width_before_text), width_before_text);
    return out.str();
}

/// The options of a verb by group: common ones, or all.
std::string options_by_group(const CLI::Formatter& formatter, const CLI::App* app, bool all) {
    constexpr std::array titles{"Options", "Input", "Geometry", "Metric", "Quality", "Output", "Run"};
    std::string text;
    bool is_complete = true;
    for (const std::string title : titles) {
        std::vector<const CLI::Option*> shown;
        for (const CLI::Option* const option : app->get_options())
            if (option->nonpositional() && option->get_group() == title) {
                if (all || is_common(*option))
                    shown.push_back(option);
                else
                    is_complete = false;
            }
        if (!shown.empty()) text += formatter.make_group(title, false, shown);
    }
    if (is_complete) return text;
    return text + "\n" +
           wrapped("All options: camber " + app->get_name() + " --help-all. One option: camber explain --NAME.",
                   text_width()) +
           "\n";
}

}  // namespace

Help::Help() { column_width(width_before_text); }

std::string Help::make_description(const CLI::App* app) const {
    return wrapped(app->get_description(), text_width()) + "\n\n";
}

std::string Help::make_footer(const CLI::App* app) const {
    const std::string footer = wrapped(app->get_footer(), text_width());
    return footer.empty() ? footer : footer + "\n";
}

std::string Help::make_subcommand(const CLI::App* verb) const {
    const std::string text = verb->get_description();
    return entry(verb->get_name(), text.substr(0, text.find('\n')));
}

std::string Help::make_option(const CLI::Option* option, bool is_positional) const {
    const std::string form = make_option_opts(option);  // ends with the options that it excludes
    return entry(make_option_name(option, is_positional) + form.substr(0, form.find(" Excludes:")),
                 make_option_desc(option));
}

std::string Help::make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const {
    const bool is_program = app->get_parent() == nullptr;
    const bool all = is_program || mode == CLI::AppFormatMode::All;
    return make_description(app) + make_usage(app, std::move(name)) + make_positionals(app) +
           options_by_group(*this, app, all) + (is_program ? make_subcommands(app, CLI::AppFormatMode::Normal) : "") +
           "\n" + make_footer(app);
}

}  // namespace camber::app
