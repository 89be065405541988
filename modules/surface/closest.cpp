module;
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// The same place in a neighbour's coordinates: corners are matched by their vertices, the rest is 0.
template <int K>
Barycentric<K> carried_over(const SimplexVertices<K>& from, const Barycentric<K>& xi, const SimplexVertices<K>& to) {
    Barycentric<K> out{};
    for (int i = 0; i <= K; ++i)
        for (int j = 0; j <= K; ++j)
            if (from[i] == to[j]) out[j] = xi[i];
    return out;
}

template <int D>
SurrogateFoot<D> named(FacetId f, const CubicFoot<D - 1, D>& foot) {
    return {f, foot.xi, foot.point, foot.distance_squared};
}

/// Walks across the rim as long as the distance falls.
template <int D>
SurrogateFoot<D> walked(const Surrogate<D>& surrogate, SurrogateFoot<D> here, const Vec<D>& p) {
    constexpr int max_steps = 1000;
    for (int step = 0; step < max_steps; ++step) {
        SurrogateFoot<D> best = here;
        for (int i = 0; i < D; ++i) {
            const FacetId next = surrogate.neighbours[here.facet][i];
            if (here.xi[i] != 0 || !next.valid()) continue;
            const auto start = carried_over<D - 1>(surrogate.vertices[here.facet], here.xi, surrogate.vertices[next]);
            const auto there = named<D>(next, closest_from(surrogate.facets[next], p, start));
            if (there.distance_squared < best.distance_squared) best = there;
        }
        if (best.facet == here.facet) return here;
        here = best;
    }
    return here;
}

}  // namespace

template <int D>
SurrogateFoot<D> closest_near(const Surrogate<D>& surrogate, FacetId start, const Vec<D>& p) {
    SurrogateFoot<D> here = walked(surrogate, named<D>(start, closest_on(surrogate.facets[start], p)), p);
    for (bool improved = true; improved;) {
        improved = false;
        for (const FacetId next : surrogate.neighbours[here.facet]) {
            if (!next.valid()) continue;
            const auto there = named<D>(next, closest_on(surrogate.facets[next], p));
            if (!(there.distance_squared < here.distance_squared)) continue;
            here = walked(surrogate, there, p);
            improved = true;
            break;
        }
    }
    return here;
}

template <int D>
SurrogateFoot<D> closest_near(const Surrogate<D>& surrogate, FacetId start, const Barycentric<D - 1>& xi,
                              const Vec<D>& p) {
    return walked(surrogate, named<D>(start, closest_from(surrogate.facets[start], p, xi)), p);
}

template <int D>
CurveFoot<D> closest_on_ridges(const Surrogate<D>& surrogate, const Vec<D>& p) {
    const auto curve = [&](std::size_t i) -> const CubicSimplex<1, D>& {
        return surrogate.edge_curves[surrogate.ridge_rows[i]].curve;
    };
    const auto nearest =
        surrogate.curve_tree.nearest(p, [&](std::size_t i) { return closest_on(curve(i), p).distance_squared; });
    if (nearest.item == std::numeric_limits<std::size_t>::max())
        return {surrogate.edges.size(), 0, {}, std::numeric_limits<double>::infinity()};
    const auto foot = closest_on(curve(nearest.item), p);
    return {surrogate.ridge_rows[nearest.item], foot.xi[1], foot.point, foot.distance_squared};
}

template <int D>
Vec<D> normal_at(const CubicSimplex<D - 1, D>& facet, const Barycentric<D - 1>& xi) {
    const auto expansion = expand(facet, xi);
    if constexpr (D == 2) {
        const Vec<2>& t = expansion.first[0];
        return normalised(Vec<2>{{t[1], -t[0]}});
    } else {
        const Vec<3> n = cross(expansion.first[0], expansion.first[1]);
        if (norm_squared(n) > 0) return normalised(n);
        const auto& c = facet.control;
        return normalised(cross(c[6] - c[0], c[9] - c[0]));
    }
}

template SurrogateFoot<2> closest_near(const Surrogate<2>&, FacetId, const Vec<2>&);
template SurrogateFoot<3> closest_near(const Surrogate<3>&, FacetId, const Vec<3>&);
template SurrogateFoot<2> closest_near(const Surrogate<2>&, FacetId, const Barycentric<1>&, const Vec<2>&);
template SurrogateFoot<3> closest_near(const Surrogate<3>&, FacetId, const Barycentric<2>&, const Vec<3>&);
template CurveFoot<2> closest_on_ridges(const Surrogate<2>&, const Vec<2>&);
template CurveFoot<3> closest_on_ridges(const Surrogate<3>&, const Vec<3>&);
template Vec<2> normal_at<2>(const CubicSimplex<1, 2>&, const Barycentric<1>&);
template Vec<3> normal_at<3>(const CubicSimplex<2, 3>&, const Barycentric<2>&);

}  // namespace camber
