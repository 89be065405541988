module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
module camber.drawing;
import camber.core;

namespace camber {

namespace {

constexpr Colour rgb(std::uint32_t hexadecimal) {
    const auto part = [&](std::uint32_t shift) { return static_cast<double>((hexadecimal >> shift) & 0xffU) / 255; };
    return {part(16), part(8), part(0)};
}

// Lightness rises along the plain ramp; the other goes from warm and dark through pale to a calm blue.
constexpr std::array plain_ramp{rgb(0x2c2a6e), rgb(0x2c64a8), rgb(0x2f9fa6), rgb(0x8fca74), rgb(0xf7e26b)};
constexpr std::array quality_ramp{rgb(0x7d1630), rgb(0xd2553a), rgb(0xf0b867), rgb(0xcfe0c8), rgb(0x8fbfd0)};
constexpr std::array kinds{rgb(0x6ea6d7), rgb(0xf0a35e), rgb(0x7fc08a), rgb(0xd98a9c), rgb(0xb79bd6),
                           rgb(0xd6c35a), rgb(0x6fc2c2), rgb(0xc79a7b), rgb(0xa3b86c), rgb(0x9aa7b5)};

Colour along(const std::array<Colour, 5>& ramp, double place) {
    const double x = std::clamp(place, 0.0, 1.0) * 4;
    const auto i = std::min<std::size_t>(static_cast<std::size_t>(x), 3);
    return blend(ramp[i], ramp[i + 1], x - static_cast<double>(i));
}

}  // namespace

std::string hex(const Colour& colour) {
    constexpr char digits[] = "0123456789abcdef";
    std::string text = "#";
    for (const double part : {colour.red, colour.green, colour.blue}) {
        const auto byte = static_cast<std::size_t>(std::lround(std::clamp(part, 0.0, 1.0) * 255));
        text += digits[byte / 16];
        text += digits[byte % 16];
    }
    return text;
}

Theme theme_of(Background background) {
    if (background == Background::dark)
        return {rgb(0x14181f), rgb(0xdfe5ec), rgb(0x0d1117), rgb(0xb9c6d3), rgb(0x59616b), rgb(0xff4fa3)};
    return {rgb(0xffffff), rgb(0x23282f), rgb(0x1c2530), rgb(0xcbd8e4), rgb(0xb5b5b5), rgb(0xd5127f)};
}

double ColourRange::place_of(double value) const {
    if (!(high > low)) return 0.5;
    const double place = spacing == Spacing::linear ? (value - low) / (high - low) : log(value / low) / log(high / low);
    return std::clamp(place, 0.0, 1.0);
}
double ColourRange::value_at(double place) const {
    return spacing == Spacing::linear ? low + place * (high - low) : low * pow(high / low, place);
}

Colour colour_at(Ramp ramp, double place) { return along(ramp == Ramp::plain ? plain_ramp : quality_ramp, place); }
Colour colour_of_kind(std::size_t i) { return kinds[i % kinds.size()]; }

Colour colour_of(const Colouring& colouring, double value, const Theme& theme) {
    if (std::holds_alternative<OneColour>(colouring)) return theme.plain;
    if (const auto* range = std::get_if<ColourRange>(&colouring)) {
        // Minus infinity is the worst there is, and has the colour of the low end.
        if (std::isnan(value)) return theme.missing;
        if (range->spacing == Spacing::logarithmic && !(value > 0)) return colour_at(range->ramp, 0);
        return colour_at(range->ramp, std::isinf(value) ? (value > 0 ? 1 : 0) : range->place_of(value));
    }
    const double place = std::round(value);
    const auto count = static_cast<double>(std::get<ColourKinds>(colouring).numbers.size());
    return place >= 0 && place < count ? colour_of_kind(static_cast<std::size_t>(place)) : theme.missing;
}

}  // namespace camber
