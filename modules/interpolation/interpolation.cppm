module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>
/// What a mesh is good for: the error of a function's interpolant on it, of degree 1 and 2, straight and curved, and
/// straight within curved walls.
export module camber.interpolation;
import camber.core;
import camber.bezier;

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
/// with the point; a limit of the options; unsupported (no simplices of degree 2); memory; stopped.
template <int D>
[[nodiscard]] Outcome<InterpolationError> interpolation_error(const Mesh<D>& mesh, const ScalarField<D>& field,
                                                              const InterpolationOptions& options,
                                                              const Execution& execution);

/// The error u − u_h of a function u_h of degree 2 on that mesh, as a solver finds it, by its values at the nodes:
/// vertices first, then edges. Of degree 1 give the edges' middles their means. Errors: as above; internal, values that
/// are not the nodes'.
template <int D>
[[nodiscard]] Outcome<InterpolantError> function_error(const Mesh<D>& mesh, std::span<const double> values,
                                                       const ScalarField<D>& field, const InterpolationOptions& options,
                                                       const Execution& execution);

}  // namespace camber

namespace camber {

/// The conical rule as tables over its points. The points are also nodes of interpolation, so that values at them can
/// be differentiated.
template <int D>
struct CollapsedRule {
    explicit CollapsedRule(int points_a_direction);

    int n;
    std::size_t count = 0;
    std::vector<double> weights;  ///< their sum is 1/D!
    std::array<std::vector<double>, D + 1> barycentric;
    /// 4 λ_i λ_j of each local edge, and its derivatives by ξ_1 … ξ_D.
    std::array<std::vector<double>, edges_per_simplex<D>> bubbles;
    std::array<std::array<std::vector<double>, D>, edges_per_simplex<D>> bubble_slopes;
    /// Of the derivatives by ξ: the sum of the squares of the factors that the values have in them, by which
    /// independent errors of the values grow.
    std::array<std::vector<double>, D> amplification;

    /// ∂/∂ξ_1 … ∂/∂ξ_D of the polynomial through the values at the points.
    void differentiate(const std::vector<double>& values, std::array<std::vector<double>, D>& slopes) const;

  private:
    /// t-derivatives to ξ-derivatives, point by point.
    void to_reference(std::array<std::vector<double>, D>& slopes) const;

    std::array<std::vector<double>, D> nodes_;     ///< of each direction
    std::array<std::vector<double>, D> matrices_;  ///< n × n: the derivative at node r by the value at node c
};

/// A quadratic over a simplex: the linear function through its corners, and at each edge's middle what it has beyond
/// that. What is straight then stays so to rounding.
template <int D, class T>
struct Quadratic {
    std::array<T, D + 1> corners{};
    std::array<T, edges_per_simplex<D>> bubbles{};

    [[nodiscard]] T at(const Barycentric<D>& xi) const {
        T value{};
        for (int i = 0; i <= D; ++i) value = value + corners[i] * xi[i];
        for (int e = 0; e < edges_per_simplex<D>; ++e) value = value + bubbles[e] * edge_shape<D>(xi, e);
        return value;
    }
};

/// An element, or a part of it by a straight cut of the reference simplex, with the interpolants whose errors are
/// asked for.
template <int D>
struct Piece {
    Vec<D> origin;                ///< places are relative to it, so that small elements far from 0 keep their digits
    Quadratic<D, Vec<D>> places;  ///< F
    bool straight = false;        ///< F is affine
    int interpolants = 1;
    std::array<Quadratic<D, double>, 2> values{};  ///< u_h ∘ F
    double rounding = 0;  ///< of a value of u: its evaluation's, and that of the places where it is evaluated
};

/// Integrals over a piece. Of each interpolant: ∫ e², ∫ |∇e|², each with the share that rounding may have.
struct Integrals {
    static constexpr int quantities = 4;       ///< L2 and H1 of two interpolants
    std::array<double, quantities> squares{};  ///< L2, H1, L2, H1
    double l2_rounding = 0, h1_rounding = 0;
    bool turned = false;  ///< det J <= 0 at a point

    Integrals& operator+=(const Integrals& other);
};

/// What integrating needs beside the rule: arrays of one value a point, used again from piece to piece.
template <int D>
class Integrator {
  public:
    explicit Integrator(PointFunction<D> field) : field_(std::move(field)) {}

    [[nodiscard]] Integrals integrate(const Piece<D>& piece, const CollapsedRule<D>& rule);
    /// u at points.
    void evaluate(std::span<const Vec<D>> points, std::span<double> values) { field_(points, values); }
    /// The points of the last piece, with u at them.
    [[nodiscard]] std::span<const Vec<D>> points() const { return points_; }
    [[nodiscard]] std::span<const double> values() const { return values_; }

  private:
    void resize(std::size_t count);
    void place(const Piece<D>& piece, const CollapsedRule<D>& rule);
    void subtract(const Quadratic<D, double>& interpolant, const CollapsedRule<D>& rule, std::vector<double>& error);

