module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>
export module camber.crossing:ray;
import camber.core;
import camber.bezier;
import :facet;
import :net;
import :parabola;
import :planar;
import :straight;

/// Signed intersections of a ray along an axis with facets, certified: how often a closed boundary winds around the
/// ray's start.
namespace camber {

/// A ray along an axis.
template <int D>
struct Ray {
    Vec<D> start;
    int axis = 0;
    int sign = 1;  ///< towards rising coordinates, or −1
};

/// Intersections of a ray with one facet or several, beyond a range of distances. Distances are of model units.
struct RayHits {
    int count = 0;   ///< hits from the inner side minus hits from the outer side
    int pieces = 0;  ///< parts of facets that were hit
    double nearest = std::numeric_limits<double>::infinity(), farthest = 0;  ///< bounds of their distances
    double before = 0;  ///< everything nearer than the range is nearer than this, too
    bool certain = true;

    friend RayHits operator+(const RayHits& a, const RayHits& b) {
        return {a.count + b.count,
                a.pieces + b.pieces,
                std::min(a.nearest, b.nearest),
                std::max(a.farthest, b.farthest),
                std::max(a.before, b.before),
                a.certain && b.certain};
    }
};

/// Signed number of times that the piece, seen along the axis, covers the origin; none where the origin is too near to
/// its rim to tell. Positive: the piece's normal has a positive component along the axis.
[[nodiscard]] inline std::optional<int> covers_origin(const Net<2>& net, int axis) {
    const int other = 1 - axis;
    std::array<int, 2> side{};
    for (int i = 0; i < 2; ++i) {
        const double x = net.control[i][other];
        if (std::abs(x) <= 8 * coordinate_blur) return {};
        side[i] = x > 0 ? 1 : -1;
    }
    return (axis == 0 ? 1 : -1) * (side[1] - side[0]) / 2;
}
[[nodiscard]] inline std::optional<int> covers_origin(const Net<3>& net, int axis) {
    return turns_about(shadow_of(net, axis), Vec<2>{});
}

/// The normal of the straight facet: outwards, times its length or twice its area.
[[nodiscard]] inline Vec<2> straight_normal(const Net<2>& net) {
    const Vec<2> along = net.control[1] - net.control[0];
    return {{along[1], -along[0]}};
}
[[nodiscard]] inline Vec<3> straight_normal(const Net<3>& net) {
    return cross(net.control[1] - net.control[0], net.control[2] - net.control[0]);
}

/// A range of distances from the start of a ray (model units).
struct RayRange {
    double low = 0, high = 0;
};

/// Certified intersections of a ray with facets.
template <int D>
class RayCaster {
  public:
    explicit RayCaster(const Ray<D>& ray) : ray_(ray) {}

    /// Hits beyond the range. Curved facets are divided until each piece is beside the ray, nearer than the range, or
    /// beyond it and smaller than `resolution`.
    [[nodiscard]] RayHits hits(const NodalFacet<D>& facet, const RayRange& range = {},
                               double resolution = std::numeric_limits<double>::infinity()) const {
        const auto unit = unit_for(facet, facet, ray_.start);
        if (!unit) return uncertain();
        const Net<D> net = net_of(facet, ray_.start, *unit);
        if (is_straight(facet)) return hits_straight(net, *unit, range);
        RayHits sum;
        std::vector<Net<D>> open{net};
        for (std::size_t looked = 0; !open.empty(); ++looked) {
            const Net<D> piece = open.back();
            open.pop_back();
            const bool can_divide = piece.divisions < max_divisions && looked < max_pieces;
            const Piece seen = look_at(piece, *unit, range);
            if (seen.is_divided || (seen.hits.pieces > 0 && can_divide && seen.extent > resolution)) {
                if (!can_divide) return uncertain();
                const auto parts = pieces(piece);
                open.insert(open.end(), parts.begin(), parts.end());
            } else {
                sum = sum + seen.hits;
            }
        }
        return sum;
    }

  private:
    static constexpr double blur = 8 * coordinate_blur;
    static constexpr std::size_t max_pieces = 600;

    /// The hits of a piece as a whole, if they can be told without dividing it.
    struct Piece {
        RayHits hits = {};
        double extent = 0;  ///< along the ray (model units)
        bool is_divided = false;
    };

    [[nodiscard]] static RayHits uncertain() {
        RayHits hits;
        hits.certain = false;
        return hits;
    }

    /// Hits of a piece between these distances that covers the ray so often.
    [[nodiscard]] RayHits hits_at(int covered, double low, double high) const {
        RayHits hits;
        hits.count = ray_.sign * covered;
        hits.pieces = 1;
        hits.nearest = low;
        hits.farthest = high;
        return hits;
    }
    [[nodiscard]] static RayHits hits_before(double high) {
        RayHits hits;
        hits.before = high;
        return hits;
    }

    [[nodiscard]] Piece look_at(const Net<D>& net, double unit, const RayRange& range) const {
        const Box<D> box = box_of(net);
        for (int c = 0; c < D; ++c)
            if (c != ray_.axis && (box.low[c] > blur || box.high[c] < -blur)) return {};
        const double first = box.low[ray_.axis], last = box.high[ray_.axis];
        const double low = ((ray_.sign > 0 ? first : -last) - blur) / unit;
        const double high = ((ray_.sign > 0 ? last : -first) + blur) / unit;
        if (high < range.low) return {hits_before(high)};
        if (!(low > range.high)) return {.is_divided = true};
        const auto covered = covers_origin(net, ray_.axis);
        if (!covered) return {.is_divided = true};
        if (*covered == 0) return {};
        return {hits_at(*covered, low, high), high - low};
    }

    /// The facet's plane meets the ray at one distance, (n · a)/(n · d).
    [[nodiscard]] RayHits hits_straight(const Net<D>& net, double unit, const RayRange& range) const {
        const Piece whole = look_at(net, unit, range);
        if (!whole.is_divided && whole.hits.pieces == 0) return whole.hits;
        const auto covered = covers_origin(net, ray_.axis);
        if (!covered) return uncertain();
        if (*covered == 0) return {};
        const Vec<D> n = straight_normal(net);
        // Coordinates are below 1 and err by a few of their last bits: products and sums of them by less than this.
        constexpr double error = 4 * coordinate_blur;
        const double slope = std::abs(n[ray_.axis]) - error;
        if (!(slope > 0)) return whole.is_divided ? uncertain() : whole.hits;
        const double at = dot(n, net.control[0]) / n[ray_.axis] * ray_.sign;
        const double off = (2 * error + std::abs(at) * error) / slope;
        const double low = (at - off) / unit, high = (at + off) / unit;
        if (high < range.low) return hits_before(high);
        return low > range.high ? hits_at(*covered, low, high) : uncertain();
    }

    Ray<D> ray_;
};

}  // namespace camber
