module;
#include <cstddef>
#include <cstdint>
export module camber.shapes:random;
import camber.core;

export namespace camber {

/// A counter-based generator: the n-th number depends on the seed and on n alone, not on what was drawn before. (The
/// distributions of the standard library differ between libraries.)
struct Noise {
    std::uint64_t seed = 1;

    /// 64 well-mixed bits of (seed, a, b): two rounds of the finaliser of SplitMix64.
    [[nodiscard]] constexpr std::uint64_t bits(std::uint64_t a, std::uint64_t b = 0) const {
        return mix(mix(seed + 0x9e3779b97f4a7c15ULL * (a + 1)) + 0xd1b54a32d192ed03ULL * (b + 1));
    }
    /// Uniform in [−1, 1), 53 bits.
    [[nodiscard]] constexpr double symmetric(std::uint64_t a, std::uint64_t b = 0) const {
        return static_cast<double>(bits(a, b) >> 11U) * 0x1p-52 - 1.0;
    }
    /// Each coordinate uniform in [−1, 1).
    template <int D>
    [[nodiscard]] constexpr Vec<D> vector(std::uint64_t a, std::uint64_t b = 0) const {
        Vec<D> v;
        for (int i = 0; i < D; ++i) v[i] = symmetric(a, b * D + i);
        return v;
    }
    /// Another independent generator.
    [[nodiscard]] constexpr Noise stream(std::uint64_t i) const { return {bits(i, 0x5eedULL)}; }

  private:
    static constexpr std::uint64_t mix(std::uint64_t z) {
        z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
        z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
        return z ^ (z >> 31U);
    }
};

}  // namespace camber
