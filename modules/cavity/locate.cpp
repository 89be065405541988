module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
module camber.cavity;
import camber.core;
import :orientation;

namespace camber {

namespace {

/// How a point lies to an element: on which side of each face (positive: that of the element), and its barycentric
/// coordinates to rounding.
template <int D>
struct Sides {
    std::array<int, D + 1> signs{};
    std::array<double, D + 1> shares{};
    bool is_flat = false;  ///< the element, or inverted: nothing lies in it

    [[nodiscard]] bool is_inside() const {
        return !is_flat && std::ranges::all_of(signs, [](int sign) { return sign >= 0; });
    }
    [[nodiscard]] double least() const { return *std::ranges::min_element(shares); }
};

template <int D>
class Locating {
  public:
    Locating(const DynamicMesh<D>& mesh, const Vec<D>& point, double near)
        : mesh_(mesh), point_(point), near_(std::clamp(near, 0.0, 0.1)) {}

    [[nodiscard]] std::optional<PointSite<D>> walk(ElementId from) const {
        // In a mesh that is not Delaunay a walk may go round in circles: it begins at another face each time, and ends.
        const std::size_t most = 64 + mesh_.elements.size();
        for (std::size_t step = 0; step < most; ++step) {
            const Sides<D> sides = sides_of(from);
            if (sides.is_inside()) return site(from, sides);
            ElementId next;
            for (std::size_t i = 0; i <= D && !next.valid(); ++i)
                if (const auto face = static_cast<int>((spread_rank(ElementId(step)) + i) % (D + 1));
                    sides.signs[face] < 0)
                    next = element_across(mesh_, from, face);
            if (!next.valid()) return is_near(sides) ? std::optional(site(from, sides)) : std::nullopt;
            from = next;
        }
        return {};
    }
    /// The element that the point is in, or farthest in.
    [[nodiscard]] std::optional<PointSite<D>> scan() const {
        std::optional<PointSite<D>> best;
        double least = -std::numeric_limits<double>::infinity();
        for (std::size_t e = 0; e < mesh_.elements.size(); ++e) {
            if (mesh_.is_free(ElementId(e))) continue;
            const Sides<D> sides = sides_of(ElementId(e));
            if (sides.is_inside()) return site(ElementId(e), sides);
            if (!is_near(sides) || !(sides.least() > least)) continue;
            least = sides.least();
            best = site(ElementId(e), sides);
        }
        return best;
    }

  private:
    [[nodiscard]] Sides<D> sides_of(ElementId e) const {
        std::array<Vec<D>, D + 1> corners;
        for (int i = 0; i <= D; ++i) corners[i] = mesh_.points[mesh_.elements.vertices[e][i]];
        const double volume = exactly_signed_volume<D>(corners).volume;
        Sides<D> sides;
        sides.is_flat = !(volume > 0);
        for (int i = 0; i <= D; ++i) {
            const Vec<D> own = corners[i];
            corners[i] = point_;
            const ExactlySigned part = exactly_signed_volume<D>(corners);
            corners[i] = own;
            sides.signs[i] = part.sign;
            sides.shares[i] = part.volume / volume;
        }
        return sides;
    }
    [[nodiscard]] bool is_near(const Sides<D>& sides) const { return !sides.is_flat && sides.least() >= -near_; }
    [[nodiscard]] PointSite<D> site(ElementId e, const Sides<D>& sides) const {
        PointSite<D> out{e, {}};
        for (int i = 0; i <= D; ++i) out.spans[i] = sides.signs[i] > 0 && sides.shares[i] > near_;
        return out;
    }

    const DynamicMesh<D>& mesh_;
    const Vec<D>& point_;
    double near_;
};

template <int D>
std::string text_of(const Vec<D>& point) {
    std::string text;
    for (const double x : point.c) text += (text.empty() ? "(" : ", ") + std::to_string(x);
    return text + ")";
}

}  // namespace

template <int D>
Outcome<PointSite<D>> locate(const DynamicMesh<D>& mesh, const Vec<D>& point, ElementId hint, double near) {
    if (!std::ranges::all_of(point.c, [](double x) { return std::isfinite(x); }))
        return fail(ErrorKind::input, "the point " + text_of(point) + " has a coordinate that is no number");
    const std::size_t n = mesh.elements.size();
    std::size_t from = hint.valid() && hint.index() < n ? hint.index() : 0;
    while (from < n && mesh.is_free(ElementId(from))) ++from;
    const Locating<D> locating(mesh, point, near);
    std::optional<PointSite<D>> found;
    if (from < n) found = locating.walk(ElementId(from));
    if (!found) found = locating.scan();
    if (!found) return fail(ErrorKind::input, "the point " + text_of(point) + " is not in the mesh");
    return *found;
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<PointSite<D>> locate<D>(const DynamicMesh<D>&, const Vec<D>&, ElementId, double);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
