// Small programs on a segment, small linear and quadratic programs, and the minimum of det J of an element.
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
import camber.bezier;
import camber.validity;

namespace camber {

namespace {

double slope(const AffineConstraint& c) { return c.at_1 - c.at_0; }
double excess(const AffineConstraint& c, double theta) { return (c.at_0 - c.floor) + theta * slope(c); }

const AffineConstraint& lowest(std::span<const AffineConstraint> constraints, double theta) {
    return *std::min_element(constraints.begin(), constraints.end(),
                             [&](const auto& a, const auto& b) { return excess(a, theta) < excess(b, theta); });
}

}  // namespace

std::optional<SegmentInterval> feasible(std::span<const AffineConstraint> constraints) {
    SegmentInterval interval;
    for (const AffineConstraint& c : constraints) {
        const double s = slope(c);
        const double start = c.at_0 - c.floor;
        const double end = c.at_1 - c.floor;
        if (!(start >= 0 || end >= 0)) return {};
        // Each end is tested by its own value, so that a rounded crossing cannot exclude it.
        if (start < 0) interval.low = std::max(interval.low, -start / s);
        if (end < 0) interval.high = std::min(interval.high, -start / s);
    }
    if (!(interval.low <= interval.high)) return {};
    return interval;
}

double max_min_parameter(std::span<const AffineConstraint> constraints, SegmentInterval within) {
    if (constraints.empty()) return within.high;
    // The maximum is the crossing of a rising and a falling line. Each iteration uses the lowest line at the current
    // crossing.
    const AffineConstraint* rising = &lowest(constraints, within.low);
    const AffineConstraint* falling = &lowest(constraints, within.high);
    if (slope(*falling) >= 0) return within.high;
    if (slope(*rising) <= 0) return within.low;
    double theta = within.low;
    for (std::size_t i = 0; i <= constraints.size(); ++i) {
        theta = (excess(*rising, 0) - excess(*falling, 0)) / (slope(*falling) - slope(*rising));
        theta = std::clamp(theta, within.low, within.high);
        const AffineConstraint& next = lowest(constraints, theta);
        if (excess(next, theta) >= excess(*rising, theta) || &next == rising || &next == falling) break;
        (slope(next) > 0 ? rising : falling) = &next;
    }
    return theta;
}

namespace {

/// Later steps use Bland's rule. At the step limit the current bounds are returned.
constexpr int steepest_steps = 40;
constexpr int max_steps = 400;

/// x = Σ y_j axis_j / scale_j with orthonormal axes: gradients have size 1 for any anisotropy.
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

/// The constraint row · z + offset ≥ 0, with z = (y, t).
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

/// Dual simplex tableau: rows 0 … n−1 are the functions, then the box ±y_j ≤ reach.
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

