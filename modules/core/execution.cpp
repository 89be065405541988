// Message texts, option limits, allocation errors, and parallel loops.
module;
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tl/expected.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <mutex>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
module camber.core;

namespace camber {

namespace {

bool continues(char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U; }

}  // namespace

std::string shortened(std::string_view text, std::size_t longest) {
    constexpr std::string_view gap = "…";
    if (text.size() <= longest) return std::string(text);
    const std::size_t room = longest > gap.size() ? longest - gap.size() : 0;
    std::size_t begin = room - room / 4, end = text.size() - room / 4;
    while (begin > 0 && continues(text[begin])) --begin;
    while (end < text.size() && continues(text[end])) ++end;
    return std::string(text.substr(0, begin)).append(gap).append(text.substr(end));
}

std::string in_quotes(std::string_view text) {
    std::string one_line = shortened(text);
    for (char& c : one_line)
        if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = '?';
    return "\"" + one_line + "\"";
}

namespace {

std::string number(double x) {
    if (x == std::round(x) && std::abs(x) < 1e15) return std::to_string(static_cast<long>(x));
    std::array<char, 32> digits{};
    return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), x).ptr};
}

}  // namespace

std::string Limits::text() const {
    std::string text;
    if (std::isfinite(low)) text = (low_open ? "above " : "at least ") + number(low);
    if (std::isfinite(high))
        text += (text.empty() ? "" : " and ") + std::string(high_open ? "below " : "at most ") + number(high);
    return text;
}

std::string Limits::interval() const {
    const bool below_all = !std::isfinite(low);
    const bool above_all = !std::isfinite(high);
    return (low_open || below_all ? "(" : "[") + (below_all ? "-inf" : number(low)) + ", " +
           (above_all ? "inf" : number(high)) + (high_open || above_all ? ")" : "]");
}

Error::Error() = default;
Error::Error(ErrorKind kind_, std::string what_, std::string where_, std::optional<Entity> entity_, std::string remedy_)
    : kind(kind_),
      what(std::move(what_)),
      where(std::move(where_)),
      entity(std::move(entity_)),
      remedy(std::move(remedy_)) {}
Error::Error(const Error&) = default;
Error::Error(Error&&) noexcept = default;
Error& Error::operator=(const Error&) = default;
Error& Error::operator=(Error&&) noexcept = default;
Error::~Error() = default;

tl::unexpected<Error> fail(Error error) { return tl::unexpected<Error>(std::move(error)); }

tl::unexpected<Error> fail(ErrorKind kind, std::string what, std::string where, std::optional<Entity> entity,
                           std::string remedy) {
    return fail(Error(kind, std::move(what), std::move(where), std::move(entity), std::move(remedy)));
}

std::string describe(const Error& e) {
    constexpr std::size_t longest = 4096;
    std::string line;
    if (!e.where.empty()) line += shortened(e.where, longest) + ": ";
    if (e.entity) line += e.entity->kind + " " + std::to_string(e.entity->number) + ": ";
    line += shortened(e.what, longest);
    if (!e.remedy.empty()) line += " (" + shortened(e.remedy, longest) + ")";
    return line;
}

std::string out_of_limits(const Limits& limits, std::string_view got) {
    return "must be " + limits.text() + ", got " + shortened(got);
}

Outcome<Done> check_limits(std::string_view name, double value, const Limits& limits) {
    if (!std::isfinite(value)) return fail(ErrorKind::usage, std::string(name) + " must be a finite number");
    if (limits.permit(value)) return Done{};
    return fail(ErrorKind::usage, std::string(name) + " " + out_of_limits(limits, number(value)));
}

Error out_of_memory(const std::bad_alloc& failure) {
    const auto* const file = dynamic_cast<const NoFileForArray*>(&failure);
    if (file == nullptr)
        return {ErrorKind::memory, "not enough memory", {}, {}, "make more memory available, or use a smaller mesh"};
    return {ErrorKind::write,
            "temporary files of arrays cannot be written: " + std::generic_category().message(file->error()),
            file->folder(),
            {},
            file->error() == EFBIG ? "raise the limit (ulimit -f)"
                                   : "free disk space, or choose another folder for "
                                     "the output"};
}

namespace {

/// True if no thread could be started: TBB then throws a runtime_error with the name of the call.
bool is_thread_failure(const std::runtime_error& error) {
    return dynamic_cast<const std::system_error*>(&error) != nullptr ||
           std::string_view(error.what()).starts_with("pthread_");
}

}  // namespace

Error out_of_resources() {
    try {
        throw;
    } catch (const std::bad_alloc& failure) {
        return out_of_memory(failure);
    } catch (const std::length_error&) {
        return out_of_memory(std::bad_alloc());
    } catch (const std::runtime_error& error) {
        if (!is_thread_failure(error)) throw;
        return {ErrorKind::memory,
                std::string("the system refuses: ") + error.what(),
                {},
                {},
                "use fewer threads: --threads 1"};
    }
}

namespace {

class Ticker {
  public:
    Ticker(const Execution& execution, std::size_t total) : execution_(execution), total_(total) {}
    void add(std::size_t items) {
        done_.fetch_add(items);
        if (!execution_.progress) return;
        // A progress report is dropped while another one is running, unless it is the final report.
        std::unique_lock lock(mutex_, std::try_to_lock);
        if (!lock && done_.load() == total_) lock.lock();
        if (!lock) return;
        // `done_` is read under the lock, because an earlier value could be smaller than one already reported.
        const std::size_t done = done_.load();
        if (done == reported_) return;
        reported_ = done;
        execution_.progress(done, total_);
    }

  private:
    const Execution& execution_;
    std::size_t total_;
    std::size_t reported_ = 0;
    std::atomic<std::size_t> done_{0};
    std::mutex mutex_;
};

}  // namespace

Outcome<Done> run_chunks(const Execution& execution, std::size_t n, std::size_t grain, void* context,
                         void (*body)(void*, std::size_t, std::size_t)) {
    return guarded([&]() -> Outcome<Done> {
        const std::size_t chunks = (n + grain - 1) / grain;
        Ticker ticker(execution, n);
        const auto run_chunk = [&](std::size_t chunk) {
            if (execution.stop.stop_requested()) return;
            const std::size_t begin = chunk * grain;
            const std::size_t end = std::min(n, begin + grain);
            body(context, begin, end);
            ticker.add(end - begin);
        };
        if (execution.threads == 1 || chunks < 2) {
            for (std::size_t chunk = 0; chunk < chunks; ++chunk) run_chunk(chunk);
        } else {
            // More threads than the default concurrency would not run, and TBB would print a warning.
            const int threads = std::min(execution.threads, tbb::info::default_concurrency());
            tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
            arena.execute([&] { tbb::parallel_for(std::size_t{0}, chunks, run_chunk); });
        }
        if (execution.stop.stop_requested()) return stopped();
        return Done{};
    });
}

}  // namespace camber
