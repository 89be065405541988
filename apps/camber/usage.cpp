// The program as its parser knows it, and what it says of arguments that are not understood.
#include "usage.hpp"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>
#include <CLI/CLI.hpp>

#include "arguments.hpp"
#include "foreign_options.hpp"
#include "help.hpp"
#include "option_groups.hpp"
#include "parts.hpp"
import camber.core;
import camber.commands;
import camber.config;

namespace camber::app {

namespace {

constexpr const char* description =
    "Camber: curved (P2) meshes from straight ones, driven by a metric and by the geometry; always valid.\n\n"
    "  camber curve wing.meshb -o wing-p2.meshb          curve a mesh by its own metric\n"
    "  camber remesh wing.meshb --metric m.sol -o w.mesh bring a mesh, straight or curved, to a metric\n"
    "  camber adapt w.mesh --field 'tanh(x/0.01)' -o v.mesh   to a solution, cycle after cycle\n"
    "  camber repair broken-p2.meshb -o valid-p2.meshb   repair a curved mesh made elsewhere\n"
    "  camber run configs/spheres.json                   run a pipeline\n"
    "  camber check wing-p2.meshb                        is it a good mesh?\n"
    "  camber report wing-p2.meshb -o wing.html          the same as a page to look at it in a browser\n"
    "  camber geometry wing-p2.meshb --cad wing.step     what its boundary is, and how far from the model\n"
    "  camber metric w.mesh --solution u.sol -o m.sol    the metric that a solution asks for\n"
    "  camber transfer w.mesh new.mesh --solution u.sol -o v.sol   a solution brought to another mesh\n"
    "  camber picture wing-p2.meshb -o wing.png          a picture, edges curved as they are\n"
    "  camber convert wing-p2.meshb -o wing-p2.vtu       for ParaView\n"
    "  camber generate shell -o shell.meshb              a mesh to try things on\n"
    "  camber explain curve                              what a stage does, and its options\n";

constexpr const char* exit_codes =
    "Exit codes: 0 done; 1 done, but the result is not the requested one: elements are not certified valid or below "
    "the "
    "requested scaled Jacobian, the boundary is off its geometry, walls cross, or elements overlap (check: or the mesh "
    "has other "
    "defects); 2 bad usage or config; 3 bad input or output file; 4 not "
    "enough memory, or an internal error; 130 "
    "interrupted. What becomes of every kind of bad input: docs/input.md.";

std::vector<std::string> verbs_of(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::App* verb : app.get_subcommands({})) names.push_back(verb->get_name());
    return names;
}

/// Long names, without dashes.
std::vector<std::string> options_of(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options())
        for (const std::string& name : option->get_lnames()) names.push_back(name);
    return names;
}

/// The command line as it stands before an option: "camber curve".
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

/// An option that the verb does not have: one of another program, one of other verbs, or a misspelt one.
camber::Error unknown_option(const CLI::App& app, const CLI::App& verb, const std::string& word) {
    constexpr std::size_t most_suggestions = 3;
    const std::string where = shortened(word), here = called(app, verb);
    const auto dashes = word.find_first_not_of('-');
    const std::string name = dashes == std::string::npos ? word : word.substr(dashes, word.find('=') - dashes);
    const auto error = [&](const std::string& what, const std::string& remedy) {
        return camber::Error{camber::ErrorKind::usage, what, where, {}, remedy};
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
        remedy += (remedy.empty() ? "it is one of camber " : ", ") + other;
    if (!near.empty())
        remedy += (remedy.empty() ? "did you mean " : "; did you mean ") + config::alternatives_text(near) + "?";
    if (!remedy.empty()) return error("is not an option of " + here, remedy);
    return error("is not an option of " + here, "see " + here + (&verb == &app ? " --help" : " --help-all"));
}

/// True for one dash and more than one letter.
bool has_one_dash(const std::string& word) {
    return word.size() > 2 && word[0] == '-' && std::isalpha(static_cast<unsigned char>(word[1])) != 0;
}

/// The parser's error in its parts: the option, what is wrong, what to do.
camber::Error error_of(const CLI::ParseError& error, const std::string& help) {
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
        what = "is given " + what.substr(too_many.size()) + " times";
        remedy = "give it once";
    } else if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ArgumentMismatch)) {
        what = "a value is missing";
    }
    constexpr std::string_view not_converted = "Could not convert: ";
    if (what.starts_with(not_converted)) {
        const auto equals = what.find(" = ");
        where = what.substr(not_converted.size(), equals - not_converted.size());
        what = in_quotes(what.substr(equals + 3)) + " is no whole number";
    }
    if (const auto excludes = what.find(" excludes "); excludes != std::string::npos) {
        where = what.substr(0, excludes);
        what = "does not go with " + what.substr(excludes + 10);
        remedy = "give one of them";
    }
    if (const auto required = what.find(" is required"); required != std::string::npos) {
        where = what.substr(0, required) == "--output" ? "-o, --output" : what.substr(0, required);
        what = "is missing";
    }
    return {camber::ErrorKind::usage, what, where, {}, remedy};
}

