module;
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
module camber.core;
import :double_double;
import :elementary;

namespace camber {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

constexpr std::uint64_t upper_bits = ~((std::uint64_t{1} << 27U) - 1);  // of a double: its first 26 digits

// ---------------------------------------------------------------- exponentials

/// 2^(i/128).
constexpr std::array<DoubleDouble, 128> make_powers() {
    const DoubleDouble t{ln2.high / 128, ln2.low / 128};
    DoubleDouble step{1, 0};
    for (int n = 14; n > 0; --n) step = DoubleDouble{1, 0} + step * t / DoubleDouble{static_cast<double>(n), 0};
    std::array<DoubleDouble, 128> out{};
    out[0] = {1, 0};
    for (std::size_t i = 1; i < out.size(); ++i) out[i] = out[i - 1] * step;
    return out;
}
constexpr auto powers = make_powers();

/// x = n ln 2 / 128 + high + low, |high| ≤ ln 2 / 256.
struct OfExponent {
    double high, low;
    std::int32_t n;
};

OfExponent reduced(DoubleDouble x) {
    // ln 2 / 128 in two parts, of which multiples of the first are exact.
    constexpr double step_high = 0x1.62e42fef80000p-8, step_low = 0x1.1cf79abc9e3b4p-43, to_integer = 0x1.8p52;
    const double shifted = x.high * 0x1.71547652b82fep+7 + to_integer;
    const double n = shifted - to_integer;
    const double rest = x.high - n * step_high, small = x.low - n * step_low;
    const double high = rest + small;
    return {high, (rest - high) + small, static_cast<std::int32_t>(std::bit_cast<std::uint64_t>(shifted))};
}

/// e^r − 1 − r.
double beyond_linear(double r) {
    return r * r * (0.5 + r * (1.0 / 6 + r * (1.0 / 24 + r * (1.0 / 120 + r * (1.0 / 720)))));
}

/// m 2^n, 0.5 < m < 4; rounded once more where it is subnormal.
double with_exponent(double m, std::int32_t n) {
    if (n > -1020 && n < 1020) return m * power_of_two(n);
    if (n >= 1020) return n > 1100 ? infinity : m * 0x1p1000 * power_of_two(n - 1000);
    return n < -1100 ? 0 : m * power_of_two(n + 1000) * 0x1p-1000;
}

double exponential(const OfExponent& r) {
    const DoubleDouble& power = powers[static_cast<std::size_t>(r.n & 127)];
    const double grown = r.high + (r.low + beyond_linear(r.high));
    return with_exponent(power.high + (power.low + power.high * grown), r.n >> 7);
}

/// e^x / 2 for x > 0, which is finite a little longer than e^x.
double half_exp(double x) {
    if (x > 711) return infinity;
    OfExponent r = reduced({x, 0});
    r.n -= 128;
    return exponential(r);
}

/// e^x for |x| < 600.
DoubleDouble exp_of(double x) {
    const OfExponent r = reduced({x, 0});
    const DoubleDouble& power = powers[static_cast<std::size_t>(r.n & 127)];
    const double low = r.low + beyond_linear(r.high);
    const DoubleDouble linear = two_product(power.high, r.high), s = fast_two_sum(power.high, linear.high);
    const double rest = s.low + (linear.low + (power.low + (power.high * low + power.low * r.high)));
    return scaled(fast_two_sum(s.high, rest), power_of_two(r.n >> 7));
}
/// e^x − 1 for |x| < 600.
DoubleDouble expm1_of(double x) {
    const OfExponent r = reduced({x, 0});
    if (r.n == 0) return fast_two_sum(r.high, r.low + beyond_linear(r.high));
    return exp_of(x) + DoubleDouble{-1, 0};
}

// ---------------------------------------------------------------- logarithms

/// For c = 1 + j/128, or half of it from `halved` on: 1/c and ln c, of which `high` has no bits below 2^−42.
struct OfCentre {
    double inverse, high, low;
};
constexpr std::size_t halved = 52;

constexpr std::array<OfCentre, 128> make_centres() {
    std::array<OfCentre, 128> out{};
    DoubleDouble ln{};
    for (std::size_t j = 0; j < out.size(); ++j) {
        const double numerator = static_cast<double>(128 + j);
        const DoubleDouble of_c = j < halved ? ln : ln - ln2;
        const double high = of_c.high + 0x1.8p10 - 0x1.8p10;
        out[j] = {(j < halved ? 128 : 256) / numerator, high, (of_c.high - high) + of_c.low};
        // ln((n + 1)/n) = 2 artanh s, s = 1/(2n + 1).
        const DoubleDouble s = DoubleDouble{1, 0} / DoubleDouble{2 * numerator + 1, 0}, z = s * s;
        DoubleDouble sum{};
        for (int k = 15; k > 0; k -= 2) sum = sum * z + DoubleDouble{2, 0} / DoubleDouble{static_cast<double>(k), 0};
        ln = ln + s * sum;
    }
    return out;
}
constexpr auto centres = make_centres();

/// x = 2^times c (1 + r + rest), c the centre next to it.
struct NearCentre {
    const OfCentre& centre;
    double times, r, rest;
};

NearCentre near_centre(double x) {
    constexpr std::uint64_t half_step = std::uint64_t{1} << 44U, fraction = (std::uint64_t{1} << 45U) - 1;
    constexpr auto smallest = std::bit_cast<std::uint64_t>((1 + static_cast<double>(halved) / 128) / 2);
    std::int64_t below = 0;
    if (x < std::numeric_limits<double>::min()) {
        x *= 0x1p54;
        below = 54;
    }
    const auto bits = std::bit_cast<std::uint64_t>(x), nearest = bits + half_step;
    const std::int64_t n = static_cast<std::int64_t>(nearest - smallest) >> 52U;
    const std::uint64_t exponent = static_cast<std::uint64_t>(n) << 52U;
    const OfCentre& centre = centres[(nearest >> 45U) & 127U];
    const double c = std::bit_cast<double>((nearest & ~fraction) - exponent);
    const double off = std::bit_cast<double>(bits - exponent) - c;
    // The first part of r has 26 bits: its square, and its product with c, are exact.
    const double r = std::bit_cast<double>(std::bit_cast<std::uint64_t>(off * centre.inverse) & upper_bits);
    return {centre, static_cast<double>(n - below), r, (off - r * c) * centre.inverse};
}

/// (ln(1 + r) − r + r²/2) / r³.
double beyond_quadratic(double r) {
    return 1.0 / 3 + r * (-0.25 + r * (0.2 + r * (-1.0 / 6 + r * (1.0 / 7 + r * (-0.125 + r * (1.0 / 9))))));
}

// ln 2 in two parts, of which multiples of the first are exact.
constexpr double ln2_high = 0x1.62e42fefa3800p-1, ln2_low = 0x1.ef35793c76730p-45;

}  // namespace

