module;
#include <unistd.h>

#include <string_view>
export module camber.app_shell:standard_output;
import camber.core;

export namespace camber::app {

/// Once, before anything is opened or printed: writing to a closed pipe, or beyond the limit of the size of files,
/// becomes an error of that write, and a standard stream that the caller closed stays unwritable instead of becoming
/// the next file that is opened.
void hold_standard_streams();

/// Standard output, under one rule for all verbs: a reader that goes before all is said (`| head`) is no failure;
/// whatever else keeps the text from being written is one (a full disk, a closed stream).
class StandardOutput {
  public:
    /// For results that go to standard error instead, where a file goes to standard output.
    [[nodiscard]] static StandardOutput beside_a_file() { return StandardOutput(STDERR_FILENO); }
    StandardOutput() = default;
    void print(std::string_view text);
    /// Errors: write, with the system's reason for the first text that was not written.
    [[nodiscard]] Outcome<Done> finish();

  private:
    explicit StandardOutput(int fd) : fd_(fd) {}

    int fd_ = STDOUT_FILENO;
    int error_ = 0;
};

}  // namespace camber::app
