#pragma once
// Types of the opaque handles in camber.h.
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
    /// For each point its number in the input, from 1, or 0 for a new point. Empty: the numbers are 1, 2, 3 …
    camber::Column<std::uint32_t> input_numbers = {};
};

struct camber_result {
    std::optional<camber_mesh> mesh;
    std::string report;
    std::optional<camber::Solution> metric;
};

namespace camber::c {

/// Stores the text of the error for camber_error, and returns its status.
int status_of(const Error& error);

int guarded_status(const std::function<int()>& f);

/// A host that does not report progress and does not stop the work.
inline app::Host silent_host() {
    return {.stop = {}, .progress = [](const std::string&, double) {}};
}

/// A pointer argument with its name in camber.h.
struct Pointer {
    const char* name;
    const void* value;
};

/// Returns CAMBER_OK if no argument is NULL. Otherwise stores an error about the first NULL argument and returns its
/// status.
int missing(const char* function, std::initializer_list<Pointer> arguments);

/// Returns an error of kind usage, for example "camber_make: points: is -1 (…)".
Error wrong_argument(const std::string& function, const std::string& argument, std::string what,
                     std::string remedy = {});

/// Checks the number of the first node: 0 (C) or 1 (Fortran, Julia). Returns CAMBER_OK, or stores an error and returns
/// its status.
int wrong_first(const char* function, int first);

}  // namespace camber::c
