module;
#include <sys/resource.h>

#include <chrono>
#include <cstddef>
module camber.app_shell;

namespace camber::app {

Meter::Meter() : start_(std::chrono::steady_clock::now()) {}

Usage Meter::read() const {
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start_;
    struct rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);  // the mark is never reset: whoever waits for this process reads it too
    return {passed.count(), static_cast<std::size_t>(usage.ru_maxrss) * 1024};
}

}  // namespace camber::app
