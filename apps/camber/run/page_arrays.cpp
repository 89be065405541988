module;
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <zlib.h>
module camber.run;
import camber.core;
import :page_arrays;

namespace camber::run {

namespace {

std::vector<std::uint8_t> zipped(const std::vector<std::uint8_t>& bytes) {
    constexpr int level = 6;
    uLongf size = compressBound(bytes.size());
    std::vector<std::uint8_t> out(size);
    if (compress2(out.data(), &size, bytes.data(), bytes.size(), level) != Z_OK) throw std::bad_alloc();
    out.resize(size);
    return out;
}

void append_base64(std::string& text, const std::vector<std::uint8_t>& bytes) {
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t here = std::min<std::size_t>(3, bytes.size() - i);
        std::uint32_t word = 0;
        for (std::size_t k = 0; k < 3; ++k) word = word << 8 | (k < here ? bytes[i + k] : 0U);
        for (std::size_t k = 0; k < 4; ++k) text += k <= here ? digits[word >> (18 - 6 * k) & 63U] : '=';
    }
}

std::uint32_t rounded(float x) {
    const auto bits = std::bit_cast<std::uint32_t>(x);
    const bool is_finite = (bits & 0x7f800000U) != 0x7f800000U;
    return is_finite ? (bits + 0x80U) & ~0xffU : bits;
}

template <class T, class Word>
PageArray converted(std::string name, std::span<const T> items, Word&& word) {
    std::vector<std::uint32_t> words(items.size());
    std::ranges::transform(items, words.begin(), word);
    return array_of_words(std::move(name), words);
}

}  // namespace

float rounded_float(float x) { return std::bit_cast<float>(rounded(x)); }

PageArray array_of_words(std::string name, std::span<const std::uint32_t> words) {
    std::vector<std::uint8_t> bytes(4 * words.size());
    for (std::size_t plane = 0; plane < 4; ++plane)
        for (std::size_t i = 0; i < words.size(); ++i)
            bytes[plane * words.size() + i] = static_cast<std::uint8_t>(words[i] >> (8 * plane));
    return {std::move(name), std::move(bytes)};
}

PageArray array_of_integers(std::string name, std::span<const std::int32_t> integers) {
    return converted(std::move(name), integers, [](std::int32_t i) { return std::bit_cast<std::uint32_t>(i); });
}
PageArray array_of_rounded(std::string name, std::span<const float> numbers) {
    return converted(std::move(name), numbers, rounded);
}
PageArray array_of_floats(std::string name, std::span<const float> numbers) {
    return converted(std::move(name), numbers, [](float x) { return std::bit_cast<std::uint32_t>(x); });
}

PageArray array_of_ids(std::string name, std::span<const std::uint32_t> ids) {
    std::uint32_t next = 0;
    return converted(std::move(name), ids, [&](std::uint32_t id) {
        const std::uint32_t below = next - id;
        if (below == 0) ++next;
        return below;
    });
}

Outcome<std::vector<std::string>> packed(std::vector<PageArray> arrays, const Execution& execution) {
    std::vector<std::string> scripts(arrays.size());
    auto done = each(
        execution, arrays.size(),
        [&](std::size_t i) {
            const std::vector<std::uint8_t> bytes = zipped(arrays[i].bytes);
            arrays[i].bytes = {};
            std::string& text = scripts[i];
            text.reserve(bytes.size() / 3 * 4 + 200);
            text += "<script type=\"application/octet-stream\" id=\"camber-" + arrays[i].name + "\">";
            append_base64(text, bytes);
            text += "</script>\n";
        },
        1);
    if (!done) return fail(done.error());
    return scripts;
}

}  // namespace camber::run
