module;
#include <string>
#include <string_view>
#include <vector>
export module camber.commands:suggestion;

export namespace camber::app {

/// `did you mean "curve"?` where the word is one slip away from a known one (a letter too many, missing, wrong, or two
/// swapped) or its beginning; else `known: …`.
[[nodiscard]] std::string suggestion(std::string_view word, const std::vector<std::string>& known);

/// `did you mean "wing.mesh"?` of a file that is not there, where its folder has one of that name with another ending,
/// or one slip away; else empty.
[[nodiscard]] std::string suggested_file(const std::string& path);

}  // namespace camber::app