    PointFunction<D> field_;
    std::vector<Vec<D>> points_;
    std::array<std::array<std::vector<double>, D>, D> columns_;  ///< of J
    std::vector<double> values_, error_, other_error_;
    std::array<std::vector<double>, D> slopes_;  ///< of the first interpolant's error, by ξ
};

/// Which nodes: the middles of the chords, or those of the mesh.
enum class Sides : std::uint8_t { straight, curved };

template <int D>
[[nodiscard]] std::array<Vec<D>, quadratic_nodes<D>> nodes_of(const QuadraticMesh<D>& mesh, std::size_t e, Sides sides);

/// An element's places and values: of straight elements with the interpolants of degree 2 and 1, of curved ones with
/// that of degree 2; or, where there are values at the mesh's nodes, with the function of degree 2 that has these.
template <int D>
[[nodiscard]] Piece<D> piece_of(const QuadraticMesh<D>& mesh, std::size_t e, Sides sides, std::span<const double> nodal,
                                Integrator<D>& integrator);

/// 2^D pieces that together are the piece.
template <int D>
[[nodiscard]] std::array<Piece<D>, (1U << D)> divided(const Piece<D>& piece);

using Squares = std::array<double, Integrals::quantities>;

/// The rules by rising number of points.
template <int D>
using Rules = std::vector<CollapsedRule<D>>;
template <int D>
[[nodiscard]] Rules<D> quadrature_rules();

/// What is known of one element.
struct State {
    Integrals integrals;
    Squares change{};  ///< by the last refinement
    std::uint32_t evaluations = 0;
    std::int8_t level = -1;
};

/// The elements of a mesh that are integrated over.
template <int D>
struct IntegrationDomain {
    const QuadraticMesh<D>& mesh;
    std::vector<std::uint32_t> elements;
    Sides sides{};
};

/// A function: `nodal` has its values at the mesh's nodes if it is of degree 2; empty: of the interpolants.
template <int D>
struct Integrand {
    const ScalarField<D>& field;
    std::span<const double> nodal;
};

/// Where the integrals over elements of a mesh are refined: level after level, first with more points, then on parts of
/// an element, until what the last refinements changed is small in all.
template <int D>
class Quadrature {
  public:
    Quadrature(IntegrationDomain<D> domain, const Integrand<D>& integrand, const Rules<D>& rules, double tolerance,
               const Execution& execution)
        : mesh_(domain.mesh),
          field_(integrand.field),
          nodal_(integrand.nodal),
          rules_(rules),
          sides_(domain.sides),
          tolerance_(tolerance),
          execution_(execution),
          elements_(std::move(domain.elements)),
          states_(elements_.size(), State{}) {}

    /// To what is asked for together with `beside`, the squares of the mesh's other elements.
    [[nodiscard]] Outcome<Done> integrate(const Squares& beside);

    /// Entries of its elements, in a list of those of the mesh's.
    void put_into(std::vector<const State*>& states) const {
        for (std::size_t i = 0; i < elements_.size(); ++i) states[elements_[i]] = &states_[i];
    }
    [[nodiscard]] std::size_t evaluations() const;
    /// Elements that are not settled, at the highest level or at the highest that could be afforded.
    [[nodiscard]] std::size_t unresolved() const { return unresolved_; }

  private:
    // Elements are told by their rows in `elements_`.
    [[nodiscard]] Outcome<Done> refine(const std::vector<std::uint32_t>& active);
    void refine(std::uint32_t row, const Squares& enough, Integrator<D>& integrator);
    [[nodiscard]] bool affordable(const std::vector<std::uint32_t>& active) const;
    [[nodiscard]] Squares total() const;
    [[nodiscard]] Squares enough_of_parts() const;
    [[nodiscard]] std::vector<std::uint32_t> unsettled();
    [[nodiscard]] double threshold_of(std::size_t q, double allowed) const;
    [[nodiscard]] Error not_finite(std::uint32_t row) const;

    const QuadraticMesh<D>& mesh_;
    const ScalarField<D>& field_;
    const std::span<const double> nodal_;
    const Rules<D>& rules_;
    Sides sides_;
    double tolerance_;
    const Execution& execution_;
    std::vector<std::uint32_t> elements_;
    std::vector<State> states_;  ///< one an element of these
    Squares beside_{};
    std::size_t unresolved_ = 0;
};

/// The integrals over a piece and by how much they changed at last.
struct Integrated {
    Integrals integrals;
    Squares change{};
    std::size_t evaluations = 0;
};

/// What the squares changed by, rounding left out; of H1 nothing where det J is not positive.
[[nodiscard]] Squares effective_change(const Integrals& now, const Integrals& before);

/// Parts of parts, as deep as told (at least 1), wherever the parts together differ from the whole by more than
/// `enough`.
template <int D>
[[nodiscard]] Integrated integrate_parts(const Piece<D>& whole, const Integrals& of_whole, const Squares& enough,
                                         int depth, const CollapsedRule<D>& rule, Integrator<D>& integrator);

/// Why an element's integrals are no numbers.
template <int D>
[[nodiscard]] Error find_not_finite(const QuadraticMesh<D>& mesh, std::size_t e, Sides sides, const Rules<D>& rules,
                                    Integrator<D>& integrator);

/// Elements of which a node is not exactly in the middle of its edge, by rising number.
template <int D>
[[nodiscard]] std::vector<std::uint32_t> bent_elements(const QuadraticMesh<D>& mesh);

/// Every node exactly in the middle of its edge.
template <int D>
[[nodiscard]] bool is_straight(const QuadraticMesh<D>& mesh, std::size_t e);

/// The mesh with straight edges wherever its boundary and its interfaces allow it: the edges of their facets keep
/// their nodes where the facet is not flat, all others go straight. In a flat facet a bent edge moves no boundary, so
/// it counts as an inner one. None where all of those facets are flat: the straight mesh has the same boundary then.
/// Needs the mesh's bent elements.
template <int D>
[[nodiscard]] std::optional<QuadraticMesh<D>> straight_inside(const QuadraticMesh<D>& mesh,
                                                              const std::vector<std::uint32_t>& bent);

/// What the straight mesh and the curved one cover. Needs the curved one's elements that are not straight.
template <int D>
[[nodiscard]] Volumes volumes_of(const QuadraticMesh<D>& mesh, const std::vector<std::uint32_t>& bent);

}  // namespace camber
