// An independent minimisation of Q of a cubic form: log-simplex on 1 500 directions with linear programs solved by an
// interior-point method. The bound is searched over 5 000 directions. Shares no code with the module.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

import camber.core;
import camber.metric;

namespace camber::testing {

template <int D>
std::vector<Vec<D>> oracle_directions(int n) {
    std::vector<Vec<D>> out;
    for (int i = 0; i < n; ++i) {
        if constexpr (D == 2) {
            const double a = std::numbers::pi * (i + 0.37) / n;
            out.push_back({{std::cos(a), std::sin(a)}});
        } else {
            const double z = (i + 0.5) / n, r = std::sqrt(1 - z * z), a = std::numbers::pi * (1 + std::sqrt(5.0)) * i;
            out.push_back({{r * std::cos(a), r * std::sin(a), z}});
        }
    }
    return out;
}

template <int D>
double oracle_value(const CubicForm<D>& t, const Vec<D>& x) {
    double sum = 0;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j)
            for (int k = 0; k < D; ++k) sum += t(i, j, k) * x[i] * x[j] * x[k];
    return sum;
}

/// Solves A x = b, A symmetric and positive, by Cholesky.
template <std::size_t U>
std::array<double, U> cholesky_solved(std::array<std::array<double, U>, U> a, std::array<double, U> b) {
    for (std::size_t j = 0; j < U; ++j) {
        for (std::size_t k = 0; k < j; ++k) a[j][j] -= a[j][k] * a[j][k];
        a[j][j] = std::sqrt(std::max(a[j][j], 1e-300));
        for (std::size_t i = j + 1; i < U; ++i) {
            for (std::size_t k = 0; k < j; ++k) a[i][j] -= a[i][k] * a[j][k];
            a[i][j] /= a[j][j];
        }
    }
    for (std::size_t i = 0; i < U; ++i) {
        for (std::size_t k = 0; k < i; ++k) b[i] -= a[i][k] * b[k];
        b[i] /= a[i][i];
    }
    for (std::size_t i = U; i-- > 0;) {
        for (std::size_t k = i + 1; k < U; ++k) b[i] -= a[k][i] * b[k];
        b[i] /= a[i][i];
    }
    return b;
}

/// min c·x, rows·x ≥ b, by a primal-dual interior-point method.
template <std::size_t U>
std::array<double, U> interior_point(const std::vector<std::array<double, U>>& rows, const std::vector<double>& b,
                                     const std::array<double, U>& c, std::array<double, U> x) {
    const std::size_t n = rows.size();
    std::vector<double> s(n), z(n), ds(n), dz(n);
    const auto product = [&](std::size_t i, const std::array<double, U>& v) {
        const double *row = rows[i].data(), *x_k = v.data();  // tests are not optimised
        double sum = 0;
        for (std::size_t k = 0; k < U; ++k) sum += row[k] * x_k[k];
        return sum;
    };
    for (std::size_t i = 0; i < n; ++i) {
        s[i] = std::max(product(i, x) - b[i], 0.1);
        z[i] = 1.0 / static_cast<double>(n);
    }
    for (int it = 0; it < 40; ++it) {
        double gap = 0, residual = 0;
        for (std::size_t i = 0; i < n; ++i) {
            gap += s[i] * z[i];
            residual = std::max(residual, std::abs(product(i, x) - s[i] - b[i]));
        }
        if (gap < 1e-4 && residual < 1e-7) break;
        const double mu = 0.1 * gap / static_cast<double>(n);
        // A dx − ds = b + s − A x, Aᵀ dz = c − Aᵀ z, z ds + s dz = μ − s z.
        std::array<std::array<double, U>, U> normal{};
        std::array<double, U> right{};
        for (std::size_t k = 0; k < U; ++k) right[k] = -c[k];
        for (std::size_t i = 0; i < n; ++i) {
            const double p = b[i] + s[i] - product(i, x), w = z[i] / s[i];
            const double share = z[i] + (mu - s[i] * z[i]) / s[i] + w * p;
            const double* row = rows[i].data();
            for (std::size_t k = 0; k < U; ++k) {
                const double w_k = w * row[k];
                double* n_k = normal[k].data();
                right[k] += share * row[k];
                for (std::size_t l = 0; l <= k; ++l) n_k[l] += w_k * row[l];
            }
        }
        const auto dx = cholesky_solved(normal, right);
        double primal = 1, dual = 1;
        for (std::size_t i = 0; i < n; ++i) {
            ds[i] = product(i, dx) - (b[i] + s[i] - product(i, x));
            dz[i] = (mu - s[i] * z[i] - z[i] * ds[i]) / s[i];
            if (ds[i] < 0) primal = std::min(primal, -0.99 * s[i] / ds[i]);
            if (dz[i] < 0) dual = std::min(dual, -0.99 * z[i] / dz[i]);
        }
        for (std::size_t k = 0; k < U; ++k) x[k] += primal * dx[k];
        for (std::size_t i = 0; i < n; ++i) s[i] += primal * ds[i], z[i] += dual * dz[i];
    }
    return x;
}

/// log det of Q = (F⁻¹)ᵀF⁻¹, scaled so that the bound holds on 5 000 directions in its own frame.
template <int D>
double oracle_log_det(const CubicForm<D>& t, const Mat<D>& to_space) {
    static const auto fine = oracle_directions<D>(D == 2 ? 2000 : 5000);
    double most = 0;
    for (const Vec<D>& y : fine) most = std::max(most, std::abs(oracle_value(t, to_space * y)));
    return -2 * std::log(std::abs(det(to_space))) + D * 2.0 / 3 * std::log(most);
}

/// The minimum log det that log-simplex finds from a frame, v = F y.
template <int D>
double oracle_least_log_det(const CubicForm<D>& t, Mat<D> to_space) {
    constexpr std::size_t unknowns = sym_size<D>;
    static const auto directions = oracle_directions<D>(D == 2 ? 400 : 1500);
    std::vector<std::array<double, unknowns>> rows;
    std::array<double, unknowns> trace{};
    for (int i = 0; i < D; ++i) trace[Sym<D>::index(i, i)] = 1;
    for (const Vec<D>& y : directions) {
        std::array<double, unknowns> row{};
        for (int i = 0; i < D; ++i)
            for (int j = 0; j < D; ++j) row[Sym<D>::index(i, j)] += y[i] * y[j];
        rows.push_back(row);
    }
    double best = oracle_log_det(t, to_space);
    std::vector<double> b(rows.size());
    for (int it = 0; it < 15; ++it) {
        double most = -1e300;
        for (std::size_t i = 0; i < b.size(); ++i) {
            b[i] = 2.0 / 3 * std::log(std::max(std::abs(oracle_value(t, to_space * directions[i])), 1e-12));
            most = std::max(most, b[i]);
        }
        std::array<double, unknowns> x = trace;
        for (double& v : x) v *= most + 0.5;
        Sym<D> l;
        l.c = interior_point<unknowns>(rows, b, trace, x);
        auto e = eigen_system(l);
        for (double& v : e.values.c) v = std::exp(-v / 2);
        const Sym<D> shrink = composed(e);
        Mat<D> next;
        for (int j = 0; j < D; ++j)
            for (int k = 0; k < D; ++k) next.column[j] += shrink(k, j) * to_space.column[k];
        to_space = next;
        best = std::min(best, oracle_log_det(t, to_space));
        if (norm(l) < 3e-3) break;
    }
    return best;
}

}  // namespace camber::testing
