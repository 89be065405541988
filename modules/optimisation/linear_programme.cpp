module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.optimisation;
import camber.core;

namespace camber {

namespace {

/// Steps by the most violated constraint, then by Bland's rule; afterwards the bracket is what it is.
constexpr int steepest_steps = 40;
constexpr int max_steps = 400;

/// x = Σ y_j axis_j / scale_j, the axes orthonormal: a frame in which gradients are of size 1, however anisotropic.
template <int M>
struct Frame {
    std::array<Vec<M>, M> axis{};
    std::array<double, M> inverse_scale{};

    [[nodiscard]] Vec<M> gradient(const Vec<M>& g) const {
        Vec<M> y;
        for (int j = 0; j < M; ++j) y[j] = dot(axis[j], g) * inverse_scale[j];
        return y;
    }
    [[nodiscard]] Vec<M> point(const Vec<M>& y) const {
        Vec<M> x;
        for (int j = 0; j < M; ++j) x += (y[j] * inverse_scale[j]) * axis[j];
        return x;
    }
};

/// Gram–Schmidt over the gradients, the longest remainder first. Directions in which nothing changes stay out.
template <int M>
Frame<M> frame_of(std::span<const RaisedFunction<M>> functions) {
    Frame<M> frame;
    double first = 0;
    for (int j = 0; j < M; ++j) {
        Vec<M> longest;
        double size = 0;
        for (const auto& f : functions) {
            Vec<M> rest = f.function.gradient;
            for (int k = 0; k < j; ++k) rest -= dot(frame.axis[k], rest) * frame.axis[k];
            if (const double s = norm_squared(rest); s > size) size = s, longest = rest;
        }
        for (int k = 0; k < j; ++k) longest -= dot(frame.axis[k], longest) * frame.axis[k];
        const double length = norm(longest);
        if (j == 0) first = length;
        if (!(length > 0x1p-46 * first) || !(length > std::numeric_limits<double>::min())) break;
        frame.axis[j] = longest / length;
        frame.inverse_scale[j] = 1 / length;
    }
    return frame;
}

/// row · z + offset ≥ 0, with z = (y, t).
template <int M>
struct Row {
    std::array<double, M + 1> c{};
    double offset = 0;

    [[nodiscard]] double operator()(const std::array<double, M + 1>& z) const {
        double sum = offset;
        for (int i = 0; i <= M; ++i) sum += c[i] * z[i];
        return sum;
    }
};

/// The inverse of a small matrix of rows, by Gauss–Jordan with row pivoting; none if it is singular.
template <int N>
using Square = std::array<std::array<double, N>, N>;
template <int N>
std::optional<Square<N>> inverse_of(Square<N> a) {
    Square<N> b{};
    for (int i = 0; i < N; ++i) b[i][i] = 1;
    for (int col = 0; col < N; ++col) {
        int pivot = col;
        for (int r = col + 1; r < N; ++r)
            if (std::abs(a[r][col]) > std::abs(a[pivot][col])) pivot = r;
        std::swap(a[col], a[pivot]);
        std::swap(b[col], b[pivot]);
        if (!(std::abs(a[col][col]) > 0x1p-300)) return {};
        const double factor = 1 / a[col][col];
        for (int k = 0; k < N; ++k) a[col][k] *= factor, b[col][k] *= factor;
        for (int r = 0; r < N; ++r) {
            if (r == col) continue;
            const double m = a[r][col];
            if (m == 0) continue;
            for (int k = 0; k < N; ++k) a[r][k] -= m * a[col][k], b[r][k] -= m * b[col][k];
        }
    }
    return b;
}

/// A dual simplex tableau: the programme in z = (y, t), rows 0 … n−1 the functions, then the box, ±y_j ≤ reach.
template <int M>
class DualSimplex {
  public:
    DualSimplex(std::span<const RaisedFunction<M>> functions, const Frame<M>& frame, double reach)
        : functions_(static_cast<int>(functions.size())) {
        rows_.reserve(functions.size() + 2 * M);
        for (const auto& f : functions) {
            Row<M> row;
            const Vec<M> g = frame.gradient(f.function.gradient);
            for (int j = 0; j < M; ++j) row.c[j] = g[j];
            row.c[M] = -f.weight;
            row.offset = f.function.offset;
            magnitude_ = std::max(magnitude_, std::abs(row.offset));
            rows_.push_back(row);
        }
        for (int j = 0; j < M; ++j)
            for (const double sign : {1.0, -1.0}) {
                Row<M> row;
                row.c[j] = -sign;
                row.offset = reach;
                rows_.push_back(row);
            }
    }

    /// From the lowest raised function alone, whose optimum is a corner of the box; false if none is raised.
    bool start() {
        int lowest = -1;
        double least = 0;
        for (int i = 0; i < functions_; ++i) {
            const double weight = -rows_[i].c[M];
            if (!(weight > 0)) continue;
            if (lowest < 0 || rows_[i].offset / weight < least) lowest = i, least = rows_[i].offset / weight;
        }
        if (lowest < 0) return false;
        for (int j = 0; j < M; ++j) basis_[j] = functions_ + 2 * j + (rows_[lowest].c[j] >= 0 ? 0 : 1);
        basis_[M] = lowest;
        return solve_basis();
    }

