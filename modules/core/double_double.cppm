module;
#include <bit>
#include <cmath>
#include <cstdint>
module camber.core:double_double;

/// Numbers of about 106 bits as sums of two doubles (Dekker 1971, Knuth), for the elementary functions. Without fused
/// operations, which not every processor has.
namespace camber {

/// high + low, |low| at most about an ulp of high.
struct DoubleDouble {
    double high = 0;
    double low = 0;

    [[nodiscard]] constexpr double rounded() const { return high + low; }
};

/// a + b without rounding, |a| ≥ |b| or a = 0.
[[nodiscard]] constexpr DoubleDouble fast_two_sum(double a, double b) {
    const double s = a + b;
    return {s, b - (s - a)};
}
/// a + b without rounding.
[[nodiscard]] constexpr DoubleDouble two_sum(double a, double b) {
    const double s = a + b;
    const double t = s - a;
    return {s, (a - (s - t)) + (b - t)};
}
/// a b without rounding, |a| and |b| below 2^996, |a b| above 2^−960 or 0.
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
/// a times a power of two.
[[nodiscard]] constexpr DoubleDouble scaled(DoubleDouble a, double power) { return {a.high * power, a.low * power}; }
[[nodiscard]] inline DoubleDouble square_root(DoubleDouble a) {
    if (a.high <= 0) return {};
    const double root = std::sqrt(a.high);
    const DoubleDouble p = two_product(root, root);
    return fast_two_sum(root, (((a.high - p.high) - p.low) + a.low) / (2 * root));
}

/// 2^n, n within −1022 … 1023.
[[nodiscard]] constexpr double power_of_two(std::int64_t n) {
    return std::bit_cast<double>(static_cast<std::uint64_t>(n + 1023) << 52U);
}

inline constexpr DoubleDouble ln2{0x1.62e42fefa39efp-1, 0x1.abc9e3b39803fp-56};
inline constexpr DoubleDouble pi_half{0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};
inline constexpr DoubleDouble pi_whole{0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};

/// ln x for a positive and finite x, within 2^−68 of it.
[[nodiscard]] DoubleDouble log_of(double x);
[[nodiscard]] inline DoubleDouble log_of(DoubleDouble x) { return log_of(x.high) + DoubleDouble{x.low / x.high, 0}; }

}  // namespace camber
