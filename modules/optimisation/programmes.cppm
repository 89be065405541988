module;
#include <array>
#include <limits>
#include <optional>
#include <span>
export module camber.optimisation:programmes;
import camber.core;
import camber.bezier;
import camber.validity;

export namespace camber {

/// A quantity that is affine in θ ∈ [0, 1], and the least that it may be. A node enters each coefficient of det J
/// affinely (one column of J is affine in it), so along a segment of nodes every coefficient of the edge's shell is
/// one.
struct AffineConstraint {
    double at_0 = 0, at_1 = 0;
    double floor = 0;
};

/// Where on a segment; a closed interval of θ.
struct SegmentInterval {
    double low = 0, high = 1;
};

/// The θ ∈ [0, 1] that keep all constraints (a linear programme in one unknown); none if there is none.
[[nodiscard]] std::optional<SegmentInterval> feasible(std::span<const AffineConstraint> constraints);

/// The θ of `within` that maximises min (value − floor): the top of a concave piecewise linear function. The largest
/// such θ, to rounding.
[[nodiscard]] double highest_minimum(std::span<const AffineConstraint> constraints, SegmentInterval within);

/// function(x) ≥ weight · t. Weight 1: its value is raised; weight 0: it need only stay positive.
template <int M>
struct RaisedFunction {
    AffineFunction<M> function;
    double weight = 1;
};

/// The answer of a linear programme, as a bracket.
template <int M>
struct HighestPoint {
    Vec<M> x;
    double lower = 0;  ///< min function(x) / weight over the raised functions, at x
    double upper = 0;  ///< no x has more, but for rounding (weak duality)
    /// Functions that hold the value down; fewer than M + 1 where the reach does too.
    std::array<int, M + 1> active{};
    int active_count = 0;
};

/// Maximises t under function_i(x) ≥ weight_i t: the point with the largest smallest value. `reach` bounds x: in a
/// frame of the functions' own gradients, so that no linear change of x matters, each coordinate may change the
/// function most sensitive to it by so much. None if the functions of weight 0 contradict each other, or none has a
/// weight, or once it is known that no x has more than `least`.
///
/// Dual simplex method with explicit bases of M + 1 constraints, the most violated constraint entering (after many
/// steps the first one, by Bland's rule, against cycles); a few passes over the constraints, so linear time in
/// practice. Only exchanges, no random order: deterministic, and independent of the order of the functions but for
/// ties.
template <int M>
[[nodiscard]] std::optional<HighestPoint<M>> highest_point(std::span<const RaisedFunction<M>> functions, double reach,
                                                           double least = -std::numeric_limits<double>::infinity());

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

/// Where det J of an element is lowest.
template <int D>
struct LowestPoint {
    Barycentric<D> at{};
    double jacobian = 0;  ///< det J there
};

/// A point whose det J is within 1e-3 · max(|det of the straight element|, |the minimum|) of the smallest, by
/// bisection: for messages. What it says of det J is true to the error of the coefficients; that it is the lowest is
/// not certified.
template <int D>
[[nodiscard]] LowestPoint<D> lowest_point(const BoundedJacobian<D>& jacobian);

}  // namespace camber