DoubleDouble log_of(double x) {
    const auto [centre, times, r, rest] = near_centre(x);
    const double whole = r + rest;
    const double low = (rest - rest * (r + 0.5 * rest)) + whole * whole * whole * beyond_quadratic(whole);
    const DoubleDouble linear = fast_two_sum(times * ln2_high + centre.high, r);
    const DoubleDouble quadratic = fast_two_sum(linear.high, -0.5 * r * r);
    return fast_two_sum(quadratic.high, (quadratic.low + linear.low) + (low + (centre.low + times * ln2_low)));
}

namespace {

/// The logarithm where it is not that of a positive and finite number.
double special_log(double x) {
    if (x == 0) return -infinity;
    return x > 0 ? x : not_a_number;  // +∞
}
bool has_log(double x) { return x > 0 && x < infinity; }

/// x^y for positive and finite x, and finite y.
double positive_pow(double x, double y) {
    const DoubleDouble ln = log_of(x);
    const double about = y * ln.high;
    if (!(std::abs(about) < 746)) return about > 0 ? infinity : 0;
    if (std::abs(about) < 0x1p-60) return 1;
    const DoubleDouble exponent = two_product(y, ln.high);
    return exponential(reduced({exponent.high, exponent.low + y * ln.low}));
}

bool is_integer(double y) { return std::floor(y) == y; }
bool is_odd(double y) { return is_integer(y) && std::abs(y) < 0x1p53 && !is_integer(y / 2); }

/// x^y of other numbers.
double special_pow(double x, double y) {
    if (y == 0 || x == 1) return 1;
    if (std::isnan(x) || std::isnan(y)) return not_a_number;
    const double magnitude = std::abs(x);
    if (std::isinf(y)) return magnitude == 1 ? 1 : (magnitude > 1) == (y > 0) ? infinity : 0;
    const double sign = std::signbit(x) && is_odd(y) ? -1 : 1;
    if (!has_log(magnitude)) return sign * ((x == 0) == (y < 0) ? infinity : 0);
    return is_integer(y) ? sign * positive_pow(magnitude, y) : not_a_number;
}

}  // namespace

double exp(double x) {
    if (!(std::abs(x) < 746)) return x > 0 ? infinity : x < 0 ? 0 : x;
    return exponential(reduced({x, 0}));
}

double exp2(double x) {
    if (!(std::abs(x) < 1076)) return x > 0 ? infinity : x < 0 ? 0 : x;
    constexpr double to_integer = 0x1.8p52;
    const double shifted = x * 128 + to_integer;
    const double rest = x - (shifted - to_integer) / 128;
    const DoubleDouble r = two_product(rest, ln2.high);
    return exponential(
        {r.high, r.low + rest * ln2.low, static_cast<std::int32_t>(std::bit_cast<std::uint64_t>(shifted))});
}

double expm1(double x) {
    if (std::abs(x) < 0x1p-54) return x;
    if (!(x < 100)) return exp(x);
    if (x < -50) return -1;
    return expm1_of(x).rounded();
}

