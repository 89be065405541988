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
/// Interpolation errors of degrees 1 and 2 on three meshes: with straight edges, with the curved edges, and with only
/// the boundary curved.
export module camber.interpolation;
import camber.core;
import camber.bezier;

export namespace camber {

/// Function that evaluates a field at points; both spans have the same size.
template <int D>
using PointFunction = std::function<void(std::span<const Vec<D>>, std::span<double>)>;

/// Scalar field: a function that makes an evaluator for each thread. Evaluators may have state, but results must not
/// depend on earlier points.
template <int D>
using ScalarField = std::function<PointFunction<D>()>;

struct InterpolationOptions {
    double tolerance = 1e-3;

    [[nodiscard]] static constexpr auto options() {
        using S = InterpolationOptions;
        return std::tuple(
            option("tolerance", &S::tolerance, "relative tolerance of the norms").at_least(1e-8).at_most(0.1));
    }
};

struct ErrorNorm {
    double value = 0;
    /// Relative uncertainty of `value`: half the sum of the last changes of `squares`, divided by the sum of `squares`.
    double uncertainty = 0;
    double rounding = 0;     ///< error due to rounding errors of u; smaller errors cannot be distinguished from 0
    Column<double> squares;  ///< one per element; their sum is value²
};

/// L2 and H1 norms of the error e = u − u_h of the interpolant u_h: (∫ e²)^½ and (∫ |∇e|²)^½.
struct InterpolantError {
    ErrorNorm l2, h1;
};

/// Mesh with which the curved mesh is compared, to show the effect of curved inner edges.
enum class Comparison : std::uint8_t {
    straight,       ///< all edges straight; for a straight boundary
    same_boundary,  ///< only boundary and interfaces curved
};
constexpr auto words(Comparison) {
    return words_of(Word{Comparison::straight, "straight"}, Word{Comparison::same_boundary, "same_boundary"});
}

/// Volumes (2D: areas) of the straight and the curved mesh. Parts with negative det J count as negative.
struct Volumes {
    double straight = 0, curved = 0;
};

/// Errors of a field's interpolants on the same vertices. `linear` and `straight` have degrees 1 and 2 on straight
/// edges. `curved` has degree 2 on the unchanged mesh.
struct InterpolationError {
    InterpolantError linear;
    InterpolantError straight;
    /// Degree 2, where only the facets of boundary and interfaces are curved; equal to `straight` if these are flat.
    InterpolantError same_boundary;
    InterpolantError curved;
    Comparison compared_with = Comparison::straight;
    Volumes volume;
    /// Numbers of elements with det J ≤ 0 at a quadrature point. Their integrals use |det J|. H1 errors exclude
    /// singular points, and cause no refinement in these elements. For `same_boundary` det J is also checked at the
    /// nodes, since a coarse quadrature may miss elements.
    std::size_t straight_inverted = 0, same_boundary_inverted = 0, curved_inverted = 0;
    std::size_t unresolved = 0;
    std::size_t evaluations = 0;

    /// Returns the error on the comparison mesh. If it exceeds `curved`, curved inner edges reduce the error.
    [[nodiscard]] const InterpolantError& compared() const {
        return compared_with == Comparison::straight ? straight : same_boundary;
    }
};

/// Computes errors of Lagrange interpolants by adaptive quadrature (docs/algorithms/interpolation-error.md). Errors
/// (usage): u is not finite at a point (which the message states); options out of range; unsupported (no quadratic
/// simplices); memory; stopped.
template <int D>
[[nodiscard]] Outcome<InterpolationError> interpolation_error(const Mesh<D>& mesh, const ScalarField<D>& field,
                                                              const InterpolationOptions& options,
                                                              const Execution& execution);

/// Computes the error u − u_h of a solution u_h of degree 2 from its nodal values: vertices, then edges. For degree 1
/// set the values at edges to the means of both ends. Errors: those of `interpolation_error`; values that do not match
/// the nodes (internal).
template <int D>
[[nodiscard]] Outcome<InterpolantError> function_error(const Mesh<D>& mesh, std::span<const double> values,
                                                       const ScalarField<D>& field, const InterpolationOptions& options,
                                                       const Execution& execution);

}  // namespace camber

