module;
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <fstream>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <fcntl.h>
#include <fmt/format.h>
#include <malloc.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <unistd.h>
module camber.app_shell;
import camber.core;

namespace camber::app {

namespace {

constexpr std::size_t widest = 100, narrowest = 60;

std::string_view taken(std::string_view& text, char mark) {
    const std::size_t end = std::min(text.find(mark), text.size());
    const std::string_view front = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    return front;
}

}  // namespace

std::size_t text_width() {
    struct winsize size{};
    if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return widest;
    return std::clamp<std::size_t>(size.ws_col, narrowest, widest);
}

std::string wrapped(std::string_view text, std::size_t width, std::size_t indent) {
    const std::string margin(indent, ' ');
    std::string out;
    while (!text.empty()) {
        std::string_view line = taken(text, '\n');
        const bool as_it_is = line.starts_with(' ');
        if (!out.empty()) out += line.empty() ? "\n" : "\n" + margin;
        if (as_it_is) {
            out += line;
            continue;
        }
        for (std::size_t at = indent; !line.empty();) {
            const std::string_view word = taken(line, ' ');
            if (at > indent && at + 1 + word.size() > width) {
                out += "\n" + margin;
                at = indent;
            }
            if (at > indent) out += ' ', ++at;
            out += word;
            at += word.size();
        }
    }
    return out;
}

namespace {

constexpr double shown_from = 1;  // seconds after the start of a stage

/// "850", "27 k", "1.3 M".
std::string short_count(double count) {
    if (count < 1e3) return fmt::format("{:.0f}", count);
    if (count < 999.5e3) return fmt::format("{:.{}f} k", count / 1e3, count < 9.95e3 ? 1 : 0);
    return fmt::format("{:.{}f} M", count / 1e6, count < 9.95e6 ? 1 : 0);
}

}  // namespace

Progress::Progress(ProgressCallback progress)
    : callback_(std::move(progress)), terminal_(!callback_ && ::isatty(STDERR_FILENO) == 1 && prints_notes()) {
    begin({});
}

Progress::~Progress() { wipe(); }

void Progress::begin(std::string stage) {
    wipe();
    rounds_.reset();
    stage_ = std::move(stage);
    share_ = StageShare(elements_);
    start_ = last_ = std::chrono::steady_clock::now();
    if (callback_ && !stage_.empty()) callback_(stage_, 0);
}

void Progress::begin_in_rounds(std::string_view stage, const std::string& step) {
    if (!rounds_) {
        begin({});
        share_ = StageShare();  // elements change, so there is no rate
        rounds_.emplace();
    }
    rounds_->begin(step);
    stage_ = fmt::format("{} {}: {}", stage, rounds_->round(), step);
}

std::function<void(std::size_t, std::size_t)> Progress::ticks() {
    if (!terminal_ && !callback_) return {};
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
    if (callback_) return callback_(stage_, share.part);
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
    const double progress = total > 0 ? static_cast<double>(done) / static_cast<double>(total) : 0.0;
    part_ = std::clamp(progress, part_, almost_all);
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

StepWrapper steps_shown(Progress& progress, Execution execution) {
    return [&progress, execution](std::string_view stage, const std::function<Outcome<Done>(const Execution&)>& body) {
        progress.begin(std::string(stage));
        Execution shown = execution;
        shown.progress = progress.ticks();
        return guarded([&] { return body(shown); });
    };
}

void protect_standard_streams() {
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
    int fd = 0;  // open() returns the lowest free number; read-only, so that writing fails as on a closed stream
    while (fd >= 0 && fd <= STDERR_FILENO) fd = ::open("/dev/null", O_RDONLY);
    if (fd > STDERR_FILENO) ::close(fd);
}

void StandardOutput::print(std::string_view text) {
    if (voice() == Voice::none) return;
    std::FILE* const to = fd_ == STDOUT_FILENO ? stdout : stderr;
    if (error_ == 0 && std::fwrite(text.data(), 1, text.size(), to) < text.size()) error_ = errno;
}

Outcome<Done> StandardOutput::finish() {
    if (error_ == 0 && std::fflush(fd_ == STDOUT_FILENO ? stdout : stderr) != 0) error_ = errno;
    if (error_ == 0 || error_ == EPIPE) return Done{};
    return fail(ErrorKind::write, "cannot be written: " + std::generic_category().message(error_), "standard output");
}

namespace {

Voice of_program = Voice::usual;

}  // namespace

void set_voice(Voice voice) {
    if (of_program != Voice::none) of_program = voice;
}
Voice voice() { return of_program; }
bool prints_notes() { return of_program == Voice::usual || of_program == Voice::verbose; }

Meter::Meter() : start_(std::chrono::steady_clock::now()) {}

Usage Meter::read() const {
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start_;
    struct rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);  // the peak is never reset, because a parent process also reads it
    return {passed.count(), static_cast<std::size_t>(usage.ru_maxrss) * 1024};
}

namespace {

constexpr std::size_t unlimited = std::numeric_limits<std::size_t>::max();

/// Unlimited if the file is missing or contains no number, such as "max".
std::size_t number_in(const std::string& path) {
    std::ifstream file(path);
    std::size_t number = 0;
    return file >> number ? number : unlimited;
}

/// Control group of this process: in version 2 the line "0::/a/b", in version 1 "7:memory:/a/b" (cgroups(7)).
std::string group_of_process(bool version_2) {
    std::ifstream groups("/proc/self/cgroup");
    for (std::string line; std::getline(groups, line);) {
        const auto first = line.find(':');
        const auto second = first == std::string::npos ? first : line.find(':', first + 1);
        if (second == std::string::npos) continue;
        const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
        if (version_2 ? controllers == ",," : controllers.find(",memory,") != std::string::npos)
            return line.substr(second + 1);
    }
    return "/";
}

std::size_t of_machine() {
    const long pages = ::sysconf(_SC_PHYS_PAGES), size = ::sysconf(_SC_PAGESIZE);
    if (pages <= 0 || size <= 0) return unlimited;
    return static_cast<std::size_t>(pages) * static_cast<std::size_t>(size);
}

std::size_t of_process() {
    struct rlimit limit{};
    if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return unlimited;
    return limit.rlim_cur;
}

}  // namespace

std::size_t cgroup_limit(const std::string& root, const std::string& group, const std::string& name) {
    std::size_t least = unlimited;
    for (std::string at = group == "/" ? "" : group;; at.erase(at.rfind('/'))) {
        least = std::min(least, number_in(root + at + "/" + name));
        if (at.rfind('/') == std::string::npos) return least;
    }
}

MemoryLimit memory_limit() {
    const std::size_t group =
        std::min(cgroup_limit("/sys/fs/cgroup", group_of_process(true), "memory.max"),
                 cgroup_limit("/sys/fs/cgroup/memory", group_of_process(false), "memory.limit_in_bytes"));
    MemoryLimit least;
    for (const auto& [bytes, source] : {std::pair{of_process(), "ulimit -v"}, std::pair{group, "the control group"},
                                        std::pair{of_machine(), "this machine"}})
        if (bytes < least.bytes) least = {bytes, source};
    return least;
}

std::size_t resident_bytes() {
    std::ifstream file("/proc/self/statm");
    std::size_t pages = 0, resident = 0;
    if (!(file >> pages >> resident)) return 0;
    return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

void release_freed_memory() {
#ifdef __GLIBC__
    constexpr int large = 1 << 22;
    ::mallopt(M_MMAP_THRESHOLD, large);
#endif
}

std::string readable(std::size_t bytes) {
    constexpr double mebi = 1024 * 1024;
    const double mib = static_cast<double>(bytes) / mebi;
    return mib < 1024 ? fmt::format("{:.1f} MiB", mib) : fmt::format("{:.1f} GiB", mib / 1024);
}

}  // namespace camber::app
