module;
#include <cstdint>
#include <span>
#include <string>
#include <vector>
module camber.run:page_arrays;
import camber.core;

/// Arrays of a page as text: the bytes of words of 32 bits, those of one significance side by side (the lowest first),
/// as a zlib stream, in base64. docs/page.md tells it to others.
namespace camber::run {

/// An array before it is packed.
struct PageArray {
    std::string name;
    std::vector<std::uint8_t> bytes;
};

[[nodiscard]] PageArray array_of_words(std::string name, std::span<const std::uint32_t> words);
[[nodiscard]] PageArray array_of_integers(std::string name, std::span<const std::int32_t> integers);
/// To 15 bits of its mantissa.
[[nodiscard]] float rounded_float(float x);
/// Each float to 15 bits of its mantissa: to 1.6e-5 of itself.
[[nodiscard]] PageArray array_of_rounded(std::string name, std::span<const float> numbers);
[[nodiscard]] PageArray array_of_floats(std::string name, std::span<const float> numbers);

/// Ids that count up by first use, each as how far it is below the next new one: mostly small numbers.
[[nodiscard]] PageArray array_of_ids(std::string name, std::span<const std::uint32_t> ids);

/// One a script element, <script id="camber-NAME">; in parallel. Errors: memory, stopped.
[[nodiscard]] Outcome<std::vector<std::string>> packed(std::vector<PageArray> arrays, const Execution& execution);

}  // namespace camber::run
