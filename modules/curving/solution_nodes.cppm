module;
#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>
export module camber.curving:solution_nodes;
import camber.core;
import camber.bezier;
import camber.validity;
import :edges;

/// Volume nodes for the best interpolation of a known solution (docs/algorithms/solution-nodes.md).
export namespace camber {

/// Degree of the polynomials that represent a scalar field, one for each element, in reference coordinates. Each is
/// stored by its values at a regular lattice in the order of `multi_indices`, up to a constant.
inline constexpr int known_degree = 5;
template <int D>
struct KnownField {
    Column<std::array<float, node_count<known_degree, D>>> values;
    double weight = 1;  ///< weight of the field's error
    int exponent = 0;   ///< values are in units of 2^exponent user units
};
template <int D>
using KnownSolution = std::vector<KnownField<D>>;
/// Returns the solution in the elements of a mesh; called for copies of the mesh with other edge nodes.
template <int D>
using SolutionInElements = std::function<Outcome<KnownSolution<D>>(const QuadraticMesh<D>&, const Execution&)>;

struct SolutionNodesOptions {
    int frames = 4;          ///< maximum number of evaluations of the solution in the elements
    int rounds = 3;          ///< maximum number of steps per evaluation of the solution
    double stiffness = 0.3;  ///< an offset as long as the element adds this fraction of the squared error
    double max_slide = 0.2;  ///< maximum distance of a node from the chord's middle, along the chord and relative to it
    double min_jacobian = default_bound;
};

template <int D>
struct SolutionNodes {
    Column<LagrangeNode<D>> nodes;  ///< one row per edge
    /// Expected errors of the first start and of `nodes`. For one field: weight · ‖u − u_h‖ in user units; for several:
    /// the root of Σ (weight ‖u − u_h‖)² in units of the fields. Integrated as in `expected_error`.
    double before = 0, after = 0;
    int frames = 0;
    std::size_t relaxed = 0;  ///< edges moved by only a part of their step
};

/// Moves volume nodes to minimise Σ ∫ (u − u_h)² over fields and elements, where u_h is the interpolant of degree 2 on
/// curved elements (docs/algorithms/solution-nodes.md). Starts from the best of `starts` (one row per edge); boundary
/// nodes do not move. Elements stay above `min_jacobian`. The expected error never increases. Results do not depend on
/// the number of threads. Errors: columns that do not fit (internal); those of `solution`; stopped, memory.
template <int D>
[[nodiscard]] Outcome<SolutionNodes<D>> solution_nodes(const MeshEdges<D>& edges,
                                                       std::span<const Column<LagrangeNode<D>>> starts,
                                                       const SolutionInElements<D>& solution,
                                                       const SolutionNodesOptions& options, const Execution& execution);

/// Returns the expected L2 error of interpolants of degree 1 or 2 on straight elements, in the units of
/// `SolutionNodes`. The rule of degree 11 is exact for `solution`. Errors: not one row per element, another degree
/// (internal); stopped.
template <int D>
[[nodiscard]] Outcome<double> expected_error(const LinearMesh<D>& mesh, const KnownSolution<D>& solution, int degree,
                                             const Execution& execution);

}  // namespace camber

