module;
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
module camber.core;
import :double_double;
import :elementary;

namespace camber {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

// ---------------------------------------------------------------- arguments reduced by multiples of π/2

/// x − n π/2 within ±π/4, and n modulo 4.
struct InQuadrant {
    DoubleDouble rest;
    unsigned n = 0;
};

/// |x| < 2^20, by π/2 in four parts, of which multiples of the first three are exact (Cody and Waite).
InQuadrant reduced_by_parts(double x) {
    constexpr std::array part{0x1.921fb54400000p+0, 0x1.0b4611a600000p-34, 0x1.3198a2e000000p-69,
                              0x1.b839a252049c1p-104};
    constexpr double to_integer = 0x1.8p52;
    const double shifted = x * 0x1.45f306dc9c883p-1 + to_integer;
    const double n = shifted - to_integer;
    const DoubleDouble second = two_sum(x - n * part[0], -(n * part[1]));
    const DoubleDouble third = two_sum(second.high, -(n * part[2]));
    return {fast_two_sum(third.high, (second.low + third.low) - n * part[3]),
            static_cast<unsigned>(std::bit_cast<std::uint64_t>(shifted) & 3U)};
}

__extension__ typedef unsigned __int128 Product;

/// The bits of 2/π after 64 zeros.
constexpr std::array<std::uint64_t, 20> two_over_pi{
    0x0000000000000000, 0xa2f9836e4e441529, 0xfc2757d1f534ddc0, 0xdb6295993c439041, 0xfe5163abdebbc561,
    0xb7246e3a424dd2e0, 0x06492eea09d1921c, 0xfe1deb1cb129a73e, 0xe88235f52ebb4484, 0xe99c7026b45f7e41,
    0x3991d639835339f4, 0x9c845f8bbdf9283b, 0x1ff897ffde05980f, 0xef2f118b5a0a6d1f, 0x6d367ecf27cb09b7,
    0x4f463f669e5fea2d, 0x7527bac7ebe5f17b, 0x3d0739f78a5292ea, 0x6bfb5fb11f8d5d08, 0x56033046fc7b6bab};

/// |x| ≥ 2^20, by as many digits of 2/π as matter (Payne and Hanek): x 2/π modulo 4 with 190 bits behind the point.
InQuadrant reduced_by_digits(double x) {
    const auto bits = std::bit_cast<std::uint64_t>(x);
    const std::uint64_t mantissa = (bits & ((std::uint64_t{1} << 52U) - 1)) | (std::uint64_t{1} << 52U);
    const auto exponent = static_cast<std::int64_t>((bits >> 52U) & 0x7ffU) - 1075;  // |x| = mantissa 2^exponent
    const auto first = static_cast<std::size_t>(exponent + 62);                      // in which 2/π has the weight 2
    const auto word = [first](std::size_t i) {
        const std::size_t at = first / 64 + i, shift = first % 64;
        return shift == 0 ? two_over_pi[at] : two_over_pi[at] << shift | two_over_pi[at + 1] >> (64 - shift);
    };
    const Product last = Product{mantissa} * word(2);
    const Product middle = Product{mantissa} * word(1) + static_cast<std::uint64_t>(last >> 64U);
    std::uint64_t top = mantissa * word(0) + static_cast<std::uint64_t>(middle >> 64U);
    auto n = static_cast<unsigned>(top >> 62U);
    const auto upper = static_cast<std::uint64_t>(middle), lower = static_cast<std::uint64_t>(last);
    // The fraction as a signed number, at most a half.
    top <<= 2U;
    top |= upper >> 62U;
    n += static_cast<unsigned>(top >> 63U);
    constexpr double half_word = 0x1p-32;
    double unit = 0x1p-32;
    DoubleDouble sum{static_cast<double>(static_cast<std::int32_t>(top >> 32U)) * unit, 0};
    const std::array<std::uint64_t, 4> rest{top, upper << 2U | lower >> 62U, lower << 2U, 0};
    for (std::size_t i = 1; i < 6; ++i) {
        unit *= half_word;
        const std::uint64_t digits = i % 2 == 0 ? rest[i / 2] >> 32U : rest[i / 2] & 0xffffffffU;
        sum = sum + DoubleDouble{static_cast<double>(digits) * unit, 0};
    }
    sum = sum * pi_half;
    return std::signbit(x) ? InQuadrant{-sum, (4 - n) & 3U} : InQuadrant{sum, n & 3U};
}

InQuadrant reduced(double x) {
    if (std::abs(x) <= 0.785) return {{x, 0}, 0};
    return std::abs(x) < 0x1p20 ? reduced_by_parts(x) : reduced_by_digits(x);
}

// ---------------------------------------------------------------- sine and cosine within ±π/4

struct SineCosine {
    DoubleDouble sine, cosine;
};

/// Of i/64.
constexpr std::array<SineCosine, 52> make_sines() {
    const auto series = [](int first) {  // Σ ± t^k / k!, k from `first` in steps of 2, without the first power
        const DoubleDouble z{-0x1p-12, 0};
        DoubleDouble sum{1, 0};
        for (int k = first + 14; k > first; k -= 2)
            sum = DoubleDouble{1, 0} + sum * z / DoubleDouble{static_cast<double>(k * (k - 1)), 0};
        return sum;
    };
    const DoubleDouble sine = scaled(series(1), 0x1p-6), cosine = series(0);
    std::array<SineCosine, 52> out{};
    out[0] = {{0, 0}, {1, 0}};
    for (std::size_t i = 1; i < out.size(); ++i) {
        const auto& [s, c] = out[i - 1];
        out[i] = {s * cosine + c * sine, c * cosine - s * sine};
    }
    return out;
}
constexpr auto sines = make_sines();

/// An angle within ±π/4 as a multiple of 1/64 and the rest d: sin d = d + sine, cos d = 1 + cosine.
struct NearMultiple {
    const SineCosine& of;
    double sign, d, sine, cosine;
};
NearMultiple near_multiple(DoubleDouble r) {
    const double sign = std::signbit(r.high) ? -1 : 1, a = sign * r.high;
    const auto i = static_cast<std::size_t>(std::floor(a * 64 + 0.5));
    const double d = a - static_cast<double>(i) * 0x1p-6, z = d * d;
    return {sines[i], sign, d, sign * r.low + d * z * (-1.0 / 6 + z * (1.0 / 120 - z * (1.0 / 5040))),
            z * (-0.5 + z * (1.0 / 24 - z * (1.0 / 720)))};
}

DoubleDouble sine(DoubleDouble r) {
    if (std::abs(r.high) < 0x1p-4) {
        const double x = r.high, z = x * x;
        constexpr double c3 = -1.0 / 6, c5 = 1.0 / 120, c7 = -1.0 / 5040, c9 = 1.0 / 362880, c11 = -1.0 / 39916800;
        return fast_two_sum(x, r.low + x * z * (c3 + z * (c5 + z * (c7 + z * (c9 + z * c11)))));
    }
    const auto [of, sign, d, sine, cosine] = near_multiple(r);
    const DoubleDouble s = fast_two_sum(of.sine.high, of.cosine.high * d);
    const double low = of.sine.low + (of.sine.high * cosine + (of.cosine.high * sine + (of.cosine.low * d + s.low)));
    return scaled(fast_two_sum(s.high, low), sign);
}

DoubleDouble cosine(DoubleDouble r) {
    const auto [of, sign, d, sine, cosine] = near_multiple(r);
    return fast_two_sum(of.cosine.high, of.cosine.low + (of.cosine.high * cosine - of.sine.high * (d + sine)));
}

// ---------------------------------------------------------------- angles

/// atan(i/64).
constexpr std::array<DoubleDouble, 65> make_arcs() {
    std::array<DoubleDouble, 65> out{};
    for (std::size_t i = 0; i + 1 < out.size(); ++i) {
        // The tangent of the difference of two is t.
        const DoubleDouble t = DoubleDouble{64, 0} / DoubleDouble{static_cast<double>(4096 + i * (i + 1)), 0},
                           z = t * t;
        DoubleDouble sum{};
        for (int k = 17; k > 0; k -= 2) sum = DoubleDouble{1, 0} / DoubleDouble{static_cast<double>(k), 0} - sum * z;
        out[i + 1] = out[i] + t * sum;
    }
    return out;
}
constexpr auto arcs = make_arcs();

/// The angle of (x, y), 0 ≤ y ≤ x.
DoubleDouble angle_below_diagonal(DoubleDouble y, DoubleDouble x) {
    const double about = y.high / x.high;
    DoubleDouble t, arc;
    if (about < 0x1p-4) {
        t = y / x;
    } else {
        const auto i = static_cast<std::size_t>(std::floor(about * 64 + 0.5));
        const DoubleDouble c{static_cast<double>(i) * 0x1p-6, 0};
        t = (y - c * x) / (x + c * y);
        arc = arcs[i];
    }
    const double z = t.high * t.high;
    constexpr double c3 = -1.0 / 3, c5 = 1.0 / 5, c7 = -1.0 / 7, c9 = 1.0 / 9, c11 = -1.0 / 11, c13 = 1.0 / 13;
    const double series = t.high * z * (c3 + z * (c5 + z * (c7 + z * (c9 + z * (c11 + z * (c13 + z * (-1.0 / 15)))))));
    const DoubleDouble sum = fast_two_sum(arc.high, t.high);
    return fast_two_sum(sum.high, sum.low + (arc.low + (t.low + series)));
}

/// The angle of (x, y), y ≥ 0, within 0 … π.
DoubleDouble angle_above(DoubleDouble y, DoubleDouble x) {
    const bool left = x.high < 0;
    if (left) x = -x;
    if (y.high <= x.high) {
        const DoubleDouble angle = angle_below_diagonal(y, x);
        return left ? pi_whole - angle : angle;
    }
    const DoubleDouble angle = angle_below_diagonal(x, y);
    return left ? pi_half + angle : pi_half - angle;
}

/// √(1 − x²), |x| ≤ 1.
DoubleDouble other_leg(double x) { return square_root(DoubleDouble{1, 0} - two_product(x, x)); }

}  // namespace

