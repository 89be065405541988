module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

using PointPack = std::array<Pack, 3>;

/// F − P_300 by powers of u = ξ_1 and v = ξ_2: 3!/((3−i−j)! i! j!) times the differences Δ_1^i Δ_2^j.
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

/// F − p, p relative to the origin.
[[nodiscard, gnu::always_inline]] inline PointPack residual(const Powers& f, Pack u, Pack v, const PointPack& p) {
    PointPack r{};
    for (int c = 0; c < 3; ++c)
        r[c] = u * (f.u[c] + u * (f.uu[c] + u * f.uuu[c] + v * f.uuv[c]) + v * (f.uv[c] + v * f.uvv[c])) +
               v * (f.v[c] + v * (f.vv[c] + v * f.vvv[c])) - p[c];
    return r;
}

/// Half the squared distance at a place: its gradient and its second derivatives, these without and with the part of
/// the surface's own, r · F_ab.
struct ModelPack {
    Pack gu{}, gv{};
    Pack muu{}, muv{}, mvv{};
    Pack huu{}, huv{}, hvv{};
};
[[nodiscard, gnu::always_inline]] inline ModelPack model_at(const Powers& f, Pack u, Pack v, const PointPack& r) {
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

/// Eight points: their distances, not a number where the method does not end well inside.
[[nodiscard, gnu::always_inline]] inline Pack distances_of(const Powers& f, Pack u, Pack v, const PointPack& p) {
    constexpr int max_steps = 8;
    constexpr double last_step = 1e-7;  // the next would be its square
    constexpr double margin = 0.05;     // how far outside a step may lead
    PointPack r = residual(f, u, v, p);
    const Pack first = dot(r, r);
    Mask sound = first >= 0;  // a number
    Mask open = sound;
    for (int step = 0; step < max_steps && any(open); ++step) {
        const ModelPack m = model_at(f, u, v, r);
        const Pack determinant = m.huu * m.hvv - m.huv * m.huv;
        // Where second derivatives spoil definiteness, `closest_from` goes another way.
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
