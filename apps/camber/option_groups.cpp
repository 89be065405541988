// Groups of options in the help of a verb.
#include "option_groups.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <CLI/CLI.hpp>

namespace camber::app {

namespace {

/// Options of one group, by their long names with blanks between them.
struct OptionGroup {
    std::string_view name;
    std::string_view options;
    std::string_view verb = {};  ///< empty: of all verbs that no other row names
};

/// Rows of one verb come first.
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

/// Options that `--help` shows.
constexpr std::string_view common_options =
    "solution field solve elements structure geometry cad boundary-tolerance ridge-angle metric size geometry-error "
    "complexity vertices objective min-scaled-jacobian degree method output force format report page partition elevate "
    "straighten json cut show hide view colour surface threads cycles set allow-commands dry-run verbose quiet help "
    "help-all";

/// True if the list has that word.
bool has_word(std::string_view list, std::string_view word) {
    for (std::size_t at = list.find(word); at != std::string_view::npos; at = list.find(word, at + 1)) {
        const std::size_t end = at + word.size();
        if ((at == 0 || list[at - 1] == ' ') && (end == list.size() || list[end] == ' ')) return true;
    }
    return false;
}

std::string name_of(const CLI::Option& option) {
    return option.get_lnames().empty() ? std::string() : option.get_lnames().front();
}

}  // namespace

void set_groups(CLI::App& app) {
    for (CLI::App* const verb : app.get_subcommands({}))
        for (CLI::Option* const option : verb->get_options()) {
            const auto row = std::ranges::find_if(option_groups, [&](const OptionGroup& group) {
                return (group.verb.empty() || group.verb == verb->get_name()) &&
                       has_word(group.options, name_of(*option));
            });
            if (row != option_groups.end()) option->group(std::string(row->name));
        }
}

bool is_common(const CLI::Option& option) {
    return option.get_required() || name_of(option).empty() || has_word(common_options, name_of(option));
}

}  // namespace camber::app
