module;
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>
export module camber.solution_metric:local_model;
import camber.core;
import camber.metric;

export namespace camber {

/// How the least Q of third derivatives is found.
enum class CubicBound : std::uint8_t {
    optimal,   ///< to 1 % of the least determinant
    diagonal,  ///< by entries in the frame of T:T, four times faster; its determinant is mostly 1 to 1.5 times the
               ///< least
};
[[nodiscard]] constexpr auto words(CubicBound) {
    return words_of(Word{CubicBound::optimal, "optimal"}, Word{CubicBound::diagonal, "diagonal"});
}

struct ModelOptions {
    CubicBound bound = CubicBound::optimal;
    /// Of the sizes that a model alone asks for: where the derivatives vanish along a direction, or are the rounding of
    /// others, Q is raised to its largest eigenvalue over the square of this. The rounding of third derivatives'
    /// entries alone asks for sizes 2e5 times apart, in axes that nothing means.
    double max_anisotropy = 1e5;

    [[nodiscard]] static constexpr auto options() {
        using S = ModelOptions;
        return std::tuple(
            option("cubic_bound", &S::bound, "how well the metric of third derivatives bounds them: optimal, diagonal"),
            option("max_anisotropy", &S::max_anisotropy, "largest ratio of the sizes that derivatives alone ask for")
                .at_least(1)
                .at_most(1e12));
    }
    friend bool operator==(const ModelOptions&, const ModelOptions&) = default;
};

/// What became of a model where derivatives vanish.
enum class ModelKind : std::uint8_t {
    regular,
    floored,  ///< along some directions raised to max_anisotropy
    zero,     ///< all derivatives are 0: the function is resolved whatever the size
};

/// Q of a local model of the error, (|d^{k+1}u(v)|)^{2/(k+1)} ≤ vᵀQv: Q = R diag(e^{λ_i}) Rᵀ by its log-eigenvalues
/// λ_i, in any unit that u may have. Of a model that is zero all λ_i are −∞, and R is the identity.
template <int D>
struct LocalModel {
    EigenSystem<D> logs;
    ModelKind kind = ModelKind::regular;
};

template <int D>
[[nodiscard]] inline LocalModel<D> zero_model() {
    LocalModel<D> out{{{}, Mat<D>::identity()}, ModelKind::zero};
    for (double& x : out.logs.values.c) x = -std::numeric_limits<double>::infinity();
    return out;
}

/// The model with sizes no further apart than max_anisotropy.
template <int D>
[[nodiscard]] inline LocalModel<D> floored(LocalModel<D> model, double max_anisotropy) {
    auto& values = model.logs.values.c;
    constexpr double near = 0.1;  // what was bounded from below already
    const double least = *std::max_element(values.begin(), values.end()) - 2 * log(max_anisotropy);
    for (double& x : values)
        if (!(x >= least + near)) {
            x = std::fmax(x, least);
            model.kind = ModelKind::floored;
        }
    return model;
}

/// k = 1: Q = |H|, the Hessian with the absolute values of its eigenvalues.
template <int D>
[[nodiscard]] inline LocalModel<D> hessian_model(Sym<D> hessian, const ModelOptions& options) {
    double scale = 0;
    for (const double x : hessian.c) scale = std::max(scale, std::abs(x));
    if (scale == 0) return zero_model<D>();
    for (double& x : hessian.c) x /= scale;
    LocalModel<D> model{eigen_system(hessian)};
    for (double& x : model.logs.values.c) x = log(std::abs(x)) + log(scale);
    return floored(model, options.max_anisotropy);
}

}  // namespace camber
