#include "help.hpp"

#include <cstddef>
#include <sstream>
#include <string>

#include <CLI/CLI.hpp>
import camber.app_shell;

namespace camber::app {

namespace {

constexpr std::size_t width_before_text = 30;

std::string entry(const std::string& name, const std::string& text) {
    std::ostringstream out;
    CLI::detail::format_help(out, name, wrapped(text, text_width() - width_before_text), width_before_text);
    return out.str();
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
    return entry(make_option_name(option, is_positional) + make_option_opts(option), make_option_desc(option));
}

}  // namespace camber::app
