module;
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
#include <unistd.h>
/// Access to the system: files, terminal, clocks, memory and signals.
export module camber.app_shell;
import camber.core;

/// Child processes of this program, for work that may crash or never end, such as libraries on damaged files.
export namespace camber::app {

struct ChildLimits {
    double seconds = 0;     ///< wall-clock and CPU time
    std::size_t bytes = 0;  ///< address space
};

enum class ChildEnd : std::uint8_t { done, crashed, out_of_time };
struct ChildResult {
    ChildEnd end = ChildEnd::done;
    std::string bytes;  ///< passed by `hand_over`
    std::string how;    ///< reason of a crash
};

/// Sets the command that starts this program again, with leading arguments; initially /proc/self/exe; empty: none.
void start_itself_by(std::vector<std::string> words);
[[nodiscard]] bool can_start_itself();

/// Waits for the child, which dies with its parent. Errors: stopped; internal.
[[nodiscard]] Outcome<ChildResult> run_self(const std::vector<std::string>& arguments, const ChildLimits& limits,
                                            const Execution& execution);

/// Called in the child. The address sanitizer reserves all address space, so `bytes` has no effect with it.
void set_limits(const ChildLimits& limits);

/// Called in the child: sends bytes to the parent. False if some were not sent.
[[nodiscard]] bool hand_over(std::string_view bytes);

}  // namespace camber::app

/// Runs another program without a shell.
export namespace camber::app {

enum class CommandEnd : std::uint8_t { done, failed, out_of_time };
struct CommandResult {
    CommandEnd end = CommandEnd::done;
    std::string how;  ///< "exit code 3", "segmentation fault"
    double seconds = 0;
};

/// Runs a program, found along PATH, without standard input. Both output streams go to the file `output`. `seconds`:
/// time limit; 0: none. After a timeout or a request to stop, its process group gets SIGTERM, then SIGKILL after two
/// seconds. Errors: usage, it cannot be started; write; stopped.
[[nodiscard]] Outcome<CommandResult> run_command_line(const std::vector<std::string>& words, double seconds,
                                                      const std::string& output, const Execution& execution);

}  // namespace camber::app

export namespace camber::app {

/// Call once, at the start.
void set_command_line(std::span<char*> arguments);
/// With quotes for a shell; the program has its plain name.
[[nodiscard]] const std::string& command_line();

/// SIGINT and SIGTERM request a stop; a second signal ends the process. Call once.
[[nodiscard]] std::stop_token stop_on_signals();

/// During its lifetime, the signal handler unlinks the file. A process that waits for others can be killed before it
/// checks the stop request. At most 8 files; further ones and too long paths are ignored.
class RemovedOnSignals {
  public:
    RemovedOnSignals() = default;
    explicit RemovedOnSignals(std::string_view path);
    RemovedOnSignals(RemovedOnSignals&& other) noexcept : place_(std::exchange(other.place_, std::nullopt)) {}
    RemovedOnSignals& operator=(RemovedOnSignals&& other) noexcept {
        std::swap(place_, other.place_);
        return *this;
    }
    RemovedOnSignals(const RemovedOnSignals&) = delete;
    RemovedOnSignals& operator=(const RemovedOnSignals&) = delete;
    ~RemovedOnSignals();

  private:
    std::optional<std::size_t> place_;
};

struct MemoryLimit {
    std::size_t bytes = std::numeric_limits<std::size_t>::max();
    std::string source;  ///< "this machine", "the control group", "ulimit -v"; empty: unknown
};

/// Minimum of the machine's memory, the limits of the control groups (versions 1 and 2), and RLIMIT_AS.
[[nodiscard]] MemoryLimit memory_limit();

/// Minimum of the numbers in files `name` from the group's folder up to `root`; without a number the largest size_t.
[[nodiscard]] std::size_t cgroup_limit(const std::string& root, const std::string& group, const std::string& name);

/// Resident memory; 0: unknown.
[[nodiscard]] std::size_t resident_bytes();

/// Returns freed large arrays to the system at once, although glibc raises its threshold. Saves 1/10 to 1/7 of the peak
/// memory for a few hundredths of the time.
void release_freed_memory();

/// "3.2 GiB", "17.0 MiB".
[[nodiscard]] std::string readable(std::size_t bytes);

struct Usage {
    double seconds = 0;          ///< wall-clock time
    std::size_t peak_bytes = 0;  ///< peak resident memory up to now
};

/// Measures from its construction.
class Meter {
  public:
    Meter();
    [[nodiscard]] Usage read() const;

