// Arguments of programs that are numbers by name: --seed 3.
#pragma once

#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <span>
#include <string_view>

namespace camber::testing {

struct NumberArgument {
    std::string_view name;  ///< with its dashes
    double* value;
    double least = 0;
};

/// False, and what there is on the standard error, where a word is none of them or a number too small.
inline bool read_numbers(int argc, char** argv, std::initializer_list<NumberArgument> numbers) {
    const std::span<char*> given(argv, static_cast<std::size_t>(argc));
    for (std::size_t i = 1; i < given.size(); i += 2) {
        bool known = false;
        for (const auto& [name, value, least] : numbers) {
            if (name != given[i]) continue;
            *value = i + 1 < given.size() ? std::strtod(given[i + 1], nullptr) : 0;
            known = *value >= least;
        }
        if (known) continue;
        std::fprintf(stderr, "arguments, each with a number:");
        for (const auto& [name, value, least] : numbers)
            std::fprintf(stderr, " %.*s", static_cast<int>(name.size()), name.data());
        std::fprintf(stderr, "\n");
        return false;
    }
    return true;
}

}  // namespace camber::testing
