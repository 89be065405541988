module;
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include "viewer.hpp"
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.io;
import camber.run;
import :ending;
import :formats;
import :page_file;

namespace camber::app {

Outcome<Done> check_page(const std::string& path) {
    if (path != standard_stream && !path.ends_with(".html") && !path.ends_with(".htm"))
        return fail(ErrorKind::usage, "is no page: it does not end in .html", path, {}, "give it that ending");
    if (viewer().script.empty())
        return fail(ErrorKind::unsupported, "this program was built without the viewer of pages", path, {},
                    "install npm and esbuild and build it anew where npm reaches its registry; camber check tells the "
                    "numbers, camber plot draws the histograms of a report.json");
    return Done{};
}

Outcome<Done> write_page(run::PageSource source, const std::string& mesh, const std::string& path,
                         const run::PageOptions& options, const Execution& execution) {
    Viewer parts = viewer();
    source.title = mesh == standard_stream ? called_input(mesh) : std::filesystem::path(mesh).filename().string();
    source.version = CAMBER_VERSION;
    source.command = command_line();
    const auto text = run::page(source, {std::move(parts.frame), std::move(parts.style), std::move(parts.script)},
                                options, execution);
    return text ? write_text(path, *text) : Outcome<Done>(fail(text.error()));
}

}  // namespace camber::app
