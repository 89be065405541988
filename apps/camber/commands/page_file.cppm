module;
#include <string>
#include <vector>
module camber.commands:page_file;
import camber.core;
import camber.io;
import camber.run;
import :ending;

namespace camber::app {

/// Whether a page can be made: its file is an .html that can be written, and the program has the viewer. Asked before
/// the work is done. `where`: the option that names the file. Errors: usage, unsupported, write.
[[nodiscard]] Outcome<Done> check_page(const std::string& path, const std::string& where);

/// A page of a mesh that was checked; `source` without title, version and command.
[[nodiscard]] Outcome<Done> write_page(run::PageSource source, const std::string& title, const std::string& path,
                                       const run::PageOptions& options, const Execution& execution);

}  // namespace camber::app
