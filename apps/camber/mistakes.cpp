#include "help.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>
#include <CLI/CLI.hpp>

#include "arguments.hpp"
import camber.core;
import camber.commands;
import camber.config;
import camber.recipes;

namespace camber::app {

namespace {

struct Row {
    std::string_view names;  ///< lower case, with "-" instead of "_", separated by spaces
    std::string_view program;
    std::string_view remedy;
};

constexpr std::array options{
    // sizes
    Row{"hausd", "Mmg", "use --geometry-error DISTANCE"},
    Row{"hsiz", "Mmg", "use camber remesh --metric SIZE"},
    Row{"hmax", "Mmg",
        "use --max-size with camber metric or adapt, or --set 'metric_operations=[{\"bound\": {\"max_size\": SIZE}}]'"},
    Row{"hmin", "Mmg",
        "use --min-size with camber metric or adapt, or --set 'metric_operations=[{\"bound\": {\"min_size\": SIZE}}]'"},
    Row{"hgrad hgradreq", "Mmg", "use --gradation RATIO"},
    Row{"sol met", "Mmg", "use --metric FILE for a metric, or --solution FILE for a solution"},
    Row{"lc clmax", "Gmsh", "use camber remesh --metric SIZE"},
    Row{"clmin", "Gmsh",
        "use --min-size with camber metric or adapt, or --set 'metric_operations=[{\"bound\": {\"min_size\": SIZE}}]'"},
    Row{"clscale", "Gmsh", "use camber remesh --complexity NUMBER: in 3D, half the size needs 8 times the complexity"},
    Row{"clcurv", "Gmsh", "use --geometry-error DISTANCE"},
    Row{"bgm", "Gmsh", "use --metric FILE"},
    Row{"size-field sizing mesh-size target-size edge-length resolution h", "", "use camber remesh --metric SIZE"},
    Row{"size-map sizes local-size", "", "use --size REFERENCE=SIZE"},
    // geometry
    Row{"ar angle feature-angle angle-detection", "Mmg",
        "use --set features/ridge_angle=DEGREES, or --ridge-angle with camber check or geometry"},
    Row{"nr no-ridges", "Mmg", "use --set features/ridge_angle=180"},
    Row{"nosurf", "Mmg", "list the triangles as RequiredTriangles in the mesh; required entities are preserved"},
    Row{"ls lag opnbdy", "Mmg", "Camber has no equivalent"},
    Row{"tol tolerance", "", "use --geometry-tolerance for boundary nodes, or --geometry-error for the boundary"},
    Row{"step stp iges brep geo", "",
        "use --cad FILE.step with a mesh; Camber does not generate a mesh from a CAD "
        "model"},
    Row{"model geom cad-file", "", "use --cad FILE"},
    // degree and quality
    Row{"order degree p2 high-order highorder", "Gmsh",
        "camber curve makes degree 2, camber convert --straighten degree 1; there are no higher degrees"},
    Row{"optimize optimise optimize-ho optimize-netgen optimize-threshold optimize-lowmem optho", "Gmsh",
        "use camber repair for a curved mesh, or camber remesh"},
    Row{"optim optimles", "Mmg", "use camber remesh without --metric: it preserves the sizes and improves the shapes"},
    Row{"noinsert noswap nomove", "Mmg",
        "use a config with only the required stages of split, collapse, swap and smooth, see camber explain stages"},
    Row{"smooth smoothing", "Gmsh", "use camber remesh, or the stage smooth in a config"},
    Row{"refine level", "Gmsh", "use camber remesh --metric SIZE"},
    Row{"quality min-quality threshold", "", "use --min-scaled-jacobian BOUND"},
    Row{"algo algorithm", "Gmsh", "Camber does not generate a mesh from a model: mesh it with gmsh first"},
    // files
    Row{"in i input", "", "name the input mesh as the first argument, without an option"},
    Row{"out outfile output-file", "", "use -o FILE"},
    Row{"f input-format output-format outformat bin binary ascii", "", "use --format NAME, see camber convert --help"},
    Row{"save save-all save-topology", "Gmsh", "leave it out: the whole mesh is written to -o FILE"},
    Row{"y yes overwrite clobber", "", "use --force"},
    Row{"part nparts", "Gmsh", "use --partition NUMBER"},
    Row{"3dmedit rn nreg xreg keep-ref", "Mmg", "Camber has no equivalent"},
    // run
    Row{"nt j np cores jobs num-threads nthreads", "", "use --threads NUMBER; several processes: mpirun camber-mpi"},
    Row{"v verbosity debug d", "", "use --verbose for details, or --quiet"},
    Row{"q silent s", "", "use --quiet"},
    Row{"m mem max-memory", "Mmg", "use --memory SIZE with camber curve"},
    Row{"setnumber setstring param", "Gmsh", "use --set PATH=VALUE, see camber explain"},
    Row{"nopopup gui fltk", "Gmsh",
        "leave it out: Camber has no graphical interface; use camber report or picture to "
        "view a mesh"},
    Row{"1 2 3", "Gmsh",
        "leave it out: the dimension is that of the mesh; Camber does not generate a mesh from a model"},
    Row{"a anisotropic aniso", "Mmg", "use --metric FILE with a tensor at each vertex"},
    Row{"val", "Mmg", "use camber VERB --print-config"},
};

constexpr std::array commands{
    Row{"mesh refine coarsen remeshing mmg mmg3d mmg2d mmgs", "", "use camber remesh"},
    Row{"optimize optimise improve smooth untangle fix heal", "",
        "use camber repair for a curved mesh, or camber remesh"},
    Row{"elevate order degree ho highorder", "", "use camber curve"},
    Row{"quality validate verify test stats statistics", "", "use camber check"},
    Row{"view show open display gui", "", "use camber report for a page in a browser, or camber picture"},
    Row{"partition split", "", "use camber convert --partition NUMBER"},
    Row{"list ls cat describe", "", "use camber info"},
    Row{"export import save translate", "", "use camber convert"},
    Row{"interpolate map project", "", "use camber transfer"},
    Row{"straighten linearize", "", "use camber convert --straighten"},
    Row{"version", "", "use camber --version"},
    Row{"new create make", "", "use camber generate"},
};

std::optional<ForeignName> find(std::span<const Row> rows, std::string_view name) {
    for (const Row& row : rows)
        for (std::size_t begin = 0; begin < row.names.size();) {
            const std::size_t end = std::min(row.names.find(' ', begin), row.names.size());
            if (row.names.substr(begin, end - begin) == name)
                return ForeignName{std::string(row.program), std::string(row.remedy)};
            begin = end + 1;
        }
    return std::nullopt;
}

}  // namespace

std::optional<ForeignName> find_foreign_option(std::string_view option) {
    option.remove_prefix(std::min(option.find_first_not_of('-'), option.size()));
    std::string name(option.substr(0, option.find('=')));
    for (char& c : name) c = c == '_' ? '-' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return find(options, name);
}

namespace {

constexpr std::size_t most_suggestions = 3;

std::vector<std::string> names_of_verbs() {
    std::vector<std::string> names;
    for (const Verb& verb : verbs()) names.emplace_back(verb.name);
    return names;
}

std::vector<std::string> options_of(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options())
        for (const std::string& name : option->get_lnames()) names.push_back(name);
    return names;
}

std::string called(const CLI::App& app, const CLI::App& verb) {
    return (&verb != &app ? app.get_name() + " " : "") + verb.get_name();
}

std::vector<std::string> verbs_with(const CLI::App& app, const std::string& option) {
    std::vector<std::string> verbs;
    for (const CLI::App* const verb : app.get_subcommands({})) {
        const CLI::Option* const found = verb->get_option_no_throw("--" + option);
        if (found != nullptr && !found->get_positional()) verbs.push_back(verb->get_name());
    }
    return verbs;
}

/// The option belongs to another program or verb, or is misspelt.
Error unknown_option(const CLI::App& app, const CLI::App& verb, const std::string& word) {
    const std::string where = shortened(word), here = called(app, verb);
    const auto dashes = word.find_first_not_of('-');
    const std::string name = dashes == std::string::npos ? word : word.substr(dashes, word.find('=') - dashes);
    const auto error = [&](const std::string& what, const std::string& remedy) {
        return Error{ErrorKind::usage, what, where, {}, remedy};
    };
    const auto own = options_of(verb);
    if (dashes == 1 && std::ranges::find(own, name) != own.end()) return error("has one dash", "write --" + name);
    if (const std::string now = config::new_name(config::NameKind::argument, name, own); !now.empty())
        return error("was renamed to --" + now, "write --" + now);
    if (const auto foreign = find_foreign_option(word))
        return error(foreign->program.empty() ? "is not an option of " + here
                                              : "is an option of " + foreign->program + ", not of " + here,
                     foreign->remedy);
    auto near = config::nearest_words(name, own, most_suggestions);
    for (std::string& option : near) option.insert(0, "--");
    std::string remedy;
    for (const std::string& other : verbs_with(app, name))
        remedy += (remedy.empty() ? "it is an option of camber " : ", ") + other;
    if (!near.empty())
        remedy += (remedy.empty() ? "did you mean " : "; did you mean ") + config::alternatives_text(near) + "?";
    if (!remedy.empty()) return error("is not an option of " + here, remedy);
    return error("is not an option of " + here, "see " + here + (&verb == &app ? " --help" : " --help-all"));
}

bool has_one_dash(const std::string& word) {
    return word.size() > 2 && word[0] == '-' && std::isalpha(static_cast<unsigned char>(word[1])) != 0;
}

Error error_of(const CLI::ParseError& error, const std::string& help) {
    std::string what = error.what(), where, remedy = "see " + help;
    if (const auto colon = what.find(": "); what.starts_with('-') && colon != std::string::npos) {
        where = what.substr(0, colon);
        what.erase(0, colon + 2);
    }
    if (const auto line = what.find('\n'); line != std::string::npos) {
        remedy = what.substr(line + 1);
        what.erase(line);
    }
    constexpr std::string_view too_many = "At Most 1 required but received ";
    if (what.starts_with(too_many)) {
        what = "appears " + what.substr(too_many.size()) + " times";
        remedy = "use it once";
    } else if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ArgumentMismatch)) {
        what = "a value is missing";
    }
    constexpr std::string_view not_converted = "Could not convert: ";
    if (what.starts_with(not_converted)) {
        const auto equals = what.find(" = ");
        where = what.substr(not_converted.size(), equals - not_converted.size());
        what = in_quotes(what.substr(equals + 3)) + " is not a whole number";
    }
    if (const auto excludes = what.find(" excludes "); excludes != std::string::npos) {
        where = what.substr(0, excludes);
        what = "cannot be combined with " + what.substr(excludes + 10);
        remedy = "use only one of them";
    }
    if (const auto required = what.find(" is required"); required != std::string::npos) {
        where = what.substr(0, required) == "--output" ? "-o, --output" : what.substr(0, required);
        what = "is missing";
    }
    return {ErrorKind::usage, what, where, {}, remedy};
}

}  // namespace

