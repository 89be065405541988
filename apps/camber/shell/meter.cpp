module;
#include <sys/resource.h>

#include <chrono>
#include <cstddef>
#include <fstream>
#include <ostream>
#include <string>
module camber.app_shell;

namespace camber::app {

namespace {

/// VmHWM of this process; 0 where there is none to read.
std::size_t high_water_mark() {
    std::ifstream status("/proc/self/status");
    std::string line;
    while (std::getline(status, line))
        if (line.starts_with("VmHWM:")) return std::stoull(line.substr(6)) * 1024;
    return 0;
}

}  // namespace

Meter::Meter() : start_(std::chrono::steady_clock::now()), reset_(false) {
    std::ofstream clear("/proc/self/clear_refs");
    clear << "5" << std::flush;  // proc(5): resets the peak resident size to the present one
    reset_ = static_cast<bool>(clear) && high_water_mark() > 0;
}

Usage Meter::read() const {
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start_;
    if (const std::size_t mark = high_water_mark(); mark > 0) return {passed.count(), mark, reset_};
    struct rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return {passed.count(), static_cast<std::size_t>(usage.ru_maxrss) * 1024, false};
}

}  // namespace camber::app
