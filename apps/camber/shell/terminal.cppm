module;
#include <cstddef>
#include <string>
#include <string_view>
export module camber.app_shell:terminal;

export namespace camber::app {

/// How wide text for standard output should be: 100 columns, or the terminal's where it has fewer.
[[nodiscard]] std::size_t text_width();

/// The text in lines of at most `width` columns, of which all but the first begin with `indent` spaces; the first is
/// thought to stand behind as many columns. Lines of the text that begin with a space (examples) are not broken.
[[nodiscard]] std::string wrapped(std::string_view text, std::size_t width, std::size_t indent = 0);

}  // namespace camber::app
