module;
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <tuple>
export module camber.interpolation:error;
import camber.core;

export namespace camber {

/// Values of a scalar function u at points, written into a span of the same size.
template <int D>
using PointFunction = std::function<void(std::span<const Vec<D>>, std::span<double>)>;

/// A scalar field by what makes its evaluators: each thread works with its own, so that an evaluator may have a state.
/// What it gives for a point must not depend on the points before.
template <int D>
using ScalarField = std::function<PointFunction<D>()>;

struct InterpolationOptions {
    double tolerance = 1e-3;

    [[nodiscard]] static constexpr auto options() {
        using S = InterpolationOptions;
        return std::tuple(option("tolerance", &S::tolerance, "relative error of the norms that is asked for")
                              .at_least(1e-8)
                              .at_most(0.1));
    }
};

/// One norm of an error over the mesh.
struct ErrorNorm {
    double value = 0;
    /// How far it may be from the integral's value, relative: half of the sum over the elements of what the last
    /// refinement of their quadrature changed, by the sum of the squares.
    double uncertainty = 0;
    double rounding =
        0;  ///< what the rounding of u's values alone may give: an error about as small is 0 for all one knows
    Column<double> squares;  ///< of the elements: value² is their sum
};

/// The error e = u − u_h of an interpolant: (∫ e²)^½ and (∫ |∇e|²)^½.
struct InterpolantError {
    ErrorNorm l2, h1;
};

/// The mesh without curved inner edges that says whether they pay.
enum class Comparison : std::uint8_t {
    straight,       ///< boundary and interfaces are straight, too: straight edges cover the same domain
    same_boundary,  ///< they are curved, and stay so
};
constexpr auto words(Comparison) {
    return words_of(Word{Comparison::straight, "straight"}, Word{Comparison::same_boundary, "same_boundary"});
}

/// What meshes cover: volume, in 2D area; where det J is negative it counts as such.
struct Volumes {
    double straight = 0, curved = 0;
};

/// Errors of a field's interpolants on a mesh of degree 2, all with the mesh's vertices.
struct InterpolationError {
    InterpolantError linear;    ///< of degree 1, straight edges
    InterpolantError straight;  ///< of degree 2, straight edges
    /// Of degree 2, the boundary's and interfaces' facets as they are, all other edges straight; `straight` where these
    /// facets are flat.
    InterpolantError same_boundary;
    InterpolantError curved;  ///< of degree 2, the mesh as it is
    Comparison compared_with = Comparison::straight;
    Volumes volume;
    /// Elements in which det J is not positive somewhere at a point of the quadrature: their integrals are taken with
    /// |det J|, their part of the H1 error leaves out points where J is singular and decides about no refinement. Of
    /// the same boundary at a node, too, so that none is missed that a coarser quadrature does not meet.
    std::size_t straight_turned = 0, same_boundary_turned = 0, curved_turned = 0;
    std::size_t unresolved = 0;   ///< elements whose quadrature found no end: at its finest, and still needed
    std::size_t evaluations = 0;  ///< of u in all

    /// By the error of the mesh as it is: above 1 the curvature of inner edges pays.
    [[nodiscard]] const InterpolantError& compared() const {
        return compared_with == Comparison::straight ? straight : same_boundary;
    }
};

/// The error of the Lagrange interpolants of a field, by quadrature that is refined element by element until the norms
/// are as exact as asked for. Docs: docs/algorithms/interpolation-error.md. Errors (usage): u is not finite somewhere,
/// with the point; a limit of the options; memory; stopped.
template <int D>
[[nodiscard]] Outcome<InterpolationError> interpolation_error(const QuadraticMesh<D>& mesh, const ScalarField<D>& field,
                                                              const InterpolationOptions& options,
                                                              const Execution& execution);

/// The error u − u_h of a function u_h of degree 2 on that mesh, as a solver finds it, by its values at the nodes:
/// vertices first, then edges. Of degree 1 give the edges' middles their means. Errors: as above; internal, values that
/// are not the nodes'.
template <int D>
[[nodiscard]] Outcome<InterpolantError> function_error(const QuadraticMesh<D>& mesh, std::span<const double> values,
                                                       const ScalarField<D>& field, const InterpolationOptions& options,
                                                       const Execution& execution);

}  // namespace camber
