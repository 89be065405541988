#pragma once
// What stands behind the handles of camber.h.
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

/// A pointer argument of a function of camber.h, by its name there.
struct Pointer {
    const char* name;
    const void* value;
};

/// The status of the first argument that is NULL, with an error that names the function and the argument; CAMBER_OK if
/// none is.
int missing(const char* function, std::initializer_list<Pointer> arguments);

/// The error (usage) of an argument of a function: "camber_make: points: is -1 (…)".
Error wrong_argument(const std::string& function, const std::string& argument, std::string what,
                     std::string remedy = {});

/// The status of a number of a first node other than those of C, and of Fortran and Julia.
int wrong_first(const char* function, int first);

}  // namespace camber::c
