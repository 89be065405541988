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

/// This program once more, for work that may crash or never end: what libraries do on damaged files.
export namespace camber::app {

struct ChildLimits {
    double seconds = 0;     ///< by the clock, and of a processor
    std::size_t bytes = 0;  ///< of address space
};

enum class ChildEnd : std::uint8_t { done, crashed, out_of_time };
struct ChildResult {
    ChildEnd end = ChildEnd::done;
    std::string bytes;  ///< that it handed over
    std::string how;    ///< it crashed
};

/// By which words this program is started once more: first the file, then arguments that come before others. At first
/// /proc/self/exe. None: it cannot be, as a library of programs that know nothing of it.
void start_itself_by(std::vector<std::string> words);
[[nodiscard]] bool can_start_itself();

/// Runs this program with other arguments, and waits. It dies with its parent. Errors: stopped; internal, it cannot be
/// started.
[[nodiscard]] Outcome<ChildResult> run_self(const std::vector<std::string>& arguments, const ChildLimits& limits,
                                            const Execution& execution);

/// In the child: nothing beyond the limits from now on (under the address sanitizer, which takes all address space, but
/// for memory).
void set_limits(const ChildLimits& limits);

/// In the child: what the parent gets. Whether it got all of it.
[[nodiscard]] bool hand_over(std::string_view bytes);

}  // namespace camber::app

/// A program of somebody else's, run without a shell.
export namespace camber::app {

enum class CommandEnd : std::uint8_t { done, failed, out_of_time };
struct CommandResult {
    CommandEnd end = CommandEnd::done;
    std::string how;  ///< it failed: "exit code 3", "segmentation fault"
    double seconds = 0;
};

/// Runs the command, found along PATH, with what it says on either stream in the file `output`, and nothing to read;
/// waits at most `seconds` (0: any time). It has a process group of its own: out of time or stopped, all of that is
/// asked to end, and killed two seconds later. Errors: usage, it cannot be started; write, of `output`; stopped.
[[nodiscard]] Outcome<CommandResult> run_command_line(const std::vector<std::string>& words, double seconds,
                                                      const std::string& output, const Execution& execution);

}  // namespace camber::app

export namespace camber::app {

/// Sets the command line, for texts that show it; once, when the program begins.
void set_command_line(std::span<char*> arguments);
/// As one would type it again, with quotes where a shell wants them; the program by its plain name.
[[nodiscard]] const std::string& command_line();

/// Ctrl-C and SIGTERM become the request to stop; a second one ends the process as if nobody had listened. Call once,
/// before the work.
[[nodiscard]] std::stop_token stop_on_signals();

/// While it lives, the request to stop by a signal unlinks this file at once: who waits for other processes may be
/// killed before it hears the request. Of a few at a time; one too many, or with too long a name, is left.
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

/// The memory that this process may have, and what says so.
struct MemoryLimit {
    std::size_t bytes = std::numeric_limits<std::size_t>::max();
    std::string source;  ///< "this machine", "the control group", "ulimit -v"; empty: no limit known
};

/// The least of the machine's memory, the limits of the control groups that hold the process (versions 1 and 2), and
/// RLIMIT_AS.
[[nodiscard]] MemoryLimit memory_limit();

/// The limit that a hierarchy of control groups sets: the least number in the files FOLDER/…/NAME from the group up to
/// the root of the hierarchy; none is the largest number.
[[nodiscard]] std::size_t cgroup_limit(const std::string& root, const std::string& group, const std::string& name);

/// Memory that the process has now; 0 where the system does not say.
[[nodiscard]] std::size_t resident_bytes();

/// From now on large arrays that are let go of leave the process at once, however large those before were (glibc learns
/// to keep them): a tenth to a seventh of a run's peak, for a few hundredths of its time.
void release_freed_memory();

/// "3.2 GiB", "17.0 MiB".
[[nodiscard]] std::string readable(std::size_t bytes);

/// Cost of a stage.
struct Usage {
    double seconds = 0;          ///< on the wall
    std::size_t peak_bytes = 0;  ///< largest resident memory of the process up to now
};

/// Runs from its making.
class Meter {
  public:
    Meter();
    [[nodiscard]] Usage read() const;

