// Cubic simplices: evaluation and closest points, of one or eight points at once.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// For each multi-index β of degree N − 1 and each i: position of the multi-index β + e_i of degree N. e_i is the unit
/// multi-index of ξ_i.
template <int N, int K>
constexpr auto raised = [] {
    std::array<std::array<int, K + 1>, node_count<N - 1, K>> table{};
    for (int n = 0; n < node_count<N - 1, K>; ++n)
        for (int i = 0; i <= K; ++i) {
            auto alpha = multi_indices<N - 1, K>[n];
            ++alpha[i];
            table[n][i] = position<N, K>(alpha);
        }
    return table;
}();

template <int N, int K, int D>
std::array<Vec<D>, node_count<N - 1, K>> reduced(const std::array<Vec<D>, node_count<N, K>>& net,
                                                 const Barycentric<K>& xi) {
    std::array<Vec<D>, node_count<N - 1, K>> out{};
    for (int n = 0; n < node_count<N - 1, K>; ++n)
        for (int i = 0; i <= K; ++i) out[n] += xi[i] * net[raised<N, K>[n][i]];
    return out;
}

template <int K, int D>
Vec<D> combined(const std::array<Vec<D>, K + 1>& net, const Barycentric<K>& xi) {
    Vec<D> p;
    for (int i = 0; i <= K; ++i) p += xi[i] * net[i];
    return p;
}

}  // namespace

template <int K, int D>
CubicExpansion<K, D> expand(const CubicSimplex<K, D>& simplex, const Barycentric<K>& xi) {
    const auto quadratic = reduced<3, K, D>(simplex.control, xi);
    const auto linear = reduced<2, K, D>(quadratic, xi);
    const auto second = [&](int i, int j) {
        return quadratic[raised<2, K>[i][j]];  // in a net of degree 1, control points have the order of the coordinates
    };
    CubicExpansion<K, D> out;
    out.point = combined<K, D>(linear, xi);
    for (int a = 0; a < K; ++a) {
        out.first[a] = 3 * (linear[a + 1] - linear[0]);
        for (int b = 0; b < K; ++b)
            out.second[a][b] = 6 * ((second(a + 1, b + 1) - second(a + 1, 0)) - (second(b + 1, 0) - second(0, 0)));
    }
    return out;
}

template <int K, int D>
Vec<D> point_at(const CubicSimplex<K, D>& simplex, const Barycentric<K>& xi) {
    return combined<K, D>(reduced<2, K, D>(reduced<3, K, D>(simplex.control, xi), xi), xi);
}

template <int D>
CubicSimplex<1, D> cubic_edge(const Vec<D>& a, const Vec<D>& tangent_a, const Vec<D>& tangent_b, const Vec<D>& b) {
    constexpr double min_cosine = 0.26;  // 75°
    const Vec<D> e = b - a;
    const double length = norm(e);
    const auto handle = [&](const Vec<D>& tangent) {
        const Vec<D> t = normalised(tangent);
        const double cosine = length > 0 ? dot(t, e) / length : 0;
        return cosine > min_cosine ? (length * (2.0 / 3.0) / (1 + cosine)) * t : e / 3;
    };
    return {{a, a + handle(tangent_a), b - handle(tangent_b), b}};
}

template <int D>
Vec<D> classical_centre(const CubicSimplex<2, D>& triangle) {
    Vec<D> edges, vertices;
    for (std::size_t n = 0; n < triangle.control.size(); ++n) {
        const auto& alpha = multi_indices<3, 2>[n];
        const Vec<D> from_first = triangle.control[n] - triangle.control[0];
        const bool is_vertex = alpha[0] == 3 || alpha[1] == 3 || alpha[2] == 3;
        const bool is_centre = alpha[0] == 1 && alpha[1] == 1;
        if (is_vertex)
            vertices += from_first;
        else if (!is_centre)
            edges += from_first;
    }
    return triangle.control[0] + (edges / 4 - vertices / 6);
}

template CubicExpansion<1, 2> expand(const CubicSimplex<1, 2>&, const Barycentric<1>&);
template CubicExpansion<1, 3> expand(const CubicSimplex<1, 3>&, const Barycentric<1>&);
template CubicExpansion<2, 3> expand(const CubicSimplex<2, 3>&, const Barycentric<2>&);
template Vec<2> point_at(const CubicSimplex<1, 2>&, const Barycentric<1>&);
template Vec<3> point_at(const CubicSimplex<1, 3>&, const Barycentric<1>&);
template Vec<3> point_at(const CubicSimplex<2, 3>&, const Barycentric<2>&);
template CubicSimplex<1, 2> cubic_edge(const Vec<2>&, const Vec<2>&, const Vec<2>&, const Vec<2>&);
template CubicSimplex<1, 3> cubic_edge(const Vec<3>&, const Vec<3>&, const Vec<3>&, const Vec<3>&);
template Vec<3> classical_centre(const CubicSimplex<2, 3>&);

