module;
#include <array>
#include <limits>
#include <optional>
#include <span>
export module camber.optimisation:small_programs;
import camber.core;
import camber.bezier;
import camber.validity;

export namespace camber {

/// An affine function of θ ∈ [0, 1] and its lower bound, such as a coefficient of det J while one node moves on a
/// segment.
struct AffineConstraint {
    double at_0 = 0, at_1 = 0;
    double floor = 0;
};

/// Closed interval of θ.
struct SegmentInterval {
    double low = 0, high = 1;
};

[[nodiscard]] std::optional<SegmentInterval> feasible(std::span<const AffineConstraint> constraints);

/// Returns the largest maximiser of min (value − floor), a concave piecewise linear function, up to rounding.
[[nodiscard]] double max_min_parameter(std::span<const AffineConstraint> constraints, SegmentInterval within);

/// Constraint function(x) ≥ weight · t. A function with weight 1 is raised; with weight 0 it stays non-negative.
template <int M>
struct RaisedFunction {
    AffineFunction<M> function;
    double weight = 1;
};

template <int M>
struct MaxMinPoint {
    Vec<M> x;
    double lower = 0;  ///< min function(x) / weight over the raised functions
    double upper = 0;  ///< upper bound for any x, up to rounding (weak duality)
    /// Active functions; fewer than M + 1 if the limit `reach` is active too.
    std::array<int, M + 1> active{};
    int active_count = 0;
};

/// Maximises t under function_i(x) ≥ weight_i t. `reach` limits the coordinates of x by the change that they cause in
/// the most sensitive function, so linear changes of x have no influence. Nothing if the functions of weight 0 are
/// contradictory, if no function has a weight, or if the maximum is certainly at most `least`.
///
/// Dual simplex method with explicit bases of M + 1 constraints. The most violated constraint enters; after many steps
/// Bland's rule prevents cycles. Linear time in practice. Deterministic, and independent of the order of the functions
/// except for ties.
template <int M>
[[nodiscard]] std::optional<MaxMinPoint<M>> max_min_point(std::span<const RaisedFunction<M>> functions, double reach,
                                                          double least = -std::numeric_limits<double>::infinity());

/// The strictly convex function value + ½ (x − centre)ᵀ hessian (x − centre).
template <int M>
struct QuadraticModel {
    Vec<M> centre;
    Sym<M> hessian = Sym<M>::identity();  ///< symmetric positive definite
    double value = 0;                     ///< value at the centre

    [[nodiscard]] constexpr double operator()(const Vec<M>& x) const {
        return value + 0.5 * dot(x - centre, hessian * (x - centre));
    }
};

template <int M>
struct NearestPoint {
    bool feasible = false;
    Vec<M> x;
    double cost = 0;  ///< model at x minus its value at the centre
    /// Active functions, which are 0 at x; if infeasible, contradictory functions.
    std::array<int, M + 1> active{};
    int active_count = 0;
};

/// Minimises the model under function_i(x) ≥ 0. Finite dual active set method of Goldfarb and Idnani (1983), in the
/// frame where the Hessian is the identity; the most violated function enters.
template <int M>
[[nodiscard]] NearestPoint<M> nearest_point(const QuadraticModel<M>& model,
                                            std::span<const AffineFunction<M>> functions);

template <int D>
struct MinJacobianPoint {
    Barycentric<D> at{};
    double jacobian = 0;  ///< det J at the point
};

/// Returns a point with det J within 1e-3 · max(|det of the straight element|, |minimum|) of the minimum, for messages.
/// `jacobian` is accurate to the error of the coefficients; the minimum is not certified.
template <int D>
[[nodiscard]] MinJacobianPoint<D> min_jacobian_point(const BoundedJacobian<D>& jacobian);

}  // namespace camber
