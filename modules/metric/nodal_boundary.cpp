// Nearest points of curved boundaries.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
module camber.metric;
import camber.core;

namespace camber {

namespace {

template <int K>
struct Nearest {
    std::array<double, K + 1> xi{};
    double distance_squared = std::numeric_limits<double>::infinity();
};

inline Vec<1> solved(const Sym<1>& a, const Vec<1>& b) { return {{b[0] / a(0, 0)}}; }
inline Vec<2> solved(const Sym<2>& a, const Vec<2>& b) {
    const double det = a(0, 0) * a(1, 1) - a(1, 0) * a(1, 0);
    return {{(a(1, 1) * b[0] - a(1, 0) * b[1]) / det, (a(0, 0) * b[1] - a(1, 0) * b[0]) / det}};
}
inline bool is_definite(const Sym<1>& a) { return a(0, 0) > 0; }
inline bool is_definite(const Sym<2>& a) {
    return a(0, 0) > 0 && a(0, 0) * a(1, 1) - a(1, 0) * a(1, 0) > 1e-10 * a(0, 0) * a(1, 1);
}

/// Returns the Hessian TᵀT + (F − r)·F'' of |F(ξ) − r|²/2, or TᵀT if this Hessian is not positive definite. T:
/// `tangents` of F; F − r: `off`.
template <int K, int D>
Sym<K> curvature_of_distance(const CurvedSimplex<K, D>& s, const std::array<Vec<D>, K>& tangents, const Vec<D>& off) {
    const auto second = s.second();
    Sym<K> metric, all;
    for (int a = 0; a < K; ++a)
        for (int b = 0; b <= a; ++b) {
            metric(a, b) = dot(tangents[a], tangents[b]);
            all(a, b) = metric(a, b) + dot(off, second[a][b]);
        }
    return is_definite(all) ? all : metric;
}

template <int K, int D>
void descend(const CurvedSimplex<K, D>& s, const Vec<D>& r, Nearest<K>& nearest) {
    for (int step = 0; step < 30; ++step) {
        const Vec<D> off = s.point(nearest.xi) - r;
        const auto tangents = s.derivatives(nearest.xi);
        Vec<K> slope;
        for (int a = 0; a < K; ++a) slope[a] = -dot(tangents[a], off);
        const Vec<K> move = solved(curvature_of_distance<K, D>(s, tangents, off), slope);
        if (!is_finite(move)) return;
        const auto whole = moved<K>(nearest.xi, move);
        // Small steps are taken without a comparison of distances. Near the minimum, distances determine only half the
        // digits of ξ, but Newton steps determine all.
        constexpr double small = 1e-4, smallest = 1e-9;
        if (norm(move) < small && std::ranges::all_of(whole, [](double u) { return u >= 0; })) {
            nearest = {whole, norm_squared(s.point(whole) - r)};
            if (norm(move) < smallest) return;
            continue;
        }
        // The step is shortened to stay in the simplex, then halved until the distance decreases.
        double share = 1;
        for (int i = 0; i <= K; ++i)
            if (whole[i] < 0) share = std::min(share, nearest.xi[i] / (nearest.xi[i] - whole[i]));
        if (!(share > 0)) return;
        Nearest<K> next;
        for (int halving = 0; halving < 8; ++halving, share *= 0.5) {
            next.xi = moved<K>(nearest.xi, share * move);
            for (double& u : next.xi) u = std::max(u, 0.0);
            next.distance_squared = norm_squared(s.point(next.xi) - r);
            if (next.distance_squared < nearest.distance_squared) break;
        }
        if (!(next.distance_squared < nearest.distance_squared)) return;
        nearest = next;
    }
}

template <int D>
Nearest<1> nearest_in(const CurvedSimplex<1, D>& s, const Vec<D>& r) {
    Nearest<1> best;
    constexpr int samples = 8;
    for (int i = 0; i <= samples; ++i) {
        const double t = static_cast<double>(i) / samples;
        Nearest<1> at{{1 - t, t}};
        at.distance_squared = norm_squared(s.point(at.xi) - r);
        if (at.distance_squared < best.distance_squared) best = at;
    }
    descend<1, D>(s, r, best);
    return best;
}

inline Nearest<2> nearest_in(const CurvedSimplex<2, 3>& s, const Vec<3>& r) {
    Nearest<2> best;
    constexpr int samples = 6;
    for (int i = 0; i <= samples; ++i)
        for (int j = 0; i + j <= samples; ++j) {
            const double u = static_cast<double>(i) / samples, v = static_cast<double>(j) / samples;
            Nearest<2> at{{static_cast<double>(samples - i - j) / samples, u, v}};
            at.distance_squared = norm_squared(s.point(at.xi) - r);
            if (at.distance_squared < best.distance_squared) best = at;
        }
    Nearest<2> within = best;
    descend<2, 3>(s, r, within);
    // The edges are searched separately, because a descent that meets an edge ends there.
    for (int e = 0; e < edges_per_simplex<2>; ++e) {
        const auto [i, j] = local_edges<2>[e];
        CurvedSimplex<1, 3> edge;
        edge.d[1] = s.d[j] - s.d[i];
        edge.u[0] = s.u[e];
        const Nearest<1> on_edge = nearest_in<3>(edge, r - s.d[i]);
        if (on_edge.distance_squared > within.distance_squared) continue;
        within = {{}, on_edge.distance_squared};
        within.xi[i] = on_edge.xi[0];
        within.xi[j] = on_edge.xi[1];
    }
    return within;
}

/// Returns true if a ball that contains the simplex proves that all its points are farther from r than
/// sqrt(`distance_squared`).
template <int K, int D>
bool is_farther(const CurvedSimplex<K, D>& s, const Vec<D>& r, double distance_squared) {
    Vec<D> centre;
    for (const Vec<D>& d : s.d) centre += (1.0 / (K + 1)) * d;
    double radius = 0, bow = 0;
    for (const Vec<D>& d : s.d) radius = std::max(radius, distance(d, centre));
    for (const Vec<D>& u : s.u) bow = std::max(bow, norm(u));
    const double gap = distance(r, centre) - radius - 4.0 / 3 * bow;  // 4/3 is the maximum of Σ 4 ξ_i ξ_j
    return gap > 0 && gap * gap > distance_squared;
}

template <int D>
bool looks_outward(const CurvedLocator<D>& back, const NearestOnCurved<D>& nearest, const Vec<D>& p) {
    // The function returns false on an edge or vertex of the mesh. Some boundary faces there may be oriented away from
    // p, others towards p.
    for (const double u : nearest.xi)
        if (!(u > 1e-9)) return false;
    Barycentrics<D> xi{};
    const auto local = face_opposite<D>(static_cast<int>(nearest.face.opposite));
    for (int i = 0; i < D; ++i) xi[local[i]] = nearest.xi[i];
    const auto element = curved_element(back.mesh, nearest.face.element);
    const Vec<D> step = inverse(jacobian_at(element, xi)) * (p - element.origin - element.point(xi));
    double inward = 0;
    for (int a = 0; a < D; ++a) inward -= step[a];
    if (nearest.face.opposite > 0) inward = step[nearest.face.opposite - 1];
    return inward < -1e-9;
}

}  // namespace

template <int D>
NearestOnCurved<D> nearest_on_boundary(const CurvedLocator<D>& back, const Vec<D>& p) {
    double least = std::numeric_limits<double>::infinity();
    const auto found = back.boundary_tree.nearest(p, [&](std::size_t f) {
        const auto face = curved_face(back.mesh, back.boundary[f]);
        const Vec<D> r = p - face.origin;
        if (is_farther<D - 1, D>(face, r, least)) return std::numeric_limits<double>::infinity();
        const Nearest<D - 1> here = nearest_in(face, r);
        least = std::min(least, here.distance_squared);
        return here.distance_squared;
    });
    NearestOnCurved<D> nearest;
    // If squares of lengths overflow, comparisons with NaN are false and no face is found; then any face is used.
    nearest.face = back.boundary[found.item < back.boundary.size() ? found.item : 0];
    const auto face = curved_face(back.mesh, nearest.face);
    nearest.xi = nearest_in(face, p - face.origin).xi;
    nearest.is_beyond = looks_outward(back, nearest, p);
    return nearest;
}

template <int D>
std::array<Vec<D>, D> nearest_point_derivative(const CurvedLocator<D>& back, const Location<D>& location,
                                               const Vec<D>& p) {
    std::array<int, D + 1> support{};
    int n = 0;
    for (int i = 0; i <= D; ++i)
        if (location.xi[i] > 0) support[n++] = i;
    std::array<Vec<D>, D> out{};
    if (n < 2 || n > D) return out;
    const auto element = curved_element(back.mesh, location.element);
    const auto columns = element.derivatives(location.xi);
    const auto second = element.second();
    const Vec<D> off = element.point(location.xi) - (p - element.origin);
    const auto column = [&](int i) { return i == 0 ? Vec<D>{} : columns[i - 1]; };
    const auto bend = [&](int i, int j) { return i == 0 || j == 0 ? Vec<D>{} : second[i - 1][j - 1]; };
    const auto solve = [&]<int K>() {
        const int o = support[0];
        std::array<Vec<D>, K> t;
        Sym<K> metric, all;
        for (int a = 0; a < K; ++a) t[a] = column(support[a + 1]) - column(o);
        for (int a = 0; a < K; ++a)
            for (int b = 0; b <= a; ++b) {
                const int i = support[a + 1], j = support[b + 1];
                metric(a, b) = dot(t[a], t[b]);
                all(a, b) = metric(a, b) + dot(off, bend(i, j) - bend(i, o) - bend(o, j) + bend(o, o));
            }
        const Sym<K>& h = is_definite(all) ? all : metric;
        for (int c = 0; c < D; ++c) {
            Vec<K> rhs;
            for (int a = 0; a < K; ++a) rhs[a] = t[a][c];
            const Vec<K> move = solved(h, rhs);
            if (!is_finite(move)) continue;
            for (int a = 0; a < K; ++a) {
                if (support[a + 1] > 0) out[support[a + 1] - 1][c] += move[a];
                if (o > 0) out[o - 1][c] -= move[a];
            }
        }
    };
    if (n == 2)
        solve.template operator()<1>();
    else if constexpr (D == 3)
        solve.template operator()<2>();
    return out;
}

#define CAMBER_INSTANTIATE(D)                                                                               \
    template NearestOnCurved<D> nearest_on_boundary<D>(const CurvedLocator<D>&, const Vec<D>&);             \
    template std::array<Vec<D>, D> nearest_point_derivative<D>(const CurvedLocator<D>&, const Location<D>&, \
                                                               const Vec<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
