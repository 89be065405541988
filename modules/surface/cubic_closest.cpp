module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

template <int K>
std::array<double, K> inner_coordinates(const Barycentric<K>& xi) {
    std::array<double, K> u{};
    for (int a = 0; a < K; ++a) u[a] = xi[a + 1];
    return u;
}

/// The quadratic model g·δ + ½ δᵀHδ of half the squared distance.
template <int K>
struct Model {
    std::array<double, K> g{};
    std::array<std::array<double, K>, K> h{};

    [[nodiscard]] double value(const std::array<double, K>& d) const {
        double v = 0;
        for (int a = 0; a < K; ++a) {
            v += g[a] * d[a];
            for (int b = 0; b < K; ++b) v += 0.5 * d[a] * h[a][b] * d[b];
        }
        return v;
    }
};

/// With r = F − p: g_a = r·F_a, H_ab = F_a·F_b + r·F_ab; the last term is left out where it spoils definiteness.
template <int K, int D>
Model<K> model_at(const CubicExpansion<K, D>& x) {
    Model<K> m;
    for (int a = 0; a < K; ++a) {
        m.g[a] = dot(x.point, x.first[a]);
        for (int b = 0; b < K; ++b) m.h[a][b] = dot(x.first[a], x.first[b]);
    }
    Model<K> full = m;
    for (int a = 0; a < K; ++a)
        for (int b = 0; b < K; ++b) full.h[a][b] += dot(x.point, x.second[a][b]);
    if constexpr (K == 1)
        return full.h[0][0] > 0.05 * m.h[0][0] ? full : m;
    else {
        const auto determinant = [](const Model<K>& k) { return k.h[0][0] * k.h[1][1] - k.h[0][1] * k.h[1][0]; };
        const bool definite = full.h[0][0] > 0.05 * m.h[0][0] && determinant(full) > 0.05 * determinant(m);
        return definite ? full : m;
    }
}

/// The model's least point on the segment from `from` to `from + along`, both as steps δ.
template <int K>
std::array<double, K> min_on_segment(const Model<K>& m, const std::array<double, K>& from,
                                     const std::array<double, K>& along) {
    double slope = 0, curvature = 0;
    for (int a = 0; a < K; ++a) {
        double gradient = m.g[a];
        for (int b = 0; b < K; ++b) {
            gradient += m.h[a][b] * from[b];
            curvature += along[a] * m.h[a][b] * along[b];
        }
        slope += gradient * along[a];
    }
    double s = slope < 0 ? 1 : 0;
    if (curvature > 0) s = std::fmin(1, std::fmax(0, -slope / curvature));
    std::array<double, K> d = from;
    for (int a = 0; a < K; ++a) d[a] += s * along[a];
    return d;
}

/// The model's least point over the simplex around the place u, as a step from it.
std::array<double, 1> min_step(const Model<1>& m, const std::array<double, 1>& u) {
    return min_on_segment<1>(m, {-u[0]}, {1});
}
std::array<double, 2> min_step(const Model<2>& m, const std::array<double, 2>& u) {
    const double determinant = m.h[0][0] * m.h[1][1] - m.h[0][1] * m.h[1][0];
    if (determinant > 0 && m.h[0][0] > 0) {
        const std::array<double, 2> d{(m.h[0][1] * m.g[1] - m.h[1][1] * m.g[0]) / determinant,
                                      (m.h[1][0] * m.g[0] - m.h[0][0] * m.g[1]) / determinant};
        if (u[0] + d[0] >= 0 && u[1] + d[1] >= 0 && u[0] + d[0] + u[1] + d[1] <= 1) return d;
    }
    const std::array<double, 2> origin{-u[0], -u[1]};
    std::array<double, 2> best = min_on_segment<2>(m, origin, {1, 0});
    for (const auto& d : {min_on_segment<2>(m, origin, {0, 1}), min_on_segment<2>(m, {1 - u[0], -u[1]}, {-1, 1})})
        if (m.value(d) < m.value(best)) best = d;
    return best;
}

