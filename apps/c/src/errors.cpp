// Errors as texts, one a thread.
#include <exception>
#include <functional>
#include <new>
#include <string>

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
    } catch (const std::bad_alloc&) {
        return status_of(Error{ErrorKind::memory, "not enough memory", {}, {}, "give it more, or a smaller mesh"});
    } catch (const std::exception& error) {
        return status_of(Error{ErrorKind::internal, error.what(), {}, {}, {}});
    }
}

int missing(const char* argument) { return status_of(Error{ErrorKind::usage, "is NULL", argument, {}, {}}); }

}  // namespace camber::c

const char* camber_version(void) { return CAMBER_VERSION; }
const char* camber_error(void) { return camber::c::last_error().c_str(); }