Error unknown_verb(const std::string& word) {
    const auto foreign = find(commands, word);
    const auto known = names_of_verbs();
    const auto near = config::nearest_words(word, known, most_suggestions);
    return {ErrorKind::usage,
            "is not a command",
            shortened(word),
            {},
            foreign        ? foreign->remedy
            : near.empty() ? suggestion("", known)
                           : "did you mean " + config::alternatives_text(near) + "?"};
}

std::optional<Error> check_words(const CLI::App& app, std::vector<std::string>& words) {
    const CLI::App* verb = &app;
    for (const CLI::App* const known : app.get_subcommands({}))
        if (!words.empty() && known->get_name() == words.front()) verb = known;
    if (verb->get_name() == "explain") {
        if (words.size() == 2 && words[1].starts_with('-') && words[1] != "-h" && !words[1].starts_with("--help"))
            words = {"explain", "--", words[1]};
        return std::nullopt;
    }
    const auto own = options_of(*verb);
    const auto is_own = [&](const std::string& word) {
        return std::ranges::find(own, word.substr(1, word.find('=') - 1)) != own.end();
    };
    for (const std::string& word : words)
        if (has_one_dash(word) && (word[1] == 'h' || is_own(word) || find_foreign_option(word)))
            return unknown_option(app, *verb, word);
    return std::nullopt;
}

Error usage_error(const CLI::App& app, const CLI::ParseError& error) {
    const CLI::App& verb = app.get_subcommands().empty() ? app : *app.get_subcommands().front();
    const bool has_verb = &verb != &app;
    const std::string help = called(app, verb) + " --help";
    const std::vector<std::string> words = app.remaining(true);
    const auto kind = static_cast<CLI::ExitCodes>(error.get_exit_code());
    const bool about_words = kind == CLI::ExitCodes::RequiredError || kind == CLI::ExitCodes::ExtrasError;
    if (about_words && !has_verb && words.empty())
        return {ErrorKind::usage, "a command is missing", {}, {}, suggestion("", names_of_verbs())};
    if (!about_words || words.empty()) return error_of(error, help);
    const auto option =
        std::ranges::find_if(words, [](const auto& word) { return word.starts_with('-') && word.size() > 1; });
    if (!has_verb && !words.front().starts_with('-')) return unknown_verb(words.front());
    if (option != words.end()) return unknown_option(app, verb, *option);
    return {ErrorKind::usage,
            "is an unexpected argument",
            shortened(words.front()),
            {},
            "specify an output with -o, put a name with spaces in quotes; see " + help};
}

}  // namespace camber::app
