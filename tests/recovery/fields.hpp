// Meshes of degree 2 with bent edges, and polynomials on them with derivatives in closed form.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <span>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "mapped.hpp"
#include "meshes.hpp"

import camber.core;
import camber.bezier;
import camber.recovery;

namespace camber::testing {

/// x = origin + R (stretch_i z_i) with the lattice coordinates z, in which errors are measured.
template <int D>
struct Frame {
    Vec<D> origin{};
    Vec<D> stretch = [] {
        Vec<D> one;
        for (double& c : one.c) c = 1;
        return one;
    }();
    Mat<D> rotation = Mat<D>::identity();

    [[nodiscard]] Vec<D> outside(Vec<D> z) const {
        for (int i = 0; i < D; ++i) z[i] *= stretch[i];
        return origin + rotation * z;
    }
    [[nodiscard]] Vec<D> inside(const Vec<D>& x) const {
        Vec<D> z = transposed_times(rotation, x - origin);
        for (int i = 0; i < D; ++i) z[i] /= stretch[i];
        return z;
    }
    /// ∂x/∂z.
    [[nodiscard]] Mat<D> matrix() const {
        Mat<D> m = rotation;
        for (int i = 0; i < D; ++i) m.column[i] *= stretch[i];
        return m;
    }
};

/// A lattice with vertices and nodes moved by up to `jitter` and `bend` of a cell, mapped to the frame.
template <int D>
QuadraticMesh<D> bent_mesh(const std::array<int, D>& cells, std::uint64_t seed, double jitter = 0.12,
                           double bend = 0.08, const Frame<D>& frame = {}) {
    LatticeOptions<D> options;
    options.cells = cells;
    options.jitter = jitter;
    options.seed = seed;
    QuadraticMesh<D> mesh = must(elevate(lattice_mesh<D>(options), one_thread));
    Dice dice(seed + 1);
    auto nodes = take(std::move(mesh.mid_nodes));
    for (auto& n : nodes) n.point += dice.vector<D>(-bend, bend);
    mesh.mid_nodes = std::move(nodes);
    return mapped<D>(std::move(mesh), [&](const Vec<D>& z) { return frame.outside(z); });
}
template <int D>
std::array<int, D> cells_of(int n) {
    std::array<int, D> cells;
    cells.fill(n);
    return cells;
}

/// Values at the nodes of a field of the given degree.
template <int D>
Column<double> values_of(const QuadraticMesh<D>& mesh, int degree, const std::function<double(const Vec<D>&)>& u) {
    Buffer<double> values;
    for (const Vec<D>& x : mesh.linear.points) values.push_back(u(x));
    if (degree == 2)
        for (const auto& n : mesh.mid_nodes) values.push_back(u(n.point));
    return values;
}

/// A polynomial in D variables with random coefficients.
template <int D>
class RandomPolynomial {
  public:
    RandomPolynomial(int degree, Dice& dice) {
        std::array<int, D> e{};
        const std::function<void(int, int)> fill = [&](int i, int remaining) {
            if (i == D) {
                terms_.push_back({e, dice.uniform(-1, 1)});
                return;
            }
            for (e[i] = 0; e[i] <= remaining; ++e[i]) fill(i + 1, remaining - e[i]);
            e[i] = 0;
        };
        fill(0, degree);
    }
    /// ∂_{i} ∂_{j} … at z; without axes the value.
    [[nodiscard]] double operator()(const Vec<D>& z, std::initializer_list<int> axes = {}) const {
        double sum = 0;
        for (const Term& t : terms_) {
            auto e = t.exponents;
            double term = t.c;
            for (const int a : axes) term *= e[a]--;
            for (int i = 0; i < D && term != 0; ++i) term *= std::pow(z[i], e[i]);
            sum += term;
        }
        return sum;
    }

  private:
    struct Term {
        std::array<int, D> exponents;
        double c;
    };
    std::vector<Term> terms_;
};

/// The largest error of the derivatives of a row by z, relative to the largest |u| (cells have size 1).
template <int D, class U>
double error_at(const FieldDerivatives<D>& field, std::size_t row, const Frame<D>& frame, const Vec<D>& x, const U& u) {
    const Vec<D> z = frame.inside(x);
    const Mat<D> m = frame.matrix();
    double error = 0;
    const Vec<D> g = transposed_times(m, field.gradients[row]);
    const Sym<D> h = congruence(transposed(m), field.hessians[row]);
    const CubicForm<D> t = field.thirds.empty() ? CubicForm<D>{} : pulled_back(field.thirds[row], m);
    for (int i = 0; i < D; ++i) {
        error = std::max(error, std::abs(g[i] - u(z, {i})));
        for (int j = 0; j <= i; ++j) {
            error = std::max(error, std::abs(h(i, j) - u(z, {i, j})));
            for (int k = 0; k <= j && !field.thirds.empty(); ++k)
                error = std::max(error, std::abs(t(i, j, k) - u(z, {i, j, k})));
        }
    }
    return error;
}

template <int D>
RecoveredDerivatives<D> recovered(const QuadraticMesh<D>& mesh, const std::vector<Column<double>>& fields,
                                  const RecoveryOptions& options = {}, const Execution& execution = one_thread) {
    return must(recover_derivatives<D>(mesh, fields, options, execution));
}

}  // namespace camber::testing
