// Python module camber._camber: exceptions, and work on threads. Users import the package camber.
#include "python.hpp"

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <chrono>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

import camber.core;
import camber.app_shell;
import camber.commands;

namespace camber::python {

void raise(const Error& error) {
    const py::object result = py::module_::import("camber.exceptions")
                                  .attr("of")(static_cast<int>(error.kind), error.what, error.where,
                                              error.entity ? error.entity->kind : std::string(),
                                              error.entity ? error.entity->number : 0, error.remedy);
    PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(result.ptr())), result.ptr());
    throw py::error_already_set();
}

app::Host BackgroundTask::host() {
    app::Host host{.stop = stop_.get_token()};
    host.progress = [this](const std::string& stage, double part) {
        const std::scoped_lock lock(mutex_);
        pending_progress_ = std::pair(stage, part);
    };
    return host;
}

void BackgroundTask::look_after() {
    using namespace std::chrono_literals;
    constexpr auto tick = 50ms;
    std::unique_lock lock(mutex_);
    while (!done_) {
        changed_.wait_for(lock, tick, [&] { return done_ || pending_call_; });
        lock.unlock();
        visit_python();
        lock.lock();
    }
}

void BackgroundTask::visit_python() {
    std::function<void()> requested;
    std::optional<std::pair<std::string, double>> progress;
    {
        const std::scoped_lock lock(mutex_);
        requested = pending_call_;
        progress = std::exchange(pending_progress_, std::nullopt);
    }
    if (!raised_) {
        const py::gil_scoped_acquire locked;
        try {
            if (PyErr_CheckSignals() != 0) throw py::error_already_set();
            if (progress && !progress_.is_none()) {
                // The callback stops the work if it returns False, also a NumPy False. None means that the work
                // continues.
                const py::object answer = progress_(progress->first, progress->second);
                const int is_continuing = answer.is_none() ? 1 : PyObject_IsTrue(answer.ptr());
                if (is_continuing < 0) throw py::error_already_set();
                if (is_continuing == 0) stop_.request_stop();
            }
            if (requested) requested();
        } catch (...) {
            raised_ = std::current_exception();
            stop_.request_stop();
        }
    }
    if (!requested) return;
    const std::scoped_lock lock(mutex_);
    pending_call_ = nullptr;
    changed_.notify_all();
}

bool BackgroundTask::call(std::function<void()> f) {
    std::unique_lock lock(mutex_);
    pending_call_ = std::move(f);
    changed_.notify_all();
    changed_.wait(lock, [&] { return !pending_call_; });
    return !raised_;
}

}  // namespace camber::python

namespace {

/// Reads a CAD model. It is the main function of a second Python process that this module starts.
int read_cad(const std::vector<std::string>& words) {
    std::vector<const char*> arguments;
    arguments.reserve(words.size());
    for (const std::string& word : words) arguments.push_back(word.c_str());
    return camber::app::cad_reader({arguments.data(), arguments.size()}).value_or(1);
}

}  // namespace

PYBIND11_MODULE(_camber, module) {
    module.attr("version") = CAMBER_VERSION;
    camber::python::bind_mesh(module);
    camber::python::bind_verbs(module);
    module.def("read_cad", &read_cad);
    module.def("start_itself_by", &camber::app::start_itself_by);
}
