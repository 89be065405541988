// Location of points in straight back meshes.
module;
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>
module camber.metric;
import camber.core;

namespace camber {

namespace {

template <int D>
int lowest(const Barycentrics<D>& xi) {
    return static_cast<int>(std::min_element(xi.begin(), xi.end()) - xi.begin());
}

constexpr int short_walk = 64;
constexpr unsigned long_walk = 100000;

/// Walks from `start` to neighbouring elements until x is inside one. The walk crosses the face opposite the vertex
/// with the smallest barycentric coordinate ξ_i of x. Returns `lost` outside the mesh or after too many steps.
template <int D>
Location<D> walk(const StraightBack<D>& back, const Vec<D>& x, ElementId start) {
    Location<D> last{
        .element = start.valid() ? start : ElementId(std::size_t{0}), .xi = {}, .placement = Placement::lost};
    last.xi.fill(1.0 / (D + 1));
    ElementId at = start;
    for (int step = 0; step < short_walk && at.valid(); ++step) {
        const ElementFrame<D> frame(back.mesh, at);
        const Barycentrics<D> xi = frame.barycentrics(x);
        if (xi[lowest<D>(xi)] >= -frame.tolerance()) return {at, xi, Placement::inside};
        // The mesh need not be convex. If the face opposite the vertex with the smallest ξ_i is on the boundary, the
        // walk crosses another face whose opposite vertex has a negative ξ_i.
        ElementId next;
        double least = 0;
        for (int i = 0; i <= D; ++i) {
            if (!(xi[i] < -frame.tolerance()) || !back.neighbours[at][i].valid() || xi[i] >= least) continue;
            next = back.neighbours[at][i];
            least = xi[i];
        }
        at = next;
    }
    return last;
}

/// Walks along the segment from the point `from`, in the element `start`, to x. If rounding errors stop the walk, the
/// result is `lost`, in the visited element for which the smallest barycentric coordinate of x is largest.
template <int D>
Location<D> walk_along(const StraightBack<D>& back, const Vec<D>& from, const Vec<D>& x, ElementId start) {
    Location<D> best{.element = start, .xi = {}, .placement = Placement::lost};
    double best_lowest = -std::numeric_limits<double>::infinity();
    ElementId at = start;
    ElementId passed;  // element at the last step whose number is a power of two, for Brent's cycle detection: the walk
                       // may cycle if straight elements are inverted
    for (unsigned step = 0; step < long_walk && at.valid() && at != passed; ++step) {
        if (std::has_single_bit(step)) passed = at;
        const ElementFrame<D> frame(back.mesh, at);
        const Barycentrics<D> xi = frame.barycentrics(x);
        if (xi[lowest<D>(xi)] >= -frame.tolerance()) return {at, xi, Placement::inside};
        if (xi[lowest<D>(xi)] > best_lowest) {
            best_lowest = xi[lowest<D>(xi)];
            best.element = at;
            best.xi = xi;
        }
        const Barycentrics<D> xi_from = frame.barycentrics(from);
        ElementId next;
        double first = std::numeric_limits<double>::infinity();
        for (int i = 0; i <= D; ++i) {
            if (!(xi[i] < -frame.tolerance())) continue;
            const double t = xi_from[i] / (xi_from[i] - xi[i]);
            if (t >= first) continue;
            first = t;
            next = back.neighbours[at][i];
        }
        at = next;
    }
    return best;
}

inline std::array<double, 2> nearest_in_face(const std::array<Vec<2>, 2>& p, const Vec<2>& x) {
    const Vec<2> e = p[1] - p[0];
    const double t = std::clamp(dot(x - p[0], e) / norm_squared(e), 0.0, 1.0);
    return {1 - t, t};
}

inline std::array<double, 3> nearest_in_face(const std::array<Vec<3>, 3>& p, const Vec<3>& x) {
    const Vec<3> u = p[1] - p[0];
    const Vec<3> v = p[2] - p[0];
    const Vec<3> r = x - p[0];
    // The coordinates are computed with the normal n. With the Gram determinant u² v² − (u·v)², needles would lose
    // twice as many digits.
    const Vec<3> n = cross(u, v);
    const double b = dot(cross(r, v), n) / norm_squared(n);
    const double c = dot(cross(u, r), n) / norm_squared(n);
    if (b >= 0 && c >= 0 && b + c <= 1) return {1 - b - c, b, c};
    std::array<double, 3> best{};
    double best_distance = 1e300;
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        const Vec<3> e = p[j] - p[i];
        const double t = std::clamp(dot(x - p[i], e) / norm_squared(e), 0.0, 1.0);
        const double d = norm_squared(x - p[i] - t * e);
        if (d >= best_distance) continue;
        best_distance = d;
        best = {};
        best[i] = 1 - t;
        best[j] = t;
    }
    return best;
}

template <int D>
struct NearestOnBoundary {
    ElementFace face;
    std::array<double, D> xi{};
    Vec<D> point;
};

template <int D>
NearestOnBoundary<D> nearest_on_boundary(const StraightBack<D>& back, const Vec<D>& x) {
    const auto nearest = back.boundary_tree.nearest(x, [&](std::size_t f) {
        const auto p = face_points<D>(back.mesh, back.boundary[f]);
        const auto xi = nearest_in_face(p, x);
        // r is measured from a corner of the face, since the origin may be far away.
        Vec<D> r = x - p[0];
        for (int i = 1; i < D; ++i) r -= xi[i] * (p[i] - p[0]);
        return norm_squared(r);
    });
    // If squares of lengths overflow, comparisons with NaN are false and no face is found; then any face is used.
    const ElementFace face = back.boundary[nearest.item < back.boundary.size() ? nearest.item : 0];
    const auto p = face_points<D>(back.mesh, face);
    NearestOnBoundary<D> found{face, nearest_in_face(p, x), p[0]};
    for (int i = 1; i < D; ++i) found.point += found.xi[i] * (p[i] - p[0]);
    return found;
}

/// Returns the element at the nearest boundary point that the segment from this point to x enters; none if x is outside
/// the mesh. The element of the nearest face may be the wrong one if the point is on an edge or vertex, so all elements
/// there are tested.
template <int D>
ElementId element_towards(const StraightBack<D>& back, const NearestOnBoundary<D>& nearest, const Vec<D>& x) {
    const auto& corner = back.mesh.elements.vertices[nearest.face.element];
    const auto local = face_opposite<D>(static_cast<int>(nearest.face.opposite));
    std::array<VertexId, D> support;
    int n = 0;
    for (int i = 0; i < D; ++i)
        if (nearest.xi[i] > 0) support[n++] = corner[local[i]];
    const auto supports = [&](VertexId v) {
        return std::find(support.begin(), support.begin() + n, v) != support.begin() + n;
    };
    std::vector<ElementId> star{nearest.face.element};
    for (std::size_t k = 0; k < star.size(); ++k) {
        const ElementId e = star[k];
        const ElementFrame<D> frame(back.mesh, e);
        const Barycentrics<D> xi = frame.barycentrics(x);
        bool faces = true;
        for (int i = 0; i <= D; ++i) {
            if (supports(back.mesh.elements.vertices[e][i])) continue;
            faces = faces && xi[i] >= -frame.tolerance();
            const ElementId next = back.neighbours[e][i];
            if (next.valid() && std::find(star.begin(), star.end(), next) == star.end()) star.push_back(next);
        }
        if (faces) return e;
    }
    return {};
}

template <int D>
Location<D> on_face(const NearestOnBoundary<D>& nearest) {
    Location<D> location{.element = nearest.face.element, .xi = {}, .placement = Placement::outside};
    const auto local = face_opposite<D>(static_cast<int>(nearest.face.opposite));
    for (int i = 0; i < D; ++i) location.xi[local[i]] = nearest.xi[i];
    return location;
}

template <int D>
Location<D> clamped(Location<D> location) {
    double sum = 0;
    for (double& u : location.xi) sum += u = std::max(u, 0.0);
    for (double& u : location.xi) u /= sum;
    location.placement = Placement::outside;
    return location;
}

}  // namespace

template <int D>
Location<D> StraightBack<D>::locate(const Vec<D>& p, ElementId hint) const {
    const StraightBack& back = *this;
    const ElementId start = element_or_none(mesh, hint);
    if (const auto there = at_vertex_of(mesh, start, p)) return *there;
    const Location<D> near = walk(back, p, start);
    if (near.placement == Placement::inside || boundary.empty() || !is_finite(p)) return near;
    const NearestOnBoundary<D> nearest = nearest_on_boundary(back, p);
    // No boundary is closer to p than the nearest boundary point, so the segment between them does not cross the
    // boundary.
    const ElementId last = element_towards(back, nearest, p);
    if (!last.valid()) return on_face<D>(nearest);
    const Location<D> far = walk_along(back, nearest.point, p, last);
    if (far.placement == Placement::inside) return far;
    // `element_towards` found p inside the mesh, so p is outside this element only by a rounding error.
    if (far.xi[lowest<D>(far.xi)] > -1e-6) return clamped<D>(far);
    Location<D> lost = on_face<D>(nearest);
    lost.placement = Placement::lost;
    return lost;
}

#define CAMBER_INSTANTIATE(D) template Location<D> StraightBack<D>::locate(const Vec<D>&, ElementId) const;

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
