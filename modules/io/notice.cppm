module;
#include <cstddef>
#include <string>
#include <vector>
export module camber.io:notice;
import camber.core;

export namespace camber {

/// Something of a file that the value made from it does not hold: one sentence without a full stop.
struct Notice {
    std::string what;
    friend bool operator==(const Notice&, const Notice&) = default;
};

/// An encoded file: its bytes are those of the chunks, one after the other.
using Chunks = std::vector<Buffer<std::byte>>;

}  // namespace camber
