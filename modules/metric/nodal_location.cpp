module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
module camber.metric;
import :curved_simplex;
import :element_frame;
import :back_mesh;
import :location_start;
import :curved_locator;
import :nodal_back;
import :quadratic_root;
import camber.core;

namespace camber {

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

/// Walks across the curved face that p lies farthest behind, by what Newton's method says of ξ, until p is in an
/// element for certain. When that leads out of the mesh, or takes too long, it is lost.
template <int D>
Location<D> walk(const CurvedLocator<D>& back, const Vec<D>& p, ElementId start) {
    Location<D> seen{
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
        // Behind a boundary face the other faces that hide p are tried: the mesh need not be convex. And never back at
        // once: what lies beyond an element is a guess there.
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
    return seen;
}

/// A look at all elements whose boxes hold p: by Newton's method from their centres, then by bisection of each.
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
        if (!may_hold<D>(element, r)) return Found<D>{Membership::not_inside, {}};
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
    // A ball around p that reaches to its nearest boundary point holds no boundary: p is beyond it if it looks so
    // there.
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

#define CAMBER_INSTANTIATE(D)                                                      \
    template Location<D> CurvedLocator<D>::locate(const Vec<D>&, ElementId) const; \
    template std::optional<double> root_radius<D>(const QuadraticMesh<D>&, const Location<D>&, const Vec<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
