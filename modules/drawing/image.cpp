// Draws marks on images and writes PNG files.
module;
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>
module camber.drawing;
import camber.core;

namespace camber {

namespace {

// A stroke font: digits, lower-case letters, a few signs and the J of Jacobian.

struct StrokePoint {
    double x, y;  ///< y is measured from the base line; unit: 1/6 of a capital letter's height
};
using Stroke = std::vector<StrokePoint>;

/// Strokes of each character. A point is two characters, x and y; y values a and b mean one and two units below the
/// base line. A stroke of one point is a dot.
constexpr auto letters = std::to_array<std::pair<char, std::string_view>>({
    {'0', "103041453616050110"},
    {'1', "052620 1030"},
    {'2', "05163645440040"},
    {'3', "051636454433 133342413010 01"},
    {'4', "30360242"},
    {'5', "460603334241301001"},
    {'6', "453616050110304142331302"},
    {'7', "064610"},
    {'8', "133344453616050413 130201103041423313"},
    {'9', "011030414536160504133344"},
    {'.', "0000"},
    {'-', "0333"},
    {'+', "0343 2125"},
    {'_', "0040"},
    {'/', "0046"},
    {',', "100a"},
    {'(', "26151120"},
    {')', "06151100"},
    {'=', "0242 0444"},
    {':', "0101 0404"},
    {'J', "4641301001"},
    {'a', "04344340 421201103041"},
    {'b', "0600 0314344341301001"},
    {'c', "4334140301103041"},
    {'d', "4640 4334140301103041"},
    {'e', "02424334140301103041"},
    {'f', "36261510 0434"},
    {'g', "444a3b0b 4334140301103041"},
    {'h', "0600 0314344340"},
    {'i', "0004 0606"},
    {'j', "141a0b 1616"},
    {'k', "0600 340230"},
    {'l', "0600"},
    {'m', "0400 0314243330 3344546360"},
    {'n', "0400 0314344340"},
    {'o', "103041433414030110"},
    {'p', "040b 0314344341301001"},
    {'q', "444b 4334140301103041"},
    {'r', "0400 031434"},
    {'s', "43341403123241301001"},
    {'t', "16112030 0434"},
    {'u', "0401103041 4440"},
    {'v', "042044"},
    {'w', "0410243044"},
    {'x', "0440 0044"},
    {'y', "0420 440b"},
    {'z', "04440040"},
});

struct StrokedText {
    std::vector<Stroke> strokes;
    double width = 0;
};

inline StrokedText stroked(std::string_view text) {
    constexpr double between = 1.8, space = 3;
    StrokedText out;
    for (const char input : text) {
        const char c = input == 'J' ? input : static_cast<char>(std::tolower(static_cast<unsigned char>(input)));
        double width = 0;
        bool is_known = false;
        for (const auto& [letter, points] : letters) {
            if (letter != c) continue;
            is_known = true;
            out.strokes.emplace_back();
            for (std::size_t i = 0; i < points.size();) {
                if (points[i] == ' ') {
                    out.strokes.emplace_back();
                    ++i;
                    continue;
                }
                const double x = points[i] - '0';
                const double y = points[i + 1] >= 'a' ? 'a' - 1 - points[i + 1] : points[i + 1] - '0';
                out.strokes.back().push_back({out.width + x, y});
                width = x > width ? x : width;
                i += 2;
            }
        }
        out.width += is_known ? width + between : space;
    }
    return out;
}

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

// PNG files are written without libpng: a file is four chunks around zlib data, and zlib is already required for
// meshes.

namespace {

using Bytes = std::vector<std::uint8_t>;

void put_number(Bytes& out, std::uint32_t value) {
    for (const unsigned shift : {24U, 16U, 8U, 0U}) out.push_back(static_cast<std::uint8_t>(value >> shift));
}

void put_chunk(Bytes& out, std::string_view name, std::span<const std::uint8_t> data) {
    put_number(out, static_cast<std::uint32_t>(data.size()));
    const std::size_t begin = out.size();
    out.insert(out.end(), name.begin(), name.end());
    out.insert(out.end(), data.begin(), data.end());
    put_number(out, static_cast<std::uint32_t>(crc32(0, out.data() + begin, static_cast<uInt>(out.size() - begin))));
}

/// Prediction of a byte by a PNG filter: 0 none, 1 left, 2 above, 3 mean, 4 Paeth.
std::uint8_t predicted(int filter, int left, int above, int corner) {
    switch (filter) {
        case 1: return static_cast<std::uint8_t>(left);
        case 2: return static_cast<std::uint8_t>(above);
        case 3: return static_cast<std::uint8_t>((left + above) / 2);
        case 4: {
            const int a = std::abs(above - corner), b = std::abs(left - corner),
                      c = std::abs(left + above - 2 * corner);
            return static_cast<std::uint8_t>(a <= b && a <= c ? left : b <= c ? above : corner);
        }
        default: return 0;
    }
}

Bytes filtered(int filter, std::span<const std::uint8_t> row, std::span<const std::uint8_t> above, std::size_t pixel) {
    Bytes out(row.size() + 1);
    out[0] = static_cast<std::uint8_t>(filter);
    for (std::size_t i = 0; i < row.size(); ++i) {
        const int left = i < pixel ? 0 : row[i - pixel], up = above.empty() ? 0 : above[i];
        const int corner = i < pixel || above.empty() ? 0 : above[i - pixel];
        out[i + 1] = static_cast<std::uint8_t>(row[i] - predicted(filter, left, up, corner));
    }
    return out;
}

std::size_t weight(const Bytes& row) {
    std::size_t sum = 0;
    for (std::size_t i = 1; i < row.size(); ++i) sum += std::min<std::size_t>(row[i], 256U - row[i]);
    return sum;
}

Bytes filtered_rows(const Image& image, std::size_t pixel) {
    Bytes out;
    Bytes row(image.width * pixel), above;
    for (std::size_t y = 0; y < image.height; ++y) {
        for (std::size_t x = 0; x < image.width; ++x)
            std::copy_n(image.bytes.data() + (y * image.width + x) * 4, pixel,
                        row.begin() + static_cast<std::ptrdiff_t>(x * pixel));
        Bytes best;
        for (int filter = 0; filter < 5; ++filter) {
            Bytes tried = filtered(filter, row, above, pixel);
            if (best.empty() || weight(tried) < weight(best)) best = std::move(tried);
        }
        out.insert(out.end(), best.begin(), best.end());
        above = row;
    }
    return out;
}

}  // namespace

Outcome<Buffer<std::byte>> png(const Image& image) {
    return guarded([&]() -> Outcome<Buffer<std::byte>> {
        bool is_opaque = true;
        for (std::size_t i = 3; i < image.bytes.size(); i += 4) is_opaque = is_opaque && image.bytes[i] == 255;
        const Bytes rows = filtered_rows(image, is_opaque ? 3 : 4);
        uLongf size = compressBound(static_cast<uLong>(rows.size()));
        Bytes packed(size);
        if (compress2(packed.data(), &size, rows.data(), static_cast<uLong>(rows.size()), Z_BEST_COMPRESSION) != Z_OK)
            return fail(ErrorKind::memory, "zlib could not compress the picture");
        packed.resize(size);
        Bytes out{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'}, head;
        put_number(head, static_cast<std::uint32_t>(image.width));
        put_number(head, static_cast<std::uint32_t>(image.height));
        const std::array<std::uint8_t, 5> kind{8, static_cast<std::uint8_t>(is_opaque ? 2 : 6), 0, 0, 0};
        head.insert(head.end(), kind.begin(), kind.end());
        put_chunk(out, "IHDR", head);
        put_chunk(out, "IDAT", packed);
        put_chunk(out, "IEND", {});
        Buffer<std::byte> bytes(out.size());
        std::memcpy(bytes.data(), out.data(), out.size());
        return bytes;
    });
}

}  // namespace camber
