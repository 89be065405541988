module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>
module camber.metric;
import camber.core;

namespace camber {

namespace {

template <class Kernel>
[[gnu::always_inline]] inline void each_pack(std::size_t n, const Kernel& kernel) {
    for (std::size_t begin = 0; begin < n; begin += pack_size) kernel(begin);
}

template <int D>
[[gnu::always_inline]] inline void scatter_sym(const SymPack<D>& s, std::size_t begin, std::size_t n, auto&& out) {
    for (std::size_t lane = 0; lane < pack_size && begin + lane < n; ++lane) {
        Sym<D>& to = out(begin + lane);
        for (int k = 0; k < sym_size<D>; ++k) to.c[k] = s.c[k][lane];
    }
}

}  // namespace

template <int D>
void metric_norms(std::span<const LogMetric<D>> metrics, std::span<const Vec<D>> vectors, std::span<double> norms,
                  Instructions set) {
    with_instructions(set, [&]() __attribute__((always_inline)) {
        each_pack(norms.size(), [&](std::size_t begin) __attribute__((always_inline)) {
            const EigenPack<D> e = eigen_system<D>(gathered_sym<D>(
                metrics, begin,
                [](const LogMetric<D>& m) __attribute__((always_inline)) -> const Sym<D>& { return m.l; }));
            const VecPack<D> v = gathered_vec<D>(
                vectors, begin, [](const Vec<D>& x) __attribute__((always_inline)) -> const Vec<D>& { return x; });
            Pack square = packed(0);
            for (int i = 0; i < D; ++i) {
                const Pack w = dot(e.vectors.column[i], v);
                square += exp(e.values[i]) * w * w;
            }
            const Pack norm = sqrt(square);
            for (std::size_t lane = 0; lane < pack_size && begin + lane < norms.size(); ++lane)
                norms[begin + lane] = norm[lane];
        });
    });
}

template <int D>
void natural_log_metrics(std::span<const std::array<Vec<D>, D + 1>> simplices, std::span<LogMetric<D>> metrics,
                         Instructions set) {
    using Simplex = std::array<Vec<D>, D + 1>;
    const Mat<D> reference = inverse(regular_simplex<D>());
    with_instructions(set, [&]() __attribute__((always_inline)) {
        each_pack(metrics.size(), [&](std::size_t begin) __attribute__((always_inline)) {
            std::array<VecPack<D>, D + 1> p{};
            for (int i = 0; i <= D; ++i)
                p[i] = gathered_vec<D>(simplices, begin,
                                       [&](const Simplex& s)
                                           __attribute__((always_inline)) -> const Vec<D>& { return s[i]; });
            const RightSingularPack<D> s = right_singular<D>(natural_frame<D>(p, reference));
            scatter_sym<D>(natural_log_metric<D>(s), begin, metrics.size(),
                           [&](std::size_t i) __attribute__((always_inline)) -> Sym<D>& { return metrics[i].l; });
        });
    });
}

template <int D>
void pull_back_metrics(std::span<const LogMetric<D>> metrics, std::span<const Mat<D>> jacobians,
                       std::span<PulledBackMetric<D>> pulled_back, Instructions set) {
    with_instructions(set, [&]() __attribute__((always_inline)) {
        each_pack(pulled_back.size(), [&](std::size_t begin) __attribute__((always_inline)) {
            const SymPack<D> metric = gathered_sym<D>(
                metrics, begin,
                [](const LogMetric<D>& m) __attribute__((always_inline)) -> const Sym<D>& { return m.l; });
            const MatPack<D> jacobian = gathered_mat<D>(
                jacobians, begin, [](const Mat<D>& m) __attribute__((always_inline)) -> const Mat<D>& { return m; });
            const PulledBackPack<D> pack = pull_back_pack<D>(metric, jacobian);
            scatter_sym<D>(pack.log_metric, begin, pulled_back.size(),
                           [&](std::size_t i)
                               __attribute__((always_inline)) -> Sym<D>& { return pulled_back[i].log_metric.l; });
            for (std::size_t lane = 0; lane < pack_size && begin + lane < pulled_back.size(); ++lane)
                for (int i = 0; i < D; ++i)
                    for (int j = 0; j < D; ++j) pulled_back[begin + lane].axes(i, j) = pack.axes(i, j)[lane];
        });
    });
}

namespace {

enum class TensorState : std::uint8_t { sound, floored, indefinite, singular, zero, out_of_range, not_finite };

template <int D>
bool has_zero_row(const Sym<D>& m) {
    for (int i = 0; i < D; ++i) {
        bool zero = true;
        for (int j = 0; j < D; ++j) zero = zero && m(i, j) == 0;
        if (zero) return true;
    }
    return false;
}

template <int D>
bool is_out_of_range(const Sym<D>& m) {
    double largest = 0;
    for (const double x : m.c) largest = std::max(largest, std::abs(x));
    constexpr double beyond = 4;
    return largest * (min_length * min_length) > beyond || largest * (max_length * max_length) * beyond < 1;
}

/// Returns for each eigenvalue a bound of its change if the entries m_jk of M have the relative error ε: ε Σ_jk |r_j|
/// |m_jk| |r_k| with the eigenvector r. It is at most ε λ_max D, and far less for axes along the coordinates. The bound
/// covers the error of the decomposition.
template <int D>
Vec<D> eigenvalue_rounding(const Sym<D>& m, const EigenSystem<D>& e, double epsilon) {
    Vec<D> rounding;
    for (int i = 0; i < D; ++i) {
        for (int j = 0; j < D; ++j)
            for (int k = 0; k < D; ++k) rounding[i] += epsilon * std::abs(e.vectors(j, i) * m(j, k) * e.vectors(k, i));
        rounding[i] = std::max(rounding[i], std::numeric_limits<double>::epsilon() * norm(m));
    }
    return rounding;
}

template <int D>
TensorState log_of_tensor(std::span<const double> row, double epsilon, LogMetric<D>& out) {
    Sym<D> m;
    for (std::size_t i = 0; i < row.size(); ++i) {
        if (!std::isfinite(row[i])) return TensorState::not_finite;
        m.c[i] = row[i];
    }
    if (m == Sym<D>{}) return TensorState::zero;
    if (is_out_of_range(m)) return TensorState::out_of_range;
    EigenSystem<D> e = eigen_system(m);
    const Vec<D> rounding = eigenvalue_rounding(m, e, epsilon);
    const double largest = *std::max_element(e.values.c.begin(), e.values.c.end());
    if (!(largest > 0)) return TensorState::indefinite;
    TensorState state = TensorState::sound;
    for (int i = 0; i < D; ++i) {
        double& value = e.values[i];
        if (value < -8 * rounding[i]) return TensorState::indefinite;
        if (value < rounding[i]) {
            value = rounding[i];
            state = TensorState::floored;
        }
        value = log(value);
    }
    if (has_zero_row(m)) return TensorState::singular;
    out.l = composed(e);
    return state;
}

std::optional<Error> refusal_of(TensorState state, const Entity& vertex) {
    constexpr auto kind = ErrorKind::input;
    switch (state) {
        case TensorState::sound:
        case TensorState::floored: break;
        case TensorState::not_finite: return Error{kind, "contains a number that is not finite", {}, vertex, {}};
        case TensorState::zero:
            return Error{kind, "is zero", {}, vertex, "sizes would be infinite: give each direction a size"};
        case TensorState::out_of_range:
            static_assert(min_length == 1e-60 && max_length == 1e60);
            return Error{
                kind, "has sizes that are not between 1e-60 and 1e60", {}, vertex, "use another unit of length"};
        case TensorState::singular:
            return Error{kind, "is singular", {}, vertex, "a size would be infinite: give each direction a size"};
        case TensorState::indefinite:
            return Error{kind,
                         "is not positive definite",
                         {},
                         vertex,
                         "an eigenvalue is negative beyond the rounding of the file's reals"};
    }
    return {};
}

}  // namespace

template <int D>
Outcome<TensorLogs<D>> log_metrics_of_tensors(std::span<const double> rows, TensorPrecision precision,
                                              const Execution& execution) {
    const double epsilon = precision == TensorPrecision::four_bytes
                               ? static_cast<double>(std::numeric_limits<float>::epsilon())
                               : std::numeric_limits<double>::epsilon();
    const std::size_t n = rows.size() / sym_size<D>;
    TensorLogs<D> out{.log_metrics = Buffer<LogMetric<D>>(n)};
    auto states = map_each(execution, n, [&](std::size_t i) {
        return log_of_tensor<D>(rows.subspan(i * sym_size<D>, sym_size<D>), epsilon, out.log_metrics[i]);
    });
    if (!states) return fail(states.error());
    for (std::size_t i = 0; i < n; ++i) {
        if (auto error = refusal_of((*states)[i], {"metric at vertex", i + 1})) return fail(std::move(*error));
        out.floored += (*states)[i] == TensorState::floored;
    }
    return out;
}

#define CAMBER_INSTANTIATE(D)                                                                                 \
    template void metric_norms<D>(std::span<const LogMetric<D>>, std::span<const Vec<D>>, std::span<double>,  \
                                  Instructions);                                                              \
    template void natural_log_metrics<D>(std::span<const std::array<Vec<D>, D + 1>>, std::span<LogMetric<D>>, \
                                         Instructions);                                                       \
    template void pull_back_metrics<D>(std::span<const LogMetric<D>>, std::span<const Mat<D>>,                \
                                       std::span<PulledBackMetric<D>>, Instructions);                         \
    template Outcome<TensorLogs<D>> log_metrics_of_tensors<D>(std::span<const double>, TensorPrecision,       \
                                                              const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
