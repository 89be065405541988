module;
#include <chrono>
#include <cstddef>
#include <functional>
#include <string>
export module camber.app_shell:progress;

export namespace camber::app {

/// How far a stage is.
struct Share {
    double part = 0;           ///< from 0 up to 1
    double seconds_left = -1;  ///< below 0: not known yet
};

/// How far a stage is, from what it tells of itself: the time that is left is taken to pass as that which passed. It is
/// not at its end before it ends, so that the part never becomes 1; it never falls.
class StageShare {
  public:
    /// `done` of `total`, so many seconds after the stage began.
    [[nodiscard]] Share tick(std::size_t done, std::size_t total, double seconds);

  private:
    double part_ = 0;
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

/// "curve  [#####     ]  50 %  12 s left", the time only where it is known and some is left.
[[nodiscard]] std::string progress_line(const std::string& stage, Share share);

}  // namespace camber::app
