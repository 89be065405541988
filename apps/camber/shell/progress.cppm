module;
#include <chrono>
#include <cstddef>
#include <functional>
#include <string>
export module camber.app_shell:progress;

export namespace camber::app {

/// How far a stage is.
struct Share {
    double part = 0;           ///< from 0 up to 1; below 0: nobody knows, for loop follows loop
    double seconds_left = -1;  ///< below 0: not known yet
    std::size_t loop = 1;      ///< the how many-th
    double seconds = 0;        ///< since the stage began
};

/// How far a stage is, from what each of its loops tells of itself: by the time that the loops before took and that the
/// present one seems to need. More may come, so that the part never becomes 1; from the first second on it never falls.
/// Once the loops before took most of the time, the present one says nothing of the stage: from then on its part is not
/// known.
class StageShare {
  public:
    /// `done` of the present loop's `total`, so many seconds after the stage began.
    [[nodiscard]] Share tick(std::size_t done, std::size_t total, double seconds);

  private:
    std::size_t done_ = 0, total_ = 0, loop_ = 0;
    double loop_start_ = 0, last_ = 0, part_ = 0;
    bool known_ = true;
};

/// One line on standard error that tells how far a stage is: only on a terminal, and only once the stage has taken a
/// second. Wiped when the next stage begins and at the end.
class Progress {
  public:
    Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    Progress(Progress&&) = delete;
    Progress& operator=(Progress&&) = delete;
    ~Progress();

    void begin(std::string stage);
    /// For Execution::progress; empty when there is no terminal to write to.
    [[nodiscard]] std::function<void(std::size_t done, std::size_t total)> ticks();
    void wipe();

  private:
    void show(std::size_t done, std::size_t total);

    bool terminal_;
    bool shown_ = false;
    std::string stage_;
    StageShare share_;
    std::chrono::steady_clock::time_point start_, last_;
};

/// "curve  [#####     ]  50 %  12 s left", the time only where it is known and some is left; or "relax  step 7, 12 s".
[[nodiscard]] std::string progress_line(const std::string& stage, Share share);

}  // namespace camber::app
