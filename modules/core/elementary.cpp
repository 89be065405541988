// Elementary functions in double-double arithmetic. Their results are bitwise equal on every machine.
module;
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
module camber.core;

namespace camber {

namespace {

// Numbers of about 106 bits as sums of two doubles (Dekker 1971, Knuth). Fused operations are not used, because some
// processors lack them.

/// The number high + low, where |low| is at most about one ulp of high.
struct DoubleDouble {
    double high = 0;
    double low = 0;

    [[nodiscard]] constexpr double rounded() const { return high + low; }
};

/// Returns a + b exactly. Requires |a| ≥ |b| or a = 0.
[[nodiscard]] constexpr DoubleDouble fast_two_sum(double a, double b) {
    const double s = a + b;
    return {s, b - (s - a)};
}
[[nodiscard]] constexpr DoubleDouble two_sum(double a, double b) {
    const double s = a + b;
    const double t = s - a;
    return {s, (a - (s - t)) + (b - t)};
}
/// Returns a b exactly. Requires |a|, |b| < 2^996, and |a b| > 2^−960 or a b = 0.
[[nodiscard]] constexpr DoubleDouble two_product(double a, double b) {
    constexpr double splitter = 0x1p27 + 1;
    const double ta = splitter * a, tb = splitter * b;
    const double a_high = ta - (ta - a), b_high = tb - (tb - b);
    const double a_low = a - a_high, b_low = b - b_high;
    const double p = a * b;
    return {p, ((a_high * b_high - p) + a_high * b_low + a_low * b_high) + a_low * b_low};
}

[[nodiscard]] constexpr DoubleDouble operator-(DoubleDouble a) { return {-a.high, -a.low}; }
[[nodiscard]] constexpr DoubleDouble operator+(DoubleDouble a, DoubleDouble b) {
    const DoubleDouble s = two_sum(a.high, b.high);
    return fast_two_sum(s.high, s.low + (a.low + b.low));
}
[[nodiscard]] constexpr DoubleDouble operator-(DoubleDouble a, DoubleDouble b) { return a + -b; }
[[nodiscard]] constexpr DoubleDouble operator*(DoubleDouble a, DoubleDouble b) {
    const DoubleDouble p = two_product(a.high, b.high);
    return fast_two_sum(p.high, p.low + (a.high * b.low + a.low * b.high));
}
[[nodiscard]] constexpr DoubleDouble operator/(DoubleDouble a, DoubleDouble b) {
    const double q = a.high / b.high;
    const DoubleDouble p = two_product(q, b.high);
    return fast_two_sum(q, (((a.high - p.high) - p.low) + (a.low - q * b.low)) / b.high);
}
[[nodiscard]] constexpr DoubleDouble scaled(DoubleDouble a, double power) { return {a.high * power, a.low * power}; }
[[nodiscard]] DoubleDouble square_root(DoubleDouble a) {
    if (a.high <= 0) return {};
    const double root = std::sqrt(a.high);
    const DoubleDouble p = two_product(root, root);
    return fast_two_sum(root, (((a.high - p.high) - p.low) + a.low) / (2 * root));
}

[[nodiscard]] constexpr double power_of_two(std::int64_t n) {
    return std::bit_cast<double>(static_cast<std::uint64_t>(n + 1023) << 52U);
}

constexpr DoubleDouble ln2{0x1.62e42fefa39efp-1, 0x1.abc9e3b39803fp-56};
constexpr DoubleDouble pi_half{0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};
constexpr DoubleDouble pi_whole{0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

constexpr std::uint64_t upper_bits = ~((std::uint64_t{1} << 27U) - 1);  // mask of the first 26 digits of a double

// ---------------------------------------------------------------- exponentials

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

/// Parts of an argument of exp: x = n ln 2 / 128 + high + low, with |high| ≤ ln 2 / 256.
struct OfExponent {
    double high, low;
    std::int32_t n;
};

OfExponent reduced(DoubleDouble x) {
    // ln 2 / 128 as the sum of two parts. The products of the first part with the used integers are exact.
    constexpr double step_high = 0x1.62e42fef80000p-8, step_low = 0x1.1cf79abc9e3b4p-43, to_integer = 0x1.8p52;
    const double shifted = x.high * 0x1.71547652b82fep+7 + to_integer;
    const double n = shifted - to_integer;
    const double rest = x.high - n * step_high, small = x.low - n * step_low;
    const double high = rest + small;
    return {high, (rest - high) + small, static_cast<std::int32_t>(std::bit_cast<std::uint64_t>(shifted))};
}

double beyond_linear(double r) {
    return r * r * (0.5 + r * (1.0 / 6 + r * (1.0 / 24 + r * (1.0 / 120 + r * (1.0 / 720)))));
}

/// Returns m 2^n for 0.5 < m < 4; subnormal results are rounded once more.
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

/// Returns e^x / 2 for x > 0. It is still finite for x slightly beyond the overflow of e^x.
double half_exp(double x) {
    if (x > 711) return infinity;
    OfExponent r = reduced({x, 0});
    r.n -= 128;
    return exponential(r);
}

/// Returns e^x for |x| < 600.
DoubleDouble exp_of(double x) {
    const OfExponent r = reduced({x, 0});
    const DoubleDouble& power = powers[static_cast<std::size_t>(r.n & 127)];
    const double low = r.low + beyond_linear(r.high);
    const DoubleDouble linear = two_product(power.high, r.high), s = fast_two_sum(power.high, linear.high);
    const double rest = s.low + (linear.low + (power.low + (power.high * low + power.low * r.high)));
    return scaled(fast_two_sum(s.high, rest), power_of_two(r.n >> 7));
}
DoubleDouble expm1_of(double x) {
    const OfExponent r = reduced({x, 0});
    if (r.n == 0) return fast_two_sum(r.high, r.low + beyond_linear(r.high));
    return exp_of(x) + DoubleDouble{-1, 0};
}

// ---------------------------------------------------------------- logarithms

/// Table row of a centre c: 1/c, and ln c = high + low. c is 1 + j/128 for table index j < `halved`, and half of this
/// for the other indices. `high` has no bits below 2^−42.
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

/// Parts of an argument of ln: x = 2^times c (1 + r + rest), where c is the nearest centre.
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
    // r has 26 bits, so its square and its product with c are exact.
    const double r = std::bit_cast<double>(std::bit_cast<std::uint64_t>(off * centre.inverse) & upper_bits);
    return {centre, static_cast<double>(n - below), r, (off - r * c) * centre.inverse};
}

/// Returns (ln(1 + r) − r + r²/2) / r³.
double beyond_quadratic(double r) {
    return 1.0 / 3 + r * (-0.25 + r * (0.2 + r * (-1.0 / 6 + r * (1.0 / 7 + r * (-0.125 + r * (1.0 / 9))))));
}

// ln 2 as the sum of two parts. The products of the first part with the used integers are exact.
constexpr double ln2_high = 0x1.62e42fefa3800p-1, ln2_low = 0x1.ef35793c76730p-45;

/// Returns ln x for positive, finite x, with a relative error of at most 2^−68.
DoubleDouble log_of(double x) {
    const auto [centre, times, r, rest] = near_centre(x);
    const double whole = r + rest;
    const double low = (rest - rest * (r + 0.5 * rest)) + whole * whole * whole * beyond_quadratic(whole);
    const DoubleDouble linear = fast_two_sum(times * ln2_high + centre.high, r);
    const DoubleDouble quadratic = fast_two_sum(linear.high, -0.5 * r * r);
    return fast_two_sum(quadratic.high, (quadratic.low + linear.low) + (low + (centre.low + times * ln2_low)));
}
DoubleDouble log_of(DoubleDouble x) { return log_of(x.high) + DoubleDouble{x.low / x.high, 0}; }

double special_log(double x) {
    if (x == 0) return -infinity;
    return x > 0 ? x : not_a_number;  // +∞
}
bool has_log(double x) { return x > 0 && x < infinity; }

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
    const auto [centre, times, r, rest] = near_centre(x);  // unlike log_of, evaluates the terms after r in plain
                                                           // doubles
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
    // Divides the exponent by 3, then makes Halley iterations, then a Newton iteration with the exact residual.
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

namespace {

// ---------------------------------------------------------------- arguments reduced by multiples of π/2

/// An argument x reduced to the angle x − n π/2 within ±π/4, and n modulo 4.
struct InQuadrant {
    DoubleDouble rest;
    unsigned n = 0;
};

/// For |x| < 2^20: subtracts π/2 in four parts, where multiples of the first three are exact (Cody and Waite).
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

/// Binary digits of 2/π, preceded by 64 zero bits.
constexpr std::array<std::uint64_t, 20> two_over_pi{
    0x0000000000000000, 0xa2f9836e4e441529, 0xfc2757d1f534ddc0, 0xdb6295993c439041, 0xfe5163abdebbc561,
    0xb7246e3a424dd2e0, 0x06492eea09d1921c, 0xfe1deb1cb129a73e, 0xe88235f52ebb4484, 0xe99c7026b45f7e41,
    0x3991d639835339f4, 0x9c845f8bbdf9283b, 0x1ff897ffde05980f, 0xef2f118b5a0a6d1f, 0x6d367ecf27cb09b7,
    0x4f463f669e5fea2d, 0x7527bac7ebe5f17b, 0x3d0739f78a5292ea, 0x6bfb5fb11f8d5d08, 0x56033046fc7b6bab};

/// For |x| ≥ 2^20: computes x 2/π modulo 4 with 190 fractional bits (Payne and Hanek).
InQuadrant reduced_by_digits(double x) {
    const auto bits = std::bit_cast<std::uint64_t>(x);
    const std::uint64_t mantissa = (bits & ((std::uint64_t{1} << 52U) - 1)) | (std::uint64_t{1} << 52U);
    const auto exponent = static_cast<std::int64_t>((bits >> 52U) & 0x7ffU) - 1075;  // |x| = mantissa 2^exponent
    const auto first = static_cast<std::size_t>(exponent + 62);                      // index of the first used bit of
                                                                                     // 2/π: its weight times 2^exponent
                                                                                     // is 2
    const auto word = [first](std::size_t i) {
        const std::size_t at = first / 64 + i, shift = first % 64;
        return shift == 0 ? two_over_pi[at] : two_over_pi[at] << shift | two_over_pi[at + 1] >> (64 - shift);
    };
    const Product last = Product{mantissa} * word(2);
    const Product middle = Product{mantissa} * word(1) + static_cast<std::uint64_t>(last >> 64U);
    std::uint64_t top = mantissa * word(0) + static_cast<std::uint64_t>(middle >> 64U);
    auto n = static_cast<unsigned>(top >> 62U);
    const auto upper = static_cast<std::uint64_t>(middle), lower = static_cast<std::uint64_t>(last);
    // Makes the fraction a signed number of at most 1/2 in magnitude.
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

InQuadrant in_quadrant(double x) {
    if (std::abs(x) <= 0.785) return {{x, 0}, 0};
    return std::abs(x) < 0x1p20 ? reduced_by_parts(x) : reduced_by_digits(x);
}

// ---------------------------------------------------------------- sine and cosine within ±π/4

struct SineCosine {
    DoubleDouble sine, cosine;
};

constexpr std::array<SineCosine, 52> make_sines() {
    const auto series = [](int first) {  // returns Σ ± t^k / k! for k = `first`, `first` + 2, …, divided by the first
                                         // power of t
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

/// An angle within ±π/4 is a multiple of 1/64 plus d, with sin d = d + sine and cos d = 1 + cosine.
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

constexpr std::array<DoubleDouble, 65> make_arcs() {
    std::array<DoubleDouble, 65> out{};
    for (std::size_t i = 0; i + 1 < out.size(); ++i) {
        // t is the tangent of the difference of two consecutive arcs.
        const DoubleDouble t = DoubleDouble{64, 0} / DoubleDouble{static_cast<double>(4096 + i * (i + 1)), 0},
                           z = t * t;
        DoubleDouble sum{};
        for (int k = 17; k > 0; k -= 2) sum = DoubleDouble{1, 0} / DoubleDouble{static_cast<double>(k), 0} - sum * z;
        out[i + 1] = out[i] + t * sum;
    }
    return out;
}
constexpr auto arcs = make_arcs();

/// Returns the angle between the x axis and the vector (x, y), for 0 ≤ y ≤ x.
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

DoubleDouble other_leg(double x) { return square_root(DoubleDouble{1, 0} - two_product(x, x)); }

}  // namespace

double sin(double x) {
    if (std::abs(x) < 0x1p-27) return x;
    if (!std::isfinite(x)) return not_a_number;
    const auto [rest, n] = in_quadrant(x);
    const double value = (n % 2 == 0 ? sine(rest) : cosine(rest)).rounded();
    return n >= 2 ? -value : value;
}

double cos(double x) {
    if (!std::isfinite(x)) return not_a_number;
    const auto [rest, n] = in_quadrant(x);
    const double value = (n % 2 == 0 ? cosine(rest) : sine(rest)).rounded();
    return n == 1 || n == 2 ? -value : value;
}

double tan(double x) {
    if (std::abs(x) < 0x1p-27) return x;
    if (!std::isfinite(x)) return not_a_number;
    const auto [rest, n] = in_quadrant(x);
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
    if (a == b && (a == 0 || a == infinity)) {  // directions along the axes and the diagonals
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