  private:
    std::chrono::steady_clock::time_point start_;
};

struct Share {
    double part = 0;           ///< from 0 to 1
    double seconds_left = -1;  ///< below 0: unknown
    double a_second = 0;       ///< elements per second; 0: unknown
};

/// Progress of a stage. The remaining time is extrapolated. The share never decreases, and is below 1.
class StageShare {
  public:
    /// `elements`: size of the mesh; 0: unknown.
    explicit StageShare(std::size_t elements = 0) : elements_(elements) {}
    /// `seconds`: time since the stage began.
    [[nodiscard]] Share tick(std::size_t done, std::size_t total, double seconds);

  private:
    std::size_t elements_;
    double part_ = 0;
};

/// Progress of steps that are repeated in rounds. The number of rounds is unknown, so each round counts as half of the
/// remaining work. The share never decreases, and is below 1.
class RoundsShare {
  public:
    /// Begins a new round if the step is the first one again.
    void begin(const std::string& step);
    /// Total share if the current step has the share `part`.
    [[nodiscard]] double tick(double part);
    /// From 1; 0: not begun.
    [[nodiscard]] std::size_t round() const { return round_; }

  private:
    std::string first_;  ///< first step of each round
    std::size_t round_ = 0, step_ = 0;
    std::size_t steps_before_ = 6;  ///< of the previous round; initially an estimate
    double share_ = 0;
};

/// Receives the stage and its share from 0 to 1. Any thread calls it, but never two at once.
using ProgressCallback = std::function<void(const std::string& stage, double part)>;

/// Shows progress in one line on a terminal's standard error after the first second; erases it at a stage's end.
class Progress {
  public:
    /// An empty callback means the terminal.
    explicit Progress(ProgressCallback progress = {});
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    Progress(Progress&&) = delete;
    Progress& operator=(Progress&&) = delete;
    ~Progress();

    void begin(std::string stage);
    /// Begins a step of a stage with rounds, which have one common progress.
    void begin_in_rounds(std::string_view stage, const std::string& step);
    /// Sets the number of elements of the following stages; 0: unknown.
    void of_mesh(std::size_t elements) { elements_ = elements; }
    /// Callback for `Execution::progress`; empty without terminal and callback.
    [[nodiscard]] std::function<void(std::size_t done, std::size_t total)> ticks();
    void wipe();

  private:
    void show(std::size_t done, std::size_t total);

    ProgressCallback callback_;
    bool terminal_;
    bool shown_ = false;
    std::size_t elements_ = 0;
    std::string stage_;
    StageShare share_;
    std::optional<RoundsShare> rounds_;
    std::chrono::steady_clock::time_point start_, last_;
};

/// "curve [##### ] 50 % 270 k elements/s 12 s left", without unknown values.
[[nodiscard]] std::string progress_line(const std::string& stage, Share share);

/// Shows the progress of steps. Exhausted memory becomes an error.
[[nodiscard]] StepWrapper steps_shown(Progress& progress, Execution execution);

/// Runs work() on a thread with 8 MiB of stack if the limit of the process (ulimit -s) is lower. Later threads then
/// also have 8 MiB.
[[nodiscard]] int with_usual_stack(const std::function<int()>& work);

/// Call once, before any file is opened. Writing to a closed pipe, or beyond the file size limit, then returns an error
/// instead of a signal. Closed standard streams become unwritable, and no file takes their number.
void protect_standard_streams();

/// A reader that ends early (`| head`) is no error; other failures are (a full disk, a closed stream).
class StandardOutput {
  public:
    /// Writes to standard error, if a file goes to standard output.
    [[nodiscard]] static StandardOutput beside_a_file() { return StandardOutput(STDERR_FILENO); }
    StandardOutput() = default;
    void print(std::string_view text);
    /// Errors: write, with the system's reason for the first failure.
    [[nodiscard]] Outcome<Done> finish();

  private:
    explicit StandardOutput(int fd) : fd_(fd) {}

