module;
#include <algorithm>
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

enum class TensorState : std::uint8_t { sound, floored, indefinite, singular, zero, out_of_range, not_finite };

/// Whether a row of the matrix is zero: then so is an eigenvalue, and no rounding of the entries made it so. That any
/// other matrix is singular cannot be told from rounding.
template <int D>
bool has_zero_row(const Sym<D>& m) {
    for (int i = 0; i < D; ++i) {
        bool zero = true;
        for (int j = 0; j < D; ++j) zero = zero && m(i, j) == 0;
        if (zero) return true;
    }
    return false;
}

/// Whether the sizes are beyond the range of lengths by far: squares of the entries would overflow or vanish.
template <int D>
bool is_out_of_range(const Sym<D>& m) {
    double largest = 0;
    for (const double x : m.c) largest = std::max(largest, std::abs(x));
    constexpr double beyond = 4;
    return largest * (min_length * min_length) > beyond || largest * (max_length * max_length) * beyond < 1;
}

/// What rounding the entries of M by ε each does to an eigenvalue: ε Σ |r_j| |m_jk| |r_k|, at most ε λ_max D and far
/// less where the axes are those of the coordinates. What the decomposition itself may do comes on top.
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

/// Why a tensor is refused; nothing where it is not.
std::optional<Error> refusal_of(TensorState state, const Entity& vertex) {
    constexpr auto kind = ErrorKind::input;
    switch (state) {
        case TensorState::sound:
        case TensorState::floored: break;
        case TensorState::not_finite: return Error{kind, "holds a number that is not finite", {}, vertex, {}};
        case TensorState::zero:
            return Error{kind, "is zero", {}, vertex, "sizes would be infinite: give each direction a size"};
        case TensorState::out_of_range:
            static_assert(min_length == 1e-60 && max_length == 1e60);
            return Error{
                kind, "is of sizes that are not between 1e-60 and 1e60", {}, vertex, "take another unit of length"};
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

#define CAMBER_INSTANTIATE(D)                                                                           \
    template Outcome<TensorLogs<D>> log_metrics_of_tensors<D>(std::span<const double>, TensorPrecision, \
                                                              const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
