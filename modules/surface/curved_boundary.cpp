module;
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
module camber.surface;
import camber.core;
import camber.box_tree;
import camber.bezier;

namespace camber {

namespace {

/// c_α = Σ_i α_i/3 P_{α − e_i}: the same simplex as one of degree 3.
template <int K, int D>
CubicSimplex<K, D> raised(const QuadraticSimplex<K, D>& simplex) {
    CubicSimplex<K, D> out;
    for (const MultiIndex<K>& alpha : multi_indices<3, K>) {
        Vec<D> point;
        for (int i = 0; i <= K; ++i) {
            if (alpha[static_cast<std::size_t>(i)] == 0) continue;
            MultiIndex<K> rest = alpha;
            --rest[static_cast<std::size_t>(i)];
            int first = 0, last = K;
            while (rest[static_cast<std::size_t>(first)] == 0) ++first;
            while (rest[static_cast<std::size_t>(last)] == 0) --last;
            point += alpha[static_cast<std::size_t>(i)] / 3.0 * simplex.at(first, last);
        }
        out.at(alpha) = point;
    }
    return out;
}

template <int D>
Box<D> box_of(const CubicSimplex<D - 1, D>& facet) {
    Box<D> box;
    for (const Vec<D>& c : facet.control) box.include(c);
    return box;
}

template <int D>
BoundaryFoot<D> on_facet(const CurvedBoundary<D>& boundary, std::size_t f, const Vec<D>& p) {
    const auto foot = closest_on(boundary.facets[f], p);
    return {FacetId(f), foot.xi, foot.point, foot.distance_squared};
}

}  // namespace

template <int D>
Outcome<CurvedBoundary<D>> curved_boundary(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> mid_nodes,
                                           const Execution& execution) {
    auto facets = map_each(execution, mesh.linear.facets.size(), [&](std::size_t f) {
        return raised<D - 1, D>(bezier_form<D - 1, D>(mesh.linear.points, mid_nodes, mesh.linear.facets.vertices[f],
                                                      mesh.edges.of_facets[f]));
    });
    if (!facets) return fail(facets.error());
    auto boxes =
        map_each(without_progress(execution), facets->size(), [&](std::size_t f) { return box_of<D>((*facets)[f]); });
    if (!boxes) return fail(boxes.error());
    return guarded(
        [&]() -> Outcome<CurvedBoundary<D>> { return CurvedBoundary<D>{std::move(*facets), BoxTree<D>(*boxes)}; });
}

template <int D>
BoundaryFoot<D> closest_on(const CurvedBoundary<D>& boundary, const Vec<D>& p, FacetId near) {
    BoundaryFoot<D> best;
    if (near.valid()) best = on_facet(boundary, near.index(), p);
    const auto distance_squared = [&](std::size_t f) {
        if (FacetId(f) == best.facet) return best.distance_squared;
        const double beyond = box_of<D>(boundary.facets[f]).distance_squared(p);
        if (beyond > best.distance_squared) return std::numeric_limits<double>::infinity();
        const BoundaryFoot<D> foot = on_facet(boundary, f, p);
        if (foot.distance_squared < best.distance_squared ||
            (foot.distance_squared == best.distance_squared && f < best.facet.index()))
            best = foot;
        return foot.distance_squared;
    };
    (void)boundary.tree.nearest(p, distance_squared, best.distance_squared);
    return best;
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template Outcome<CurvedBoundary<D>> curved_boundary<D>(const QuadraticMesh<D>&, std::span<const LagrangeNode<D>>, \
                                                           const Execution&);                                         \
    template BoundaryFoot<D> closest_on<D>(const CurvedBoundary<D>&, const Vec<D>&, FacetId);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
