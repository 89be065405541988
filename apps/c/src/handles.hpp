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
    /// Input number (from 1) of each point, 0: a new point; empty: 1, 2, 3 …
    camber::Column<std::uint32_t> input_numbers = {};
};

struct camber_result {
    std::optional<camber_mesh> mesh;
    std::string report;
    std::optional<camber::Solution> metric;
};

namespace camber::c {

/// Stores the error's text for camber_error. Returns its status.
int status_of(const Error& error);

int guarded_status(const std::function<int()>& f);

/// A host that neither reports progress nor stops the work.
inline app::Host silent_host() {
    return {.stop = {}, .progress = [](const std::string&, double) {}};
}

/// A pointer argument with its name in camber.h.
struct Pointer {
    const char* name;
    const void* value;
};

/// Returns CAMBER_OK, or stores an error about the first NULL argument and returns its status.
int missing(const char* function, std::initializer_list<Pointer> arguments);

/// Returns an error of kind usage, for example "camber_make: points: is -1 (…)".
Error wrong_argument(const std::string& function, const std::string& argument, std::string what,
                     std::string remedy = {});

/// Returns CAMBER_OK if `first` is 0 (C) or 1 (Fortran, Julia), else stores an error and returns its status.
int wrong_first(const char* function, int first);

}  // namespace camber::c
