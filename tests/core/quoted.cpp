// Quoted input texts in messages.
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <string_view>

#include <doctest/doctest.h>
#include <rapidcheck.h>

#include "dice.hpp"
#include "property.hpp"

import camber.core;

using namespace camber;
using namespace camber::testing;

namespace {

/// Random characters of one to four bytes.
std::string letters(Dice& dice, std::size_t count) {
    constexpr std::string_view all[] = {"a", " ", "\"", "ä", "€", "😀"};
    std::string text;
    for (std::size_t i = 0; i < count; ++i) text += all[dice.below(std::size(all))];
    return text;
}

bool begins_within_a_letter(std::string_view text) {
    return !text.empty() && (static_cast<unsigned char>(text.front()) & 0xC0U) == 0x80U;
}

}  // namespace

TEST_CASE("a short text is quoted with control characters replaced") {
    CHECK(in_quotes("") == "\"\"");
    CHECK(in_quotes("curve") == "\"curve\"");
    CHECK(in_quotes(std::string(longest_quote, 'x')) == "\"" + std::string(longest_quote, 'x') + "\"");
    CHECK(in_quotes("a\nb\x1b[31m") == "\"a?b?[31m\"");
}

TEST_CASE("a long text keeps its beginning and its end") {
    property("a shortened text keeps to its limit and cuts no character", [](std::uint64_t seed) {
        Dice dice(seed);
        const std::string text = letters(dice, dice.below(400));
        const std::size_t longest = 20 + dice.below(200);
        const std::string brief = shortened(text, longest);
        RC_ASSERT(brief.size() <= longest);
        if (text.size() <= longest) {
            RC_ASSERT(brief == text);
            return;
        }
        std::size_t begin = 0;
        while (begin < brief.size() && brief[begin] == text[begin]) ++begin;
        RC_ASSERT(begin + 8 >= (longest - 3) * 3 / 4);
        const std::size_t gap = brief.rfind("…", begin + 3);
        RC_ASSERT(gap != std::string::npos);
        const std::string_view end = std::string_view(brief).substr(gap + 3);
        RC_ASSERT(text.ends_with(end));
        RC_ASSERT(!begins_within_a_letter(end));
        RC_ASSERT(!begins_within_a_letter(std::string_view(text).substr(gap)));
    });
}

TEST_CASE("the length of a message is bounded for any length of its parts") {
    const std::string megabyte(std::size_t{1} << 20U, 'x');
    CHECK(describe({ErrorKind::input, megabyte, megabyte, Entity{"vertex", 1}, megabyte}).size() < 13000);
}
