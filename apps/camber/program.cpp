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
         "Adapt a straight or curved mesh to a metric: split, collapse, swap and smooth until its edges have unit "
         "length.",
         declare_remesh},
    Verb{"adapt", VerbGroup::on_one_rank,
         "Adapt a mesh to a solution in cycles of metric, remesh, curve, transfer and solver.", declare_adapt},
    Verb{"repair", VerbGroup::on_one_rank, "Repair a curved mesh from another program: validate, relax, commit.",
         declare_repair},
    Verb{"metric", VerbGroup::on_one_rank,
         "Compute the metric for a solution: a mesh with the specified number of elements then interpolates it best.",
         declare_metric},
    Verb{"transfer", VerbGroup::on_one_rank, "Transfer a solution to another mesh of the domain.", declare_transfer},
    Verb{"convert", VerbGroup::by_blocks, "Convert a mesh or a solution to another format.", declare_convert},
    Verb{"generate", VerbGroup::by_blocks, "Generate a straight mesh of a simple shape, at any size.",
         declare_generate},
    Verb{"plot", VerbGroup::on_one_rank, "Plot histograms of a run as SVG pictures, before and after correction.",
         declare_plot},
    Verb{"picture", VerbGroup::on_one_rank, "Draw a mesh with its curved edges as a picture. No display is necessary.",
         declare_picture},
    Verb{"check", VerbGroup::on_one_rank,
         "Check the validity and quality of a mesh of degree 1 or 2 from any program. The mesh is not changed.",
         declare_check},
    Verb{"report", VerbGroup::on_one_rank,
         "Write a mesh and the report of check as a page for a browser. It shows the curved faces, cuts, colours, the "
         "worst elements, histograms and tables. The page is one file that needs no network.",
         declare_report},
    Verb{"geometry", VerbGroup::on_one_rank,
         "Analyse the boundary of a mesh and its distance from a geometry. The mesh has degree 1 or 2 and is not "
         "changed.",
         declare_geometry},
    Verb{"info", VerbGroup::data, "Print the contents of a mesh or solution file", declare_info},
    Verb{"explain", VerbGroup::data,
         "Explain a word: a section, stage or source of configs, an option, or a word of the tables.", declare_explain},
    Verb{"help", VerbGroup::data, "Print this text, or the help of a command", declare_help},
    Verb{"schema", VerbGroup::data, "Print the JSON Schema of a config, for editors, or of a report", declare_schema},
};

constexpr const char* description =
    "Camber converts straight meshes to curved (P2) meshes that follow a metric and a geometry. Its curved elements "
    "are proven valid.\n\n"
    "  camber curve wing.meshb -o wing-p2.meshb          curve a mesh by its natural metric\n"
    "  camber remesh wing.meshb --metric m.sol -o w.mesh adapt a straight or curved mesh to a metric\n"
    "  camber adapt w.mesh --field 'tanh(x/0.01)' -o v.mesh   adapt a mesh to a solution, in cycles\n"
    "  camber repair broken-p2.meshb -o valid-p2.meshb   repair a curved mesh from another program\n"
    "  camber run configs/spheres.json                   run a pipeline\n"
    "  camber check wing-p2.meshb                        check validity and quality\n"
    "  camber report wing-p2.meshb -o wing.html          write the check as a page for a browser\n"
    "  camber geometry wing-p2.meshb --cad wing.step     boundary, and distances from the CAD model\n"
    "  camber metric w.mesh --solution u.sol -o m.sol    compute the metric for a solution\n"
    "  camber transfer w.mesh new.mesh --solution u.sol -o v.sol   transfer a solution to another mesh\n"
    "  camber picture wing-p2.meshb -o wing.png          draw a picture with curved edges\n"
    "  camber convert wing-p2.meshb -o wing-p2.vtu       convert for ParaView\n"
    "  camber generate shell -o shell.meshb              generate an example mesh\n"
    "  camber explain curve                              explain a stage and its options\n";

