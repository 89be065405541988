module;
#include <cstddef>
#include <cstdint>

// With CAMBER_BASELINE_INSTRUCTIONS a build has the baseline's kernels alone: sanitizers take minutes for each copy of
// a large one.
#if defined(__x86_64__) && !defined(CAMBER_BASELINE_INSTRUCTIONS)
#define CAMBER_WIDER_INSTRUCTIONS
#endif
export module camber.core:pack;

/// Kernels over packs: eight numbers that go through the same operations, in whatever registers the processor has. A
/// kernel uses IEEE operations, selections by lane and the functions below, and nothing across lanes: so each lane has
/// the same bytes with every set of instructions, alone and beside any other.
///
/// What works on packs is always inlined into the function that was made for a set of instructions
/// (`with_instructions`): compiled by itself it would pass packs in other registers than its caller does.
export namespace camber {

/// How many numbers a pack has, for every set of instructions.
inline constexpr int pack_size = 8;

using Pack = double __attribute__((ext_vector_type(8)));
/// Lanes: −1 where true, 0 where false.
using Mask = std::int64_t __attribute__((ext_vector_type(8)));

[[nodiscard, gnu::always_inline]] inline Pack packed(double x) { return Pack(x); }
/// Where mask, a; elsewhere b.
[[nodiscard, gnu::always_inline]] inline Pack select(Mask mask, Pack a, Pack b) { return mask ? a : b; }
[[nodiscard, gnu::always_inline]] inline Pack abs(Pack x) { return __builtin_elementwise_abs(x); }
[[nodiscard, gnu::always_inline]] inline Pack sqrt(Pack x) { return __builtin_elementwise_sqrt(x); }
/// |x| with the sign of y.
[[nodiscard, gnu::always_inline]] inline Pack copysign(Pack x, Pack y) { return __builtin_elementwise_copysign(x, y); }
/// b where a is not a number.
[[nodiscard, gnu::always_inline]] inline Pack min(Pack a, Pack b) { return a < b ? a : b; }
[[nodiscard, gnu::always_inline]] inline Pack max(Pack a, Pack b) { return a > b ? a : b; }
[[nodiscard, gnu::always_inline]] inline bool any(Mask mask) { return __builtin_reduce_or(mask) != 0; }

/// The bits of a pack, and a pack of bits.
[[nodiscard, gnu::always_inline]] inline Mask bits_of(Pack x) { return __builtin_bit_cast(Mask, x); }
[[nodiscard, gnu::always_inline]] inline Pack of_bits(Mask bits) { return __builtin_bit_cast(Pack, bits); }

/// e^x within 1.5 ulp. Beyond ±708 that of ±708: no infinities and no subnormals come of finite numbers.
[[nodiscard, gnu::always_inline]] inline Pack exp(Pack x) {
    constexpr double log2e = 0x1.71547652b82fep+0;
    // ln 2 in two parts, of which multiples of the first are exact (Cody and Waite).
    constexpr double ln2_high = 0x1.62e42fee00000p-1;
    constexpr double ln2_low = 0x1.a39ef35793c76p-33;
    constexpr double to_integer = 0x1.8p52;  // x + this − this is x rounded
    x = x < -708 ? packed(-708) : x;
    x = x > 708 ? packed(708) : x;
    const Pack shifted = x * log2e + to_integer;
    const Pack n = shifted - to_integer;
    const Pack r = (x - n * ln2_high) - n * ln2_low;  // |r| ≤ ln 2 / 2
    // Taylor: the next term is below 5e-18.
    Pack p = packed(1.0 / 6227020800.0);
    p = p * r + 1.0 / 479001600.0;
    p = p * r + 1.0 / 39916800.0;
    p = p * r + 1.0 / 3628800.0;
    p = p * r + 1.0 / 362880.0;
    p = p * r + 1.0 / 40320.0;
    p = p * r + 1.0 / 5040.0;
    p = p * r + 1.0 / 720.0;
    p = p * r + 1.0 / 120.0;
    p = p * r + 1.0 / 24.0;
    p = p * r + 1.0 / 6.0;
    p = p * r + 0.5;
    const Pack e = 1 + (r + r * r * p);
    // The low bits of `shifted` are the integer: added to the exponent.
    return of_bits(bits_of(e) + (bits_of(shifted) << 52));
}

/// ln x within 2 ulp, x > 0 and normal; not a number elsewhere.
[[nodiscard, gnu::always_inline]] inline Pack log(Pack x) {
    constexpr double ln2_high = 0x1.62e42fee00000p-1;
    constexpr double ln2_low = 0x1.a39ef35793c76p-33;
    constexpr std::int64_t half_sqrt2 = 0x3fe6a09e667f3bcd;  // bits of √½
    // x = 2^n m, √½ ≤ m < √2.
    const Mask bits = bits_of(x);
    const Mask n = (bits - half_sqrt2) >> 52;
    const Pack m = of_bits(bits - (n << 52));
    const Pack exponent = __builtin_convertvector(n, Pack);
    // ln m = 2 artanh s.
    const Pack s = (m - 1) / (m + 1);
    const Pack z = s * s;
    Pack p = packed(2.0 / 23);
    p = p * z + 2.0 / 21;
    p = p * z + 2.0 / 19;
    p = p * z + 2.0 / 17;
    p = p * z + 2.0 / 15;
    p = p * z + 2.0 / 13;
    p = p * z + 2.0 / 11;
    p = p * z + 2.0 / 9;
    p = p * z + 2.0 / 7;
    p = p * z + 2.0 / 5;
    p = p * z + 2.0 / 3;
    const Pack ln = exponent * ln2_high + (2 * s + (s * z * p + exponent * ln2_low));
    return x > 0 ? ln : packed(__builtin_nan(""));
}

/// The registers that a kernel is compiled for.
enum class Instructions : std::uint8_t {
    baseline,  ///< what the program as a whole is compiled for (SSE2 on x86-64)
    avx2,
    avx512,
};

/// Whether this processor has them, and this build kernels for them.
[[nodiscard]] inline bool has(Instructions set) {
#ifdef CAMBER_WIDER_INSTRUCTIONS
    switch (set) {
        case Instructions::avx512: return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq");
        case Instructions::avx2: return __builtin_cpu_supports("avx2") != 0;
        case Instructions::baseline: return true;
    }
#endif
    return set == Instructions::baseline;
}
/// The widest that it has.
[[nodiscard]] inline Instructions widest_instructions() {
    static const Instructions widest = has(Instructions::avx512) ? Instructions::avx512
                                       : has(Instructions::avx2) ? Instructions::avx2
                                                                 : Instructions::baseline;
    return widest;
}

#ifdef CAMBER_WIDER_INSTRUCTIONS
template <class Kernel>
[[gnu::target("avx512f,avx512dq")]] void with_avx512(const Kernel& kernel) {
    kernel();
}
template <class Kernel>
[[gnu::target("avx2")]] void with_avx2(const Kernel& kernel) {
    kernel();
}
#endif

/// A function of its own too, so that a caller of several kernels is not all of them.
template <class Kernel>
[[gnu::noinline]] void with_baseline(const Kernel& kernel) {
    kernel();
}

/// kernel(), compiled for that set; kernel: `[&]() __attribute__((always_inline)) { … }`. The processor must have it.
template <class Kernel>
void with_instructions([[maybe_unused]] Instructions set, const Kernel& kernel) {
#ifdef CAMBER_WIDER_INSTRUCTIONS
    if (set == Instructions::avx512) return with_avx512(kernel);
    if (set == Instructions::avx2) return with_avx2(kernel);
#endif
    with_baseline(kernel);
}

}  // namespace camber
