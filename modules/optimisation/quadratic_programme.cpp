module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>
#include <vector>
module camber.optimisation;
import camber.core;
import camber.validity;

namespace camber {

namespace {

/// A longer search than any seen, by far: each full step raises the cost, so that no active set comes twice.
constexpr int max_steps = 400;

/// L⁻¹ b.
template <int M>
Vec<M> forward(const Mat<M>& lower, Vec<M> b) {
    for (int i = 0; i < M; ++i) {
        for (int k = 0; k < i; ++k) b[i] -= lower(i, k) * b[k];
        b[i] /= lower(i, i);
    }
    return b;
}
/// L⁻ᵀ b.
template <int M>
Vec<M> backward(const Mat<M>& lower, Vec<M> b) {
    for (int i = M - 1; i >= 0; --i) {
        for (int k = i + 1; k < M; ++k) b[i] -= lower(k, i) * b[k];
        b[i] /= lower(i, i);
    }
    return b;
}

/// unit · y + offset ≥ 0 in the frame y = Lᵀ (x − centre); |unit| = 1, so that values are distances.
template <int M>
struct Plane {
    Vec<M> unit;
    double offset = 0;
    int function = 0;
};

/// The active planes with N = Q R (Gram–Schmidt), their multipliers u ≥ 0, and the point nearest to the origin on them:
/// y = Σ u_i unit_i.
template <int M>
struct ActiveSet {
    int count = 0;
    std::array<Plane<M>, M + 1> planes{};
    std::array<double, M + 1> multiplier{};
    std::array<Vec<M>, M> q{};
    std::array<std::array<double, M>, M> r{};
    Vec<M> y;

    /// What is left of a unit vector off the span of the active normals, and R⁻¹ Qᵀ of it.
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

    /// Rᵀ w = −offsets, y = Q w, R u = w.
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

/// Makes one violated plane hold: moves along the remainder of its normal, dropping planes whose multiplier reaches 0.
template <int M>
Step enter(ActiveSet<M>& set, const Plane<M>& plane) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    Vec<M> y = set.y;
    double own = 0;
    for (;;) {
        std::array<double, M + 1> weights{};
        const Vec<M> z = set.remainder(plane.unit, weights);
        const double slope = norm_squared(z);
        // A normal within rounding of the span of the active ones: the step in y would be beyond all scales.
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

}  // namespace

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
        } else if (!(offset >= 0)) {  // nothing can raise it
            nearest.active[nearest.active_count++] = static_cast<int>(i);
            return nearest;
        }
    }
    ActiveSet<M> set;
    bool contradiction = false;
    for (int step = 0; step < max_steps && !contradiction; ++step) {
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

#define CAMBER_INSTANTIATE(M)                   \
    template Mat<M> cholesky<M>(const Sym<M>&); \
    template NearestPoint<M> nearest_point<M>(const QuadraticModel<M>&, std::span<const AffineFunction<M>>);

CAMBER_INSTANTIATE(1)
CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
