// Random numbers, vectors and matrices for property tests: a property receives a seed and draws from a `Dice`.
//
//     property("the determinant of a product is the product of the determinants", [](std::uint64_t seed) { Dice
//     dice(seed); const auto a = dice.matrix<3>(); …
//     });
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <random>

import camber.core;

namespace camber::testing {

class Dice {
  public:
    explicit Dice(std::uint64_t seed) : engine_(seed) {}

    [[nodiscard]] double uniform(double low, double high) {
        return low + (high - low) * static_cast<double>(engine_() >> 11U) * 0x1p-53;
    }
    /// Uniform in 0 … n − 1.
    [[nodiscard]] std::size_t below(std::size_t n) { return engine_() % n; }

    template <int D>
    [[nodiscard]] Vec<D> vector(double low = -1, double high = 1) {
        Vec<D> v;
        for (double& x : v.c) x = uniform(low, high);
        return v;
    }
    template <int D>
    [[nodiscard]] Mat<D> matrix() {
        Mat<D> m;
        for (Vec<D>& column : m.column) column = vector<D>();
        return m;
    }
    template <int D>
    [[nodiscard]] Sym<D> symmetric(double size = 1) {
        Sym<D> s;
        for (double& x : s.c) x = uniform(-size, size);
        return s;
    }
    template <int D>
    [[nodiscard]] Vec<D> direction() {
        for (;;) {
            const Vec<D> v = vector<D>();
            if (const double n = norm(v); n > 0.1 && n < 1) return v / n;
        }
    }
    /// A rotation (determinant 1), orthonormal to rounding.
    template <int D>
    [[nodiscard]] Mat<D> rotation() {
        if constexpr (D == 2) {
            const double angle = uniform(0, 2 * std::numbers::pi);
            return {{Vec<2>{{std::cos(angle), std::sin(angle)}}, Vec<2>{{-std::sin(angle), std::cos(angle)}}}};
        } else {
            const Vec<3> a = direction<3>();
            const Vec<3> b = direction<3>();
            const Vec<3> c = normalised(cross(a, std::abs(dot(a, b)) < 0.99 ? b : Vec<3>{{a[1], -a[2], a[0]}}));
            return {{a, cross(c, a), c}};
        }
    }
    /// Barycentric coordinates of a point of a K-simplex.
    template <int K>
    [[nodiscard]] std::array<double, K + 1> barycentric() {
        std::array<double, K + 1> xi{};
        double sum = 0;
        for (double& x : xi) sum += x = -std::log(uniform(1e-9, 1));
        for (double& x : xi) x /= sum;
        return xi;
    }
    [[nodiscard]] std::mt19937_64& engine() { return engine_; }

  private:
    std::mt19937_64 engine_;
};

}  // namespace camber::testing
