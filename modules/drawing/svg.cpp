// Marks of pictures and SVG files.
module;
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
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

struct Place {
    double x, top, height, size;
};
Place place_of(const PictureOptions& o) {
    const double size = text_size(o), height = static_cast<double>(o.height);
    return {static_cast<double>(o.width) - legend_width(o), 0.5 * height - 0.22 * height, 0.44 * height, size};
}

void add_title(const PictureOptions& o, const Place& p, const Theme& theme, std::vector<PictureMark>& marks) {
    marks.emplace_back(TextMark{p.x, p.top - 1.2 * p.size, p.size, Anchor::start, theme.ink, o.title});
}

/// Rounds to about 1/1000 of the range, so that rounding errors near 0 are printed as 0.
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
    // The colour bar is drawn in steps from the top. Each step extends down to the end of the bar, so that no gap opens
    // between steps.
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

constexpr double letter_width = 0.66, text_indent = 1.7;

std::string text_of_kind(const ColourKinds& kinds, std::size_t i) {
    const std::string number = std::to_string(kinds.numbers[i]);
    return i < kinds.names.size() && !kinds.names[i].empty() ? kinds.names[i] + " (" + number + ")" : number;
}

std::vector<std::size_t> listed(const ColourKinds& kinds) {
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < kinds.numbers.size(); ++i)
        if (kinds.is_listed.empty() || kinds.is_listed[i] != 0) places.push_back(i);
    return places;
}

std::string shortened(const std::string& text, double room) {
    const std::size_t most = static_cast<std::size_t>(std::fmax(room, 4));
    const auto is_middle = [&](std::size_t at) { return (static_cast<unsigned char>(text[at]) & 0xc0U) == 0x80U; };
    if (text.size() <= most) return text;
    std::size_t end = most - 3;
    while (end > 0 && is_middle(end)) --end;  // do not cut inside a UTF-8 character
    return text.substr(0, end) + "...";
}

void add_kinds(const PictureOptions& o, const ColourKinds& kinds, std::vector<PictureMark>& marks) {
    const Place p = place_of(o);
    const Theme theme = theme_of(o.background);
    add_title(o, p, theme, marks);
    const std::vector<std::size_t> all = listed(kinds);
    const std::size_t shown = std::min(all.size(), most_kinds);
    const double room = (static_cast<double>(o.width) - p.x) / (letter_width * p.size) - text_indent / letter_width;
    for (std::size_t i = 0; i < shown; ++i) {
        const double y = p.top + 1.7 * p.size * static_cast<double>(i);
        marks.emplace_back(BoxMark{{p.x, y, 1.2 * p.size, 1.2 * p.size}, colour_of_kind(all[i])});
        marks.emplace_back(TextMark{p.x + text_indent * p.size, y + 0.95 * p.size, p.size, Anchor::start, theme.ink,
                                    shortened(text_of_kind(kinds, all[i]), room)});
    }
    if (shown < all.size())
        marks.emplace_back(TextMark{p.x, p.top + 1.7 * p.size * static_cast<double>(shown) + p.size, p.size,
                                    Anchor::start, theme.ink, "and " + std::to_string(all.size() - shown)});
}

void add_pointers(const Scene& scene, std::vector<PictureMark>& marks) {
    const double size = text_size(scene.options);
    const Colour colour = theme_of(scene.options.background).accent;
    for (const Pointer& pointer : scene.options.pointers) {
        Vec<3> at = scene.projection(pointer.at);
        if (const auto& clip = scene.clip) {
            at[0] = std::clamp(at[0], clip->left, clip->left + clip->width);
            at[1] = std::clamp(at[1], clip->top, clip->top + clip->height);
        }
        marks.emplace_back(RingMark{at[0], at[1], 0.8 * size, 0.14 * size, colour});
        marks.emplace_back(
            TextMark{at[0] + 1.1 * size, at[1] + 0.35 * size, 0.85 * size, Anchor::start, colour, pointer.text});
    }
}

}  // namespace