constexpr const char* exit_codes =
    "Exit codes: 0 success; 1 the output does not meet the requirements: elements are not proven valid, or are below "
    "the requested scaled Jacobian, the boundary is off its geometry, facets cross, or elements overlap (check: or the "
    "mesh has other defects); 2 wrong usage or config; 3 an input or output file failed; 4 not enough memory, or an "
    "internal error; 130 interrupted. Errors of input files: docs/input.md.";

struct Program {
    std::unique_ptr<Call> call = std::make_unique<Call>();
    std::shared_ptr<CLI::App> parser = std::make_shared<CLI::App>(description, "camber");
    std::vector<Work> works = {};
};

void add_version(CLI::App& app) {
    const CLI::Option* const verbose = app.add_flag_callback(
        "--verbose",
        [&app] {
            if (app.count("--version") == 0) throw CLI::RequiresError("--verbose", "--version");
        },
        "With --version: also print the parts of this build, and the commands that add missing parts");
    app.set_version_flag("--version", [verbose] {
        return verbose->count() == 0 ? std::string(CAMBER_VERSION) : version_text(CAMBER_VERSION, parts_of_build());
    });
}

void add_voice(CLI::App& verb) {
    CLI::Option* const quiet = verb.add_flag_callback(
        "--quiet", [] { set_voice(Voice::quiet); },
        "Print only errors, and the reasons for exit code 1: no tables, notes or progress");
    verb.add_flag_callback(
            "--verbose", [] { set_voice(Voice::verbose); },
            "Also print details: data other than names and fields that the output format cannot store")
        ->excludes(quiet);
}

Program program() {
    Program result;
    CLI::App& app = *result.parser;
    app.formatter(std::make_shared<Help>());
    add_version(app);
    app.require_subcommand(1);
    for (const Verb& verb : verbs()) {
        CLI::App* const parser = app.add_subcommand(std::string(verb.name), std::string(verb.summary));
        parser->set_help_all_flag("--help-all", "Print the help with all options, and exit");
        result.works.push_back(verb.declare(parser, result.call->arguments));
        if (verb.group != VerbGroup::data) add_voice(*parser);
    }
    set_groups(app);
    app.footer(exit_codes);  // set last, so that verbs do not inherit it
    return result;
}

Outcome<std::variant<std::unique_ptr<Call>, std::string>> parse(std::vector<std::string> words) {
    Program result = program();
    CLI::App& app = *result.parser;
    if (const auto unknown = check_words(app, words)) return fail(*unknown);
    try {
        std::ranges::reverse(words);  // the parser consumes words from the end
        app.parse(std::move(words));
    } catch (const CLI::Success& success) {
        std::ostringstream text;
        app.exit(success, text);
        return text.str();
    } catch (const CLI::ParseError& error) {
        return fail(usage_error(app, error));
    }
    const auto row = std::ranges::find(table, app.get_subcommands().front()->get_name(), &Verb::name) - table.begin();
    result.call->verb = &table[static_cast<std::size_t>(row)];
    result.call->work = std::move(result.works[static_cast<std::size_t>(row)]);
    result.call->parser = std::move(result.parser);
    return std::move(result.call);
}

/// Several ranks can only run verbs that work by blocks.
Outcome<Done> check_ranks(const Verb& verb, const Ranks& ranks) {
    if (ranks.size() == 1 || verb.group == VerbGroup::by_blocks) return Done{};
    return fail(ErrorKind::usage, "cannot run on several ranks", std::string(verb.name), {},
                "run camber, or mpirun -n 1; one rank uses all threads");
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

/// Returns the common exit code. A failed rank cancels the exchanges of waiting ranks.
int end_together(Ranks& ranks, int code) {
    constexpr int first_of_failures = 2;
    if (ranks.size() == 1) return code;
    const Error none{ErrorKind::internal, "a rank ended with exit code " + std::to_string(code), {}, {}, {}};
    const auto codes = gather_all<int>(
        ranks, code < first_of_failures ? Outcome<std::vector<int>>({code}) : fail(unreported_error().value_or(none)));
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
    return fail(ErrorKind::usage, "prints a text and is not accepted here", "--help");
}

std::string arguments_json() {
    const Program result = program();
    Json json = Json::object();
    for (const CLI::App* const verb : result.parser->get_subcommands({})) {
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