namespace {

template <int K>
std::array<double, K> inner_coordinates(const Barycentric<K>& xi) {
    std::array<double, K> u{};
    for (int a = 0; a < K; ++a) u[a] = xi[a + 1];
    return u;
}

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

/// Quadratic model of ½|r|² for r = F − p, where F is the simplex's point and F_a, F_ab are its derivatives. The
/// gradient is g_a = r · F_a, the matrix H_ab = F_a · F_b + r · F_ab. The term r · F_ab is omitted if H would be
/// indefinite.
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

/// Control points of the derivatives F_a: 3 (c_{α+e_a} − c_{α+e_0}) for α of degree 2, with the simplex's control
/// points c and unit multi-indices e_a. Their convex hull contains F_a.
template <int K, int D>
std::array<std::array<Vec<D>, K>, node_count<2, K>> control_gradients(const CubicSimplex<K, D>& simplex) {
    std::array<std::array<Vec<D>, K>, node_count<2, K>> out{};
    for (std::size_t n = 0; n < out.size(); ++n) {
        MultiIndex<K> base = multi_indices<2, K>[n];
        ++base[0];
        for (std::size_t a = 0; a < K; ++a) {
            MultiIndex<K> up = multi_indices<2, K>[n];
            ++up[a + 1];
            out[n][a] = 3 * (simplex.at(up) - simplex.at(base));
        }
    }
    return out;
}
/// Control points of the second derivatives F_ab: 2 (g_{α+e_b} − g_{α+e_0}) for a corner α, with the control points g
/// of F_a. The hull over all corners contains F_ab.
template <int K, int D>
std::array<std::array<Vec<D>, K>, K> control_hessian(
    const std::array<std::array<Vec<D>, K>, node_count<2, K>>& gradients, std::size_t corner) {
    const auto raised_by = [&](std::size_t by) {
        MultiIndex<K> alpha{};
        ++alpha[corner];
        ++alpha[by];
        return position<2, K>(alpha);
    };
    std::array<std::array<Vec<D>, K>, K> out{};
    for (std::size_t a = 0; a < K; ++a)
        for (std::size_t b = 0; b < K; ++b)
            out[a][b] = 2 * (gradients[raised_by(b + 1)][a] - gradients[raised_by(0)][a]);
    return out;
}

/// Matrix L⁻¹ of the factorisation JᵀJ = L Lᵀ for a Jacobian matrix J. It transforms the columns of J into orthonormal
/// vectors.
template <int K>
using Whitening = std::array<std::array<double, K>, K>;  // lower triangular
template <int K, int D>
std::optional<Whitening<K>> whitening_of(const std::array<Vec<D>, K>& first) {
    Whitening<K> w{};
    const double a = norm_squared(first[0]);
    if (!(a > 0)) return std::nullopt;
    w[0][0] = 1 / std::sqrt(a);
    if constexpr (K == 2) {
        const double b = dot(first[0], first[1]);
        const double rest = norm_squared(first[1]) - b * b / a;
        constexpr double flat = 1e-6;  // relative to |first[1]|²; smaller values of `rest` are rounding
        if (!(rest > flat * norm_squared(first[1]))) return std::nullopt;
        w[1][1] = 1 / std::sqrt(rest);
        w[1][0] = -b / a * w[1][1];
    }
    return w;
}
template <int K, int D>
std::array<Vec<D>, K> whitened(const Whitening<K>& w, const std::array<Vec<D>, K>& x) {
    std::array<Vec<D>, K> out{};
    for (std::size_t a = 0; a < K; ++a)
        for (std::size_t c = 0; c <= a; ++c) out[a] += w[a][c] * x[c];
    return out;
}

/// True if ½|r|² with r = F − p is certainly convex over the simplex with the points F. Coordinates are chosen in which
/// the mean Jacobian matrix is orthonormal. The eigenvalues of the Hessian JᵀJ + Σ r · F'' are then at least (1 −
/// max‖ΔJ‖)² − max|r| max‖F''‖, where ΔJ is the difference of J from the mean. The maxima are over control points.
template <int K, int D>
bool is_distance_convex(const CubicSimplex<K, D>& simplex, const Vec<D>& p) {
    const auto gradients = control_gradients<K, D>(simplex);
    std::array<Vec<D>, K> mean{};
    for (const auto& g : gradients)
        for (std::size_t a = 0; a < K; ++a) mean[a] += g[a] / static_cast<double>(gradients.size());
    const auto w = whitening_of<K, D>(mean);
    if (!w) return false;
    double turned = 0;
    for (const auto& g : gradients) {
        std::array<Vec<D>, K> apart{};
        for (std::size_t a = 0; a < K; ++a) apart[a] = g[a] - mean[a];
        double sum = 0;
        for (const Vec<D>& x : whitened<K, D>(*w, apart)) sum += norm_squared(x);
        turned = std::fmax(turned, sum);
    }
    const double least = 1 - std::sqrt(turned);
    if (!(least > 0)) return false;
    double bent = 0;
    for (std::size_t corner = 0; corner <= K; ++corner) {
        const auto hessian = control_hessian<K, D>(gradients, corner);
        double sum = 0;
        std::array<std::array<Vec<D>, K>, K> rows{};
        for (std::size_t a = 0; a < K; ++a) rows[a] = whitened<K, D>(*w, hessian[a]);
        for (std::size_t b = 0; b < K; ++b) {
            std::array<Vec<D>, K> column{};
            for (std::size_t a = 0; a < K; ++a) column[a] = rows[a][b];
            for (const Vec<D>& x : whitened<K, D>(*w, column)) sum += norm_squared(x);
        }
        bent = std::fmax(bent, sum);
    }
    double farthest = 0;
    for (const Vec<D>& c : simplex.control) farthest = std::fmax(farthest, norm_squared(c - p));
    return std::sqrt(farthest * bent) < least * least;
}

}  // namespace