namespace camber {

/// Tables of a conical quadrature rule. A polynomial interpolates values at its points, so these can be differentiated.
template <int D>
struct CollapsedRule {
    explicit CollapsedRule(int points_per_direction);

    int n;
    std::size_t count = 0;
    std::vector<double> weights;  ///< their sum is 1/D!
    std::array<std::vector<double>, D + 1> barycentric;
    /// Values of the shape function 4 λ_i λ_j of each local edge i–j, then its derivatives by ξ_1 … ξ_D.
    std::array<std::vector<double>, edges_per_simplex<D>> bubbles;
    std::array<std::array<std::vector<double>, D>, edges_per_simplex<D>> bubble_slopes;
    /// For each ξ-derivative: sum of the squared coefficients of the values, the factor by which independent squared
    /// errors grow.
    std::array<std::vector<double>, D> amplification;

    /// Computes the derivatives by ξ_1 … ξ_D of the polynomial that interpolates `values`.
    void differentiate(const std::vector<double>& values, std::array<std::vector<double>, D>& slopes) const;

  private:
    void to_reference(std::array<std::vector<double>, D>& slopes) const;

    std::array<std::vector<double>, D> nodes_;
    std::array<std::vector<double>, D> matrices_;  ///< n × n for each direction: derivative at node r by the value at
                                                   ///< node c
};

/// Quadratic function: the linear interpolation of `corners`, plus the offsets `bubbles` from it at the edge middles.
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

/// An element with its interpolants, or a part of it with straight sides in reference coordinates.
template <int D>
struct Piece {
    Vec<D> origin;  ///< origin of `places`, so that coordinates of small elements far from 0 keep their digits
    Quadratic<D, Vec<D>> places;
    bool straight = false;
    int interpolants = 1;
    std::array<Quadratic<D, double>, 2> values{};  ///< interpolants as functions of ξ: u_h(F(ξ))
    double rounding = 0;  ///< rounding error of a value of u, from its evaluation and from the coordinates
};

/// ∫ e² and ∫ |∇e|² for the error e of each interpolant, with their rounding errors.
struct Integrals {
    static constexpr int quantities = 4;  ///< squared L2 and H1 errors of two interpolants
    std::array<double, quantities> squares{};
    double l2_rounding = 0, h1_rounding = 0;
    bool turned = false;

    Integrals& operator+=(const Integrals& other);
};

template <int D>
class Integrator {
  public:
    explicit Integrator(PointFunction<D> field) : field_(std::move(field)) {}

    [[nodiscard]] Integrals integrate(const Piece<D>& piece, const CollapsedRule<D>& rule);
    void evaluate(std::span<const Vec<D>> points, std::span<double> values) { field_(points, values); }
    [[nodiscard]] std::span<const Vec<D>> points() const { return points_; }
    [[nodiscard]] std::span<const double> values() const { return values_; }

  private:
    void resize(std::size_t count);
    void place(const Piece<D>& piece, const CollapsedRule<D>& rule);
    void subtract(const Quadratic<D, double>& interpolant, const CollapsedRule<D>& rule, std::vector<double>& error);

