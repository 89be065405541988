#pragma once
// Work that Python waits for: in a thread of its own, without the interpreter's lock, while the caller's thread looks
// after signals, tells how far it is, and runs what must be run in Python.
#include <pybind11/pybind11.h>

#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>

import camber.core;
import camber.app_shell;
import camber.commands;

namespace camber::python {

namespace py = pybind11;

/// Raises the exception of camber.exceptions that an error is.
[[noreturn]] void raise(const Error& error);

/// The value, or its error raised.
template <class T>
T value_of(Outcome<T> outcome) {
    if (!outcome) raise(outcome.error());
    return std::move(*outcome);
}

class Watched {
  public:
    /// `progress`: None, or called with the stage and its share; a False from it stops the work.
    explicit Watched(py::object progress) : progress_(std::move(progress)) {}

    /// f(host) in another thread. Raises what Python raised meanwhile (KeyboardInterrupt, from `progress`, from what
    /// was called), else the error.
    template <class F>
    auto run(F&& f) {
        using Result = std::invoke_result_t<F, app::Host>;
        std::optional<Result> made;
        {
            const py::gil_scoped_release without_lock;
            const std::jthread worker([&] {
                made = guarded([&]() -> Result { return f(host()); });
                const std::scoped_lock lock(mutex_);
                done_ = true;
                changed_.notify_all();
            });
            look_after();
        }
        if (raised_) std::rethrow_exception(raised_);
        return value_of(std::move(*made));
    }

    /// In the work's thread: f() with the interpreter's lock, in the caller's thread. False: it raised, and the work is
    /// to end.
    bool call(std::function<void()> f);

  private:
    app::Host host();
    void look_after();
    void visit_python();

    py::object progress_;
    std::mutex mutex_;
    std::condition_variable changed_;
    bool done_ = false;
    std::function<void()> asked_;  ///< to be called
    std::optional<std::pair<std::string, double>> told_;
    std::stop_source stop_;
    std::exception_ptr raised_;
};

}  // namespace camber::python
