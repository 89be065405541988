module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <variant>
#include <vector>
module camber.drawing;
import camber.core;
import :strokes;

namespace camber {

namespace {

/// Marks put upon an image, smooth at their rims.
class Brush {
  public:
    explicit Brush(Image& image) : image_(image) {}

    void operator()(const BoxMark& m) {
        const PaperFrame& f = m.frame;
        each_pixel(f.left, f.top, f.left + f.width, f.top + f.height, [&](double x, double y) {
            const double dx = std::fmin(x + 0.5, f.left + f.width) - std::fmax(x - 0.5, f.left);
            const double dy = std::fmin(y + 0.5, f.top + f.height) - std::fmax(y - 0.5, f.top);
            return std::pair(m.colour, std::fmax(dx, 0) * std::fmax(dy, 0));
        });
    }
    void operator()(const RingMark& m) {
        const double reach = m.radius + m.width;
        each_pixel(m.x - reach, m.y - reach, m.x + reach, m.y + reach, [&](double x, double y) {
            const double away = std::abs(hypot(x - m.x, y - m.y) - m.radius);
            return std::pair(m.colour, m.width / 2 + 0.5 - away);
        });
    }
    void operator()(const TextMark& m) {
        const StrokedText text = stroked(m.text);
        const double unit = 0.125 * m.size, width = std::fmax(0.085 * m.size, 1.0);
        const double shift = m.anchor == Anchor::start ? 0 : text.width * (m.anchor == Anchor::end ? 1 : 0.5);
        const auto place = [&](const StrokePoint& p) {
            return StrokePoint{m.x + unit * (p.x - shift), m.y - unit * p.y};
        };
        for (const Stroke& stroke : text.strokes)
            for (std::size_t i = 1; i < stroke.size(); ++i)
                line(place(stroke[i - 1]), place(stroke[i]), width, m.colour);
    }

  private:
    void line(const StrokePoint& a, const StrokePoint& b, double width, const Colour& colour) {
        const double ux = b.x - a.x, uy = b.y - a.y, squared = ux * ux + uy * uy;
        each_pixel(std::fmin(a.x, b.x) - width, std::fmin(a.y, b.y) - width, std::fmax(a.x, b.x) + width,
                   std::fmax(a.y, b.y) + width, [&](double x, double y) {
                       const double t =
                           squared > 0 ? std::clamp(((x - a.x) * ux + (y - a.y) * uy) / squared, 0.0, 1.0) : 0;
                       const double away = hypot(x - a.x - t * ux, y - a.y - t * uy);
                       return std::pair(colour, width / 2 + 0.5 - away);
                   });
    }

    /// cover(x, y) → colour and how much of it, for the middles of pixels in a box.
    template <class Cover>
    void each_pixel(double left, double top, double right, double bottom, Cover&& cover) {
        const auto within = [](double v, std::size_t most) {
            return static_cast<std::size_t>(std::clamp(v, 0.0, static_cast<double>(most)));
        };
        const std::size_t x1 = within(std::ceil(right + 1), image_.width),
                          y1 = within(std::ceil(bottom + 1), image_.height);
        for (std::size_t y = within(std::floor(top - 1), image_.height); y < y1; ++y)
            for (std::size_t x = within(std::floor(left - 1), image_.width); x < x1; ++x) {
                const auto [colour, part] = cover(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
                if (part > 0) put(y * image_.width + x, colour, std::fmin(part, 1));
            }
    }

    /// The colour over what is there, as opaque as its part of the pixel.
    void put(std::size_t pixel, const Colour& colour, double part) {
        std::uint8_t* p = image_.bytes.data() + 4 * pixel;
        const double below = p[3] / 255.0 * (1 - part), all = part + below;
        const double parts[] = {colour.red, colour.green, colour.blue};
        for (int c = 0; c < 3; ++c)
            p[c] = static_cast<std::uint8_t>(std::lround((255 * parts[c] * part + p[c] * below) / all));
        p[3] = static_cast<std::uint8_t>(std::lround(255 * all));
    }

    Image& image_;
};

}  // namespace

Image with_marks(Image image, const std::vector<PictureMark>& marks) {
    Brush brush(image);
    for (const PictureMark& mark : marks) std::visit(brush, mark);
    return image;
}

}  // namespace camber
