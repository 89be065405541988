// Draws scenes as pixels: divides faces into flat triangles and samples them with a depth buffer.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.drawing;
import camber.core;

namespace camber {

namespace {

// Division of a face into flat triangles.

/// Maximum distance in pixels between a curved edge and its chords, and maximum number of chords for an edge.
constexpr double chord_error = 0.05;
constexpr std::size_t max_pieces = 64;

/// Number of chords of an edge. If its mid node is d away from the chord's midpoint, n chords deviate from it by at
/// most d/n². The number is a power of two, so that points of a coarser division belong to finer ones.
inline std::size_t pieces_of_edge(const DrawnFace& patch, std::size_t edge) {
    const Vec<3> chord = midpoint(patch.nodes[edge], patch.nodes[(edge + 1) % 3]);
    const double ideal_count = std::sqrt(distance(patch.nodes[3 + edge], chord) / chord_error);
    std::size_t n = 1;
    while (n < max_pieces && static_cast<double>(n) < ideal_count) n *= 2;
    return n;
}

struct SmallCorner {
    FacePoint xi;
    Vec<3> point;
};

/// Divides a face into flat triangles. The corners of these triangles on an edge of the face depend only on the edge.
/// So no gap opens between the face and its neighbour.
class Subdivision {
  public:
    void cut(const DrawnFace& patch) {
        std::array<std::size_t, 3> pieces{};
        n_ = 1;
        for (std::size_t e = 0; e < 3; ++e) {
            pieces[e] = pieces_of_edge(patch, e);
            n_ = std::max(n_, pieces[e]);
        }
        corners_.clear();
        for (std::size_t j = 0; j <= n_; ++j)
            for (std::size_t i = 0; i + j <= n_; ++i) {
                const std::array<std::size_t, 3> lattice{n_ - i - j, i, j};
                FacePoint xi{};
                for (std::size_t k = 0; k < 3; ++k) xi[k] = static_cast<double>(lattice[k]) / static_cast<double>(n_);
                corners_.push_back({xi, on_paper(patch, pieces, lattice, xi)});
            }
    }
    template <class Visit>
    void each_triangle(Visit&& visit) const {
        for (std::size_t j = 0; j < n_; ++j)
            for (std::size_t i = 0; i + j < n_; ++i) {
                visit(at(i, j), at(i + 1, j), at(i, j + 1));
                if (i + j + 1 < n_) visit(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            }
    }

  private:
    [[nodiscard]] const SmallCorner& at(std::size_t i, std::size_t j) const {
        // Index of corner (i, j): row j has n + 1 − j corners.
        return corners_[j * (n_ + 1) - (j * j - j) / 2 + i];
    }
    [[nodiscard]] Vec<3> on_paper(const DrawnFace& patch, const std::array<std::size_t, 3>& pieces,
                                  const std::array<std::size_t, 3>& lattice, const FacePoint& xi) const {
        for (std::size_t e = 0; e < 3; ++e) {
            if (lattice[(e + 2) % 3] != 0 || pieces[e] == n_) continue;
            const std::size_t stride = n_ / pieces[e], along = lattice[(e + 1) % 3];
            const std::size_t before = along / stride * stride;
            if (before == along) break;
            const double t = static_cast<double>(along - before) / static_cast<double>(stride);
            return (1 - t) * on_edge(patch, e, before) + t * on_edge(patch, e, before + stride);
        }
        return point_at(patch.nodes, xi);
    }
    [[nodiscard]] Vec<3> on_edge(const DrawnFace& patch, std::size_t edge, std::size_t along) const {
        FacePoint xi{};
        xi[(edge + 1) % 3] = static_cast<double>(along) / static_cast<double>(n_);
        xi[edge] = 1 - xi[(edge + 1) % 3];
        return point_at(patch.nodes, xi);
    }

    std::size_t n_ = 1;
    std::vector<SmallCorner> corners_;
};

// Depth buffer: finds the nearest face at each sample of a strip of the picture.

constexpr std::size_t samples_per_pixel = 3;

struct Strip {
    std::size_t width, first, last;
    [[nodiscard]] std::size_t columns() const { return width * samples_per_pixel; }
    [[nodiscard]] std::size_t rows() const { return (last - first) * samples_per_pixel; }
};

/// A sample on a face, with its barycentric coordinates ξ_i.
struct Hit {
    const DrawnFace& patch;
    FacePoint xi;
    std::array<double, 3> slopes;  ///< |∇ξ_i| (per pixel)
};

struct FlatTriangle {
    std::array<SmallCorner, 3> c;
    double twice;  ///< twice the signed area, positive if counter-clockwise for the viewer

