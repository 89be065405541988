module;
#include <chrono>
#include <cstddef>
export module camber.app_shell:meter;

export namespace camber::app {

/// What a stage cost.
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

}  // namespace camber::app