    /// False if the rows contradict each other, or t, which is never raised, comes to be no more than `least`.
    bool run(double least) {
        for (int step = 0; step < max_steps; ++step) {
            if (t() <= least) return false;
            const int entering = step < steepest_steps ? max_violated() : first_violated();
            if (entering < 0) return true;
            const int leaving = ratio_test(entering);
            if (leaving < 0) return false;
            const auto before = basis_;
            basis_[leaving] = entering;
            if (!solve_basis()) {  // numerically singular: what is known already stays
                basis_ = before;
                return solve_basis();
            }
        }
        return true;
    }

    [[nodiscard]] Vec<M> y() const {
        Vec<M> y;
        for (int j = 0; j < M; ++j) y[j] = z_[j];
        return y;
    }
    [[nodiscard]] double t() const { return z_[M]; }

    void list_active(HighestPoint<M>& point) const {
        for (int i = 0; i <= M; ++i)
            if (basis_[i] < functions_ && multiplier_[i] > 0x1p-40) point.active[point.active_count++] = basis_[i];
    }

  private:
    /// z of the basis, and the multipliers λ with Σ λ_i row_i = −(0, …, 0, 1).
    bool solve_basis() {
        Square<M + 1> matrix;
        for (int i = 0; i <= M; ++i) matrix[i] = rows_[basis_[i]].c;
        const auto inverse = inverse_of<M + 1>(matrix);
        if (!inverse) return false;
        inverse_ = *inverse;
        for (int i = 0; i <= M; ++i) {
            z_[i] = 0;
            for (int k = 0; k <= M; ++k) z_[i] -= inverse_[i][k] * rows_[basis_[k]].offset;
            multiplier_[i] = std::max(0.0, -inverse_[M][i]);
        }
        double size = magnitude_;
        for (const double c : z_) size += std::abs(c);
        tolerance_ = 0x1p-47 * size;
        return true;
    }

    [[nodiscard]] int max_violated() const {
        int worst = -1;
        double least = -tolerance_;
        for (std::size_t i = 0; i < rows_.size(); ++i)
            if (const double value = rows_[i](z_); value < least) least = value, worst = static_cast<int>(i);
        return in_basis(worst) ? -1 : worst;
    }

    [[nodiscard]] int first_violated() const {
        for (std::size_t i = 0; i < rows_.size(); ++i)
            if (rows_[i](z_) < -tolerance_ && !in_basis(static_cast<int>(i))) return static_cast<int>(i);
        return -1;
    }

    [[nodiscard]] bool in_basis(int row) const { return std::find(basis_.begin(), basis_.end(), row) != basis_.end(); }

    /// Which of the basis gives way: entering = Σ u_i row_i, the least λ_i / u_i, u_i > 0; the lower row in a tie.
    [[nodiscard]] int ratio_test(int entering) const {
        std::array<double, M + 1> u{};
        double largest = 0;
        for (int i = 0; i <= M; ++i) {
            for (int k = 0; k <= M; ++k) u[i] += inverse_[k][i] * rows_[entering].c[k];
            largest = std::max(largest, std::abs(u[i]));
        }
        int leaving = -1;
        double least = 0;
        for (int i = 0; i <= M; ++i) {
            if (!(u[i] > 0x1p-44 * largest)) continue;
            const double ratio = multiplier_[i] / u[i];
            if (leaving < 0 || ratio < least || (ratio == least && basis_[i] < basis_[leaving]))
                least = ratio, leaving = i;
        }
        return leaving;
    }

    std::vector<Row<M>> rows_;
    int functions_;
    double magnitude_ = 0;
    double tolerance_ = 0;
    std::array<int, M + 1> basis_{};
    Square<M + 1> inverse_{};
    std::array<double, M + 1> z_{}, multiplier_{};
};

}  // namespace

template <int M>
std::optional<HighestPoint<M>> highest_point(std::span<const RaisedFunction<M>> functions, double reach, double least) {
    const Frame<M> frame = frame_of(functions);
    DualSimplex<M> simplex(functions, frame, reach);
    if (!simplex.start() || !simplex.run(least)) return {};
    HighestPoint<M> highest;
    highest.x = frame.point(simplex.y());
    highest.upper = simplex.t();
    highest.lower = std::numeric_limits<double>::infinity();
    for (const auto& f : functions)
        if (f.weight > 0) highest.lower = std::min(highest.lower, f.function(highest.x) / f.weight);
    highest.upper = std::max(highest.upper, highest.lower);
    simplex.list_active(highest);
    return highest;
}

template std::optional<HighestPoint<1>> highest_point<1>(std::span<const RaisedFunction<1>>, double, double);
template std::optional<HighestPoint<2>> highest_point<2>(std::span<const RaisedFunction<2>>, double, double);
template std::optional<HighestPoint<3>> highest_point<3>(std::span<const RaisedFunction<3>>, double, double);

}  // namespace camber
