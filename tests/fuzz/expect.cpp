#include "targets.hpp"

#include <cstdio>
#include <cstdlib>
#include <string>

namespace fuzz {

void expect(bool holds, std::string_view expectation) {
    if (holds) return;
    std::fprintf(stderr, "fuzz: failed expectation: %s\n", std::string(expectation).c_str());
    std::abort();
}

}  // namespace fuzz