double legend_width(const PictureOptions& o) {
    double letters = std::max(7.0, static_cast<double>(o.title.size()));
    if (const auto* kinds = std::get_if<ColourKinds>(&o.colouring); kinds && !kinds->names.empty())
        for (const std::size_t i : listed(*kinds))
            letters =
                std::max(letters, static_cast<double>(text_of_kind(*kinds, i).size()) + text_indent / letter_width);
    return std::min(letter_width * text_size(o) * (letters + 1.5), 0.3 * static_cast<double>(o.width));
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

namespace {

/// Writes the number tenths/10 in its shortest form, for example "-.5", "12", "3.4". A blank before it is omitted if it
/// has a minus sign.
void put_tenths(std::string& out, std::int64_t tenths) {
    if (tenths < 0)
        out += '-';
    else if (!out.empty() && std::string_view(".0123456789").find(out.back()) != std::string_view::npos)
        out += ' ';
    const std::int64_t size = tenths < 0 ? -tenths : tenths;
    if (size >= 10 || size == 0) out += std::to_string(size / 10);
    if (size % 10 != 0) out += '.' + std::to_string(size % 10);
}
/// Value in tenths, limited because points may be far outside the paper.
std::int64_t tenths_of(double value) { return std::llround(std::clamp(10 * value, -1e12, 1e12)); }
void put(std::string& out, double value) { put_tenths(out, tenths_of(value)); }

/// Writes segments of an SVG path in tenths of a pixel, relative to the rounded previous point, so that rounding errors
/// do not add up.
class Pen {
  public:
    explicit Pen(const Vec<3>& begin) : at_(tenths(begin)), d_("M") { put(at_); }

    void edge(const Vec<3>& from, const Vec<3>& middle, const Vec<3>& to) {
        const Vec<3> bow = middle - midpoint(from, to);
        const Point end = tenths(to), control = tenths(control_point(from, to, middle));
        if (bow[0] * bow[0] + bow[1] * bow[1] < 1e-6) {
            d_ += 'l';
        } else {
            d_ += 'q';
            put({control[0] - at_[0], control[1] - at_[1]});
        }
        put({end[0] - at_[0], end[1] - at_[1]});
        at_ = end;
    }
    [[nodiscard]] const std::string& path() const { return d_; }

  private:
    using Point = std::array<std::int64_t, 2>;
    static Point tenths(const Vec<3>& p) { return {tenths_of(p[0]), tenths_of(p[1])}; }
    void put(const Point& p) {
        put_tenths(d_, p[0]);
        put_tenths(d_, p[1]);
    }

    Point at_;
    std::string d_;
};

void put(std::string& out, std::string_view name, double value) {
    out += ' ';
    out += name;
    out += "=\"";
    put(out, value);
    out += '"';
}

void draw_edge(Pen& pen, const DrawnFace& patch, std::size_t edge) {
    pen.edge(patch.nodes[edge], patch.nodes[3 + edge], patch.nodes[(edge + 1) % 3]);
}
std::string outline(const DrawnFace& patch) {
    Pen pen(patch.nodes[0]);
    for (std::size_t e = 0; e < 3; ++e) draw_edge(pen, patch, e);
    return pen.path() + "z";
}
std::string curve(const DrawnFace& patch, std::size_t edge) {
    Pen pen(patch.nodes[edge]);
    draw_edge(pen, patch, edge);
    return pen.path();
}

constexpr FacePoint middle{1.0 / 3, 1.0 / 3, 1.0 / 3};

DrawnFace part_of_patch(const DrawnFace& whole, const std::array<FacePoint, 3>& corners) {
    DrawnFace part = whole;
    part.lines = {};
    for (std::size_t i = 0; i < 3; ++i) {
        const FacePoint &a = corners[i], &b = corners[(i + 1) % 3];
        const FacePoint between{(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2};
        part.nodes[i] = point_at(whole.nodes, a);
        part.nodes[3 + i] = point_at(whole.nodes, between);
        part.values[i] = static_cast<float>(value_at(whole.values, a));
        part.values[3 + i] = static_cast<float>(value_at(whole.values, between));
        for (std::size_t e = 0; e < 3; ++e)
            if (a[(e + 2) % 3] == 0 && b[(e + 2) % 3] == 0) part.lines[i] = whole.lines[e];
    }
    return part;
}

bool folds(const DrawnFace& patch) {
    bool towards = false, away = false;
    for (std::size_t i = 0; i < 3; ++i) {
        FacePoint corner{}, half{0.5, 0.5, 0.5};
        corner[i] = 1;
        half[i] = 0;
        for (const FacePoint& xi : {corner, half}) (normal_at(patch.nodes, xi)[2] > 0 ? towards : away) = true;
    }
    return towards && away;
}

constexpr std::size_t cuts_of_a_fold = 5;

void add_parts(const DrawnFace& patch, std::vector<DrawnFace>& out) {
    constexpr auto n = static_cast<double>(cuts_of_a_fold);
    const auto at = [&](std::size_t i, std::size_t j) {
        return FacePoint{static_cast<double>(cuts_of_a_fold - i - j) / n, static_cast<double>(i) / n,
                         static_cast<double>(j) / n};
    };
    const auto add = [&](const std::array<FacePoint, 3>& corners) {
        const DrawnFace part = part_of_patch(patch, corners);
        if (normal_at(part.nodes, middle)[2] > 0) out.push_back(part);
    };
    for (std::size_t j = 0; j < cuts_of_a_fold; ++j)
        for (std::size_t i = 0; i + j < cuts_of_a_fold; ++i) {
            add({at(i, j), at(i + 1, j), at(i, j + 1)});
            if (i + j + 1 < cuts_of_a_fold) add({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
        }
}

std::vector<DrawnFace> painted_in_order(const Scene& scene, const Buffer<std::uint32_t>& visible) {
    std::vector<DrawnFace> patches;
    for (const std::uint32_t f : visible) {
        const DrawnFace& patch = scene.patches[f];
        if (scene.sides == VisibleSides::outer && folds(patch))
            add_parts(patch, patches);
        else
            patches.push_back(patch);
    }
    std::stable_sort(patches.begin(), patches.end(), [](const DrawnFace& a, const DrawnFace& b) {
        return point_at(a.nodes, middle)[2] < point_at(b.nodes, middle)[2];
    });
    return patches;
}

constexpr double max_opacity = 0.8;

double opacity_of_lines(const DrawnFace& patch, double width) {
    double longest = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec<3> u = patch.nodes[(i + 1) % 3] - patch.nodes[i];
        longest = std::fmax(longest, hypot(u[0], u[1]));
    }
    const Vec<3> u = patch.nodes[1] - patch.nodes[0], v = patch.nodes[2] - patch.nodes[0];
    const double height = longest > 0 ? std::abs(u[0] * v[1] - u[1] * v[0]) / longest : 0;
    return std::round(10 * line_opacity(height, width, max_opacity)) / 10;
}

class Writer {
  public:
    explicit Writer(const Scene& scene)
        : scene_(scene), theme_(theme_of(scene.options.background)), width_(line_width(scene.options, 0.6)) {}

    void head() {
        const PictureOptions& o = scene_.options;
        const std::string w = std::to_string(o.width), h = std::to_string(o.height);
        out_ = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + w + "\" height=\"" + h + "\" viewBox=\"0 0 " + w +
               " " + h + "\" font-family=\"Helvetica, Arial, sans-serif\">\n";
        if (o.background != Background::transparent)
            out_ += "<rect width=\"" + w + "\" height=\"" + h + "\" fill=\"" + hex(theme_.paper) + "\"/>\n";
    }
    void faces(const std::vector<DrawnFace>& patches) {
        if (const auto& clip = scene_.clip) {
            out_ += "<clipPath id=\"box\"><rect";
            put_frame(*clip);
            out_ += "/></clipPath>\n";
        }
        out_ += scene_.clip ? "<g clip-path=\"url(#box)\"" : "<g";
        out_ += " stroke-linejoin=\"round\" stroke-linecap=\"round\" stroke=\"" + hex(theme_.line) + "\"";
        put(out_, "stroke-width", width_);
        put(out_, "stroke-opacity", max_opacity);
        out_ += ">\n";
        for (const DrawnFace& patch : patches) face(patch);
        out_ += "</g>\n";
    }
    void operator()(const BoxMark& m) {
        out_ += "<rect";
        put_frame(m.frame);
        out_ += " fill=\"" + hex(m.colour) + "\"/>\n";
    }
    void operator()(const RingMark& m) {
        out_ += "<circle";
        put(out_, "cx", m.x);
        put(out_, "cy", m.y);
        put(out_, "r", m.radius);
        out_ += " fill=\"none\" stroke=\"" + hex(m.colour) + "\"";
        put(out_, "stroke-width", m.width);
        out_ += "/>\n";
    }
    void operator()(const TextMark& m) {
        out_ += "<text";
        put(out_, "x", m.x);
        put(out_, "y", m.y);
        put(out_, "font-size", m.size);
        if (m.anchor != Anchor::start)
            out_ += m.anchor == Anchor::end ? " text-anchor=\"end\"" : " text-anchor=\"middle\"";
        out_ += " fill=\"" + hex(m.colour) + "\">" + escaped(m.text) + "</text>\n";
    }
    [[nodiscard]] std::string finish() && { return std::move(out_) + "</svg>\n"; }

  private:
    static std::string escaped(std::string_view text) {
        std::string out;
        for (const char c : text) out += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
        return out;
    }
    [[nodiscard]] std::string fill_of(const DrawnFace& patch) const {
        Colour colour = colour_of(scene_.options.colouring, value_at(patch.values, middle), theme_);
        if (scene_.lighting == Lighting::lit) colour = scaled(colour, brightness(patch.nodes, middle));
        return hex(colour);
    }
    void put_frame(const PaperFrame& frame) {
        put(out_, "x", frame.left);
        put(out_, "y", frame.top);
        put(out_, "width", frame.width);
        put(out_, "height", frame.height);
    }
    void put_opacity(double opacity) {
        if (opacity != max_opacity) put(out_, "stroke-opacity", opacity);
    }
    void face(const DrawnFace& patch) {
        const bool is_lined =
            std::all_of(patch.lines.begin(), patch.lines.end(), [](LineKind kind) { return kind == LineKind::shared; });
        const std::string fill = fill_of(patch);
        out_ += "<path d=\"" + outline(patch) + "\" fill=\"" + fill + "\"";
        if (is_lined && !patch.is_marked) {
            put_opacity(opacity_of_lines(patch, width_));
            out_ += "/>\n";
            return;
        }
        // A thin stroke in the same colour closes gaps between faces.
        out_ += " stroke=\"" + fill + "\" stroke-width=\".4\"";
        put_opacity(1);
        out_ += "/>\n";
        for (std::size_t e = 0; e < 3; ++e) {
            if (patch.lines[e] == LineKind::none) continue;
            out_ += "<path d=\"" + curve(patch, e) + "\" fill=\"none\"";
            if (patch.is_marked) out_ += " stroke=\"" + hex(theme_.accent) + "\"";
            put_opacity(patch.is_marked ? 1 : opacity_of_lines(patch, width_));
            if (patch.lines[e] == LineKind::rim || patch.is_marked) put(out_, "stroke-width", 1.8 * width_);
            out_ += "/>\n";
        }
    }

    const Scene& scene_;
    Theme theme_;
    double width_;
    std::string out_;
};

}  // namespace

Outcome<std::string> svg_of(const Scene& scene, const Execution& execution) {
    return guarded([&]() -> Outcome<std::string> {
        const auto visible = visible_faces(scene, execution);
        if (!visible) return fail(visible.error());
        Writer writer(scene);
        writer.head();
        writer.faces(painted_in_order(scene, *visible));
        for (const PictureMark& mark : marks_of(scene)) std::visit(writer, mark);
        return std::move(writer).finish();
    });
}

}  // namespace camber
