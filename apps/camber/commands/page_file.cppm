module;
#include <string>
#include <vector>
module camber.commands:page_file;
import camber.core;
import camber.io;
import camber.run;
import :ending;

namespace camber::app {

/// Whether a page can be made: its file ends in .html, and the program has the viewer. Asked before the work is done.
/// Errors: usage, unsupported.
[[nodiscard]] Outcome<Done> check_page(const std::string& path);

/// A page of a mesh that was checked; `source` without title, version and command; `mesh`: its path, which names
/// the page. Errors: those of `run::page` and of writing.
[[nodiscard]] Outcome<Done> write_page(run::PageSource source, const std::string& mesh, const std::string& path,
                                       const run::PageOptions& options, const Execution& execution);

}  // namespace camber::app
