// Location of points in curved meshes.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
#include <vector>
module camber.metric;
import camber.core;
import camber.box_tree;

namespace camber {

namespace {

template <int D, class Simplex>
Outcome<BoxTree<D>> tree_of(std::size_t n, const Execution& execution, const Simplex& simplex) {
    auto boxes = map_each(execution, n, [&](std::size_t i) { return simplex(i).box(); });
    if (!boxes) return fail(boxes.error());
    return guarded([&]() -> Outcome<BoxTree<D>> { return BoxTree<D>(*boxes); });
}

}  // namespace

template <int D>
ElementId CurvedLocator<D>::hint_for(const Vec<D>& p) const {
    ElementId hint;
    element_tree.containing(p, [&](std::size_t e) {
        if (!hint.valid() && curved_element(mesh, ElementId(e)).box().contains(p)) hint = ElementId(e);
    });
    return hint;
}

template <int D>
Outcome<CurvedLocator<D>> make_curved_locator(QuadraticMesh<D> mesh, const Incidence<ElementId>& balls,
                                              const Execution& execution) {
    CurvedLocator<D> locator;
    auto across = neighbours(mesh.linear, balls, part_of(execution, 0, 0.5));
    if (!across) return fail(across.error());
    locator.neighbours = std::move(*across);
    locator.boundary = boundary_faces<D>(locator.neighbours);
    locator.mesh = std::move(mesh);
    auto elements = tree_of<D>(locator.mesh.linear.elements.size(), part_of(execution, 0.5, 0.8),
                               [&](std::size_t e) { return curved_element(locator.mesh, ElementId(e)); });
    if (!elements) return fail(elements.error());
    locator.element_tree = std::move(*elements);
    auto faces = tree_of<D>(locator.boundary.size(), part_of(execution, 0.8, 1),
                            [&](std::size_t f) { return curved_face(locator.mesh, locator.boundary[f]); });
    if (!faces) return fail(faces.error());
    locator.boundary_tree = std::move(*faces);
    return locator;
}

namespace {

/// Newton's method ends if a step is below `negligible_step`, or if two successive steps are below `small_step`. The
/// remaining error is the square of the step times a factor. In thin curved layers it is their bow over their height.
constexpr double small_step = 1e-6, negligible_step = 1e-9;
constexpr int max_steps = 12;

template <int D>
double largest(const Vec<D>& v) {
    double most = 0;
    for (const double x : v.c) most = std::max(most, std::abs(x));
    return most;
}

template <int D>
Vec<D> rounding(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Barycentrics<D>& xi) {
    Vec<D> bound;
    for (int c = 0; c < D; ++c) {
        double size = std::abs(r[c]);
        for (int i = 1; i <= D; ++i) size += std::abs(xi[i] * element.d[i][c]);
        for (int e = 0; e < edges_per_simplex<D>; ++e) {
            const auto [i, j] = local_edges<D>[e];
            size += std::abs(edge_shape<D>(xi, e)) *
                    (std::abs(element.u[e][c]) + std::abs(element.d[i][c]) + std::abs(element.d[j][c]));
        }
        bound[c] = 8 * std::numeric_limits<double>::epsilon() * size;
    }
    return bound;
}

/// Scaled coordinates z of a step in ξ: δξ = B z. In z, thin and bent elements are well proportioned
/// (docs/algorithms/back-mesh-location.md). Q is an orthonormal frame whose first axis is the thinnest direction of the
/// element. W is the diagonal matrix of the units of z along these axes.
template <int D>
struct Scaled {
    Mat<D> b;                      ///< B ≈ J⁻¹ Q W (J: Jacobian of the element)
    Mat<D> p;                      ///< P = W⁻¹ Qᵀ, which transforms the residual r − F(ξ)
    std::array<Mat<D>, D> second;  ///< [k]: second derivatives of coordinate k of P F by z
};
template <int D>
Mat<D> frame_along(const Vec<D>& direction) {
    Mat<D> q;
    q.column[0] = normalised(direction);
    const Vec<D>& n = q.column[0];
    if constexpr (D == 2) {
        q.column[1] = {{-n[1], n[0]}};
    } else {
        int least = 0;
        for (int c = 1; c < D; ++c)
            if (std::abs(n[c]) < std::abs(n[least])) least = c;
        Vec<D> axis;
        axis[least] = 1;
        q.column[1] = normalised(cross(n, axis));
        q.column[2] = cross(n, q.column[1]);
    }
    return q;
}
template <int D>
Scaled<D> scaled_at(const CurvedSimplex<D, D>& element, const Mat<D>& inverse) {
    Vec<D> steepest;
    for (int i = 0; i < D; ++i) {
        Vec<D> row;
        for (int c = 0; c < D; ++c) row[c] = inverse(i, c);
        if (norm_squared(row) > norm_squared(steepest)) steepest = row;
    }
    const Mat<D> q = frame_along<D>(steepest);
    const Mat<D> steps = inverse * q;
    const auto second = element.second();
    const auto bend = [&](const Vec<D>& x, const Vec<D>& y) {
        Vec<D> sum;
        for (int a = 0; a < D; ++a)
            for (int b = 0; b < D; ++b) sum += (x[a] * y[b]) * second[a][b];
        return sum;
    };
    Vec<D> w;
    w[0] = 1 / norm(steepest);
    for (int k = 1; k < D; ++k) {
        const double whole = 1 / largest(steps.column[k]);  // length of the element along axis k
        const double off = std::abs(dot(q.column[0], bend(whole * steps.column[k], whole * steps.column[k])));
        w[k] = off > w[0] ? whole * std::sqrt(w[0] / off) : whole;
    }
    Scaled<D> s;
    for (int k = 0; k < D; ++k) {
        s.b.column[k] = w[k] * steps.column[k];
        for (int c = 0; c < D; ++c) s.p(k, c) = q.column[k][c] / w[k];
    }
    for (int a = 0; a < D; ++a)
        for (int b = 0; b < D; ++b) {
            const Vec<D> h = s.p * bend(s.b.column[a], s.b.column[b]);
            for (int k = 0; k < D; ++k) s.second[k](a, b) = h[k];
        }
    return s;
}

template <int D>
double largest_row(const Mat<D>& m) {
    double most = 0;
    for (int i = 0; i < D; ++i) {
        double sum = 0;
        for (int j = 0; j < D; ++j) sum += std::abs(m(i, j));
        most = std::max(most, sum);
    }
    return most;
}

template <int D>
struct Part {
    std::array<Barycentrics<D>, D + 1> corners{};
    int depth = 0;

