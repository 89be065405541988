module;
#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
export module camber.app_shell:progress;
import camber.core;

export namespace camber::app {

/// How far a stage is.
struct Share {
    double part = 0;           ///< from 0 up to 1
    double seconds_left = -1;  ///< below 0: not known yet
    double a_second = 0;       ///< elements; 0: not known
};

/// How far a stage is, from what it tells of itself: the time that is left is taken to pass as that which passed. It is
/// not at its end before it ends, so that the part never becomes 1; it never falls.
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

/// How far steps are that come again, round after round, until nothing changes much: nobody knows how many rounds there
/// will be, and each is taken to do half of what is left. It rises, and never becomes 1.
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

/// Who is told, in place of a terminal: the stage, and how far it is, from 0 up to 1; from any thread, one at a time.
using ProgressTold = std::function<void(const std::string& stage, double part)>;

/// One line on standard error that tells how far a stage is: only on a terminal, and only once the stage has taken a
/// second. Wiped when the next stage begins and at the end.
class Progress {
  public:
    /// `told`: empty, the terminal.
    explicit Progress(ProgressTold told = {});
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

    ProgressTold told_;
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
[[nodiscard]] Around steps_shown(Progress& progress, Execution execution);

}  // namespace camber::app
