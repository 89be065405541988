module;
#include <chrono>
#include <cstddef>
#include <functional>
#include <string>
export module camber.app_shell:progress;

export namespace camber::app {

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
    std::chrono::steady_clock::time_point start_, last_;
};

/// "curve  [#####     ]  50 %  12 s left"; time left from the time spent, once some is done.
[[nodiscard]] std::string progress_line(const std::string& stage, std::size_t done, std::size_t total, double seconds);

}  // namespace camber::app