double sin(double x) {
    if (std::abs(x) < 0x1p-27) return x;
    if (!std::isfinite(x)) return not_a_number;
    const auto [rest, n] = reduced(x);
    const double value = (n % 2 == 0 ? sine(rest) : cosine(rest)).rounded();
    return n >= 2 ? -value : value;
}

double cos(double x) {
    if (!std::isfinite(x)) return not_a_number;
    const auto [rest, n] = reduced(x);
    const double value = (n % 2 == 0 ? cosine(rest) : sine(rest)).rounded();
    return n == 1 || n == 2 ? -value : value;
}

double tan(double x) {
    if (std::abs(x) < 0x1p-27) return x;
    if (!std::isfinite(x)) return not_a_number;
    const auto [rest, n] = reduced(x);
    const DoubleDouble s = sine(rest), c = cosine(rest);
    return (n % 2 == 0 ? s / c : -c / s).rounded();
}

double asin(double x) {
    const double a = std::abs(x);
    if (!(a <= 1)) return not_a_number;
    if (a < 0x1p-27) return x;
    return std::copysign(angle_above({a, 0}, other_leg(a)).rounded(), x);
}

double acos(double x) {
    if (!(std::abs(x) <= 1)) return not_a_number;
    return angle_above(other_leg(x), {x, 0}).rounded();
}

double atan(double x) { return atan2(x, 1); }

double atan2(double y, double x) {
    if (std::isnan(x) || std::isnan(y)) return not_a_number;
    double a = std::abs(y), b = std::abs(x);
    if (a == b && (a == 0 || a == infinity)) {  // of all directions, those along the axes and the diagonals
        const double angle = a == 0 ? 0 : pi_half.high / 2;
        return std::copysign(std::signbit(x) ? (a == 0 ? pi_whole.high : 3 * (pi_half.high / 2)) : angle, y);
    }
    if (a >= b * 0x1p60) return std::copysign(pi_half.high, y);
    if (b >= a * 0x1p60) return x > 0 ? y / x : std::copysign(pi_whole.high, y);
    const double unit = std::fmax(a, b) > 0x1p400 ? 0x1p-600 : std::fmax(a, b) < 0x1p-400 ? 0x1p600 : 1;
    a *= unit;
    b *= unit;
    return std::copysign(angle_above({a, 0}, {std::copysign(b, x), 0}).rounded(), y);
}

}  // namespace camber
