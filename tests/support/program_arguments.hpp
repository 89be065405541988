// Named numeric arguments of programs, for example --seed 3.
#pragma once

#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <span>
#include <string_view>

namespace camber::testing {

struct NumberArgument {
    std::string_view name;  ///< including the dashes
    double* value;
    double least = 0;
};

/// Returns false and prints the known arguments to standard error if an argument is unknown or a number too small.
inline bool read_numbers(int argc, char** argv, std::initializer_list<NumberArgument> numbers) {
    const std::span<char*> words(argv, static_cast<std::size_t>(argc));
    for (std::size_t i = 1; i < words.size(); i += 2) {
        bool known = false;
        for (const auto& [name, value, least] : numbers) {
            if (name != words[i]) continue;
            *value = i + 1 < words.size() ? std::strtod(words[i + 1], nullptr) : 0;
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