template <int K, int D>
CubicFoot<K, D> closest_from(const CubicSimplex<K, D>& simplex, const Vec<D>& p, const Barycentric<K>& start) {
    constexpr int max_steps = 40;
    constexpr double small_step = 1e-14;
    constexpr double rounding_step = 1e-9;  // a shorter step without a decrease is rounding noise: stop
    // Moves p to the origin, so that far from the model's origin only the input's own rounding remains.
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
    if (is_distance_convex(simplex, p)) {
        Barycentric<K> centre{};
        centre.fill(1.0 / (K + 1));
        return closest_from(simplex, p, centre);
    }
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

namespace {

using PointPack = std::array<Pack, 3>;

/// Power form of a cubic triangle: F = `origin` + Σ c_ij u^i v^j with u = ξ_1 and v = ξ_2. For example, `uuv` is c_21.
struct Powers {
    Vec<3> origin;
    Vec<3> u, v, uu, uv, vv, uuu, uuv, uvv, vvv;
};

Powers powers_of(const CubicSimplex<2, 3>& simplex) {
    std::array<Vec<3>, 10> c = simplex.control;
    for (Vec<3>& p : c) p -= simplex.control[0];
    const auto& [p300, p210, p201, p120, p111, p102, p030, p021, p012, p003] = c;
    return {simplex.control[0],
            3 * p210,
            3 * p201,
            3 * (p120 - 2 * p210),
            6 * (p111 - p210 - p201),
            3 * (p102 - 2 * p201),
            p030 - 3 * (p120 - p210),
            3 * (p021 - 2 * p111 + p201 - p120 + 2 * p210),
            3 * (p012 - 2 * p111 + p210 - p102 + 2 * p201),
            p003 - 3 * (p102 - p201)};
}

[[nodiscard, gnu::always_inline]] inline Pack dot(const PointPack& a, const PointPack& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

[[nodiscard, gnu::always_inline]] inline PointPack residual(const Powers& f, Pack u, Pack v, const PointPack& p) {
    PointPack r{};
    for (int c = 0; c < 3; ++c)
        r[c] = u * (f.u[c] + u * (f.uu[c] + u * f.uuu[c] + v * f.uuv[c]) + v * (f.uv[c] + v * f.uvv[c])) +
               v * (f.v[c] + v * (f.vv[c] + v * f.vvv[c])) - p[c];
    return r;
}

/// Derivatives of ½|r|² by u and v for r = F − p: gradient g, second derivatives h, and second derivatives m without
/// the term r · F_ab.
struct ModelPack {
    Pack gu{}, gv{};
    Pack muu{}, muv{}, mvv{};
    Pack huu{}, huv{}, hvv{};
};
[[nodiscard, gnu::always_inline]] inline ModelPack model_pack_at(const Powers& f, Pack u, Pack v, const PointPack& r) {
    PointPack fu{}, fv{}, fuu{}, fuv{}, fvv{};
    for (int c = 0; c < 3; ++c) {
        fu[c] = f.u[c] + u * (2 * f.uu[c] + 3 * u * f.uuu[c] + 2 * v * f.uuv[c]) + v * (f.uv[c] + v * f.uvv[c]);
        fv[c] = f.v[c] + v * (2 * f.vv[c] + 3 * v * f.vvv[c] + 2 * u * f.uvv[c]) + u * (f.uv[c] + u * f.uuv[c]);
        fuu[c] = 2 * f.uu[c] + 6 * u * f.uuu[c] + 2 * v * f.uuv[c];
        fuv[c] = f.uv[c] + 2 * u * f.uuv[c] + 2 * v * f.uvv[c];
        fvv[c] = 2 * f.vv[c] + 6 * v * f.vvv[c] + 2 * u * f.uvv[c];
    }
    ModelPack m;
    m.gu = dot(r, fu);
    m.gv = dot(r, fv);
    m.muu = dot(fu, fu);
    m.muv = dot(fu, fv);
    m.mvv = dot(fv, fv);
    m.huu = m.muu + dot(r, fuu);
    m.huv = m.muv + dot(r, fuv);
    m.hvv = m.mvv + dot(r, fvv);
    return m;
}

[[nodiscard, gnu::always_inline]] inline Pack distances_of(const Powers& f, Pack u, Pack v, const PointPack& p) {
    constexpr int max_steps = 8;
    constexpr double last_step = 1e-7;  // the next step would be about the square of this one
    constexpr double margin = 0.05;     // largest overshoot of a step outside the triangle
    PointPack r = residual(f, u, v, p);
    const Pack first = dot(r, r);
    Mask sound = first >= 0;  // not NaN
    Mask open = sound;
    for (int step = 0; step < max_steps && any(open); ++step) {
        const ModelPack m = model_pack_at(f, u, v, r);
        const Pack determinant = m.huu * m.hvv - m.huv * m.huv;
        // If the second derivatives are not positive definite, `closest_from` takes a Gauss-Newton step. This step is
        // not computed here; the result is NaN.
        sound &= (m.huu > 0.05 * m.muu) & (determinant > 0.05 * (m.muu * m.mvv - m.muv * m.muv));
        const Pack du = (m.huv * m.gv - m.hvv * m.gu) / determinant;
        const Pack dv = (m.huv * m.gu - m.huu * m.gv) / determinant;
        open &= sound;
        u = select(open, u + du, u);
        v = select(open, v + dv, v);
        sound &= (u > -margin) & (v > -margin) & (u + v < 1 + margin);
        open &= sound & (max(abs(du), abs(dv)) > last_step);
        r = residual(f, u, v, p);
    }
    const Pack found = dot(r, r);
    constexpr double rim = 1e-12;
    const Mask inside = sound & ~open & (u > rim) & (v > rim) & (u + v < 1 - rim) & (found <= first);
    return select(inside, sqrt(found), packed(__builtin_nan("")));
}

}  // namespace

void distances_inside(const CubicSimplex<2, 3>& simplex, std::span<const Barycentric<2>> starts,
                      std::span<const Vec<3>> points, std::span<double> distances, Instructions set) {
    const Powers f = powers_of(simplex);
    with_instructions(set, [&]() __attribute__((always_inline)) {
        for (std::size_t begin = 0; begin < points.size(); begin += pack_size) {
            Pack u{}, v{};
            PointPack p{};
            for (std::size_t lane = 0; lane < pack_size; ++lane) {
                const std::size_t i = std::min(begin + lane, points.size() - 1);
                u[lane] = starts[i][1];
                v[lane] = starts[i][2];
                for (int c = 0; c < 3; ++c) p[c][lane] = points[i][c] - f.origin[c];
            }
            const Pack found = distances_of(f, u, v, p);
            const std::size_t n = std::min<std::size_t>(pack_size, points.size() - begin);
            for (std::size_t lane = 0; lane < n; ++lane) distances[begin + lane] = found[lane];
        }
    });
}

}  // namespace camber