    [[nodiscard]] Barycentrics<D> centre() const {
        Barycentrics<D> c{};
        for (const auto& corner : corners)
            for (int i = 0; i <= D; ++i) c[i] += corner[i] / (D + 1);
        return c;
    }
    [[nodiscard]] bool is_within(const Barycentrics<D>& xi, double radius) const {
        return std::ranges::all_of(corners, [&](const Barycentrics<D>& corner) {
            for (int i = 1; i <= D; ++i)
                if (!(std::abs(corner[i] - xi[i]) < radius)) return false;
            return true;
        });
    }
    [[nodiscard]] std::array<Part, 2> halves() const {
        int from = 0, to = 1;
        double longest = -1;
        for (const auto& [i, j] : local_edges<D>) {
            double length = 0;
            for (int k = 0; k <= D; ++k) length += (corners[j][k] - corners[i][k]) * (corners[j][k] - corners[i][k]);
            if (length > longest) {
                longest = length;
                from = i;
                to = j;
            }
        }
        std::array<Part, 2> out{*this, *this};
        Barycentrics<D> middle{};
        for (int k = 0; k <= D; ++k) middle[k] = 0.5 * (corners[from][k] + corners[to][k]);
        out[0].corners[to] = out[1].corners[from] = middle;
        out[0].depth = out[1].depth = depth + 1;
        return out;
    }
};

/// Candidate directions for separating a point from an element: the normals of its faces, and directions normal to an
/// edge and to the thinnest direction. The latter serve thin elements, whose face normals almost coincide. `a` is the
/// inverse Jacobian.
template <int D>
auto directions_of(const Mat<D>& a, const Mat<D>& jacobian) {
    std::array<Vec<D>, D + 1 + (D == 2 ? 1 : edges_per_simplex<D>)> out{};
    Vec<D> normal;
    for (int i = 0; i < D; ++i) {
        for (int c = 0; c < D; ++c) out[i][c] = a(i, c);
        out[D] -= out[i];
        if (norm_squared(out[i]) > norm_squared(normal)) normal = out[i];
    }
    if constexpr (D == 2) {
        out[3] = {{-normal[1], normal[0]}};
    } else {
        for (int k = 0; k < edges_per_simplex<D>; ++k) {
            const auto [i, j] = local_edges<D>[k];
            out[D + 1 + k] = cross(normal, i == 0   ? jacobian.column[j - 1]
                                           : j == 0 ? jacobian.column[i - 1]
                                                    : jacobian.column[j - 1] - jacobian.column[i - 1]);
        }
    }
    return out;
}

template <int D>
bool misses(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Part<D>& part, const Mat<D>& a,
            const Mat<D>& jacobian) {
    const Vec<D> error = rounding<D>(element, r, part.centre());
    std::array<Vec<D>, (D + 1) * (D + 2) / 2> offs;
    int n = 0;
    for (int i = 0; i <= D; ++i)
        for (int j = i; j <= D; ++j) offs[n++] = element.blossom(part.corners[i], part.corners[j]) - r;
    for (const Vec<D>& direction : directions_of<D>(a, jacobian)) {
        double slack = 0, low = std::numeric_limits<double>::infinity(), high = -low;
        for (int k = 0; k < D; ++k) slack += 2 * std::abs(direction[k]) * error[k];
        for (const Vec<D>& off : offs) {
            const double side = dot(direction, off);
            low = std::min(low, side);
            high = std::max(high, side);
        }
        if (low > slack || high < -slack) return true;
    }
    return false;
}

}  // namespace

template <int D>
Root<D> proven_root(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Barycentrics<D>& xi,
                    const Mat<D>& inverse) {
    Root<D> root{.xi = xi};
    const Mat<D> jacobian = jacobian_at(element, xi);
    const Scaled<D> s = scaled_at<D>(element, inverse);
    const Vec<D> residual = s.p * (r - element.point(xi));
    const Vec<D> error = rounding<D>(element, r, xi);
    // `y` bounds |P (r − F(ξ))|, `z1` bounds |P J B − I|, and `z2` bounds the second derivatives of P F by z. If y + z1
    // ρ + z2 ρ²/2 ≤ ρ, the map T(z) = z + P (r − F(ξ + B z)) takes the ball |z| ≤ ρ into itself and contracts.
    Mat<D> product = s.p * (jacobian * s.b);
    double y = 0, z2 = 0;
    for (int k = 0; k < D; ++k) {
        product(k, k) -= 1;
        double y_k = std::abs(residual[k]), z2_k = 0;
        for (int c = 0; c < D; ++c) {
            y_k += std::abs(s.p(k, c)) * error[c];
            for (int b = 0; b < D; ++b) z2_k += std::abs(s.second[k](c, b));
        }
        y = std::max(y, y_k);
        z2 = std::max(z2, z2_k);
    }
    // `blur` bounds the rounding errors of P J B and of the second derivatives. In both sums, terms may cancel.
    constexpr double epsilon = 16 * D * D * std::numeric_limits<double>::epsilon();
    double terms = 0;
    for (int k = 0; k < D; ++k)
        for (int c = 0; c < D; ++c) {
            double column = 0;
            for (const Vec<D>& d : element.d) column += std::abs(d[c]);
            for (const Vec<D>& u : element.u) column += 8 * std::abs(u[c]);
            terms = std::max(terms, std::abs(s.p(k, c)) * column);
        }
    const double blur = epsilon * terms * largest_row<D>(s.b);
    const double z1 = largest_row<D>(product) + blur;
    z2 = (1 + epsilon) * z2 + blur * largest_row<D>(s.b);
    const double slope = 1 - z1, discriminant = slope * slope - 2 * (1 + epsilon) * y * z2;
    if (!(slope > 0) || !(discriminant > 0)) return root;
    constexpr double inflated = 1 + 1e-9;  // covers the rounding errors of the next lines
    root.is_proven = true;
    root.radius = inflated * 2 * y / (slope + std::sqrt(discriminant)) * largest_row<D>(s.b);
    const double unique = (slope + std::sqrt(discriminant)) / (inflated * z2);
    root.uniqueness = 0.99 * (1 - z1) * unique / largest_row<D>(s.p * jacobian);
    return root;
}

template <int D>
RootIterate<D> newton(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Barycentrics<D>& from) {
    RootIterate<D> at;
    at.xi = from;
    Barycentrics<D> first = from;
    for (int step = 0; step < max_steps; ++step) {
        at.inverse = inverse(jacobian_at(element, at.xi));
        const Vec<D> move = at.inverse * (r - element.point(at.xi));
        if (!is_finite(move)) break;
        at.xi = moved<D>(at.xi, move);
        if (step == 0) first = at.xi;
        const double length = largest(move);
        const bool was_small = std::exchange(at.has_converged, length < small_step);
        if (at.has_converged && (was_small || length < negligible_step || step + 1 == max_steps)) return at;
    }
    at.has_converged = false;
    at.xi = first;
    return at;
}

template <int D>
Root<D> newton_root(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Barycentrics<D>& from) {
    const RootIterate<D> at = newton<D>(element, r, from);
    return at.has_converged ? proven_root<D>(element, r, at.xi, at.inverse) : Root<D>{.xi = at.xi};
}

template <int D>
bool may_contain(const CurvedSimplex<D, D>& element, const Vec<D>& r) {
    Part<D> whole;
    for (int i = 0; i <= D; ++i) whole.corners[i][i] = 1;
    const Mat<D> jacobian = jacobian_at(element, whole.centre());
    const Mat<D> a = inverse(jacobian);
    const bool has_inverse = std::ranges::all_of(a.column, [](const Vec<D>& c) { return is_finite(c); });
    return !misses<D>(element, r, whole, has_inverse ? a : Mat<D>::identity(), jacobian);
}

template <int D>
Found<D> find_in_element(const CurvedSimplex<D, D>& element, const Vec<D>& r) {
    constexpr int max_parts = 4000, deepest = 60;
    Part<D> whole;
    for (int i = 0; i <= D; ++i) whole.corners[i][i] = 1;
    std::vector<Part<D>> parts{whole};
    Found<D> found{Membership::not_inside, {}};
    for (int visited = 0; !parts.empty(); ++visited) {
        if (visited == max_parts) return {Membership::undecided, found.root};
        const Part<D> part = parts.back();
        parts.pop_back();
        const Mat<D> jacobian = jacobian_at(element, part.centre());
        const Mat<D> a = inverse(jacobian);
        const bool has_inverse = std::ranges::all_of(a.column, [](const Vec<D>& c) { return is_finite(c); });
        if (misses<D>(element, r, part, has_inverse ? a : Mat<D>::identity(), jacobian)) continue;
        Root<D> root;
        // From the centres of a part and of its halves, Newton's method mostly finds the same solution. So it runs only
        // at every third depth.
        if (part.depth % 3 == 0) root = newton_root<D>(element, r, part.centre());
        if (root.is_inside()) return {Membership::inside, root};
        if (root.is_proven && part.is_within(root.xi, root.uniqueness)) continue;
        if (part.depth == deepest) {
            found.membership = Membership::undecided;
            found.root = root;
            continue;
        }
        const auto halves = part.halves();
        parts.insert(parts.end(), halves.begin(), halves.end());
    }
    return found;
}

namespace {

constexpr int short_walk = 16;

template <int D>
Barycentrics<D> centre() {
    Barycentrics<D> xi{};
    xi.fill(1.0 / (D + 1));
    return xi;
}

template <int D>
Location<D> at_root(ElementId e, const Root<D>& root) {
    return {.element = e, .xi = root.xi, .placement = Placement::inside};
}

/// Walks from `start` to neighbouring elements until p is proven inside one. Newton's method computes the coordinates ξ
/// of p in the current element. The walk crosses the face opposite the vertex with the smallest ξ. Returns `lost`
/// outside the mesh or after too many steps.
template <int D>
Location<D> walk(const CurvedLocator<D>& back, const Vec<D>& p, ElementId start) {
    Location<D> located{
        .element = start.valid() ? start : ElementId(std::size_t{0}), .xi = centre<D>(), .placement = Placement::lost};
    ElementId at = start, before;
    for (int step = 0; step < short_walk && at.valid(); ++step) {
        const auto element = curved_element(back.mesh, at);
        const Vec<D> r = p - element.origin;
        const RootIterate<D> root = newton<D>(element, r, centre<D>());
        constexpr double near = 1e-3;
        if (root.has_converged && *std::ranges::min_element(root.xi) > -near)
            if (const auto proven = proven_root<D>(element, r, root.xi, root.inverse); proven.is_inside())
                return at_root(at, proven);
        // The mesh need not be convex. If the face opposite the smallest ξ is on the boundary, the walk crosses another
        // face with negative ξ. It never returns to the previous element, because ξ outside an element is only an
        // extrapolation.
        ElementId next;
        double least = 0;
        for (int i = 0; i <= D; ++i) {
            const ElementId across = back.neighbours[at][i];
            if (!(root.xi[i] < least) || !across.valid() || across == before) continue;
            next = across;
            least = root.xi[i];
        }
        before = at;
        at = next;
    }
    return located;
}

template <int D>
struct Looked {
    Location<D> location;
    bool is_found = false, is_decided = true;
};
template <int D>
Looked<D> look_at_all(const CurvedLocator<D>& back, const Vec<D>& p) {
    Looked<D> looked;
    const auto look = [&](auto&& find) {
        back.element_tree.containing(p, [&](std::size_t e) {
            if (looked.is_found) return;
            const auto element = curved_element(back.mesh, ElementId(e));
            if (!element.box().contains(p)) return;
            const Found<D> found = find(element, p - element.origin);
            looked.is_decided = looked.is_decided && found.membership != Membership::undecided;
            looked.is_found = found.membership == Membership::inside;
            if (looked.is_found) looked.location = at_root(ElementId(e), found.root);
        });
    };
    look([](const CurvedSimplex<D, D>& element, const Vec<D>& r) {
        if (!may_contain<D>(element, r)) return Found<D>{Membership::not_inside, {}};
        const Root<D> root = newton_root<D>(element, r, centre<D>());
        return Found<D>{root.is_inside() ? Membership::inside : Membership::not_inside, root};
    });
    if (!looked.is_found)
        look([](const CurvedSimplex<D, D>& element, const Vec<D>& r) { return find_in_element<D>(element, r); });
    return looked;
}

template <int D>
Location<D> on_face(const NearestOnCurved<D>& nearest, Placement placement) {
    Location<D> location{.element = nearest.face.element, .xi = {}, .placement = placement};
    const auto local = face_opposite<D>(static_cast<int>(nearest.face.opposite));
    for (int i = 0; i < D; ++i) location.xi[local[i]] = nearest.xi[i];
    return location;
}

}  // namespace

template <int D>
Location<D> CurvedLocator<D>::locate(const Vec<D>& p, ElementId hint) const {
    const CurvedLocator& back = *this;
    if (!is_finite(p)) return walk(back, p, {});
    const ElementId start = element_or_none(mesh.linear, hint);
    if (const auto there = at_vertex_of(mesh.linear, start, p)) return *there;
    const Location<D> near = walk(back, p, start);
    if (near.placement == Placement::inside) return near;
    if (boundary.empty()) {
        const Looked<D> looked = look_at_all(back, p);
        return looked.is_found ? looked.location : near;
    }
    const NearestOnCurved<D> nearest = nearest_on_boundary(back, p);
    // No boundary is closer to p than the nearest boundary point. So p lies outside the mesh if it is on the outer side
    // of the face there.
    if (nearest.is_beyond) return on_face<D>(nearest, Placement::outside);
    const Looked<D> looked = look_at_all(back, p);
    if (looked.is_found) return looked.location;
    return on_face<D>(nearest, looked.is_decided ? Placement::outside : Placement::lost);
}

template <int D>
std::optional<double> root_radius(const QuadraticMesh<D>& mesh, const Location<D>& location, const Vec<D>& p) {
    const auto element = curved_element(mesh, location.element);
    const Mat<D> a = inverse(jacobian_at(element, location.xi));
    const Root<D> root = proven_root<D>(element, p - element.origin, location.xi, a);
    if (!root.is_proven) return std::nullopt;
    return root.radius;
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template ElementId CurvedLocator<D>::hint_for(const Vec<D>&) const;                                                \
    template Outcome<CurvedLocator<D>> make_curved_locator<D>(QuadraticMesh<D>, const Incidence<ElementId>&,           \
                                                              const Execution&);                                       \
    template Root<D> proven_root<D>(const CurvedSimplex<D, D>&, const Vec<D>&, const Barycentrics<D>&, const Mat<D>&); \
    template RootIterate<D> newton<D>(const CurvedSimplex<D, D>&, const Vec<D>&, const Barycentrics<D>&);              \
    template Root<D> newton_root<D>(const CurvedSimplex<D, D>&, const Vec<D>&, const Barycentrics<D>&);                \
    template bool may_contain<D>(const CurvedSimplex<D, D>&, const Vec<D>&);                                           \
    template Found<D> find_in_element<D>(const CurvedSimplex<D, D>&, const Vec<D>&);                                   \
    template Location<D> CurvedLocator<D>::locate(const Vec<D>&, ElementId) const;                                     \
    template std::optional<double> root_radius<D>(const QuadraticMesh<D>&, const Location<D>&, const Vec<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
