module;
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>
#include <vector>
module camber.validity;
import camber.core;
import camber.bezier;
import :certificate;
import :coefficients;
import :jacobian;
import :motion;
import :subdivide;
import :tensor;
import :twice;
import :verdict;

namespace camber {

namespace {

template <int D>
using Moving = Tensor<D, D, double>;

/// det J over ξ and s, and what rounding may have done to each number.
template <int D>
struct BoundedMotion {
    Moving<D> whole;
    double error = 0;  ///< of a coefficient before the first bisection
    double step = 0;   ///< more of it for each bisection
    double asked = 0;  ///< the bound, at least 0
};

/// Coefficients over ξ and s in numbers of the kind, and the error bound of each.
template <int D, class Real>
struct MotionCoefficients {
    std::array<std::array<Real, jacobian_coefficients<D>>, D + 1> values{};
    std::array<Real, D + 1> straight{};
    Real error{};
};

/// det is linear in each column: the coefficient of s^k (1 − s)^(D−k) is the mean over the choices of k columns that
/// are those of the end. The error bound of one such set of columns, with the larger w of both ends, covers the mean
/// too (`error_bound`).
template <int D, class Real>
MotionCoefficients<D, Real> motion_in(const NodalSimplex<D>& from, const NodalSimplex<D>& to) {
    const auto start = columns_of_nodes<D, Real>([&](int node, int c) { return Real(from.nodes[node][c]); });
    const auto end = columns_of_nodes<D, Real>([&](int node, int c) { return Real(to.nodes[node][c]); });
    MotionCoefficients<D, Real> motion;
    for (unsigned chosen = 0; chosen < (1U << D); ++chosen) {
        auto d = start.d;
        auto edges = start.straight;
        for (int a = 0; a < D; ++a)
            if ((chosen >> a) & 1U) d[a] = end.d[a], edges[a] = end.straight[a];
        const auto c = coefficients_of<D, Real>(d);
        const int k = std::popcount(chosen);
        const double share = 1.0 / binomial(D, k);
        for (int p = 0; p < jacobian_coefficients<D>; ++p) motion.values[k][p] += share * c[p];
        motion.straight[k] += share * determinant<D, Real>(edges);
    }
    ColumnBounds<D, Real> w;
    for (int a = 0; a < D; ++a)
        for (int c = 0; c < D; ++c) w[a][c] = larger<Real>(start.w[a][c], end.w[a][c]);
    motion.error = error_bound<D, Real>(w);
    return motion;
}

/// A bisection's roundings are those of `Blur` in verdict.cpp.
template <int D>
BoundedMotion<D> bounded(const MotionCoefficients<D, double>& c, double bound) {
    BoundedMotion<D> motion;
    double largest = 0;
    for (int k = 0; k <= D; ++k) {
        motion.whole.values[k] = c.values[k];
        motion.whole.straight[k] = c.straight[k];
        largest = std::max(largest, std::abs(c.straight[k]));
        for (const double x : c.values[k]) largest = std::max(largest, std::abs(x));
    }
    motion.asked = std::max(bound, 0.0);
    motion.error = c.error * (1 + motion.asked) * 1.0001;
    motion.step = (0x1p-51 * largest + 0x1p-1070) * (1 + motion.asked) * 1.0001;
    return motion;
}

template <int D>
BoundedMotion<D> motion_of(const NodalSimplex<D>& from, const NodalSimplex<D>& to, double bound) {
    return bounded<D>(motion_in<D, double>(from, to), bound);
}

/// The same by numbers of twice the digits, rounded at the end. The factors (of a coefficient, of a mean) are rounded
/// to doubles, but the same for all terms, so that they err by 2 u of the mean; the last rounding by u.
template <int D>
BoundedMotion<D> sharp_motion_of(const NodalSimplex<D>& from, const NodalSimplex<D>& to, double bound) {
    const auto twice = motion_in<D, Twice>(from, to);
    MotionCoefficients<D, double> rounded;
    double largest = 0;
    for (int k = 0; k <= D; ++k) {
        for (int p = 0; p < jacobian_coefficients<D>; ++p) {
            rounded.values[k][p] = twice.values[k][p].high;
            largest = std::max(largest, std::abs(rounded.values[k][p]));
        }
        rounded.straight[k] = twice.straight[k].high;
        largest = std::max(largest, std::abs(rounded.straight[k]));
    }
    rounded.error = twice.error.high + 0x1p-50 * largest;
    return bounded<D>(rounded, bound);
}

/// Neither NaN nor overflow: sums of infinities are one or the other.
template <int D>
bool finite(const BoundedMotion<D>& motion) {
    double sum = motion.error + motion.step;
    for (const auto& row : motion.whole.values)
        for (const double c : row) sum += std::abs(c);
    for (const double x : motion.whole.straight) sum += std::abs(x);
    return std::isfinite(sum);
}

/// Good when every coefficient is above the bound beyond its error, bad when one that is a value of det J is below it.
/// A corner that is neither remains one of parts, and where the coefficients bend by less than what rounding blurs,
/// bisections tell no more: stuck.
template <int D>
PartVerdict judge(const BoundedMotion<D>& motion, const Moving<D>& part) {
    const double blur = motion.error + motion.step * part.depth;
    bool good = true;
    bool doubtful = false;
    for (int k = 0; k <= D; ++k) {
        const double least = motion.asked * std::abs(part.straight[k]);
        const double slack = blur + least * 0x1p-50;
        for (const double c : part.values[k]) good &= c > least + slack;
        if (k == 0 || k == D)
            for (const int i : corner_coefficients<D>) {
                if (part.values[k][i] < least - slack) return PartVerdict::bad;
                doubtful |= part.values[k][i] <= least + slack;
            }
    }
    if (good) return PartVerdict::good;
    return doubtful || largest_bend(part).size < 0.125 * motion.error ? PartVerdict::stuck : PartVerdict::split;
}

/// The corner that is farthest below the bound: row and local vertex.
template <int D>
std::pair<int, int> failing_corner(const BoundedMotion<D>& motion, const Moving<D>& part) {
    std::pair<int, int> lowest{0, 0};
    const auto excess = [&](int k, int i) {
        return part.values[k][corner_coefficients<D>[i]] - motion.asked * std::abs(part.straight[k]);
    };
    for (const int k : {0, D})
        for (int i = 0; i <= D; ++i)
            if (excess(k, i) < excess(lowest.first, lowest.second)) lowest = {k, i};
    return lowest;
}

/// Parts of a motion looked at in doubles, and of one piece of it in `certified_step`.
constexpr int max_motion_parts = 2000;
constexpr int max_piece_parts = 400;

template <int D>
int moving_nodes(const NodalSimplex<D>& from, const NodalSimplex<D>& to) {
    int count = 0;
    for (int i = 0; i < quadratic_nodes<D>; ++i) count += !(from.nodes[i] == to.nodes[i]);
    return count;
}

template <int D>
MotionCertificate<D> in_doubles(const BoundedMotion<D>& motion) {
    MotionCertificate<D> certificate;
    if (!finite(motion)) return certificate;
    int deepest = 0;
    certificate.verdict = search<D, D, double>(
        motion.whole, {exact_places, max_motion_parts},
        [&](const Moving<D>& part) {
            deepest = std::max(deepest, part.depth);
            return judge(motion, part);
        },
        [&](const Moving<D>& part) {
            const auto place = place_of(part);
            const auto [k, i] = failing_corner(motion, part);
            certificate.witness = MotionWitness<D>{place.steps[k > 0], place.corners[i]};
        });
    if (deepest > 0) certificate.level = Level::bisection;
    return certificate;
}

template <int D>
MotionCertificate<D> at_an_end(const Certificate<D>& end, double step) {
    MotionCertificate<D> certificate{end.verdict, end.level, {}};
    if (end.witness) certificate.witness = MotionWitness<D>{step, *end.witness};
    return certificate;
}

}  // namespace

template <int D>
MotionCertificate<D> certify_motion(const NodalSimplex<D>& from, const NodalSimplex<D>& to, double bound) {
    const BoundedMotion<D> motion = motion_of(from, to, bound);
    if (finite(motion) && judge(motion, motion.whole) == PartVerdict::good) return {Verdict::valid, Level::filter, {}};
    const Certificate<D> start = certify(from, bound);
    if (start.verdict == Verdict::invalid) return at_an_end(start, 0);
    const Certificate<D> end = certify(to, bound);
    if (end.verdict == Verdict::invalid) return at_an_end(end, 1);
    if (moving_nodes(from, to) <= 1) {
        // det J is affine in s at each point, |det straight| convex: what holds at both ends holds in between.
        const bool valid = start.verdict == Verdict::valid && end.verdict == Verdict::valid;
        return {valid ? Verdict::valid : Verdict::undecided, std::max(start.level, end.level), {}};
    }
    MotionCertificate<D> certificate = in_doubles(motion);
    if (certificate.verdict != Verdict::undecided) return certificate;
    certificate = in_doubles(sharp_motion_of(from, to, bound));
    certificate.level = Level::twice;
    if (certificate.verdict != Verdict::undecided) return certificate;
    return certify_motion_exactly(from, to, bound);
}

template <int D>
double certified_step(const NodalSimplex<D>& from, const NodalSimplex<D>& to, double bound) {
    if (decide(from, bound) != Verdict::valid) return 0;
    if (certify_motion(from, to, bound).verdict == Verdict::valid) return 1;
    const BoundedMotion<D> motion = sharp_motion_of(from, to, bound);
    if (!finite(motion)) return 0;
    // Pieces of the motion in their order, halved until they are certified, or as short as the resolution.
    std::vector<Moving<D>> pieces{motion.whole};
    double certified = 0;
    while (!pieces.empty()) {
        const Moving<D> piece = pieces.back();
        pieces.pop_back();
        const Verdict verdict = search<D, D, double>(
            piece, {exact_places, max_piece_parts}, [&](const Moving<D>& part) { return judge(motion, part); },
            [](const Moving<D>&) {});
        const auto steps = place_of(piece).steps;
        if (verdict == Verdict::valid) {
            certified = steps[1];
            continue;
        }
        if (steps[1] - steps[0] <= step_resolution) break;
        pieces.push_back(half(piece, step_direction<D>, 1));
        pieces.push_back(half(piece, step_direction<D>, 0));
    }
    return certified;
}

#define CAMBER_INSTANTIATE(D)                                                                                \
    template MotionCertificate<D> certify_motion<D>(const NodalSimplex<D>&, const NodalSimplex<D>&, double); \
    template double certified_step<D>(const NodalSimplex<D>&, const NodalSimplex<D>&, double);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
