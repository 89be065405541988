// Jacobian coefficients of packed elements and of triangles in space, and signed volumes.
module;
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
module camber.validity;
import camber.core;
import camber.bezier;

namespace camber {

template <int D>
std::array<JacobianSummary, pack_size> jacobian_summaries(const NodalPack<D>& elements, Instructions set) {
    std::array<JacobianSummary, pack_size> out;
    with_instructions(set, [&]() __attribute__((always_inline)) {
        const auto jacobian = jacobian_of_nodes<D, Pack>([&](int node, int c) __attribute__((always_inline)) {
            return std::bit_cast<Pack>(elements.nodes[node][c]);
        });
        Pack lowest = jacobian.coefficients[0];
        Pack sum = packed(0);
        for (const Pack& c : jacobian.coefficients) {
            lowest = min(c, lowest);
            sum += abs(c);
        }
        for (std::size_t lane = 0; lane < pack_size; ++lane)
            out[lane] = {lowest[lane], jacobian.straight[lane], jacobian.error[lane], sum[lane]};
    });
    return out;
}

namespace {

template <int D, class Real>
struct BoundedVolume {
    Real value{}, error{};
};
template <int D, class Real>
BoundedVolume<D, Real> volume_in(const std::array<Vec<D>, D + 1>& p) {
    std::array<std::array<Real, D>, D> columns{};
    ColumnBounds<D, Real> bounds{};
    for (int a = 1; a <= D; ++a)
        for (int c = 0; c < D; ++c) {
            columns[a - 1][c] = Real(p[a][c]) - Real(p[0][c]);
            bounds[a - 1][c] = magnitude<Real>(columns[a - 1][c]);
        }
    return {determinant<D, Real>(columns), error_bound<D, Real>(bounds)};
}

}  // namespace

template <int D>
double signed_volume(const std::array<Vec<D>, D + 1>& p) {
    const auto plain = volume_in<D, double>(p);
    if (std::abs(plain.value) > plain.error) return plain.value;
    const auto sharp = volume_in<D, DoubleDouble>(p);
    return magnitude(sharp.value) > sharp.error ? sharp.value.high : 0;
}

template <int D>
double signed_volume(const NodalSimplex<D>& s) {
    const BoundedJacobian<D> jacobian = bounded_jacobian(s);
    double mean = 0;
    for (const double c : jacobian.coefficients) mean += c / jacobian_coefficients<D>;
    if (std::abs(mean) > 2 * jacobian.error) return mean;
    std::array<Vec<D>, D + 1> corners;
    for (int i = 0; i <= D; ++i) corners[i] = s.nodes[i];
    return signed_volume<D>(corners);
}

template double signed_volume<2>(const std::array<Vec<2>, 3>&);
template double signed_volume<3>(const std::array<Vec<3>, 4>&);
template double signed_volume<2>(const NodalSimplex<2>&);
template double signed_volume<3>(const NodalSimplex<3>&);

namespace {

double leading(double x) { return x; }
double leading(const DoubleDouble& x) { return x.high; }

template <class Real>
struct Columns {
    SurfaceColumns<Real> d;
    std::array<std::array<Real, 3>, 2> w, straight;
};

template <class Real>
Columns<Real> columns_of(const SurfaceTriangle& t) {
    const auto at = [&](int node, int c) { return Real(t.nodes[node].c[c]); };
    Columns<Real> j{};
    for (int a = 1; a <= 2; ++a)
        for (int c = 0; c < 3; ++c) {
            const Real edge = at(a, c) - at(0, c);
            const Real half = 0.5 * edge;
            Real largest{};
            for (int i = 0; i <= 2; ++i) {
                const Real twice = 2 * (at(node_between<2>[i][a], c) - at(node_between<2>[i][0], c));
                j.d[a - 1][i][c] = twice - half;
                largest = larger<Real>(largest, magnitude<Real>(twice));
            }
            j.w[a - 1][c] = largest + magnitude<Real>(half) + smallest_bound<Real>;
            j.straight[a - 1][c] = edge;
        }
    return j;
}

/// Computes N · s and s · s, where s is 2⁻ᵏ times the straight normal (exact scaling). On axis c, N_c has the error ε_c
/// (error_bound) and s_c the error 2⁻ᵏ ε_c; |N_c| and |2ᵏ s_c| are at most M_c = 4 perm(w). Products err by M 2⁻ᵏε + ε
/// (|s| + 2⁻ᵏε). The three products and two sums add far less than γ M (|s| + 2⁻ᵏε).
template <class Real>
BoundedJacobian<2, Real> projected_jacobian(const SurfaceTriangle& t) {
    const Columns<Real> j = columns_of<Real>(t);
    std::array<Real, 3> s = product(j.straight[0], j.straight[1]);
    double largest = 0;
    for (const Real& x : s) largest = std::max(largest, std::abs(leading(x)));
    BoundedJacobian<2, Real> out;
    out.error = std::numeric_limits<double>::infinity();  // doubles cannot represent the normal
    if (!(largest > 0) || !std::isfinite(largest)) return out;
    const Real scale = std::ldexp(1.0, -std::max(std::ilogb(largest), -1000));
    Real error = 0;
    Real all = 1;
    for (int c = 0; c < 3; ++c) {
        const int x = (c + 1) % 3, y = (c + 2) % 3;
        s[c] = s[c] * scale;
        const Real most = 4 * (j.w[0][x] * j.w[1][y] + j.w[0][y] * j.w[1][x]);
        const Real of_normal = error_bound<2, Real>({{{j.w[0][x], j.w[0][y]}, {j.w[1][x], j.w[1][y]}}});
        const Real of_straight = of_normal * scale;
        const Real present = magnitude<Real>(s[c]) + of_straight;
        error += most * of_straight + of_normal * present + rounding_factor<Real> * (most * present);
        all += most;
    }
    const auto sums = normal_sums<Real>(j.d);
    for (int p = 0; p < jacobian_coefficients<2>; ++p) {
        const auto& n = sums[p];
        out.coefficients[p] =
            (n[0] * s[0] + n[1] * s[1] + n[2] * s[2]) * (4.0 / multinomial<2>(jacobian_indices<2>[p]));
    }
    const auto unscaled = product(j.straight[0], j.straight[1]);
    out.straight = unscaled[0] * s[0] + unscaled[1] * s[1] + unscaled[2] * s[2];
    constexpr double underflow = 0x1p-1000;
    out.error = 1.0001 * error + underflow * all;
    return out;
}

/// Positively oriented 2D form of a triangle in an axis-parallel plane; nothing if its orientation is uncertain.
std::optional<NodalSimplex<2>> in_axis_plane(const SurfaceTriangle& t) {
    for (int c = 0; c < 3; ++c) {
        if (!std::ranges::all_of(t.nodes, [&](const Vec<3>& p) { return p[c] == t.nodes[0][c]; })) continue;
        NodalSimplex<2> flat;
        for (int i = 0; i < quadratic_nodes<2>; ++i) flat.nodes[i] = {t.nodes[i][(c + 1) % 3], t.nodes[i][(c + 2) % 3]};
        const BoundedJacobian<2> jacobian = bounded_jacobian(flat);
        if (!(std::abs(jacobian.straight) > jacobian.error)) return {};
        if (jacobian.straight < 0)
            for (Vec<2>& p : flat.nodes) std::swap(p.c[0], p.c[1]);
        return flat;
    }
    return {};
}

}  // namespace

BoundedJacobian<2> bounded_jacobian(const SurfaceTriangle& triangle) {
    if (const auto flat = in_axis_plane(triangle)) return bounded_jacobian(*flat);
    return projected_jacobian<double>(triangle);
}

BoundedJacobian<2> double_double_jacobian(const SurfaceTriangle& triangle) {
    if (const auto flat = in_axis_plane(triangle)) return double_double_jacobian(*flat);
    return rounded<2>(projected_jacobian<DoubleDouble>(triangle));
}

#define CAMBER_INSTANTIATE(D) \
    template std::array<JacobianSummary, pack_size> jacobian_summaries(const NodalPack<D>&, Instructions);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
