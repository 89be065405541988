module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.drawing;
import camber.core;
import :drawn_face;
import :samples;

namespace camber {

namespace {

constexpr std::size_t rows_of_a_strip = 16;

/// The patches that each strip may show, in their order.
struct Strips {
    std::vector<std::uint32_t> offsets, patches;
    std::size_t count = 0;
    [[nodiscard]] std::span<const std::uint32_t> operator[](std::size_t strip) const {
        return {patches.data() + offsets[strip], patches.data() + offsets[strip + 1]};
    }
};

struct StripRange {
    std::size_t begin, end;
};
StripRange strips_of(const DrawnFace& patch, const PictureOptions& o, std::size_t count) {
    const Box<3> box = box_of(patch);
    if (box.high[1] < 0 || box.low[1] > static_cast<double>(o.height) || box.high[0] < 0 ||
        box.low[0] > static_cast<double>(o.width))
        return {0, 0};
    const double begin = std::floor(std::fmax(box.low[1] - 1, 0) / rows_of_a_strip);
    // What is enlarged beyond measure goes on far below the paper.
    const double end = std::fmin(std::floor((box.high[1] + 1) / rows_of_a_strip) + 1, static_cast<double>(count));
    return {static_cast<std::size_t>(begin), static_cast<std::size_t>(end)};
}

Strips sorted_into_strips(const Scene& scene) {
    Strips strips;
    strips.count = (scene.options.height + rows_of_a_strip - 1) / rows_of_a_strip;
    strips.offsets.assign(strips.count + 1, 0);
    const auto each_place = [&](auto&& visit) {
        for (std::size_t p = 0; p < scene.patches.size(); ++p) {
            const StripRange range = strips_of(scene.patches[p], scene.options, strips.count);
            for (std::size_t s = range.begin; s < range.end; ++s) visit(s, static_cast<std::uint32_t>(p));
        }
    };
    each_place([&](std::size_t s, std::uint32_t) { ++strips.offsets[s + 1]; });
    for (std::size_t s = 0; s < strips.count; ++s) strips.offsets[s + 1] += strips.offsets[s];
    strips.patches.resize(strips.offsets.back());
    std::vector<std::uint32_t> cursor(strips.offsets.begin(), strips.offsets.end() - 1);
    each_place([&](std::size_t s, std::uint32_t p) { strips.patches[cursor[s]++] = p; });
    return strips;
}

/// finish(strip, samples) for each strip, once its samples have what `of(hit)` makes of the nearest patch.
template <class Sample, class Of, class Finish>
Outcome<Done> each_strip(const Scene& scene, const Execution& execution, const Sample& none, Of&& of, Finish&& finish) {
    return guarded([&]() -> Outcome<Done> {
        const Strips strips = sorted_into_strips(scene);
        return each(
            execution, strips.count,
            [&](std::size_t s) {
                const std::size_t first = s * rows_of_a_strip;
                const Strip strip{scene.options.width, first, std::min(first + rows_of_a_strip, scene.options.height)};
                DepthBuffer depths(strip);
                std::vector<Sample> samples(strip.columns() * strip.rows(), none);
                for (const std::uint32_t p : strips[s])
                    depths.draw(scene.patches[p], scene.sides,
                                [&](std::size_t at, const Hit& hit) { samples[at] = of(hit); });
                finish(strip, samples);
            },
            1);
    });
}

class Shader {
  public:
    explicit Shader(const Scene& scene)
        : scene_(scene), theme_(theme_of(scene.options.background)), width_(line_width(scene.options, 0.8)) {}

    [[nodiscard]] Colour operator()(const Hit& hit) const {
        Colour colour = colour_of(scene_.options.colouring, value_at(hit.patch.values, hit.xi), theme_);
        if (scene_.lighting == Lighting::lit) colour = scaled(colour, brightness(hit.patch.nodes, hit.xi));
        return blend(colour, hit.patch.is_marked ? theme_.accent : theme_.line, line_at(hit));
    }

