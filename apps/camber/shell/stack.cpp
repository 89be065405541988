module;
#include <pthread.h>
#include <sys/resource.h>

#include <cstddef>
#include <exception>
#include <functional>
#include <system_error>
#include <thread>
module camber.app_shell;
import :stack;

namespace camber::app {

namespace {

/// That of Linux: ulimit -s 8192.
constexpr std::size_t usual_stack = std::size_t{8} << 20U;

bool has_usual_stack() {
    rlimit limit{};
    return ::getrlimit(RLIMIT_STACK, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY || limit.rlim_cur >= usual_stack;
}

void give_threads_usual_stacks() {
    pthread_attr_t attributes;
    if (::pthread_attr_init(&attributes) != 0) return;
    if (::pthread_attr_setstacksize(&attributes, usual_stack) == 0) (void)::pthread_setattr_default_np(&attributes);
    ::pthread_attr_destroy(&attributes);
}

}  // namespace

int with_usual_stack(const std::function<int()>& work) {
    if (has_usual_stack()) return work();
    give_threads_usual_stacks();
    int code = 0;
    std::exception_ptr failure;
    const auto run = [&] {
        try {
            code = work();
        } catch (...) {
            failure = std::current_exception();
        }
    };
    try {
        std::thread(run).join();
    } catch (const std::system_error&) {  // no memory for a thread: the work says so, or has enough of a small stack
        return work();
    }
    if (failure) std::rethrow_exception(failure);
    return code;
}

}  // namespace camber::app
