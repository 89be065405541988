module;
#include <cstddef>
#include <optional>
#include <stop_token>
#include <string_view>
#include <utility>
export module camber.app_shell:interrupt;

export namespace camber::app {

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

}  // namespace camber::app
