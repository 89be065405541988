// The program: arguments to verbs.
#include <cstddef>
#include <cstdio>
#include <exception>
#include <new>
#include <sstream>
#include <string>
#include <CLI/CLI.hpp>

#include "arguments.hpp"
#include "usage.hpp"
import camber.core;
import camber.app_shell;
import camber.commands;

namespace {

using namespace camber::app;

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

}  // namespace

int main(int argc, char** argv) {
    hold_standard_streams();
    try {
        if (const auto code = cad_reader({argv, static_cast<std::size_t>(argc)})) return *code;
        set_command_line({argv, static_cast<std::size_t>(argc)});
        Verb verb;
        const auto made = program_of(verb);
        CLI::App& app = *made;
        try {
            app.parse(argc, argv);
        } catch (const CLI::Success& asked) {
            std::ostringstream text;
            app.exit(asked, text);
            return end_with(text.str());
        } catch (const CLI::ParseError& error) {
            return report_error(usage_error(app, error));
        }
        return dispatch(app, verb);
    } catch (const std::bad_alloc&) {
        std::fputs("camber: not enough memory (give it more memory, or a smaller mesh)\n", stderr);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "camber: internal error: %s\n", error.what());
    }
    return 4;
}
