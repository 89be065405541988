module;
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <variant>
#include <vector>
module camber.drawing;
import camber.core;

namespace camber {

namespace {

constexpr std::size_t steps_of_a_bar = 64, ticks_of_a_bar = 5, most_kinds = 12;

double text_size(const PictureOptions& o) {
    return std::clamp(0.019 * static_cast<double>(std::min(o.width, o.height)), 8.0, 40.0);
}

/// Where the legend stands.
struct Place {
    double x, top, height, size;
};
Place place_of(const PictureOptions& o) {
    const double size = text_size(o), height = static_cast<double>(o.height);
    return {static_cast<double>(o.width) - legend_width(o), 0.5 * height - 0.22 * height, 0.44 * height, size};
}

/// Paper behind the legend: of a part of a mesh the rest goes on to the picture's edge.
void add_panel(const PictureOptions& o, const Place& p, const Theme& theme, std::vector<PictureMark>& marks) {
    if (!o.zoom || o.background == Background::transparent) return;
    const double left = p.x - 0.6 * p.size;
    marks.emplace_back(
        BoxMark{{left, 0, static_cast<double>(o.width) - left, static_cast<double>(o.height)}, theme.paper});
}

void add_title(const PictureOptions& o, const Place& p, const Theme& theme, std::vector<PictureMark>& marks) {
    add_panel(o, p, theme, marks);
    marks.emplace_back(TextMark{p.x, p.top - 1.2 * p.size, p.size, Anchor::start, theme.ink, o.title});
}

/// To a thousandth of the range, so that what is nearly 0 reads as 0.
double rounded(double value, const ColourRange& range) {
    if (range.spacing == Spacing::logarithmic || !(range.high > range.low)) return value;
    const double step = pow(10, std::floor(log10((range.high - range.low) / 1000)));
    const double steps = std::round(value / step);
    return steps == 0 ? 0 : steps * step;
}

void add_bar(const PictureOptions& o, const ColourRange& range, std::vector<PictureMark>& marks) {
    const Place p = place_of(o);
    const Theme theme = theme_of(o.background);
    add_title(o, p, theme, marks);
    const double step = p.height / steps_of_a_bar;
    // From the top, each down to the end of the bar, so that no paper shines through between two.
    for (std::size_t i = steps_of_a_bar; i-- > 0;) {
        const double place = (static_cast<double>(i) + 0.5) / steps_of_a_bar,
                     height = static_cast<double>(i + 1) * step;
        marks.emplace_back(
            BoxMark{{p.x, p.top + p.height - height, 1.2 * p.size, height}, colour_at(range.ramp, place)});
    }
    for (std::size_t i = 0; i < ticks_of_a_bar; ++i) {
        const double place = static_cast<double>(i) / (ticks_of_a_bar - 1);
        const double y = p.top + p.height * (1 - place);
        marks.emplace_back(TextMark{p.x + 1.7 * p.size, y + 0.35 * p.size, p.size, Anchor::start, theme.ink,
                                    short_number(rounded(range.value_at(place), range))});
    }
}

void add_kinds(const PictureOptions& o, const ColourKinds& kinds, std::vector<PictureMark>& marks) {
    const Place p = place_of(o);
    const Theme theme = theme_of(o.background);
    add_title(o, p, theme, marks);
    const std::size_t shown = std::min(kinds.numbers.size(), most_kinds);
    for (std::size_t i = 0; i < shown; ++i) {
        const double y = p.top + 1.7 * p.size * static_cast<double>(i);
        marks.emplace_back(BoxMark{{p.x, y, 1.2 * p.size, 1.2 * p.size}, colour_of_kind(i)});
        marks.emplace_back(TextMark{p.x + 1.7 * p.size, y + 0.95 * p.size, p.size, Anchor::start, theme.ink,
                                    std::to_string(kinds.numbers[i])});
    }
    if (shown < kinds.numbers.size())
        marks.emplace_back(TextMark{p.x, p.top + 1.7 * p.size * static_cast<double>(shown) + p.size, p.size,
                                    Anchor::start, theme.ink, "and " + std::to_string(kinds.numbers.size() - shown)});
}

void add_pointers(const Scene& scene, std::vector<PictureMark>& marks) {
    const double size = text_size(scene.options);
    const Colour colour = theme_of(scene.options.background).accent;
    for (const Pointer& pointer : scene.options.pointers) {
        const Vec<3> at = scene.projection(pointer.at);
        marks.emplace_back(RingMark{at[0], at[1], 0.8 * size, 0.14 * size, colour});
        marks.emplace_back(
            TextMark{at[0] + 1.1 * size, at[1] + 0.35 * size, 0.85 * size, Anchor::start, colour, pointer.text});
    }
}

}  // namespace

double legend_width(const PictureOptions& o) {
    const double letters = std::max(7.0, static_cast<double>(o.title.size()));
    return std::min(0.66 * text_size(o) * (letters + 1.5), 0.3 * static_cast<double>(o.width));
}

std::string short_number(double value) {
    std::array<char, 32> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 3).ptr;
    return {text.data(), end};
}

std::vector<PictureMark> marks_of(const Scene& scene) {
    std::vector<PictureMark> marks;
    const PictureOptions& o = scene.options;
    if (const auto* range = std::get_if<ColourRange>(&o.colouring)) add_bar(o, *range, marks);
    if (const auto* kinds = std::get_if<ColourKinds>(&o.colouring)) add_kinds(o, *kinds, marks);
    add_pointers(scene, marks);
    return marks;
}

}  // namespace camber
