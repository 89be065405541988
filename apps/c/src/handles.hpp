#pragma once
// Types behind the handles of camber.h.
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>

#include "camber.h"
import camber.core;
import camber.commands;
import camber.io;

struct camber_mesh {
    camber::DecodedMesh value;
    /// Input number (from 1) of each point, 0: none; empty: 1, 2, 3 …
    camber::Column<std::uint32_t> given_as = {};
};

struct camber_result {
    std::optional<camber_mesh> mesh;
    std::string report;
    std::optional<camber::Solution> metric;
};

namespace camber::c {

/// Status of an error, which camber_error then returns.
int status_of(const Error& error);

int guarded_status(const std::function<int()>& f);

/// A host without progress and stop.
inline app::Host nobody() {
    return {.stop = {}, .told = [](const std::string&, double) {}};
}

/// A pointer argument with its name in camber.h.
struct Pointer {
    const char* name;
    const void* value;
};

/// Status of the first NULL argument, with an error; CAMBER_OK if there is none.
int missing(const char* function, std::initializer_list<Pointer> arguments);

/// Error of kind usage: "camber_make: points: is -1 (…)".
Error wrong_argument(const std::string& function, const std::string& argument, std::string what,
                     std::string remedy = {});

/// Errors unless first is 0 (C) or 1 (Fortran, Julia).
int wrong_first(const char* function, int first);

}  // namespace camber::c