/// Polynomials in an element, defined by values at a lattice.
namespace camber {

template <int D>
inline constexpr int lattice_size = node_count<known_degree, D>;

template <int D>
[[nodiscard]] constexpr int monomials(int degree) {
    return D == 2 ? (degree + 1) * (degree + 2) / 2 : (degree + 1) * (degree + 2) * (degree + 3) / 6;
}

/// Exponents of the monomials; the exponent of the first coordinate varies fastest.
template <int D, int Degree>
inline constexpr auto exponents = [] {
    std::array<std::array<int, D>, monomials<D>(Degree)> all{};
    int n = 0;
    if constexpr (D == 2) {
        for (int b = 0; b <= Degree; ++b)
            for (int a = 0; a + b <= Degree; ++a) all[n++] = {a, b};
    } else {
        for (int c = 0; c <= Degree; ++c)
            for (int b = 0; b + c <= Degree; ++b)
                for (int a = 0; a + b + c <= Degree; ++a) all[n++] = {a, b, c};
    }
    return all;
}();

/// Coefficients of the Lagrange basis: [coefficient in the order of `exponents`][lattice node]. The simplex has its
/// vertices at the origin and at the ends of the unit axes.
template <int D>
using LatticeBasis = std::array<std::array<double, lattice_size<D>>, lattice_size<D>>;
template <int D>
[[nodiscard]] const LatticeBasis<D>& lattice_basis();

template <int D>
using PackVec = std::array<Pack, D>;

template <int D>
struct PackSlope {
    Pack value;
    PackVec<D> gradient;
};

template <int D, int Degree>
struct PackPolynomial {
    std::array<Pack, monomials<D>(Degree)> c;

    [[nodiscard, gnu::always_inline]] PackSlope<D> at(const PackVec<D>& x) const {
        if constexpr (D == 2) {
            return plane(x, monomials<D>(Degree), Degree);
        } else {
            PackSlope<D> sum{packed(0), {packed(0), packed(0), packed(0)}};
            int end = monomials<D>(Degree);
            for (int left = 0; left <= Degree; ++left) {  // degree in the first two coordinates
                const PackSlope<2> in_plane = plane({x[0], x[1]}, end, left);
                sum.gradient[2] = sum.gradient[2] * x[2] + sum.value;
                sum.gradient[0] = sum.gradient[0] * x[2] + in_plane.gradient[0];
                sum.gradient[1] = sum.gradient[1] * x[2] + in_plane.gradient[1];
                sum.value = sum.value * x[2] + in_plane.value;
                end -= monomials<2>(left);
            }
            return sum;
        }
    }

  private:
    /// Returns value and slopes of a polynomial in two coordinates. Its coefficients are the last ones of `c` before
    /// index `end`.
    [[nodiscard, gnu::always_inline]] PackSlope<2> plane(const PackVec<2>& x, int end, int degree) const {
        PackSlope<2> sum{packed(0), {packed(0), packed(0)}};
        for (int left = 0; left <= degree; ++left) {
            Pack value = c[end - 1];
            Pack slope = packed(0);
            for (int a = left - 1; a >= 0; --a) {
                slope = slope * x[0] + value;
                value = value * x[0] + c[end - 1 - left + a];
            }
            sum.gradient[1] = sum.gradient[1] * x[1] + sum.value;
            sum.gradient[0] = sum.gradient[0] * x[1] + slope;
            sum.value = sum.value * x[1] + value;
            end -= left + 1;
        }
        return sum;
    }
};

}  // namespace camber

/// Maps of eight curved elements from the reference simplex.
namespace camber {

/// Eight Jacobians; the inverse is 0 if the determinant is almost 0.
template <int D>
struct PackJacobian {
    std::array<PackVec<D>, D> inverse;
    Pack det;

    [[gnu::always_inline]] explicit PackJacobian(const std::array<PackVec<D>, D>& columns) {
        if constexpr (D == 2) {
            det = columns[0][0] * columns[1][1] - columns[0][1] * columns[1][0];
            inverse = {PackVec<2>{columns[1][1], -columns[1][0]}, PackVec<2>{-columns[0][1], columns[0][0]}};
        } else {
            inverse = {cross(columns[1], columns[2]), cross(columns[2], columns[0]), cross(columns[0], columns[1])};
            det = columns[0][0] * inverse[0][0] + columns[0][1] * inverse[0][1] + columns[0][2] * inverse[0][2];
        }
        Pack most = packed(1);
        for (const auto& column : columns) {
            Pack square = column[0] * column[0];
            for (int i = 1; i < D; ++i) square += column[i] * column[i];
            most = most * sqrt(square);
        }
        const Mask is_flat = abs(det) <= flat * most;
        const Pack over = select(is_flat, packed(0), 1 / select(is_flat, packed(1), det));
        for (auto& row : inverse)
            for (Pack& x : row) x = x * over;
    }
    /// Returns J⁻¹ v; `in_space` returns J⁻ᵀ g.
    [[nodiscard, gnu::always_inline]] PackVec<D> pulled_back(const PackVec<D>& v) const {
        PackVec<D> out;
        for (int a = 0; a < D; ++a) {
            out[a] = inverse[a][0] * v[0];
            for (int i = 1; i < D; ++i) out[a] += inverse[a][i] * v[i];
        }
        return out;
    }
    [[nodiscard, gnu::always_inline]] PackVec<D> in_space(const PackVec<D>& g) const {
        PackVec<D> out;
        for (int i = 0; i < D; ++i) {
            out[i] = inverse[0][i] * g[0];
            for (int a = 1; a < D; ++a) out[i] += inverse[a][i] * g[a];
        }
        return out;
    }

