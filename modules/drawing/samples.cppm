module;
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>
module camber.drawing:samples;
import camber.core;
import :drawn_face;
import :scene;
import :subdivision;

/// Which patch is nearest at each sample of a strip of paper.
namespace camber {

/// Samples a pixel along each axis.
constexpr std::size_t samples_per_pixel = 3;

/// Rows [first, last) of pixels, all of the paper's width.
struct Strip {
    std::size_t width, first, last;
    [[nodiscard]] std::size_t columns() const { return width * samples_per_pixel; }
    [[nodiscard]] std::size_t rows() const { return (last - first) * samples_per_pixel; }
};

/// Where on its patch a sample lies, and how fast the patch's coordinates change there (per pixel).
struct Hit {
    const DrawnFace& patch;
    FacePoint xi;
    std::array<double, 3> slopes;  ///< |∇ξ_i|
};

/// A flat triangle on paper with what interpolation needs.
struct FlatTriangle {
    std::array<SmallCorner, 3> c;
    double twice;  ///< its area with sign, positive where it turns counter-clockwise to the viewer

    FlatTriangle(const SmallCorner& a, const SmallCorner& b, const SmallCorner& d) : c{a, b, d}, twice(0) {
        const Vec<3> u = b.point - a.point, v = d.point - a.point;
        twice = v[0] * u[1] - v[1] * u[0];
    }
    /// The barycentric coordinates of a place.
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

/// The samples from `low` to `high` (pixels) of a row or column of `count`.
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

/// hit(sample, Hit) for each sample of the strip that a patch covers and that is nearer than all before.
class DepthBuffer {
  public:
    explicit DepthBuffer(const Strip& strip)
        : strip_(strip), depths_(strip.columns() * strip.rows(), -std::numeric_limits<double>::infinity()) {}

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
        constexpr double s = samples_per_pixel, slack = -1e-7;  // a little of each neighbour's, so that no gap opens
        Box<3> box;
        for (const SmallCorner& corner : t.c) box.include(corner.point);
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
    std::vector<double> depths_;
    Subdivision subdivision_;
};

}  // namespace camber
