module;
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <functional>
#include <string>
#include <utility>

#include <fmt/format.h>
module camber.app_shell;

namespace camber::app {

Progress::Progress() : terminal_(::isatty(STDERR_FILENO) == 1) { begin({}); }

Progress::~Progress() { wipe(); }

void Progress::begin(std::string stage) {
    wipe();
    stage_ = std::move(stage);
    start_ = last_ = std::chrono::steady_clock::now();
}

std::function<void(std::size_t, std::size_t)> Progress::ticks() {
    if (!terminal_) return {};
    return [this](std::size_t done, std::size_t total) { show(done, total); };
}

void Progress::show(std::size_t done, std::size_t total) {
    using namespace std::chrono_literals;
    const auto now = std::chrono::steady_clock::now();
    if (now - start_ < 1s || (shown_ && now - last_ < 100ms)) return;
    last_ = now;
    shown_ = true;
    const std::string line = progress_line(stage_, done, total, std::chrono::duration<double>(now - start_).count());
    fmt::print(stderr, "\r\x1b[K{}", line);
    std::fflush(stderr);
}

void Progress::wipe() {
    if (!std::exchange(shown_, false)) return;
    fmt::print(stderr, "\r\x1b[K");
    std::fflush(stderr);
}

std::string progress_line(const std::string& stage, std::size_t done, std::size_t total, double seconds) {
    constexpr std::size_t width = 30;
    const double part = total > 0 ? std::min(1.0, static_cast<double>(done) / static_cast<double>(total)) : 0.0;
    const auto filled = static_cast<std::size_t>(part * static_cast<double>(width));
    std::string line = fmt::format("{:<10} [{}{}] {:3.0f} %", stage, std::string(filled, '#'),
                                   std::string(width - filled, ' '), 100 * part);
    if (part > 0.02 && part < 1) line += fmt::format("  {:.0f} s left", seconds * (1 - part) / part);
    return line;
}

}  // namespace camber::app