  private:
    static constexpr double flat = 1e-13;  // limit of |det J| relative to the product of column lengths

    [[gnu::always_inline]] static PackVec<3> cross(const PackVec<3>& a, const PackVec<3>& b) {
        return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    }
};

/// Maps F(ξ) = Σ λ_v x_v + Σ 4 λ_i λ_j f of eight elements, with barycentric coordinates λ, vertices x_v, and offsets f
/// of the edges i–j. The Jacobian J is linear in ξ, and F(ξ + s) − F(ξ) = J(ξ + s/2) s.
template <int D>
class PackFrame {
  public:
    /// `axes[a]` is x_{a + 1} − x_0.
    [[gnu::always_inline]] PackFrame(const std::array<PackVec<D>, D>& axes,
                                     const std::array<PackVec<D>, edges_per_simplex<D>>& offsets)
        : first_(axes) {
        for (int e = 0; e < edges_per_simplex<D>; ++e) {
            const auto [i, j] = local_edges<D>[e];
            for (int k = 0; k < D; ++k) {
                const Pack f = 4 * offsets[e][k];
                if (i == 0 || j == 0) {  // λ_0 λ_v = (1 − Σ ξ) ξ_v
                    const int v = i + j - 1;
                    first_[v][k] += f;
                    for (int b = 0; b < D; ++b) {
                        second_[v][b][k] -= f;
                        second_[b][v][k] -= f;
                    }
                } else {
                    second_[i - 1][j - 1][k] += f;
                    second_[j - 1][i - 1][k] += f;
                }
            }
        }
    }

    [[nodiscard, gnu::always_inline]] PackJacobian<D> jacobian(const PackVec<D>& at) const {
        return PackJacobian<D>(columns(at));
    }

    /// Result of `displaced`. For δ = `delta`, Newton's method solves F(ξ + s) − F(ξ) = δ in each lane: `at` is ξ + s,
    /// and `jacobian` is J there. If δ leads to a fold or beyond, F is replaced by its tangent at ξ.
    struct Place {
        PackVec<D> at;
        PackJacobian<D> jacobian;
    };
    [[nodiscard, gnu::always_inline]] Place displaced(const PackVec<D>& from, const PackJacobian<D>& there,
                                                      const PackVec<D>& delta) const {
        const PackVec<D> tangent = there.pulled_back(delta);
        PackVec<D> s = tangent;
        Place place{from, there};
        Mask is_far;
        for (int step = 0;; ++step) {
            place.jacobian = jacobian(plus(from, s));
            const PackVec<D> correction = place.jacobian.pulled_back(residual(from, s, delta));
            place.at = plus(plus(from, s), correction);
            is_far = largest(correction) > near;
            if (step == newton_steps || !any(is_far)) break;
            for (int i = 0; i < D; ++i) s[i] = select(is_far, s[i] + correction[i], s[i]);
        }
        const Mask is_beyond = is_far | (place.jacobian.det * there.det < least_ratio * there.det * there.det);
        for (int i = 0; i < D; ++i) {
            place.at[i] = select(is_beyond, from[i] + tangent[i], place.at[i]);
            for (int k = 0; k < D; ++k)
                place.jacobian.inverse[i][k] = select(is_beyond, there.inverse[i][k], place.jacobian.inverse[i][k]);
        }
        return place;
    }