  private:
    std::chrono::steady_clock::time_point start_;
};

/// Progress of a stage.
struct Share {
    double part = 0;           ///< from 0 up to 1
    double seconds_left = -1;  ///< below 0: not known yet
    double a_second = 0;       ///< elements; 0: not known
};

/// Progress of a stage from its own reports. The remaining time is extrapolated from the elapsed time. The part never
/// falls, and never becomes 1 before the stage ends.
class StageShare {
  public:
    /// `elements`: of the mesh that the stage goes through; 0: not known.
    explicit StageShare(std::size_t elements = 0) : elements_(elements) {}
    /// `done` of `total`, so many seconds after the stage began.
    [[nodiscard]] Share tick(std::size_t done, std::size_t total, double seconds);

  private:
    std::size_t elements_;
    double part_ = 0;
};

/// Progress of steps that are repeated in rounds until nothing changes much. The number of rounds is unknown: each
/// counts as half of the remaining work. The share rises, and never becomes 1.
class RoundsShare {
  public:
    /// A step begins: the next round where it began the round before, too.
    void begin(const std::string& step);
    /// The share of all when the step has done so much of its own.
    [[nodiscard]] double tick(double part);
    /// From 1; 0: none began.
    [[nodiscard]] std::size_t round() const { return round_; }

  private:
    std::string first_;  ///< the step that begins a round
    std::size_t round_ = 0, step_ = 0;
    std::size_t steps_before_ = 6;  ///< of the round before; first a guess
    double share_ = 0;
};

/// Receives the progress in place of a terminal: the stage, and its part from 0 to 1; from any thread, one at a time.
using ProgressCallback = std::function<void(const std::string& stage, double part)>;

/// One line on standard error that tells how far a stage is: only on a terminal, and only once the stage has taken a
/// second. Wiped when the next stage begins and at the end.
class Progress {
  public:
    /// `progress`: empty, the terminal.
    explicit Progress(ProgressCallback progress = {});
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    Progress(Progress&&) = delete;
    Progress& operator=(Progress&&) = delete;
    ~Progress();