double log(double x) {
    if (!has_log(x)) return special_log(x);
    const auto [centre, times, r, rest] = near_centre(x);  // as log_of, but for the digits of the square
    const double whole = r + rest, square = whole * whole;
    const DoubleDouble linear = fast_two_sum(times * ln2_high + centre.high, r);
    const double low = rest + square * (-0.5 + whole * beyond_quadratic(whole));
    return linear.high + (low + (linear.low + (centre.low + times * ln2_low)));
}

double log2(double x) {
    constexpr DoubleDouble unit{0x1.71547652b82fep+0, 0x1.777d0ffda0d24p-56};
    return has_log(x) ? (log_of(x) * unit).rounded() : special_log(x);
}

double log10(double x) {
    constexpr DoubleDouble unit{0x1.bcb7b1526e50ep-2, 0x1.95355baaafad3p-57};
    return has_log(x) ? (log_of(x) * unit).rounded() : special_log(x);
}

double log1p(double x) {
    if (std::abs(x) < 0x1p-40) return x - 0.5 * x * x;
    if (!(x > -1) || x == infinity) return special_log(1 + x);
    return log_of(two_sum(1, x)).rounded();
}

double pow(double x, double y) {
    if (y == 2) return x * x;
    return has_log(x) && std::abs(y) < infinity ? positive_pow(x, y) : special_pow(x, y);
}

double cbrt(double x) {
    if (x == 0 || !std::isfinite(x)) return x;
    double a = std::abs(x), unit = 1;
    if (a < 0x1p-900) {
        a *= 0x1p300;
        unit = 0x1p-100;
    } else if (a > 0x1p900) {
        a *= 0x1p-300;
        unit = 0x1p100;
    }
    // A third of the exponent, then Halley's steps, then one of Newton's with the exact remainder.
    auto y = std::bit_cast<double>(std::bit_cast<std::uint64_t>(a) / 3 + 0x2a9f7893782da1ceU);
    for (int i = 0; i < 2; ++i) {
        const double cube = y * y * y;
        y *= (cube + 2 * a) / (2 * cube + a);
    }
    y = std::bit_cast<double>(std::bit_cast<std::uint64_t>(y) & upper_bits);
    const double square = y * y;
    const DoubleDouble cube = two_product(square, y);
    const double step = ((a - cube.high) - cube.low) / (3 * square);
    return std::copysign((y + (step - step * step / y)) * unit, x);
}

double hypot(double x, double y) {
    const double a = std::fmax(std::abs(x), std::abs(y)), b = std::fmin(std::abs(x), std::abs(y));
    if (std::isinf(x) || std::isinf(y)) return infinity;
    if (std::isnan(x) || std::isnan(y)) return not_a_number;
    if (b <= a * 0x1p-54) return a;
    const double unit = a > 0x1p400 ? 0x1p600 : a < 0x1p-400 ? 0x1p-600 : 1;
    const DoubleDouble aa = two_product(a / unit, a / unit), bb = two_product(b / unit, b / unit);
    return square_root(aa + bb).rounded() * unit;
}

double sinh(double x) {
    const double a = std::abs(x);
    if (a < 0x1p-27 || !(a < infinity)) return x;
    if (a > 40) return std::copysign(half_exp(a), x);
    const DoubleDouble e = expm1_of(a);
    return std::copysign(0.5 * (e + e / (DoubleDouble{1, 0} + e)).rounded(), x);
}

double cosh(double x) {
    const double a = std::abs(x);
    if (!(a < infinity)) return a;
    if (a > 40) return half_exp(a);
    const DoubleDouble e = exp_of(a);
    return 0.5 * (e + DoubleDouble{1, 0} / e).rounded();
}

double tanh(double x) {
    const double a = std::abs(x);
    if (a < 0x1p-28 || std::isnan(x)) return x;
    if (a > 20) return std::copysign(1, x);
    const DoubleDouble e = expm1_of(2 * a);
    return std::copysign((e / (e + DoubleDouble{2, 0})).rounded(), x);
}

double asinh(double x) {
    const double a = std::abs(x);
    if (a < 0x1p-27 || !(a < infinity)) return x;
    if (a > 0x1p60) return std::copysign((log_of(a) + ln2).rounded(), x);
    const DoubleDouble root = square_root(two_product(a, a) + DoubleDouble{1, 0});
    return std::copysign(log_of(root + DoubleDouble{a, 0}).rounded(), x);
}

double acosh(double x) {
    if (!(x >= 1)) return not_a_number;
    if (x > 0x1p60) return x < infinity ? (log_of(x) + ln2).rounded() : x;
    return log_of(square_root(two_product(x, x) + DoubleDouble{-1, 0}) + DoubleDouble{x, 0}).rounded();
}

double atanh(double x) {
    const double a = std::abs(x);
    if (a < 0x1p-27 || std::isnan(x)) return x;
    if (!(a < 1)) return a == 1 ? std::copysign(infinity, x) : not_a_number;
    return std::copysign(0.5 * log_of(two_sum(1, a) / two_sum(1, -a)).rounded(), x);
}

}  // namespace camber
