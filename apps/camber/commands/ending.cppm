module;
#include <optional>
#include <string>
#include <string_view>
#include <vector>
export module camber.commands:ending;
import camber.core;

export namespace camber::app {

/// "camber: …" in a line on standard error. Where that cannot be written there is nobody to tell.
void tell(const std::string& line);

/// The same of what is worth knowing and no error; not said where the program is to be quiet.
void tell_note(const std::string& note);

/// `camber: where: entity: what (remedy)` on standard error, and the exit code of the error's kind.
int report_error(const Error& error);

/// The last error that was not said, where the program has no voice.
[[nodiscard]] std::optional<Error> error_not_said();

/// Prints the whole of what a verb says to standard output, and returns its exit code: 0, or that of the error if the
/// text cannot be written.
[[nodiscard]] int end_with(std::string_view text);

}  // namespace camber::app

namespace camber::app {

/// A line of the table that a verb prints.
[[nodiscard]] std::string result_row(std::string_view name, std::string_view value);

/// The outputs of a verb as they come to be: an error after the first of them says which were written.
class Written {
  public:
    /// What came of writing the file; it is one of those that were written, or the error tells of them.
    [[nodiscard]] Outcome<Done> add(const std::string& path, Outcome<Done> outcome);
    /// An error that comes after them.
    [[nodiscard]] Error told(Error error) const;
    /// Whether one of them is standard output: what is said goes elsewhere.
    [[nodiscard]] bool takes_standard_output() const;
    [[nodiscard]] const std::vector<std::string>& paths() const { return paths_; }

  private:
    std::vector<std::string> paths_;
};

/// "  wrote wing.vtu\n", for each path that is not empty.
[[nodiscard]] std::string wrote_rows(const std::vector<std::string>& paths);

/// As above, of what a verb that wrote these files says: nothing where it is to be quiet, and to standard error where a
/// file went to standard output. An error also tells which outputs were written.
[[nodiscard]] int end_with(std::string_view text, const Written& written);

}  // namespace camber::app