camber::Error unknown_command(const CLI::App& app, const std::string& word) {
    constexpr std::size_t most_suggestions = 3;
    const auto foreign = find_foreign_command(word);
    const auto verbs = verbs_of(app);
    const auto near = config::nearest_words(word, verbs, most_suggestions);
    return {camber::ErrorKind::usage,
            "is not a command",
            shortened(word),
            {},
            foreign        ? foreign->remedy
            : near.empty() ? suggestion("", verbs)
                           : "did you mean " + config::alternatives_text(near) + "?"};
}

}  // namespace

std::optional<camber::Error> check_words(const CLI::App& app, std::vector<std::string>& words) {
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

std::unique_ptr<CLI::App> program_of(Verb& verb) {
    auto app = std::make_unique<CLI::App>(description, "camber");
    app->formatter(std::make_shared<Help>());
    const CLI::Option* const verbose = app->add_flag_callback(
        "--verbose",
        [program = app.get()] {
            if (program->count("--version") == 0) throw CLI::RequiresError("--verbose", "--version");
        },
        "With --version: also print the parts of this build, and the commands that add missing ones");
    app->set_version_flag("--version", [verbose] {
        return verbose->count() == 0 ? std::string(CAMBER_VERSION) : version_text(CAMBER_VERSION, parts_of_build());
    });
    app->require_subcommand(1);
    add_verbs(*app, verb);
    add_voice(*app);
    set_groups(*app);
    app->footer(exit_codes);  // not the verbs', which take theirs when they are made
    return app;
}

camber::Error usage_error(const CLI::App& app, const CLI::ParseError& error) {
    const CLI::App& verb = app.get_subcommands().empty() ? app : *app.get_subcommands().front();
    const bool has_verb = &verb != &app;
    const std::string help = called(app, verb) + " --help";
    const std::vector<std::string> words = app.remaining(true);
    const auto kind = static_cast<CLI::ExitCodes>(error.get_exit_code());
    const bool about_words = kind == CLI::ExitCodes::RequiredError || kind == CLI::ExitCodes::ExtrasError;
    if (about_words && !has_verb && words.empty())
        return {camber::ErrorKind::usage, "a command is missing", {}, {}, suggestion("", verbs_of(app))};
    if (!about_words || words.empty()) return error_of(error, help);
    const auto option =
        std::ranges::find_if(words, [](const auto& word) { return word.starts_with('-') && word.size() > 1; });
    if (!has_verb && !words.front().starts_with('-')) return unknown_command(app, words.front());
    if (option != words.end()) return unknown_option(app, verb, *option);
    return {camber::ErrorKind::usage,
            "is one argument too many",
            shortened(words.front()),
            {},
            "name an output with -o, quote a name with blanks; see " + help};
}

}  // namespace camber::app
