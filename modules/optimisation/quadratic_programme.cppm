module;
#include <array>
#include <span>
export module camber.optimisation:quadratic_programme;
import camber.core;
import :linear_programme;

export namespace camber {

/// A strictly convex quadratic function of x ∈ R^M: value + ½ (x − centre)ᵀ hessian (x − centre).
template <int M>
struct QuadraticModel {
    Vec<M> centre;
    Sym<M> hessian = Sym<M>::identity();  ///< symmetric positive definite
    double value = 0;                     ///< at the centre

    [[nodiscard]] constexpr double operator()(const Vec<M>& x) const {
        return value + 0.5 * dot(x - centre, hessian * (x - centre));
    }
};

}  // namespace camber

namespace camber {

/// L with hessian = L Lᵀ; a pivot lost to rounding becomes a small positive one.
template <int M>
[[nodiscard]] Mat<M> cholesky(const Sym<M>& hessian);

}  // namespace camber

export namespace camber {

/// The answer of a quadratic programme.
template <int M>
struct NearestPoint {
    bool feasible = false;
    Vec<M> x;
    double cost = 0;  ///< of the model at x, less its value at the centre
    /// Functions that are 0 at x and hold it back; where infeasible, functions that contradict each other.
    std::array<int, M + 1> active{};
    int active_count = 0;
};

/// Minimises the model under function_i(x) ≥ 0. Exact and finite: the dual active set method of Goldfarb and Idnani
/// (1983), the most violated function entering, in the frame where the Hessian is the identity.
template <int M>
[[nodiscard]] NearestPoint<M> nearest_point(const QuadraticModel<M>& model,
                                            std::span<const AffineFunction<M>> functions);

}  // namespace camber
