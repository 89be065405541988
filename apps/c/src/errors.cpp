// Errors as texts, one a thread.
#include <exception>
#include <functional>
#include <initializer_list>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>

#include "camber.h"
#include "handles.hpp"
import camber.core;

namespace camber::c {

namespace {

std::string& last_error() {
    static thread_local std::string text;
    return text;
}

int status_of(ErrorKind kind) {
    switch (kind) {
        case ErrorKind::usage: return CAMBER_USAGE;
        case ErrorKind::input:
        case ErrorKind::unsupported:
        case ErrorKind::write: return CAMBER_INPUT;
        case ErrorKind::stopped: return CAMBER_STOPPED;
        case ErrorKind::memory:
        case ErrorKind::internal: return CAMBER_INTERNAL;
    }
    return CAMBER_INTERNAL;
}

}  // namespace

int status_of(const Error& error) {
    last_error() = describe(error);
    return status_of(error.kind);
}

int guarded_status(const std::function<int()>& f) {
    try {
        return f();
    } catch (const std::bad_alloc& failure) {
        return status_of(out_of_memory(failure));
    } catch (const std::length_error&) {  // more than any memory has
        return status_of(out_of_memory(std::bad_alloc()));
    } catch (const std::exception& error) {
        return status_of(Error{ErrorKind::internal, error.what(), {}, {}, {}});
    }
}

Error wrong_argument(const std::string& function, const std::string& argument, std::string what, std::string remedy) {
    return {ErrorKind::usage, std::move(what), function + ": " + argument, {}, std::move(remedy)};
}

int missing(const char* function, std::initializer_list<Pointer> arguments) {
    for (const Pointer& argument : arguments)
        if (argument.value == nullptr) return status_of(wrong_argument(function, argument.name, "is NULL"));
    return CAMBER_OK;
}

int wrong_first(const char* function, int first) {
    if (first == 0 || first == 1) return CAMBER_OK;
    return status_of(wrong_argument(function, "first", "is " + std::to_string(first),
                                    "give 0, or 1 where nodes count from 1, as in Fortran and Julia"));
}

}  // namespace camber::c

const char* camber_version(void) { return CAMBER_VERSION; }
const char* camber_error(void) { return camber::c::last_error().c_str(); }
