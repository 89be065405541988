#include "targets.hpp"

#include <cstdio>
#include <cstdlib>
#include <string>

namespace fuzz {

void expect(bool holds, std::string_view promise) {
    if (holds) return;
    std::fprintf(stderr, "fuzz: broken promise: %s\n", std::string(promise).c_str());
    std::abort();
}

}  // namespace fuzz