/// Keeps the coordinates in [0, 1] and their sum 1 after a step that rounding may have led out by an ulp; a coordinate
/// within rounding of the rim is on it.
template <int K>
Barycentric<K> moved(const Barycentric<K>& xi, const std::array<double, K>& d, double factor) {
    constexpr double rim = 1e-15;
    Barycentric<K> out{};
    double rest = 1;
    for (int a = 1; a <= K; ++a) {
        out[a] = std::fmin(rest, xi[a] + factor * d[a - 1]);
        if (out[a] < rim) out[a] = 0;
        rest -= out[a];
    }
    out[0] = rest < rim ? 0 : rest;
    return out;
}

}  // namespace

template <int K, int D>
CubicFoot<K, D> closest_from(const CubicSimplex<K, D>& simplex, const Vec<D>& p, const Barycentric<K>& start) {
    constexpr int max_steps = 40;
    constexpr double small_step = 1e-14;
    constexpr double rounding_step = 1e-9;  // one that does not help is led by rounding: shorter ones are no better
    // From here on p is the origin: far from the model's origin nothing is lost but the input's own rounding.
    CubicSimplex<K, D> local = simplex;
    for (auto& c : local.control) c -= p;
    Barycentric<K> xi = start;
    auto here = expand(local, xi);
    double least = norm_squared(here.point);
    for (int step = 0; step < max_steps; ++step) {
        const auto d = min_step(model_at<K, D>(here), inner_coordinates<K>(xi));
        double length = 0;
        for (const double x : d) length = std::fmax(length, std::fabs(x));
        if (length < small_step) break;
        bool better = false;
        for (double factor = 1; factor > 1e-3; factor *= 0.5) {
            const auto next = moved<K>(xi, d, factor);
            const auto there = expand(local, next);
            const double found = norm_squared(there.point);
            if (!(found < least) && length < rounding_step) break;
            if (!(found < least)) continue;
            xi = next;
            here = there;
            least = found;
            better = true;
            break;
        }
        if (!better) break;
    }
    return {xi, here.point + p, least};
}

template <int K, int D>
CubicFoot<K, D> closest_on(const CubicSimplex<K, D>& simplex, const Vec<D>& p) {
    constexpr int lattice = 4;
    constexpr std::size_t starts = 3;
    struct Start {
        double distance_squared;
        Barycentric<K> xi;
    };
    std::array<Start, node_count<lattice, K>> all{};
    for (std::size_t n = 0; n < all.size(); ++n) {
        for (std::size_t i = 0; i <= K; ++i)
            all[n].xi[i] = static_cast<double>(multi_indices<lattice, K>[n][i]) / lattice;
        all[n].distance_squared = norm_squared(point_at(simplex, all[n].xi) - p);
    }
    std::partial_sort(all.begin(), all.begin() + starts, all.end(), [](const Start& a, const Start& b) {
        return std::pair(a.distance_squared, a.xi) < std::pair(b.distance_squared, b.xi);
    });
    CubicFoot<K, D> best = closest_from(simplex, p, all[0].xi);
    for (std::size_t n = 1; n < starts; ++n)
        if (const auto foot = closest_from(simplex, p, all[n].xi); foot.distance_squared < best.distance_squared)
            best = foot;
    return best;
}

template CubicFoot<1, 2> closest_from(const CubicSimplex<1, 2>&, const Vec<2>&, const Barycentric<1>&);
template CubicFoot<1, 3> closest_from(const CubicSimplex<1, 3>&, const Vec<3>&, const Barycentric<1>&);
template CubicFoot<2, 3> closest_from(const CubicSimplex<2, 3>&, const Vec<3>&, const Barycentric<2>&);
template CubicFoot<1, 2> closest_on(const CubicSimplex<1, 2>&, const Vec<2>&);
template CubicFoot<1, 3> closest_on(const CubicSimplex<1, 3>&, const Vec<3>&);
template CubicFoot<2, 3> closest_on(const CubicSimplex<2, 3>&, const Vec<3>&);

}  // namespace camber
