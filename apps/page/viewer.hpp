#pragma once
#include <string>

namespace camber {

/// The parts of a page that are the same in all: its frame, with places for what differs, its style, and its script.
struct Viewer {
    std::string frame, style, script;
};
[[nodiscard]] Viewer viewer();

}  // namespace camber
