#include "help.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
#include <CLI/CLI.hpp>

#include "arguments.hpp"
import camber.app_shell;

namespace camber::app {

namespace {

/// Long names are separated by spaces.
struct OptionGroup {
    std::string_view name;
    std::string_view options;
    std::string_view verb = {};  ///< empty: all verbs without a row for the option
};

/// Rows of one verb precede the general rows.
constexpr std::array option_groups{
    OptionGroup{"Input", "elements structure set", "generate"},
    OptionGroup{"Input", "field solve", "adapt"},
    OptionGroup{"Output", "size cut show hide view zoom background no-edges worst", "picture"},
    OptionGroup{"Output", "elements worst", "check"},
    OptionGroup{"Metric", "degree", "metric"},
    OptionGroup{"Input", "solution fields field flat reference-array zone"},
    OptionGroup{"Geometry",
                "geometry cad cad-unit cad-vertices cad-timeout cad-memory geometry-tolerance boundary-tolerance "
                "ridge-angle"},
    OptionGroup{"Metric",
                "metric size geometry-error gradation complexity vertices elements norm error-of min-size max-size "
                "max-anisotropy geometry-angle gap-elements intersect"},
    OptionGroup{"Quality", "objective min-scaled-jacobian rounds degree transfer method bounds"},
    OptionGroup{
        "Output",
        "output force format output-solution output-metric report page vtu plots surface partition cells elevate "
        "straighten json histogram worst inner-faces colour"},
    OptionGroup{
        "Run",
        "threads blocks memory cycles convergence-tolerance result timeout folder from mesh-file solution-file set "
        "allow-commands print-config dry-run verbose quiet help help-all"},
};

constexpr std::string_view common_options =
    "solution field solve elements structure geometry cad boundary-tolerance ridge-angle metric size geometry-error "
    "complexity vertices objective min-scaled-jacobian degree method output force format report page partition elevate "
    "straighten json cut show hide view colour surface threads cycles set allow-commands dry-run verbose quiet help "
    "help-all";

bool has_word(std::string_view list, std::string_view word) {
    for (std::size_t at = list.find(word); at != std::string_view::npos; at = list.find(word, at + 1)) {
        const std::size_t end = at + word.size();
        if ((at == 0 || list[at - 1] == ' ') && (end == list.size() || list[end] == ' ')) return true;
    }
    return false;
}

bool is_common(const CLI::Option& option) {
    return option.get_required() || option.get_lnames().empty() || has_word(common_options, long_name(option));
}

}  // namespace

void set_groups(CLI::App& app) {
    for (CLI::App* const verb : app.get_subcommands({}))
        for (CLI::Option* const option : verb->get_options()) {
            if (option->get_positional()) continue;
            const auto row = std::ranges::find_if(option_groups, [&](const OptionGroup& group) {
                return (group.verb.empty() || group.verb == verb->get_name()) &&
                       has_word(group.options, long_name(*option));
            });
            if (row != option_groups.end()) option->group(std::string(row->name));
        }
}

namespace {

constexpr std::size_t width_before_text = 30;

std::string entry(const std::string& name, const std::string& text) {
    std::ostringstream out;
    CLI::detail::format_help(out, name, wrapped(text, text_width() - width_before_text), width_before_text);
    return out.str();
}

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

namespace {

constexpr Part found_parts[] = {
#include "parts.inc"
};

}  // namespace

std::string version_text(std::string_view version, std::span<const Part> parts) {
    std::size_t width = 0;
    for (const Part& part : parts) width = std::max(width, part.name.size());
    std::string text(version);
    for (const Part& part : parts) {
        text += "\n" + std::string(part.name) + std::string(width + 2 - part.name.size(), ' ');
        text += part.libraries.empty() ? "missing; " + std::string(part.command) : std::string(part.libraries);
    }
    const auto missing = std::ranges::count(parts, std::string_view(), &Part::libraries);
    return text + (missing == 0 ? "\nNothing is missing." : "\nMissing parts: " + std::to_string(missing));
}

std::span<const Part> parts_of_build() { return found_parts; }

}  // namespace camber::app
