module;
#include <array>
#include <limits>
#include <optional>
#include <span>
export module camber.optimisation:linear_programme;
import camber.core;
import camber.validity;

export namespace camber {

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

}  // namespace camber
