module;
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>
module camber.app_shell;
import camber.core;

namespace camber::app {

namespace {

constexpr double shown_from = 1;  // second of a stage

/// "850", "27 k", "1.3 M".
std::string short_count(double count) {
    if (count < 1e3) return fmt::format("{:.0f}", count);
    if (count < 999.5e3) return fmt::format("{:.{}f} k", count / 1e3, count < 9.95e3 ? 1 : 0);
    return fmt::format("{:.{}f} M", count / 1e6, count < 9.95e6 ? 1 : 0);
}

}  // namespace

Progress::Progress(ProgressTold told)
    : told_(std::move(told)), terminal_(!told_ && ::isatty(STDERR_FILENO) == 1 && voice() == Voice::usual) {
    begin({});
}

Progress::~Progress() { wipe(); }

void Progress::begin(std::string stage) {
    wipe();
    rounds_.reset();
    stage_ = std::move(stage);
    share_ = StageShare(elements_);
    start_ = last_ = std::chrono::steady_clock::now();
    if (told_ && !stage_.empty()) told_(stage_, 0);
}

void Progress::begin_in_rounds(std::string_view stage, const std::string& step) {
    if (!rounds_) {
        begin({});
        share_ = StageShare();  // passes change the elements: there is no rate
        rounds_.emplace();
    }
    rounds_->begin(step);
    stage_ = fmt::format("{} {}: {}", stage, rounds_->round(), step);
}

std::function<void(std::size_t, std::size_t)> Progress::ticks() {
    if (!terminal_ && !told_) return {};
    return [this](std::size_t done, std::size_t total) { show(done, total); };
}

void Progress::show(std::size_t done, std::size_t total) {
    using namespace std::chrono_literals;
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - start_).count();
    constexpr double parts = 1e6;
    if (rounds_ && total > 0) {
        done = static_cast<std::size_t>(parts * rounds_->tick(static_cast<double>(done) / static_cast<double>(total)));
        total = static_cast<std::size_t>(parts);
    }
    const Share share = share_.tick(done, total, seconds);
    if (told_) return told_(stage_, share.part);
    if (seconds < shown_from || (shown_ && now - last_ < 100ms)) return;
    last_ = now;
    shown_ = true;
    std::fputs(("\r\x1b[K" + progress_line(stage_, share)).c_str(), stderr);
    std::fflush(stderr);
}

void Progress::wipe() {
    if (!std::exchange(shown_, false)) return;
    std::fputs("\r\x1b[K", stderr);
    std::fflush(stderr);
}

void RoundsShare::begin(const std::string& step) {
    if (round_ == 0) first_ = step;
    if (step == first_) {
        if (round_ > 0) steps_before_ = step_ + 1;
        ++round_;
        step_ = 0;
    } else {
        ++step_;
    }
}

double RoundsShare::tick(double part) {
    const double left = pow(0.5, static_cast<double>(round_ > 0 ? round_ - 1 : 0));
    const double of_round =
        std::min((static_cast<double>(step_) + std::clamp(part, 0.0, 1.0)) / static_cast<double>(steps_before_), 1.0);
    share_ = std::max(share_, 1 - left + 0.5 * left * of_round);
    return share_;
}

Share StageShare::tick(std::size_t done, std::size_t total, double seconds) {
    constexpr double enough_to_judge = 0.02, almost_all = 0.99;
    const double told = total > 0 ? static_cast<double>(done) / static_cast<double>(total) : 0.0;
    part_ = std::clamp(told, part_, almost_all);
    if (part_ < enough_to_judge) return {part_};
    const double a_second = seconds > 0 ? part_ * static_cast<double>(elements_) / seconds : 0;
    return {part_, seconds * (1 - part_) / part_, a_second};
}

std::string progress_line(const std::string& stage, Share share) {
    constexpr std::size_t width = 30;
    const auto filled = static_cast<std::size_t>(share.part * static_cast<double>(width));
    std::string line = fmt::format("{:<10} [{}{}] {:3.0f} %", stage, std::string(filled, '#'),
                                   std::string(width - filled, ' '), 100 * share.part);
    if (share.a_second >= 1) line += "  " + short_count(share.a_second) + " elements/s";
    if (share.seconds_left > 0) line += fmt::format("  {:.0f} s left", share.seconds_left);
    return line;
}

Around steps_shown(Progress& progress, Execution execution) {
    return [&progress, execution](std::string_view stage, const std::function<Outcome<Done>(const Execution&)>& body) {
        progress.begin(std::string(stage));
        Execution shown = execution;
        shown.progress = progress.ticks();
        return guarded([&] { return body(shown); });
    };
}

}  // namespace camber::app
