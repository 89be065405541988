module;
#include <optional>
#include <span>
export module camber.optimisation:segment;

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

}  // namespace camber