    PointFunction<D> field_;
    std::vector<Vec<D>> points_;
    std::array<std::array<std::vector<double>, D>, D> columns_;
    std::vector<double> values_, error_, other_error_;
    std::array<std::vector<double>, D> slopes_;  ///< derivatives of the first interpolant's error by ξ_1 … ξ_D
};

/// Choice of edge nodes: the chord middles, or the nodes of the mesh.
enum class Sides : std::uint8_t { straight, curved };

template <int D>
[[nodiscard]] std::array<Vec<D>, quadratic_nodes<D>> nodes_of(const QuadraticMesh<D>& mesh, std::size_t e, Sides sides);

/// Returns element `e` with its interpolants: of degrees 2 and 1 on straight sides, of degree 2 on curved ones. If
/// `nodal` is not empty, u_h is the quadratic function with these nodal values.
template <int D>
[[nodiscard]] Piece<D> piece_of(const QuadraticMesh<D>& mesh, std::size_t e, Sides sides, std::span<const double> nodal,
                                Integrator<D>& integrator);

template <int D>
[[nodiscard]] std::array<Piece<D>, (1U << D)> divided(const Piece<D>& piece);

using Squares = std::array<double, Integrals::quantities>;

template <int D>
using Rules = std::vector<CollapsedRule<D>>;
template <int D>
[[nodiscard]] Rules<D> quadrature_rules();

struct State {
    Integrals integrals;
    Squares change{};
    std::uint32_t evaluations = 0;
    std::int8_t level = -1;
};

template <int D>
struct IntegrationDomain {
    const QuadraticMesh<D>& mesh;
    std::vector<std::uint32_t> elements;
    Sides sides{};
};

/// Field u and function u_h. If `nodal` is empty, u_h is the interpolant of u; otherwise `nodal` has its nodal values.
template <int D>
struct Integrand {
    const ScalarField<D>& field;
    std::span<const double> nodal;
};

/// Adaptive integration of the squared errors. Elements are refined level by level, first with more points, then by
/// subdivision. It ends when the sum of the last changes is small.
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

    /// Integrates until the tolerance of the whole mesh is reached; `beside` are the squared errors of its other
    /// elements.
    [[nodiscard]] Outcome<Done> integrate(const Squares& beside);

    void put_into(std::vector<const State*>& states) const {
        for (std::size_t i = 0; i < elements_.size(); ++i) states[elements_[i]] = &states_[i];
    }
    [[nodiscard]] std::size_t evaluations() const;
    [[nodiscard]] std::size_t unresolved() const { return unresolved_; }

  private:
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
    std::vector<State> states_;
    Squares beside_{};
    std::size_t unresolved_ = 0;
};

struct Integrated {
    Integrals integrals;
    Squares change{};
    std::size_t evaluations = 0;
};

/// Returns the changes of the squared errors beyond rounding; H1 changes count as 0 if det J ≤ 0 at a point.
[[nodiscard]] Squares effective_change(const Integrals& now, const Integrals& before);

/// Integrates over subdivisions of an element, up to `depth` (≥ 1) levels deep. A part is subdivided again if the sum
/// over its own parts differs from its integral by more than `enough`.
template <int D>
[[nodiscard]] Integrated integrate_parts(const Piece<D>& whole, const Integrals& of_whole, const Squares& enough,
                                         int depth, const CollapsedRule<D>& rule, Integrator<D>& integrator);

template <int D>
[[nodiscard]] Error find_not_finite(const QuadraticMesh<D>& mesh, std::size_t e, Sides sides, const Rules<D>& rules,
                                    Integrator<D>& integrator);

/// Returns, in ascending order, the elements with an edge node that is not exactly at the chord's middle.
template <int D>
[[nodiscard]] std::vector<std::uint32_t> curved_elements(const QuadraticMesh<D>& mesh);

template <int D>
[[nodiscard]] bool is_straight(const QuadraticMesh<D>& mesh, std::size_t e);

/// Returns the mesh with all edges straight except those of curved facets of the boundary and interfaces. Curved edges
/// within the plane of a facet do not move the boundary, so the facet counts as flat. Returns no mesh if all these
/// facets are flat. `bent` lists the curved elements.
template <int D>
[[nodiscard]] std::optional<QuadraticMesh<D>> straight_inside(const QuadraticMesh<D>& mesh,
                                                              const std::vector<std::uint32_t>& bent);

template <int D>
[[nodiscard]] Volumes volumes_of(const QuadraticMesh<D>& mesh, const std::vector<std::uint32_t>& bent);

}  // namespace camber
