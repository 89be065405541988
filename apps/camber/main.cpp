// The program: arguments to verbs.
#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <memory>
#include <new>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>
#include <CLI/CLI.hpp>

#include "arguments.hpp"
#include "help.hpp"
import camber.core;
import camber.app_shell;
import camber.commands;

namespace {

using namespace camber::app;

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
    "Exit codes: 0 done; 1 done, but elements remain that are not certified valid, or below the scaled Jacobian that "
    "was asked for (check: or the mesh has other defects); 2 bad usage or config; 3 bad input or output file; 4 not "
    "enough memory, or an internal error; 130 "
    "interrupted. What becomes of every kind of bad input: docs/input.md.";

int dispatch(const CLI::App& app, const Verb& verb) {
    if (app.got_subcommand("run")) return run_command(verb.run);
    if (app.got_subcommand("curve")) return curve_command(verb.curve);
    if (app.got_subcommand("remesh")) return remesh_command(verb.remesh);
    if (app.got_subcommand("adapt")) return adapt_command(verb.adapt);
    if (app.got_subcommand("repair")) return repair_command(verb.repair);
    if (app.got_subcommand("plot")) return plot_command(verb.plot);
    if (app.got_subcommand("picture")) return picture_command(verb.picture);
    if (app.got_subcommand("convert")) return convert_command(verb.convert);
    if (app.got_subcommand("generate")) return generate_command(verb.generate);
    if (app.got_subcommand("report")) return report_command(verb.report);
    if (app.got_subcommand("check")) return check_command(verb.check);
    if (app.got_subcommand("geometry")) return geometry_command(verb.geometry);
    if (app.got_subcommand("metric")) return metric_command(verb.metric);
    if (app.got_subcommand("transfer")) return transfer_command(verb.transfer);
    if (app.got_subcommand("info")) return info_command(verb.info);
    if (app.got_subcommand("explain")) return explain_command(verb.topic);
    return schema_command();
}

std::vector<std::string> verbs_of(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::App* verb : app.get_subcommands({})) names.push_back(verb->get_name());
    return names;
}

std::vector<std::string> options_of(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options())
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    return names;
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
    if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ArgumentMismatch)) what = "a value is missing";
    constexpr std::string_view not_converted = "Could not convert: ";
    if (what.starts_with(not_converted)) {
        const auto equals = what.find(" = ");
        where = what.substr(not_converted.size(), equals - not_converted.size());
        what = "\"" + what.substr(equals + 3) + "\" is no whole number";
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

/// The line for arguments that are not understood: a word that is misspelt explains also what is missing elsewhere.
int report_usage(const CLI::App& app, const CLI::ParseError& error) {
    const CLI::App& verb = app.get_subcommands().empty() ? app : *app.get_subcommands().front();
    const bool has_verb = &verb != &app;
    const std::string help = (has_verb ? app.get_name() + " " : "") + verb.get_name() + " --help";
    const std::vector<std::string> words = app.remaining(true);
    const auto kind = static_cast<CLI::ExitCodes>(error.get_exit_code());
    const bool about_words = kind == CLI::ExitCodes::RequiredError || kind == CLI::ExitCodes::ExtrasError;
    if (about_words && !has_verb && words.empty())
        return report_error({camber::ErrorKind::usage, "what is to be done?", {}, {}, suggestion("", verbs_of(app))});
    if (!about_words || words.empty()) return report_error(error_of(error, help));
    const auto option =
        std::find_if(words.begin(), words.end(), [](const auto& word) { return word.starts_with("--"); });
    if (!has_verb && !words.front().starts_with('-'))
        return report_error(
            {camber::ErrorKind::usage, "is no command", words.front(), {}, suggestion(words.front(), verbs_of(app))});
    if (option != words.end())
        return report_error({camber::ErrorKind::usage,
                             "is no option",
                             *option,
                             {},
                             suggestion(option->substr(0, option->find('=')), options_of(verb))});
    return report_error({camber::ErrorKind::usage,
                         "is one argument too many",
                         words.front(),
                         {},
                         "quote what has spaces; see " + help});
}

}  // namespace

int main(int argc, char** argv) {
    hold_standard_streams();
    try {
        if (const auto code = cad_reader({argv, static_cast<std::size_t>(argc)})) return *code;
        set_command_line({argv, static_cast<std::size_t>(argc)});
        CLI::App app{description, "camber"};
        app.formatter(std::make_shared<Help>());
        app.set_version_flag("--version", CAMBER_VERSION);
        app.require_subcommand(1);
        Verb verb;
        add_verbs(app, verb);
        add_quiet(app);
        app.footer(exit_codes);  // not the verbs', which take theirs when they are made
        try {
            app.parse(argc, argv);
        } catch (const CLI::Success& asked) {
            std::ostringstream text;
            app.exit(asked, text);
            return end_with(text.str());
        } catch (const CLI::ParseError& error) {
            return report_usage(app, error);
        }
        return dispatch(app, verb);
    } catch (const std::bad_alloc&) {
        std::fputs("camber: not enough memory (give it more memory, or a smaller mesh)\n", stderr);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "camber: internal error: %s\n", error.what());
    }
    return 4;
}
