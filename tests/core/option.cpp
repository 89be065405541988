// Options described by structs, and words of enumerations.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "property.hpp"

import camber.core;

using namespace camber;
using camber::testing::property;

namespace {

enum class Colour : std::uint8_t { red = 4, green = 1, blue = 200 };
constexpr auto words(Colour) {
    return words_of(Word{Colour::blue, "blau"}, Word{Colour::red, "rot"}, Word{Colour::green, "gruen"});
}
static_assert(enumerator_count<Colour>() == 3);
static_assert(is_enumerator<Colour::blue>() && !is_enumerator<static_cast<Colour>(0)>());

struct Brush {
    double width = 2;
    std::size_t hairs = 100;
    Colour colour = Colour::red;
    int not_described = 0;

    static constexpr auto options() {
        return std::tuple(option("width", &Brush::width, "how wide").unit("mm").above(0).at_most(0.5),
                          option("hairs", &Brush::hairs, "how many").at_least(1).required(),
                          option("colour", &Brush::colour, "of what"));
    }
};

struct Reused {
    double broad = Brush{}.width;
    static constexpr auto options() { return std::tuple(option_of(&Brush::width).as(&Reused::broad)); }
};

struct Longer : Brush {
    int length = 1;
    static constexpr auto options() {
        return std::tuple_cat(Brush::options(), std::tuple(option("length", &Longer::length, "how long").at_least(1)));
    }
};

constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

TEST_CASE("each enumerator has its word in any order of declaration") {
    for (const auto& w : words(Colour{})) CHECK(word_of(w.value) == w.word);
    CHECK(word_of(Colour::red) == "rot");
    CHECK(word_of(static_cast<Colour>(7)).empty());
    CHECK(all_words<Colour>() == std::vector<std::string>{"blau", "rot", "gruen"});
}

TEST_CASE("options are described once and reused in other structs") {
    constexpr auto width = option_of(&Brush::width);
    CHECK(width.name == "width");
    CHECK(width.unit_name == "mm");
    CHECK(width.limits.text() == "above 0 and at most 0.5");
    CHECK(width.limits.interval() == "(0, 0.5]");
    CHECK(option_of(&Brush::hairs).is_required);
    constexpr auto broad = option_of(&Reused::broad);
    CHECK(broad.name == width.name);
    CHECK(broad.sentence == width.sentence);
    CHECK(broad.limits.text() == width.limits.text());
    std::vector<std::string_view> names;
    each_option<Longer>([&](const auto& o) { names.push_back(o.name); });
    CHECK(names == std::vector<std::string_view>{"width", "hairs", "colour", "length"});
}

TEST_CASE("limits are written as text and as intervals") {
    CHECK(Limits{}.text().empty());
    CHECK(Limits{}.interval() == "(-inf, inf)");
    CHECK(Limits{.low = 0, .high = 1, .high_open = true}.interval() == "[0, 1)");
    CHECK(Limits{.high = 1e-9}.text() == "at most 1e-09");
    CHECK(out_of_limits(Limits{.low = 3}, "2") == "must be at least 3, got 2");
}

TEST_CASE("numbers outside their limits are usage errors that name the option") {
    property("a number is accepted exactly if it is within its limits", [] {
        const auto x = *rc::gen::arbitrary<double>();
        const Longer brush{{.width = x}};
        RC_ASSERT(check_limits(brush).has_value() == (x > 0 && x <= 0.5));
    });
    const auto error_message = [](const Longer& brush) {
        const auto checked = check_limits(brush);
        REQUIRE_FALSE(checked.has_value());
        CHECK(checked.error().kind == ErrorKind::usage);
        return checked.error().what;
    };
    CHECK(error_message({{.width = 0}}) == "width must be above 0 and at most 0.5, got 0");
    CHECK(error_message({{.width = 0.25, .hairs = 0}}) == "hairs must be at least 1, got 0");
    CHECK(error_message({{.width = 0.25}, -1}) == "length must be at least 1, got -1");
    for (const double x : {infinity, -infinity, std::nan("")})
        CHECK(error_message({{.width = x}}) == "width must be a finite number");
}