  private:
    static constexpr int newton_steps = 4;
    /// Limit of the last correction in reference coordinates; the remaining error is about its square.
    static constexpr double near = 1e-3;
    static constexpr double least_ratio = 0.1;

    [[gnu::always_inline]] static Pack largest(const PackVec<D>& v) {
        Pack most = abs(v[0]);
        for (int i = 1; i < D; ++i) most = max(most, abs(v[i]));
        return most;
    }

    [[gnu::always_inline]] static PackVec<D> plus(PackVec<D> a, const PackVec<D>& b) {
        for (int i = 0; i < D; ++i) a[i] += b[i];
        return a;
    }
    [[nodiscard, gnu::always_inline]] std::array<PackVec<D>, D> columns(const PackVec<D>& at) const {
        std::array<PackVec<D>, D> out = first_;
        for (int a = 0; a < D; ++a)
            for (int b = 0; b < D; ++b)
                for (int k = 0; k < D; ++k) out[a][k] += second_[a][b][k] * at[b];
        return out;
    }
    [[nodiscard, gnu::always_inline]] PackVec<D> residual(const PackVec<D>& from, const PackVec<D>& s,
                                                          PackVec<D> delta) const {
        PackVec<D> half;
        for (int i = 0; i < D; ++i) half[i] = from[i] + 0.5 * s[i];
        const auto chord = columns(half);
        for (int i = 0; i < D; ++i)
            for (int a = 0; a < D; ++a) delta[i] -= chord[a][i] * s[a];
        return delta;
    }

    std::array<PackVec<D>, D> first_;                    // columns of J at 0
    std::array<std::array<PackVec<D>, D>, D> second_{};  // ∂²F/∂ξ_a∂ξ_b
};

template <int D>
struct SimplexPoint {
    std::array<double, D + 1> at;
    double weight;
};

/// Quadrature rule of degree 6, exact for the squared interpolation error of cubic functions.
template <int D>
inline constexpr auto simplex_rule = [] {
    if constexpr (D == 2) {
        // 12 points: Dunavant, Int. J. Numer. Methods Eng. 21, 1985.
        std::array<SimplexPoint<2>, 12> rule{};
        int n = 0;
        for (const auto& [a, weight] :
             {std::array{0.063089014491502, 0.050844906370207}, std::array{0.249286745170910, 0.116786275726379}})
            for (int i = 0; i < 3; ++i) {
                rule[n] = {{a, a, a}, weight};
                rule[n++].at[i] = 1 - 2 * a;
            }
        constexpr double a = 0.053145049844817, b = 0.310352451033784, c = 1 - a - b;
        for (const auto& at : {std::array{a, b, c}, std::array{b, c, a}, std::array{c, a, b}, std::array{a, c, b},
                               std::array{c, b, a}, std::array{b, a, c}})
            rule[n++] = {at, 0.082851075618374};
        return rule;
    } else {
        // 24 points: Keast, Comput. Methods Appl. Mech. Eng. 55, 1986.
        std::array<SimplexPoint<3>, 24> rule{};
        int n = 0;
        for (const auto& [a, weight] : {std::array{0.214602871259152029, 0.039922750257869636},
                                        std::array{0.040673958534611353, 0.010077211055345823},
                                        std::array{0.322337890142275510, 0.055357181543927398}})
            for (int i = 0; i < 4; ++i) {
                rule[n] = {{a, a, a, a}, weight};
                rule[n++].at[i] = 1 - 3 * a;
            }
        constexpr double a = 0.063661001875017525, b = 0.269672331458315808, c = 1 - 2 * a - b;
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j) {
                if (i == j) continue;
                rule[n] = {{a, a, a, a}, 27.0 / 560};
                rule[n].at[i] = b;
                rule[n++].at[j] = c;
            }
        return rule;
    }
}();

}  // namespace camber

