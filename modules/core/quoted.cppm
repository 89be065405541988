module;
#include <cstddef>
#include <string>
#include <string_view>
export module camber.core:quoted;

/// Texts of the input in messages, which stay short whatever the input is.
export namespace camber {

/// Bytes of a text of the input that a message has place for.
constexpr std::size_t longest_quote = 80;

/// A text of at most `longest` bytes: of a longer one the beginning and the end, with "…" between. Letters of UTF-8 are
/// whole.
[[nodiscard]] std::string shortened(std::string_view text, std::size_t longest = longest_quote);

/// A text of the input between quotation marks, shortened, with "?" for control characters.
[[nodiscard]] std::string in_quotes(std::string_view text);

}  // namespace camber
