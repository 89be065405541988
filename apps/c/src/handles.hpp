#pragma once
// What stands behind the handles of camber.h.
#include <functional>
#include <optional>
#include <string>

#include "camber.h"
import camber.core;
import camber.io;

struct camber_mesh {
    camber::DecodedMesh value;
};

struct camber_result {
    std::optional<camber_mesh> mesh;
    std::string report;
    std::optional<camber::Solution> metric;
};

namespace camber::c {

/// The status of an error, which camber_error tells of from now on.
int status_of(const Error& error);

/// f() → status, with what it throws as a status.
int guarded_status(const std::function<int()>& f);

/// The error of a null pointer.
int missing(const char* argument);

}  // namespace camber::c
