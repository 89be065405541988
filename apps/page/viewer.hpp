#pragma once
#include <string>

namespace camber {

/// Constant parts of a page: frame with placeholders, style, and script.
struct Viewer {
    std::string frame, style, script;
};
[[nodiscard]] Viewer viewer();

}  // namespace camber
