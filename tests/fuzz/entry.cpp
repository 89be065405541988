// libFuzzer program of the target named by CAMBER_FUZZ_TARGET.
#include "targets.hpp"

#include <cstddef>
#include <cstdint>
#include <span>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::CAMBER_FUZZ_TARGET(std::as_bytes(std::span(data, size)));
    return 0;
}