  private:
    /// How much of the line's colour there is.
    [[nodiscard]] double line_at(const Hit& hit) const {
        double most = 0;
        for (std::size_t e = 0; e < 3; ++e) {
            if (hit.patch.lines[e] == LineKind::none) continue;
            const std::size_t opposite = (e + 2) % 3;
            const double height = 1 / hit.slopes[opposite], away = hit.xi[opposite] * height;
            const double half =
                (hit.patch.lines[e] == LineKind::rim ? 1.1 : 0.5) * width_ * (hit.patch.is_marked ? 2.0 : 1.0);
            const double cover = std::clamp((half - away) * samples_per_pixel + 0.5, 0.0, 1.0);
            most = std::max(most, cover * line_opacity(height, width_, 0.85));
        }
        return most;
    }

    const Scene& scene_;
    Theme theme_;
    double width_;  ///< of lines (pixels)
};

struct Sample {
    Colour colour;
    bool is_covered = false;
};

/// The mean of a pixel's samples.
void put_pixel(const Theme& theme, bool is_transparent, std::span<const Sample> samples, std::size_t columns,
               std::size_t at, std::span<std::uint8_t, 4> pixel) {
    Colour sum;
    double covered = 0;
    for (std::size_t i = 0; i < samples_per_pixel; ++i)
        for (std::size_t j = 0; j < samples_per_pixel; ++j) {
            const Sample& s = samples[at + i * columns + j];
            if (!s.is_covered) continue;
            sum = {sum.red + s.colour.red, sum.green + s.colour.green, sum.blue + s.colour.blue};
            covered += 1;
        }
    constexpr double all = samples_per_pixel * samples_per_pixel;
    const Colour mean = covered > 0 ? scaled(sum, 1 / covered) : theme.paper;
    const Colour colour = is_transparent ? mean : blend(theme.paper, mean, covered / all);
    const std::array<double, 4> parts{colour.red, colour.green, colour.blue, is_transparent ? covered / all : 1};
    for (std::size_t c = 0; c < 4; ++c)
        pixel[c] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(parts[c], 0.0, 1.0)));
}

}  // namespace

Outcome<Image> rasterised(const Scene& scene, const Execution& execution) {
    return guarded([&]() -> Outcome<Image> {
        const PictureOptions& o = scene.options;
        Image image{o.width, o.height, Buffer<std::uint8_t>(o.width * o.height * 4)};
        const Shader shader(scene);
        const Theme theme = theme_of(o.background);
        auto done = each_strip<Sample>(
            scene, execution, {}, [&](const Hit& hit) { return Sample{shader(hit), true}; },
            [&](const Strip& strip, std::span<const Sample> samples) {
                for (std::size_t y = strip.first; y < strip.last; ++y)
                    for (std::size_t x = 0; x < o.width; ++x) {
                        const std::size_t at = ((y - strip.first) * strip.columns() + x) * samples_per_pixel;
                        put_pixel(theme, o.background == Background::transparent, samples, strip.columns(), at,
                                  std::span(image.bytes).subspan((y * o.width + x) * 4).first<4>());
                    }
            });
        if (!done) return fail(done.error());
        return image;
    });
}

Outcome<Buffer<std::uint32_t>> visible_faces(const Scene& scene, const Execution& execution) {
    return guarded([&]() -> Outcome<Buffer<std::uint32_t>> {
        constexpr std::uint32_t none = 0xffffffffU;
        const std::size_t count = (scene.options.height + rows_of_a_strip - 1) / rows_of_a_strip;
        std::vector<std::vector<std::uint32_t>> seen(count);
        auto done = each_strip<std::uint32_t>(
            scene, execution, none, [](const Hit& hit) { return hit.patch.face; },
            [&](const Strip& strip, std::vector<std::uint32_t>& samples) {
                std::sort(samples.begin(), samples.end());
                samples.erase(std::unique(samples.begin(), samples.end()), samples.end());
                if (!samples.empty() && samples.back() == none) samples.pop_back();
                seen[strip.first / rows_of_a_strip] = std::move(samples);
            });
        if (!done) return fail(done.error());
        Buffer<std::uint32_t> all;
        for (const auto& part : seen) all.insert(all.end(), part.begin(), part.end());
        std::sort(all.begin(), all.end());
        all.erase(std::unique(all.begin(), all.end()), all.end());
        return all;
    });
}

}  // namespace camber