    /// False if the constraints are contradictory, or if t, which never increases, is at most `least`.
    bool run(double least) {
        for (int step = 0; step < max_steps; ++step) {
            if (t() <= least) return false;
            const int entering = step < steepest_steps ? max_violated() : first_violated();
            if (entering < 0) return true;
            const int leaving = ratio_test(entering);
            if (leaving < 0) return false;
            const auto before = basis_;
            basis_[leaving] = entering;
            if (!solve_basis()) {  // numerically singular: the current bounds remain
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

    void list_active(MaxMinPoint<M>& point) const {
        for (int i = 0; i <= M; ++i)
            if (basis_[i] < functions_ && multiplier_[i] > 0x1p-40) point.active[point.active_count++] = basis_[i];
    }

  private:
    /// Computes z of the basis, and multipliers λ with Σ λ_i row_i = −(0, …, 0, 1).
    bool solve_basis() {
        SquareMatrix<M + 1> matrix;
        for (int i = 0; i <= M; ++i) matrix[i] = rows_[basis_[i]].c;
        const auto inverse = inverted(matrix);
        if (!inverse.is_regular) return false;
        inverse_ = inverse.matrix;
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

    /// Returns the leaving row: minimum of λ_i / u_i with u_i > 0, entering = Σ u_i row_i. Ties select the lower row.
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
    SquareMatrix<M + 1> inverse_{};
    std::array<double, M + 1> z_{}, multiplier_{};
};

}  // namespace

template <int M>
std::optional<MaxMinPoint<M>> max_min_point(std::span<const RaisedFunction<M>> functions, double reach, double least) {
    const Frame<M> frame = frame_of(functions);
    DualSimplex<M> simplex(functions, frame, reach);
    if (!simplex.start() || !simplex.run(least)) return {};
    MaxMinPoint<M> highest;
    highest.x = frame.point(simplex.y());
    highest.upper = simplex.t();
    highest.lower = std::numeric_limits<double>::infinity();
    for (const auto& f : functions)
        if (f.weight > 0) highest.lower = std::min(highest.lower, f.function(highest.x) / f.weight);
    highest.upper = std::max(highest.upper, highest.lower);
    simplex.list_active(highest);
    return highest;
}

template std::optional<MaxMinPoint<1>> max_min_point<1>(std::span<const RaisedFunction<1>>, double, double);
template std::optional<MaxMinPoint<2>> max_min_point<2>(std::span<const RaisedFunction<2>>, double, double);
template std::optional<MaxMinPoint<3>> max_min_point<3>(std::span<const RaisedFunction<3>>, double, double);

namespace {

/// Never reached in practice. Each full step raises the cost, so no active set repeats.
constexpr int max_full_steps = 400;

template <int M>
Vec<M> forward(const Mat<M>& lower, Vec<M> b) {
    for (int i = 0; i < M; ++i) {
        for (int k = 0; k < i; ++k) b[i] -= lower(i, k) * b[k];
        b[i] /= lower(i, i);
    }
    return b;
}
template <int M>
Vec<M> backward(const Mat<M>& lower, Vec<M> b) {
    for (int i = M - 1; i >= 0; --i) {
        for (int k = i + 1; k < M; ++k) b[i] -= lower(k, i) * b[k];
        b[i] /= lower(i, i);
    }
    return b;
}

/// unit · y + offset ≥ 0 with y = Lᵀ (x − centre); |unit| = 1, so values are distances.
template <int M>
struct Plane {
    Vec<M> unit;
    double offset = 0;
    int function = 0;
};

/// Active planes with N = Q R (Gram–Schmidt), multipliers u ≥ 0, and the point of the planes nearest to the origin, y =
/// Σ u_i unit_i.
template <int M>
struct ActiveSet {
    int count = 0;
    std::array<Plane<M>, M + 1> planes{};
    std::array<double, M + 1> multiplier{};
    std::array<Vec<M>, M> q{};
    std::array<std::array<double, M>, M> r{};
    Vec<M> y;

    /// `weights` is R⁻¹ Qᵀ unit for the remainder of `unit`.
    [[nodiscard]] Vec<M> remainder(Vec<M> unit, std::array<double, M + 1>& weights) const {
        std::array<double, M> along{};
        for (int pass = 0; pass < 2; ++pass)
            for (int i = 0; i < count; ++i) {
                const double part = dot(q[i], unit);
                along[i] += part;
                unit -= part * q[i];
            }
        for (int i = count - 1; i >= 0; --i) {
            double sum = along[i];
            for (int k = i + 1; k < count; ++k) sum -= r[i][k] * weights[k];
            weights[i] = sum / r[i][i];
        }
        return unit;
    }

    void factorise() {
        const int n = count;
        for (count = 0; count < n; ++count) {
            Vec<M> rest = planes[count].unit;
            for (int i = 0; i < count; ++i) r[i][count] = 0;
            for (int pass = 0; pass < 2; ++pass)
                for (int i = 0; i < count; ++i) {
                    const double part = dot(q[i], rest);
                    r[i][count] += part;
                    rest -= part * q[i];
                }
            r[count][count] = norm(rest);
            q[count] = rest / r[count][count];
        }
    }

    /// Solves Rᵀ w = −offsets, then sets y = Q w and solves R u = w.
    void solve() {
        std::array<double, M> w{};
        y = {};
        for (int i = 0; i < count; ++i) {
            w[i] = -planes[i].offset;
            for (int k = 0; k < i; ++k) w[i] -= r[k][i] * w[k];
            w[i] /= r[i][i];
            y += w[i] * q[i];
        }
        for (int i = count - 1; i >= 0; --i) {
            double sum = w[i];
            for (int k = i + 1; k < count; ++k) sum -= r[i][k] * multiplier[k];
            multiplier[i] = std::max(0.0, sum / r[i][i]);
        }
    }

    void drop(int i) {
        for (; i + 1 < count; ++i) planes[i] = planes[i + 1], multiplier[i] = multiplier[i + 1];
        --count;
        factorise();
    }
};

enum class Step { added, contradiction };

template <int M>
Step enter(ActiveSet<M>& set, const Plane<M>& plane) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    Vec<M> y = set.y;
    double own = 0;
    for (;;) {
        std::array<double, M + 1> weights{};
        const Vec<M> z = set.remainder(plane.unit, weights);
        const double slope = norm_squared(z);
        // If the normal is within rounding in the span of the active normals, the step in y would exceed all scales.
        const double full =
            set.count < M && slope > 0x1p-72 ? std::max(0.0, -(dot(plane.unit, y) + plane.offset) / slope) : infinity;
        int leaving = -1;
        double partial = infinity;
        for (int i = 0; i < set.count; ++i)
            if (weights[i] > 0x1p-44 && set.multiplier[i] / weights[i] < partial)
                partial = set.multiplier[i] / weights[i], leaving = i;
        if (full == infinity && leaving < 0) {
            set.planes[set.count] = plane;
            return Step::contradiction;
        }
        const double t = std::min(full, partial);
        if (full != infinity) y += t * z;
        for (int i = 0; i < set.count; ++i) set.multiplier[i] = std::max(0.0, set.multiplier[i] - t * weights[i]);
        own += t;
        if (full <= partial) break;
        set.drop(leaving);
    }
    set.planes[set.count] = plane;
    set.multiplier[set.count] = own;
    ++set.count;
    set.factorise();
    set.solve();
    return Step::added;
}

/// Returns L with hessian = L Lᵀ. Pivots lost to rounding are replaced by small positive ones.
template <int M>
Mat<M> cholesky(const Sym<M>& hessian) {
    Mat<M> lower;
    for (int j = 0; j < M; ++j) {
        double pivot = hessian(j, j);
        for (int k = 0; k < j; ++k) pivot -= lower(j, k) * lower(j, k);
        pivot = std::max({pivot, 0x1p-52 * hessian(j, j), std::numeric_limits<double>::min()});
        lower(j, j) = std::sqrt(pivot);
        for (int i = j + 1; i < M; ++i) {
            double sum = hessian(i, j);
            for (int k = 0; k < j; ++k) sum -= lower(i, k) * lower(j, k);
            lower(i, j) = sum / lower(j, j);
        }
    }
    return lower;
}

}  // namespace

template <int M>
NearestPoint<M> nearest_point(const QuadraticModel<M>& model, std::span<const AffineFunction<M>> functions) {
    NearestPoint<M> nearest;
    if (std::all_of(functions.begin(), functions.end(), [&](const auto& f) { return f(model.centre) >= 0; })) {
        nearest.feasible = true;
        nearest.x = model.centre;
        return nearest;
    }
    const Mat<M> lower = cholesky(model.hessian);
    std::vector<Plane<M>> planes;
    planes.reserve(functions.size());
    for (std::size_t i = 0; i < functions.size(); ++i) {
        const Vec<M> normal = forward(lower, functions[i].gradient);
        const double offset = functions[i](model.centre);
        const double length = norm(normal);
        if (length > std::numeric_limits<double>::min()) {
            planes.push_back({normal / length, offset / length, static_cast<int>(i)});
        } else if (!(offset >= 0)) {  // the function is constant, so infeasible
            nearest.active[nearest.active_count++] = static_cast<int>(i);
            return nearest;
        }
    }
    ActiveSet<M> set;
    bool contradiction = false;
    for (int step = 0; step < max_full_steps && !contradiction; ++step) {
        const Plane<M>* worst = nullptr;
        double least = 0;
        for (const Plane<M>& p : planes) {
            const double value = dot(p.unit, set.y) + p.offset;
            if (value < least) least = value, worst = &p;
        }
        if (!worst || least >= -0x1p-45 * (norm(set.y) + std::abs(worst->offset))) {
            nearest.feasible = true;
            break;
        }
        contradiction = enter(set, *worst) == Step::contradiction;
    }
    nearest.active_count = set.count + (contradiction ? 1 : 0);
    for (int i = 0; i < nearest.active_count; ++i) nearest.active[i] = set.planes[i].function;
    nearest.x = model.centre + backward(lower, set.y);
    nearest.cost = 0.5 * norm_squared(set.y);
    return nearest;
}

#define CAMBER_INSTANTIATE(M) \
    template NearestPoint<M> nearest_point<M>(const QuadraticModel<M>&, std::span<const AffineFunction<M>>);

CAMBER_INSTANTIATE(1)
CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

template <int D>
MinJacobianPoint<D> min_jacobian_point(const BoundedJacobian<D>& jacobian) {
    constexpr int max_parts = 4000;
    constexpr int max_depth = 40;
    MinJacobianPoint<D> lowest;
    lowest.at[0] = 1;
    lowest.jacobian = jacobian.coefficients[corner_coefficients<D>[0]];
    std::vector<JacobianPart<D>> open{whole(jacobian)};
    for (int parts = 0; !open.empty() && parts < max_parts; ++parts) {
        const JacobianPart<D> part = open.back();
        open.pop_back();
        for (int i = 0; i <= D; ++i) {
            const double value = part.coefficients[corner_coefficients<D>[i]];
            if (value < lowest.jacobian) lowest = {part.corners[i], value};
        }
        const double low = *std::min_element(part.coefficients.begin(), part.coefficients.end());
        const double slack = 1e-3 * std::max(std::abs(jacobian.straight), std::abs(lowest.jacobian));
        // Ends the search for NaN.
        if (!(low < lowest.jacobian - slack) || part.depth == max_depth) continue;
        const int edge = largest_bend(part).edge;
        open.push_back(half(part, edge, 0));
        open.push_back(half(part, edge, 1));
    }
    return lowest;
}

#define CAMBER_INSTANTIATE(D) template MinJacobianPoint<D> min_jacobian_point<D>(const BoundedJacobian<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
