module;
#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>
export module camber.drawing:colour;
import camber.core;

/// What colours stand for.
export namespace camber {

/// Parts of red, green and blue from 0 to 1, as screens take them (sRGB).
struct Colour {
    double red = 0, green = 0, blue = 0;
    friend bool operator==(const Colour&, const Colour&) = default;
};
/// (1 − t) a + t b.
[[nodiscard]] constexpr Colour blend(const Colour& a, const Colour& b, double t) {
    return {a.red + t * (b.red - a.red), a.green + t * (b.green - a.green), a.blue + t * (b.blue - a.blue)};
}
[[nodiscard]] constexpr Colour scaled(const Colour& c, double factor) {
    return {c.red * factor, c.green * factor, c.blue * factor};
}
/// "#3f86a6".
[[nodiscard]] std::string hex(const Colour& colour);

enum class Background : std::uint8_t { light, dark, transparent };
constexpr auto words(Background) {
    return words_of(Word{Background::light, "light"}, Word{Background::dark, "dark"},
                    Word{Background::transparent, "transparent"});
}

/// The colours of everything but the values.
struct Theme {
    Colour paper, ink, line, plain, missing, accent;
};
[[nodiscard]] Theme theme_of(Background background);

/// Which end of a range is good: a number may be neither.
enum class Ramp : std::uint8_t { plain, good_is_high };
enum class Spacing : std::uint8_t { linear, logarithmic };

/// A range of numbers; those beyond have the colour of its end.
struct ColourRange {
    double low = 0, high = 1;
    Ramp ramp = Ramp::plain;
    Spacing spacing = Spacing::linear;
    /// Where a value lies between the ends, from 0 to 1.
    [[nodiscard]] double place_of(double value) const;
    [[nodiscard]] double value_at(double place) const;
};
/// Kinds without an order, each with a number; their values are 0, 1, 2 …, by their places here.
struct ColourKinds {
    std::vector<Reference> numbers;
};
struct OneColour {};
using Colouring = std::variant<OneColour, ColourRange, ColourKinds>;

/// The colour of a value; that of what is missing where it is not finite, or none of the kinds.
[[nodiscard]] Colour colour_of(const Colouring& colouring, double value, const Theme& theme);
/// The colour at a place of a ramp, from 0 to 1.
[[nodiscard]] Colour colour_at(Ramp ramp, double place);
/// The colour of the i-th kind.
[[nodiscard]] Colour colour_of_kind(std::size_t i);

}  // namespace camber