/// Interpolation error on eight curved elements, with derivatives.
namespace camber {

/// Eight elements: edge offsets in the mesh for which the solution was evaluated (`frame_offsets`), and current
/// offsets.
template <int D>
struct ElementPacks {
    std::array<PackVec<D>, D> axes;  ///< [a]: vertex a + 1 minus vertex 0
    std::array<PackVec<D>, edges_per_simplex<D>> frame_offsets, offsets;
};
template <int D>
using LatticePacks = std::array<Pack, lattice_size<D>>;

/// Squared errors Σ r² ≈ ∫ w² (u − u_h)² of eight elements, with residuals r at the points of a rule in the frame's
/// elements (w: weight of the field). A change d of the edge offsets changes r by R d, and the squared error becomes |r
/// + R d|² = error + 2 slope·d + d·curvature·d.
template <int D>
struct ErrorPacks {
    static constexpr int unknowns = D * edges_per_simplex<D>;
    static constexpr int entries = unknowns * (unknowns + 1) / 2;
    [[nodiscard]] static constexpr int entry(int i, int j) { return i >= j ? i * (i + 1) / 2 + j : entry(j, i); }

    Pack error{};
    std::array<Pack, unknowns> slope{};
    std::array<Pack, entries> curvature{};
};

template <int D>
void add_error(const ElementPacks<D>& elements, const LatticePacks<D>& field, double weight, Instructions set,
               ErrorPacks<D>& sum);

template <int D>
[[nodiscard]] Outcome<double> squared_error(const QuadraticMesh<D>& mesh, const KnownSolution<D>& solution,
                                            const Execution& execution);

template <int D>
class ErrorSystem {
  public:
    ErrorSystem(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds, const Incidence<ElementId>& shells,
                const KnownSolution<D>& solution, double stiffness);

    /// Sets the edge offsets from which the next steps start, relative to chord middles. The stiffness pulls them
    /// towards `reference_offsets`. Returns the squared error.
    [[nodiscard]] Outcome<double> begin(std::span<const Vec<D>> offsets, std::span<const Vec<D>> reference_offsets,
                                        const Execution& execution);
    [[nodiscard]] std::span<const double> errors() const { return errors_; }
    /// Returns approximate least-squares changes of the offsets, by conjugate gradients.
    [[nodiscard]] Outcome<Buffer<Vec<D>>> solved(int iterations, const Execution& execution);

  private:
    using Errors = ErrorPacks<D>;

    [[nodiscard]] std::size_t packs() const { return (elements_ + pack_size - 1) / pack_size; }
    [[nodiscard]] std::size_t element_of(std::size_t pack, int lane) const;
    [[nodiscard]] ElementPacks<D> elements_of(std::size_t pack, std::span<const Vec<D>> offsets) const;
    void add_fields(std::size_t pack, const ElementPacks<D>& elements, Errors& sum) const;
    void begin_pack(std::size_t pack, std::span<const Vec<D>> offsets);
    void stiffen(std::size_t pack, std::span<const Vec<D>> offsets, std::span<const Vec<D>> reference_offsets,
                 double least);
    void multiply(std::size_t pack, std::span<const Vec<D>> x);
    [[nodiscard]] Vec<D> gathered(std::size_t edge, std::span<const double> parts) const;
    [[nodiscard]] Sym<D> preconditioner(std::size_t edge) const;
    [[nodiscard]] bool is_free(std::size_t edge) const;

    const QuadraticMesh<D>& mesh_;
    const Column<EdgeKind>& kinds_;
    const Incidence<ElementId>& shells_;
    const KnownSolution<D>& solution_;
    double stiffness_;
    std::size_t elements_;
    Buffer<float> curvature_;         // layout [pack][entry][lane]
    Buffer<double> slope_, product_;  // layout [pack][unknown][lane]
    Buffer<double> errors_;           // one per element
};

}  // namespace camber
