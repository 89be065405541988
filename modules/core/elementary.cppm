export module camber.core:elementary;

/// Elementary functions with defined rounding. Those of the C library choose their code by the processor, and their
/// last digit with it: a mesh would depend on the machine. These use IEEE additions, multiplications, divisions and
/// square roots only, in one order, so that they return the same bytes on every processor. Special values are those of
/// C (IEEE 754, annex F), without errno. `tests/core/elementary.cpp` tests each against a wider type; the error is
/// below 0.6 ulp, below 1 ulp for subnormal results.
export namespace camber {

[[nodiscard]] double exp(double x);
[[nodiscard]] double exp2(double x);
/// e^x − 1.
[[nodiscard]] double expm1(double x);
[[nodiscard]] double log(double x);
[[nodiscard]] double log2(double x);
[[nodiscard]] double log10(double x);
/// ln(1 + x).
[[nodiscard]] double log1p(double x);
/// x^y; exactly x·x rounded for y = 2.
[[nodiscard]] double pow(double x, double y);
[[nodiscard]] double cbrt(double x);
/// √(x² + y²) without overflow on the way.
[[nodiscard]] double hypot(double x, double y);

[[nodiscard]] double sinh(double x);
[[nodiscard]] double cosh(double x);
[[nodiscard]] double tanh(double x);
[[nodiscard]] double asinh(double x);
[[nodiscard]] double acosh(double x);
[[nodiscard]] double atanh(double x);

[[nodiscard]] double sin(double x);
[[nodiscard]] double cos(double x);
[[nodiscard]] double tan(double x);
[[nodiscard]] double asin(double x);
[[nodiscard]] double acos(double x);
[[nodiscard]] double atan(double x);
/// The angle of (x, y), within ±π.
[[nodiscard]] double atan2(double y, double x);

}  // namespace camber