    int fd_ = STDOUT_FILENO;
    int error_ = 0;
};

/// Width of the terminal, between 60 and 100 columns.
[[nodiscard]] std::size_t text_width();

/// Wraps at `width` columns. All lines but the first are indented; the first begins at column `indent`. Lines with a
/// leading space, such as examples, are not wrapped.
[[nodiscard]] std::string wrapped(std::string_view text, std::size_t width, std::size_t indent = 0);

/// usual: tables, notes and progress; verbose: also details; quiet: only errors and requested data; none: nothing,
/// because another process prints.
enum class Voice : std::uint8_t { usual, verbose, quiet, none };

/// Set before a verb begins. `none` is final.
void set_voice(Voice voice);
[[nodiscard]] Voice voice();
[[nodiscard]] bool prints_notes();

/// File name of standard input or output.
inline constexpr std::string_view standard_stream = "-";
/// "standard input", "standard output", or the path.
[[nodiscard]] std::string called_input(const std::string& path);
[[nodiscard]] std::string called_output(const std::string& path);

/// Maximum size of a stream (pipe, device), which may be endless. It is decided from the first bytes, at most
/// `beginning_of_stream`. Errors: the stream is rejected.
using StreamBound = std::function<Outcome<std::size_t>(std::span<const std::byte> beginning)>;
inline constexpr std::size_t beginning_of_stream = std::size_t{1} << 16U;

/// For configs, reports and tables.
[[nodiscard]] Outcome<std::size_t> bound_of_text(std::span<const std::byte> beginning);

/// Reads a file, a pipe or standard input. The bound applies only to streams. Errors: input, with the system's reason,
/// or a stream beyond its bound; memory; stopped, also while a pipe is silent.
[[nodiscard]] Outcome<Buffer<std::byte>> read_file(const std::string& path, const Execution& execution = {},
                                                   const StreamBound& bound = bound_of_text);

[[nodiscard]] inline std::string_view as_text(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}
[[nodiscard]] inline std::span<const std::byte> as_bytes(std::string_view text) {
    return std::as_bytes(std::span(text.data(), text.size()));
}

/// Writes all chunks in order, or nothing. A regular file appears, or replaces the old one with its permissions, only
/// when it is complete and on disk. Until then it has no name if the file system allows, so that a killed process
/// leaves no partial file. Pipes and standard output are written directly. Errors: write; stopped, before the file has
/// its name.
[[nodiscard]] Outcome<Done> write_file(const std::string& path, std::span<const std::span<const std::byte>> chunks,
                                       const Execution& execution = {});

/// Checks the folder of the file. Errors: write; for a missing folder with the command that creates it.
[[nodiscard]] Outcome<Done> check_writable(const std::string& path);

/// The folder exists or can be created. Errors: those of `check_writable`.
[[nodiscard]] Outcome<Done> check_folder(const std::string& folder);

/// Creates a folder, whose parent must exist. Errors: write.
[[nodiscard]] Outcome<Done> make_folder(const std::string& folder);

/// Maps a regular file; bytes are loaded when accessed. If the file is truncated, an access ends the program. Errors:
/// input (also for a pipe).
[[nodiscard]] Outcome<Column<std::byte>> map_file(const std::string& path);

/// Releases mapped memory. A later access loads it again.
void release_mapping(std::span<const std::byte> of_mapped_file);

/// A file that several processes write. It gets its name when all are done. Until then it is the draft `.camber-….part`
/// next to it. A stop signal removes the draft in any process; the next file of that name removes the draft of a killed
/// process.
class SharedFile {
  public:
    /// In one process: creates an empty draft with that size. Errors: write.
    [[nodiscard]] static Outcome<SharedFile> make(const std::string& path, std::uint64_t bytes);
    /// In the other processes, on any machine, with the draft's name from the first one. Errors: write.
    [[nodiscard]] static Outcome<SharedFile> join(const std::string& path, const std::string& draft);

    SharedFile(SharedFile&&) noexcept;
    SharedFile& operator=(SharedFile&&) noexcept;
    SharedFile(const SharedFile&) = delete;
    SharedFile& operator=(const SharedFile&) = delete;
    /// Removes an unpublished draft in the process that made it.
    ~SharedFile();

    [[nodiscard]] const std::string& draft() const;
    /// Errors: write, stopped.
    [[nodiscard]] Outcome<Done> write(std::uint64_t offset, std::span<const std::byte> bytes,
                                      const Execution& execution) const;
    /// Waits until the bytes of this process are on disk. Errors: write.
    [[nodiscard]] Outcome<Done> flush() const;
    /// In the process that made the draft, after all have flushed: gives it the name of the file and the permissions of
    /// the old one. Errors: write (also if another run has begun a file of that name).
    [[nodiscard]] Outcome<Done> publish();

  private:
    struct Open;
    explicit SharedFile(std::unique_ptr<Open> open);
    std::unique_ptr<Open> open_;
};

}  // namespace camber::app