    void begin(std::string stage);
    /// The next step of a stage whose steps come in rounds: one share and one clock over all of them.
    void begin_in_rounds(std::string_view stage, const std::string& step);
    /// The mesh that the stages from the next one on go through, so that they tell a rate; 0: not known.
    void of_mesh(std::size_t elements) { elements_ = elements; }
    /// For Execution::progress; empty when there is no terminal to write to.
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

/// "curve  [#####     ]  50 %  270 k elements/s  12 s left", the rate and the time only where they are known and some
/// is left.
[[nodiscard]] std::string progress_line(const std::string& stage, Share share);

/// Steps that are shown while they run, with these threads and this request to stop; missing memory is an error.
[[nodiscard]] StepWrapper steps_shown(Progress& progress, Execution execution);

/// Returns work(). Where the stack of this process is smaller than usual (ulimit -s), the work runs on a thread with
/// one of the usual size, as all threads do that are made from then on.
[[nodiscard]] int with_usual_stack(const std::function<int()>& work);

/// Once, before anything is opened or printed: writing to a closed pipe, or beyond the limit of the size of files,
/// becomes an error of that write, and a standard stream that the caller closed stays unwritable instead of becoming
/// the next file that is opened.
void protect_standard_streams();

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

/// Width of text for standard output: 100 columns, or the terminal's if it has fewer.
[[nodiscard]] std::size_t text_width();

/// The text in lines of at most `width` columns, of which all but the first begin with `indent` spaces; the first is
/// thought to stand behind as many columns. Lines of the text that begin with a space (examples) are not broken.
[[nodiscard]] std::string wrapped(std::string_view text, std::size_t width, std::size_t indent = 0);

/// Messages beside errors and requested data: tables, notes and progress, or none of them (quiet). Verbose: also
/// details. None: nothing at all, where another process prints it.
enum class Voice : std::uint8_t { usual, verbose, quiet, none };

/// Set before a verb begins; who has none gets none back.
void set_voice(Voice voice);
[[nodiscard]] Voice voice();
/// True if tables, notes and progress are printed: the voice is usual or verbose.
[[nodiscard]] bool prints_notes();

/// Stands for standard input and standard output in place of a file's name.
inline constexpr std::string_view standard_stream = "-";
/// The path as one says it: "standard input", "standard output".
[[nodiscard]] std::string called_input(const std::string& path);
[[nodiscard]] std::string called_output(const std::string& path);

/// Decides by the first bytes of a stream (a pipe, a device), at most `beginning_of_stream`, how many may follow: a
/// stream has no size, and may have no end. Errors: those of a stream that is not read at all.
using StreamBound = std::function<Outcome<std::size_t>(std::span<const std::byte> beginning)>;
inline constexpr std::size_t beginning_of_stream = std::size_t{1} << 16U;

/// The bound of texts: configs, reports, tables.
[[nodiscard]] Outcome<std::size_t> bound_of_text(std::span<const std::byte> beginning);

/// The whole file (or pipe, or standard input). A plain file is read whatever its size. Errors: input, with the
/// system's reason, or a stream beyond its bound; memory; stopped, also while a pipe is silent.
[[nodiscard]] Outcome<Buffer<std::byte>> read_file(const std::string& path, const Execution& execution = {},
                                                   const StreamBound& bound = bound_of_text);

[[nodiscard]] inline std::string_view as_text(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}
[[nodiscard]] inline std::span<const std::byte> as_bytes(std::string_view text) {
    return std::as_bytes(std::span(text.data(), text.size()));
}

/// Writes the chunks one after the other: all of them or nothing. The file appears (or replaces the old one, keeping
/// its permissions) only when complete and on disk; until then it has no name, so that no death of the process leaves
/// a part of it. Where the target is no plain file (a pipe, standard output) it is written to as it is.
/// Errors: write, with the system's reason; stopped, as long as nothing has its name yet.
[[nodiscard]] Outcome<Done> write_file(const std::string& path, std::span<const std::span<const std::byte>> chunks,
                                       const Execution& execution = {});

/// Checks before the work that a file can be written there: its folder exists and takes files. Errors:
/// write, with the command that makes a folder that is not there.
[[nodiscard]] Outcome<Done> check_writable(const std::string& path);

/// Checks before the work that a folder is there or can be made. Errors: write, as of `check_writable`.
[[nodiscard]] Outcome<Done> check_folder(const std::string& folder);

/// Makes a folder if it is not there. The folder that it is in must be. Errors: write, as of `check_folder`, or with
/// the system's reason.
[[nodiscard]] Outcome<Done> make_folder(const std::string& folder);

/// A plain file's bytes, of which the system brings those into memory that are looked at. Who cuts the file short
/// meanwhile ends the program. Errors: input, with the system's reason (a pipe cannot be read so).
[[nodiscard]] Outcome<Column<std::byte>> map_file(const std::string& path);

/// Lets a mapped file's bytes leave this process's memory; those that are looked at again come back.
void release_mapping(std::span<const std::byte> of_mapped_file);

/// A file that several processes write to, each at its places, and that has its name when all have done so. Until then
/// it is a draft beside it, `.camber-….part`: the request to stop (interrupt.cppm) takes it away in whichever process,
/// and the next file of that name what a process left that was killed.
class SharedFile {
  public:
    /// By one of them: an empty draft of so many bytes. Errors: write.
    [[nodiscard]] static Outcome<SharedFile> make(const std::string& path, std::uint64_t bytes);
    /// By the others, on whichever machine: `draft` is the name that the first tells. Errors: write.
    [[nodiscard]] static Outcome<SharedFile> join(const std::string& path, const std::string& draft);

    SharedFile(SharedFile&&) noexcept;
    SharedFile& operator=(SharedFile&&) noexcept;
    SharedFile(const SharedFile&) = delete;
    SharedFile& operator=(const SharedFile&) = delete;
    /// The draft goes with the process that made it.
    ~SharedFile();

    [[nodiscard]] const std::string& draft() const;
    /// Errors: write, stopped.
    [[nodiscard]] Outcome<Done> write(std::uint64_t offset, std::span<const std::byte> bytes,
                                      const Execution& execution) const;
    /// Waits until the bytes of this process are on disk. Errors: write.
    [[nodiscard]] Outcome<Done> flush() const;
    /// By the process that made it, once all have flushed: the draft has the file's name and the old one's permissions.
    /// Errors: write (also where somebody else has begun a file of the name).
    [[nodiscard]] Outcome<Done> publish();

  private:
    struct Open;
    explicit SharedFile(std::unique_ptr<Open> open);
    std::unique_ptr<Open> open_;
};

}  // namespace camber::app
