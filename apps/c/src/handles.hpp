#pragma once
// What stands behind the handles of camber.h.
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "camber.h"
import camber.core;
import camber.commands;
import camber.io;

struct camber_mesh {
    camber::DecodedMesh value;
    /// Of each point the number, from 1, that it was given as, 0: none; empty: 1, 2, 3 …
    camber::Column<std::uint32_t> given_as = {};
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

/// A host that is told of nothing and stops nothing.
inline app::Host nobody() {
    return {.stop = {}, .told = [](const std::string&, double) {}};
}

/// The error of a null pointer.
int missing(const char* argument);

}  // namespace camber::c