    FlatTriangle(const SmallCorner& a, const SmallCorner& b, const SmallCorner& d) : c{a, b, d}, twice(0) {
        const Vec<3> u = b.point - a.point, v = d.point - a.point;
        twice = v[0] * u[1] - v[1] * u[0];
    }
    [[nodiscard]] std::array<double, 3> barycentric(double x, double y) const {
        std::array<double, 3> b{};
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec<3>&p = c[(k + 1) % 3].point, &q = c[(k + 2) % 3].point;
            b[k] = ((q[0] - x) * (p[1] - y) - (q[1] - y) * (p[0] - x)) / twice;
        }
        return b;
    }
    [[nodiscard]] std::array<double, 3> slopes() const {
        std::array<double, 3> lengths{};
        for (std::size_t i = 0; i < 3; ++i) {
            double gx = 0, gy = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec<3>&p = c[(k + 1) % 3].point, &q = c[(k + 2) % 3].point;
                gx += c[k].xi[i] * (q[1] - p[1]) / twice;
                gy += c[k].xi[i] * (p[0] - q[0]) / twice;
            }
            lengths[i] = std::sqrt(gx * gx + gy * gy);
        }
        return lengths;
    }
};

struct SampleRange {
    std::size_t begin, end;
};
inline SampleRange samples_between(double low, double high, std::size_t first, std::size_t count) {
    const double s = static_cast<double>(samples_per_pixel), origin = static_cast<double>(first * samples_per_pixel);
    const double begin = std::ceil(low * s - 0.5 - origin), end = std::floor(high * s - 0.5 - origin) + 1;
    const auto clamped = [&](double x) {
        return static_cast<std::size_t>(std::fmin(std::fmax(x, 0), static_cast<double>(count)));
    };
    return {clamped(begin), clamped(end)};
}

/// Draws faces one after the other. Calls hit(sample, Hit) for each sample at which the face is nearer than all earlier
/// ones.
class DepthBuffer {
  public:
    DepthBuffer(const Strip& strip, const std::optional<PaperFrame>& clip)
        : strip_(strip), depths_(strip.columns() * strip.rows(), -std::numeric_limits<double>::infinity()) {
        if (!clip) return;
        low_ = {clip->left, clip->top};
        high_ = {clip->left + clip->width, clip->top + clip->height};
    }

    template <class OnHit>
    void draw(const DrawnFace& patch, VisibleSides sides, OnHit&& hit) {
        subdivision_.cut(patch);
        subdivision_.each_triangle([&](const SmallCorner& a, const SmallCorner& b, const SmallCorner& c) {
            const FlatTriangle triangle(a, b, c);
            if (!(std::abs(triangle.twice) > 1e-12) || (sides == VisibleSides::outer && triangle.twice < 0)) return;
            draw(patch, triangle, hit);
        });
    }

  private:
    template <class OnHit>
    void draw(const DrawnFace& patch, const FlatTriangle& t, OnHit&& hit) {
        constexpr double s = samples_per_pixel, slack = -1e-7;  // a small overlap of adjacent triangles prevents gaps
        Box<3> box;
        for (const SmallCorner& corner : t.c) box.include(corner.point);
        for (int axis = 0; axis < 2; ++axis) {
            box.low[axis] = std::fmax(box.low[axis], low_[static_cast<std::size_t>(axis)]);
            box.high[axis] = std::fmin(box.high[axis], high_[static_cast<std::size_t>(axis)]);
        }
        const SampleRange rows = samples_between(box.low[1], box.high[1], strip_.first, strip_.rows());
        const SampleRange columns = samples_between(box.low[0], box.high[0], 0, strip_.columns());
        if (rows.begin >= rows.end || columns.begin >= columns.end) return;
        const std::array<double, 3> slopes = t.slopes();
        for (std::size_t row = rows.begin; row < rows.end; ++row)
            for (std::size_t column = columns.begin; column < columns.end; ++column) {
                const double x = (static_cast<double>(column) + 0.5) / s;
                const double y = (static_cast<double>(strip_.first * samples_per_pixel + row) + 0.5) / s;
                const std::array<double, 3> b = t.barycentric(x, y);
                if (b[0] < slack || b[1] < slack || b[2] < slack) continue;
                const double z = b[0] * t.c[0].point[2] + b[1] * t.c[1].point[2] + b[2] * t.c[2].point[2];
                double& depth = depths_[row * strip_.columns() + column];
                if (!(z > depth)) continue;
                depth = z;
                FacePoint xi{};
                for (std::size_t k = 0; k < 3; ++k)
                    for (std::size_t i = 0; i < 3; ++i) xi[i] += b[k] * t.c[k].xi[i];
                hit(row * strip_.columns() + column, Hit{patch, xi, slopes});
            }
    }

    Strip strip_;
    std::array<double, 2> low_{-HUGE_VAL, -HUGE_VAL}, high_{HUGE_VAL, HUGE_VAL};
    std::vector<double> depths_;
    Subdivision subdivision_;
};

constexpr std::size_t rows_of_a_strip = 16;

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
    // The number is limited before its conversion to an integer, because with a strong zoom faces extend far below the
    // paper.
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

/// Finds the nearest face at each sample of a strip. Stores `of(hit)` for the sample, or `none` if there is no face.
/// Then calls finish(strip, samples).
template <class Sample, class Of, class Finish>
Outcome<Done> each_strip(const Scene& scene, const Execution& execution, const Sample& none, Of&& of, Finish&& finish) {
    return guarded([&]() -> Outcome<Done> {
        const Strips strips = sorted_into_strips(scene);
        return each(
            execution, strips.count,
            [&](std::size_t s) {
                const std::size_t first = s * rows_of_a_strip;
                const Strip strip{scene.options.width, first, std::min(first + rows_of_a_strip, scene.options.height)};
                DepthBuffer depths(strip, scene.clip);
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
    double width_;
};

struct Sample {
    Colour colour;
    bool is_covered = false;
};

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
        std::vector<std::vector<std::uint32_t>> sampled(count);
        auto done = each_strip<std::uint32_t>(
            scene, execution, none, [](const Hit& hit) { return hit.patch.face; },
            [&](const Strip& strip, std::vector<std::uint32_t>& samples) {
                std::sort(samples.begin(), samples.end());
                samples.erase(std::unique(samples.begin(), samples.end()), samples.end());
                if (!samples.empty() && samples.back() == none) samples.pop_back();
                sampled[strip.first / rows_of_a_strip] = std::move(samples);
            });
        if (!done) return fail(done.error());
        Buffer<std::uint32_t> all;
        for (const auto& part : sampled) all.insert(all.end(), part.begin(), part.end());
        std::sort(all.begin(), all.end());
        all.erase(std::unique(all.begin(), all.end()), all.end());
        return all;
    });
}

}  // namespace camber
