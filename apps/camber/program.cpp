// Arguments to verbs, on one rank or on several.
#include "program.hpp"

#include <algorithm>
#include <cstddef>
#include <exception>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>
#include <CLI/CLI.hpp>

#include "arguments.hpp"
#include "explanations.hpp"
#include "usage.hpp"
import camber.core;
import camber.app_shell;
import camber.commands;
import camber.distributed;

namespace camber::app {

namespace {

/// Verbs that go by blocks of the mesh, which several ranks may share.
const std::vector<std::string> verbs_by_blocks{"curve", "remesh", "generate", "convert"};

int print_or_report(const Outcome<std::string>& text) { return text ? end_with(*text) : report_error(text.error()); }

int dispatch(const CLI::App& app, const Verb& verb, const std::shared_ptr<Ranks>& ranks,
             const GraphPartitioner& partition) {
    if (app.got_subcommand("run")) return run_command(verb.run);
    if (app.got_subcommand("curve")) return curve_command(verb.curve, {.ranks = ranks, .partition = partition});
    if (app.got_subcommand("remesh")) return remesh_command(verb.remesh, {.ranks = ranks, .partition = partition});
    if (app.got_subcommand("adapt")) return adapt_command(verb.adapt);
    if (app.got_subcommand("repair")) return repair_command(verb.repair);
    if (app.got_subcommand("plot")) return plot_command(verb.plot);
    if (app.got_subcommand("picture")) return picture_command(verb.picture);
    if (app.got_subcommand("convert")) return convert_command(verb.convert, {.ranks = ranks, .partition = partition});
    if (app.got_subcommand("generate")) return generate_command(verb.generate, {.ranks = ranks});
    if (app.got_subcommand("report")) return report_command(verb.report);
    if (app.got_subcommand("check")) return check_command(verb.check);
    if (app.got_subcommand("geometry")) return geometry_command(verb.geometry);
    if (app.got_subcommand("metric")) return metric_command(verb.metric);
    if (app.got_subcommand("transfer")) return transfer_command(verb.transfer);
    if (app.got_subcommand("info")) return info_command(verb.info);
    if (app.got_subcommand("explain"))
        return verb.topic.empty() ? end_with(list_explained_words(app))
                                  : print_or_report(explanation_of(app, verb.topic));
    if (app.got_subcommand("help")) return print_or_report(help_text_of(app, verb.help_of));
    return schema_command(verb.schema);
}

/// Several ranks would do the whole of it each. Errors: usage.
Outcome<Done> check_ranks(const CLI::App& app, const Ranks& ranks) {
    if (ranks.size() == 1) return Done{};
    for (const CLI::App* const verb : app.get_subcommands())
        if (std::ranges::find(verbs_by_blocks, verb->get_name()) == verbs_by_blocks.end())
            return fail(ErrorKind::usage, "does not go by blocks, and so on one rank alone", verb->get_name(), {},
                        "camber, or mpirun -n 1; threads are shared in any case");
    return Done{};
}

int run_line(std::span<char*> arguments, const std::shared_ptr<Ranks>& ranks, const GraphPartitioner& partition) try {
    set_command_line(arguments);
    Verb verb;
    const auto made = program_of(verb);
    CLI::App& app = *made;
    std::vector<std::string> words(arguments.begin() + (arguments.empty() ? 0 : 1), arguments.end());
    if (const auto unknown = check_words(app, words)) return report_error(*unknown);
    try {
        std::ranges::reverse(words);  // the parser takes them from the end
        app.parse(std::move(words));
    } catch (const CLI::Success& asked) {
        std::ostringstream text;
        app.exit(asked, text);
        return end_with(text.str());
    } catch (const CLI::ParseError& error) {
        return report_error(usage_error(app, error));
    }
    if (auto one = check_ranks(app, *ranks); !one) return report_error(one.error());
    return dispatch(app, verb, ranks, partition);
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

}  // namespace

std::optional<int> other_task(std::span<char*> arguments) { return cad_reader(arguments); }

int run_program(std::span<char*> arguments, const std::shared_ptr<Ranks>& ranks, const GraphPartitioner& partition) {
    if (ranks->rank() > 0) set_voice(Voice::none);
    return end_together(*ranks, run_line(arguments, ranks, partition));
}

}  // namespace camber::app
