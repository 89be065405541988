// The table of verbs, the parser that is made of it, and the program.
#include "program.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <exception>
#include <memory>
#include <new>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <variant>
#include <vector>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "arguments.hpp"
#include "help.hpp"
import camber.core;
import camber.app_shell;
import camber.commands;
import camber.distributed;

namespace camber::app {

namespace {

constexpr std::array table{
    Verb{"run", VerbGroup::on_one_rank, "Run a pipeline described in JSON", declare_run},
    Verb{"curve", VerbGroup::by_blocks, "Curve a straight mesh: elevate, curve, validate, relax, commit",
         declare_curve},
    Verb{"remesh", VerbGroup::by_blocks,
         "Bring a mesh, straight or curved, to a metric: split, collapse, swap and smooth until its edges are of unit "
         "length.",
         declare_remesh},
    Verb{"adapt", VerbGroup::on_one_rank,
         "Adapt a mesh to a solution, cycle after cycle: metric, remesh, curve, transfer; and the solver in between.",
         declare_adapt},
    Verb{"repair", VerbGroup::on_one_rank, "Repair a curved mesh made elsewhere: validate, relax, commit.",
         declare_repair},
    Verb{"metric", VerbGroup::on_one_rank,
         "The metric that a solution asks for: of all meshes with so many elements the one that interpolates it best.",
         declare_metric},
    Verb{"transfer", VerbGroup::on_one_rank,
         "A solution on another mesh of the domain: on one that was remeshed, or any.", declare_transfer},
    Verb{"convert", VerbGroup::by_blocks, "A mesh or a solution in another format.", declare_convert},
    Verb{"generate", VerbGroup::by_blocks,
         "A straight mesh of a shape, without a file: to try things on, and at any size.", declare_generate},
    Verb{"plot", VerbGroup::on_one_rank, "Histograms of a run as SVG pictures, before and after correction.",
         declare_plot},
    Verb{"picture", VerbGroup::on_one_rank, "A mesh as a picture, edges curved as they are; without a display.",
         declare_picture},
    Verb{"check", VerbGroup::on_one_rank,
         "Is it a good mesh? Of any mesh of degree 1 or 2, made by whatever program; nothing is changed.",
         declare_check},
    Verb{"report", VerbGroup::on_one_rank,
         "A mesh and what check says of it as one page for a browser: its curved faces, to be turned, cut and "
         "coloured, the worst elements, histograms, numbers. The page is one file that needs no network.",
         declare_report},
    Verb{"geometry", VerbGroup::on_one_rank,
         "What the boundary of a mesh is, and how far it is from a geometry. Of any mesh of degree 1 or 2; nothing is "
         "changed.",
         declare_geometry},
    Verb{"info", VerbGroup::data, "What a mesh or a solution file holds", declare_info},
    Verb{"explain", VerbGroup::data,
         "Explain a word: a section, stage or source of configs, an option, a word of the tables.", declare_explain},
    Verb{"help", VerbGroup::data, "Print this text, or the help of a command", declare_help},
    Verb{"schema", VerbGroup::data, "The JSON Schema of a pipeline, for editors, or of a report", declare_schema},
};

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
    "the requested scaled Jacobian, the boundary is off its geometry, walls cross, or elements overlap (check: or the "
    "mesh has other defects); 2 bad usage or config; 3 bad input or output file; 4 not enough memory, or an internal "
    "error; 130 interrupted. What becomes of every kind of bad input: docs/input.md.";

/// The parser of the program, the values that it stores, and the work of each verb in the order of the table.
struct Program {
    std::unique_ptr<Call> call = std::make_unique<Call>();
    std::shared_ptr<CLI::App> parser = std::make_shared<CLI::App>(description, "camber");
    std::vector<Work> works = {};
};

/// --version and --verbose of the program.
void add_version(CLI::App& app) {
    const CLI::Option* const verbose = app.add_flag_callback(
        "--verbose",
        [&app] {
            if (app.count("--version") == 0) throw CLI::RequiresError("--verbose", "--version");
        },
        "With --version: also print the parts of this build, and the commands that add missing ones");
    app.set_version_flag("--version", [verbose] {
        return verbose->count() == 0 ? std::string(CAMBER_VERSION) : version_text(CAMBER_VERSION, parts_of_build());
    });
}

/// --quiet and --verbose of a verb.
void add_voice(CLI::App& verb) {
    CLI::Option* const quiet = verb.add_flag_callback(
        "--quiet", [] { set_voice(Voice::quiet); },
        "Print errors, and why the result is not the requested one, only: no table, no notes, no progress");
    verb.add_flag_callback(
            "--verbose", [] { set_voice(Voice::verbose); },
            "Also print details: data other than names and fields that the output's format cannot store")
        ->excludes(quiet);
}

Program program() {
    Program made;
    CLI::App& app = *made.parser;
    app.formatter(std::make_shared<Help>());
    add_version(app);
    app.require_subcommand(1);
    for (const Verb& verb : verbs()) {
        CLI::App* const parser = app.add_subcommand(std::string(verb.name), std::string(verb.summary));
        parser->set_help_all_flag("--help-all", "Print the help with all options and exit");
        made.works.push_back(verb.declare(parser, made.call->arguments));
        if (verb.group != VerbGroup::data) add_voice(*parser);
    }
    set_groups(app);
    app.footer(exit_codes);  // not the verbs', which take theirs when they are made
    return made;
}

/// A text is the answer to --help or --version.
Outcome<std::variant<std::unique_ptr<Call>, std::string>> parse(std::vector<std::string> words) {
    Program made = program();
    CLI::App& app = *made.parser;
    if (const auto unknown = check_words(app, words)) return fail(*unknown);
    try {
        std::ranges::reverse(words);  // the parser takes them from the end
        app.parse(std::move(words));
    } catch (const CLI::Success& success) {
        std::ostringstream text;
        app.exit(success, text);
        return text.str();
    } catch (const CLI::ParseError& error) {
        return fail(usage_error(app, error));
    }
    const auto row = std::ranges::find(table, app.get_subcommands().front()->get_name(), &Verb::name) - table.begin();
    made.call->verb = &table[static_cast<std::size_t>(row)];
    made.call->work = std::move(made.works[static_cast<std::size_t>(row)]);
    made.call->parser = std::move(made.parser);
    return std::move(made.call);
}

/// Rejects work that each of several ranks would do as a whole. Errors: usage.
Outcome<Done> check_ranks(const Verb& verb, const Ranks& ranks) {
    if (ranks.size() == 1 || verb.group == VerbGroup::by_blocks) return Done{};
    return fail(ErrorKind::usage, "does not go by blocks, and so on one rank alone", std::string(verb.name), {},
                "camber, or mpirun -n 1; threads are shared in any case");
}

int run_line(std::span<char*> arguments, const std::shared_ptr<Ranks>& ranks, const GraphPartitioner& partition) try {
    set_command_line(arguments);
    const auto parsed = parse({arguments.begin() + (arguments.empty() ? 0 : 1), arguments.end()});
    if (!parsed) return report_error(parsed.error());
    if (const auto* text = std::get_if<std::string>(&*parsed)) return end_with(*text);
    const Call& call = *std::get<std::unique_ptr<Call>>(*parsed);
    if (auto possible = check_ranks(*call.verb, *ranks); !possible) return report_error(possible.error());
    const auto code = call.work.run({.ranks = ranks, .partition = partition});
    return code ? *code : report_error(code.error());
} catch (const std::bad_alloc& failure) {
    return report_error(out_of_memory(failure));
} catch (const std::exception& error) {
    return report_error({ErrorKind::internal, std::string("internal error: ") + error.what(), {}, {}, {}});
}

/// The exit code of all. A rank that has failed where the others have not tells them so in whichever exchange they are.
int end_together(Ranks& ranks, int code) {
    constexpr int first_of_failures = 2;
    if (ranks.size() == 1) return code;
    const Error none{ErrorKind::internal, "a rank has ended with exit code " + std::to_string(code), {}, {}, {}};
    const auto codes = gather_all<int>(
        ranks, code < first_of_failures ? Outcome<std::vector<int>>({code}) : fail(error_not_said().value_or(none)));
    if (codes) return *std::ranges::max_element(*codes);
    return code < first_of_failures ? report_error(codes.error()) : code;
}

using Json = nlohmann::ordered_json;

Json described(const CLI::Option& option) {
    Json json{{"name", long_name(option)}, {"help", option.get_description()}};
    json["positional"] = option.get_positional();
    json["required"] = option.get_required();
    json["type"] = option.get_option_text().empty() ? option.get_type_name() : option.get_option_text();
    json["default"] = option.get_default_str();
    json["flag"] = option.get_items_expected_max() == 0;
    json["many"] = option.get_items_expected_max() > 1;
    return json;
}

}  // namespace

std::span<const Verb> verbs() { return table; }

Outcome<std::unique_ptr<Call>> call_of(std::vector<std::string> words) {
    auto parsed = parse(std::move(words));
    if (!parsed) return fail(parsed.error());
    if (auto* const call = std::get_if<std::unique_ptr<Call>>(&*parsed)) return std::move(*call);
    return fail(ErrorKind::usage, "is a question, and no argument", "--help");
}

std::string arguments_json() {
    const Program made = program();
    Json json = Json::object();
    for (const CLI::App* const verb : made.parser->get_subcommands({})) {
        Json arguments = Json::array();
        for (const CLI::Option* option : verb->get_options())
            if (!option->get_single_name().starts_with("help")) arguments.push_back(described(*option));
        json[verb->get_name()] = {{"about", verb->get_description()}, {"arguments", std::move(arguments)}};
    }
    return json.dump(1);
}

int run_program(std::span<char*> arguments, const std::shared_ptr<Ranks>& ranks, const GraphPartitioner& partition) {
    if (ranks->rank() > 0) set_voice(Voice::none);
    return end_together(*ranks, run_line(arguments, ranks, partition));
}

}  // namespace camber::app
