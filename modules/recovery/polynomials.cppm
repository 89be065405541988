module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>
module camber.recovery:polynomials;
import camber.core;
import camber.bezier;
import :derivatives;

namespace camber {

/// Number of monomials of degree at most `p` in D variables.
template <int D>
[[nodiscard]] constexpr int monomials_up_to(int p) {
    return D == 2 ? (p + 1) * (p + 2) / 2 : (p + 1) * (p + 2) * (p + 3) / 6;
}

/// A monomial with `exponents`: the product of the variable `axis` and the monomial `parent`, whose degree is lower by
/// 1.
template <int D>
struct Monomial {
    std::array<int, D> exponents{};
    int degree = 0;
    int parent = 0;
    int axis = 0;
};

/// Index of a monomial. Monomials are ordered by degree, then by the exponent of the last variable, then of the one
/// before. Within a degree, this is the order of components of Vec, Sym and CubicForm.
template <int D>
[[nodiscard]] constexpr int place_of(const std::array<int, D>& exponents) {
    int degree = 0;
    for (const int a : exponents) degree += a;
    int place = degree > 0 ? monomials_up_to<D>(degree - 1) : 0;
    if constexpr (D == 2) return place + exponents[1];
    if constexpr (D == 3) {
        for (int c = 0; c < exponents[2]; ++c) place += degree - c + 1;
        return place + exponents[1];
    }
}

template <int D, int P>
inline constexpr auto monomials = [] {
    std::array<Monomial<D>, monomials_up_to<D>(P)> all{};
    const auto put = [&](const std::array<int, D>& exponents, int degree) {
        Monomial<D>& m = all[place_of<D>(exponents)];
        m.exponents = exponents;
        m.degree = degree;
        if (degree == 0) return;
        std::array<int, D> less = exponents;
        while (less[m.axis] == 0) ++m.axis;
        --less[m.axis];
        m.parent = place_of<D>(less);
    };
    for (int degree = 0; degree <= P; ++degree)
        for (int last = 0; last <= degree; ++last) {
            if constexpr (D == 2) put({degree - last, last}, degree);
            if constexpr (D == 3)
                for (int middle = 0; middle <= degree - last; ++middle)
                    put({degree - last - middle, middle, last}, degree);
        }
    return all;
}();

/// `products[a][b]`: index of the product of monomials a and b. The product has at most degree 2 P.
template <int D, int P>
inline constexpr auto products = [] {
    constexpr std::size_t n = monomials_up_to<D>(P);
    std::array<std::array<std::uint16_t, n>, n> places{};
    for (std::size_t a = 0; a < n; ++a)
        for (std::size_t b = 0; b < n; ++b) {
            std::array<int, D> sum{};
            for (int i = 0; i < D; ++i) sum[i] = monomials<D, P>[a].exponents[i] + monomials<D, P>[b].exponents[i];
            places[a][b] = static_cast<std::uint16_t>(place_of<D>(sum));
        }
    return places;
}();

/// Returns the covariance Σ y yᵀ / n of y = B x for the n points x.
template <int D>
[[nodiscard]] inline Sym<D> covariance(const Mat<D>& b, std::span<const Vec<D>> points) {
    Sym<D> sum;
    for (const Vec<D>& x : points) {
        const Vec<D> y = b * x;
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j) sum(i, j) += y[i] * y[j];
    }
    return sum * (1 / static_cast<double>(points.size()));
}

/// Replaces B by L⁻¹ B, where C = L Lᵀ is a Cholesky factorisation. A pivot below the cancellation error of C is
/// replaced by that error.
template <int D>
inline void divide_by_factor(const Sym<D>& c, Mat<D>& b) {
    std::array<std::array<double, D>, D> l{};
    for (int i = 0; i < D; ++i) {
        for (int j = 0; j <= i; ++j) {
            double rest = c(i, j);
            for (int k = 0; k < j; ++k) rest -= l[i][k] * l[j][k];
            if (j < i)
                l[i][j] = l[j][j] > 0 ? rest / l[j][j] : 0;
            else
                l[i][i] = std::sqrt(std::max(rest, 16 * std::numeric_limits<double>::epsilon() * c(i, i)));
        }
        for (int column = 0; column < D; ++column) {
            double rest = b(i, column);
            for (int k = 0; k < i; ++k) rest -= l[i][k] * b(k, column);
            b(i, column) = l[i][i] > 0 ? rest / l[i][i] : 0;
        }
    }
}

/// Returns B so that the points y = B x have covariance 1 about the origin, scaled to max |y| = 1. With an anisotropy
/// of 1e8, rounding in the covariance of x hides the thin direction. So whitening is repeated with the covariance of y
/// until that is 1. B is 0 in directions in which the points extend no farther than the rounding error `noise` of
/// coordinates.
template <int D>
[[nodiscard]] inline Mat<D> whitening(std::span<const Vec<D>> points, double noise) {
    double largest = 0;
    for (const Vec<D>& x : points)
        for (const double c : x.c) largest = std::max(largest, std::abs(c));
    Mat<D> b;
    if (!(largest > 0)) return b;
    for (int i = 0; i < D; ++i) b(i, i) = 1 / largest;
    constexpr int passes = 5;  // each pass reduces the anisotropy by a factor of 1e7
    for (int pass = 0; pass < passes; ++pass) {
        const Sym<D> c = covariance(b, points);
        divide_by_factor(c, b);
        for (int i = 0; i < D; ++i) {
            double gain = 0;
            for (int j = 0; j < D; ++j) gain += std::abs(b(i, j));
            if (gain * noise > 0.1)
                for (int j = 0; j < D; ++j) b(i, j) = 0;
        }
        if (norm(c - Sym<D>::identity()) < 0.1) break;
    }
    double farthest = 0;
    for (const Vec<D>& x : points) farthest = std::max(farthest, norm_squared(b * x));
    if (farthest > 0)
        for (Vec<D>& column : b.column) column *= 1 / std::sqrt(farthest);
    return b;
}

/// Nodes of a field: vertices and, in degree 2, edges.
template <int D>
struct NodalMesh {
    const QuadraticMesh<D>& mesh;
    const Incidence<ElementId>& balls;
    int degree = 1;

    [[nodiscard]] Vec<D> place(std::uint32_t node) const {
        const std::size_t vertices = mesh.linear.points.size();
        return node < vertices ? mesh.linear.points[node] : mesh.mid_nodes[node - vertices].point;
    }
};

struct NodeTag;

/// Rings of nodes around a vertex or element. Includes only elements of one material.
template <int D>
class Rings {
  public:
    explicit Rings(const NodalMesh<D>& nodal) : nodal_(nodal) {}

    void begin(VertexId v, Reference material);
    void begin(ElementId e);
    /// Adds a ring: the nodes of elements at the last ring's vertices. Returns false if there are no new nodes.
    bool grow();

    [[nodiscard]] int count() const { return count_; }
    [[nodiscard]] std::span<const std::uint32_t> nodes() const { return nodes_; }
    [[nodiscard]] std::span<const VertexId> last_vertices() const { return last_; }

  private:
    void begin(std::span<const VertexId> vertices, Reference material);

    NodalMesh<D> nodal_;
    Reference material_ = 0;
    int count_ = 0;
    ScratchSet<Id<NodeTag>> visited_nodes_{256};
    ScratchSet<ElementId> visited_elements_{256};
    std::vector<std::uint32_t> nodes_;
    std::vector<VertexId> last_, next_;
};

template <int D, int P>
using Coefficients = std::array<double, monomials_up_to<D>(P)>;

/// Least-squares fit of a polynomial p to values u at nodes: minimises Σ w² (p(y) − u)². y = B (x − vertex): whitened
/// coordinates; w = 1/(core + |y|). The normal matrix of the monomials y^α and y^β is filled from the moments Σ w²
/// y^{α+β}, of which there are only a quarter as many as entries. It is factorised once for all fields. Monomials are
/// ordered by degree, so the leading blocks of the factor are the factors for lower degrees.
template <int D, int P>
class Fit {
  public:
    static constexpr std::size_t size = monomials_up_to<D>(P);
    static constexpr double negligible_length = 1e-30;

    /// Sets the nodes. `offsets`: x − vertex of each node, the vertex first; `noise`: rounding error of the
    /// coordinates.
    void place(std::span<const Vec<D>> offsets, double noise, double core);

    [[nodiscard]] const Mat<D>& whitened_by() const { return whitened_by_; }
    [[nodiscard]] std::size_t nodes() const { return nodes_; }
    /// Share of a monomial's squared norm that is independent of earlier monomials; minimum over all monomials up to
    /// this degree. 0 if the nodes cannot distinguish the monomials.
    [[nodiscard]] double independence(int degree) const { return independence_[static_cast<std::size_t>(degree)]; }

    /// Returns the polynomial of this degree that fits one value per node. Coefficients of higher degree are 0. One
    /// step of iterative refinement restores digits that the normal equations lose.
    [[nodiscard]] Coefficients<D, P> solve(std::span<const double> values, int degree);

  private:
    using Lanes = std::array<double, pack_size>;
    struct Block {
        std::array<Lanes, D> y{};
        Lanes squared_weight{};  ///< 0 in lanes without a node
    };

    void sum_moments();
    void factorise();
    void correct(Coefficients<D, P>& c, std::size_t unknowns) const;

    Mat<D> whitened_by_;
    std::size_t nodes_ = 0;
    std::vector<Block> blocks_;
    std::vector<Lanes> values_;
    std::array<double, monomials_up_to<D>(2 * P)> moments_{};
    std::array<double, size> scale_{};  ///< scale of each monomial, so that the normal matrix has the diagonal 1
    std::array<std::array<double, size>, size> factor_{};  ///< upper triangle: Cholesky factor of the scaled normal
                                                           ///< matrix, with the inverse diagonal
    std::array<double, P + 1> independence_{};
};

/// Unit of scaled values: the maximum of |u − u(vertex)|. Values are scaled because fourth powers of 1e200 would
/// overflow.
struct Unit {
    double half = 0;  ///< half of the unit, because the unit itself may overflow
    [[nodiscard]] double times(double x) const { return x * half * 2; }
};
/// Subtracts the first value (that of the vertex) from all values and scales them to [−1, 1].
[[nodiscard]] inline Unit scale(std::span<double> values) {
    const double first = values[0] / 2;
    Unit unit;
    for (double& u : values) {
        u = u / 2 - first;
        unit.half = std::max(unit.half, std::abs(u));
    }
    if (unit.half > 0)
        for (double& u : values) u /= unit.half;
    return unit;
}

template <int D>
struct Derivatives {
    Vec<D> gradient;
    Sym<D> hessian;
    CubicForm<D> third;
};

/// Returns the derivative ∂^α p(y) = Σ_{β ≥ α} c_β β!/(β − α)! y^{β − α} of the polynomial with coefficients c.
template <int D, int P>
[[nodiscard]] double derivative(const Coefficients<D, P>& c, const std::array<int, D>& alpha, const Vec<D>& y) {
    double sum = 0;
    for (std::size_t b = 0; b < c.size(); ++b) {
        const auto& beta = monomials<D, P>[b].exponents;
        double term = c[b];
        for (int i = 0; i < D; ++i) {
            for (int k = 0; k < alpha[i]; ++k) term *= beta[i] - k;  // the product is 0 if β_i < α_i
            for (int k = alpha[i]; k < beta[i]; ++k) term *= y[i];
        }
        sum += term;
    }
    return sum;
}

template <int D, int P>
[[nodiscard]] Derivatives<D> derivatives_at(const Coefficients<D, P>& c, const Vec<D>& y) {
    Derivatives<D> at;
    const auto& all = monomials<D, P>;
    constexpr int first = monomials_up_to<D>(0), second = monomials_up_to<D>(1), third = monomials_up_to<D>(2);
    for (int i = 0; i < D; ++i) at.gradient.c[i] = derivative<D, P>(c, all[first + i].exponents, y);
    for (int i = 0; i < sym_size<D>; ++i) at.hessian.c[i] = derivative<D, P>(c, all[second + i].exponents, y);
    for (int i = 0; i < cubic_size<D>; ++i) at.third.c[i] = derivative<D, P>(c, all[third + i].exponents, y);
    return at;
}

/// Returns the derivatives α! c_α of Σ_α c_α y^α at y = 0.
template <int D, int P>
[[nodiscard]] Derivatives<D> derivatives_at_origin(const Coefficients<D, P>& c) {
    constexpr std::array factorials{1.0, 1.0, 2.0, 6.0};
    const auto of = [&](int place) {
        double value = c[static_cast<std::size_t>(place)];
        for (const int a : monomials<D, P>[static_cast<std::size_t>(place)].exponents) value *= factorials[a];
        return value;
    };
    Derivatives<D> at;
    for (int i = 0; i < D; ++i) at.gradient.c[i] = of(monomials_up_to<D>(0) + i);
    for (int i = 0; i < sym_size<D>; ++i) at.hessian.c[i] = of(monomials_up_to<D>(1) + i);
    for (int i = 0; i < cubic_size<D>; ++i) at.third.c[i] = of(monomials_up_to<D>(2) + i);
    return at;
}

/// Converts derivatives g, H, T by y = B x to derivatives by x: Bᵀ g, Bᵀ H B, T[B·, B·, B·].
template <int D>
[[nodiscard]] Derivatives<D> pulled_back(const Derivatives<D>& by_y, const Mat<D>& b) {
    return {transposed_times(b, by_y.gradient), congruence(transposed(b), by_y.hessian), pulled_back(by_y.third, b)};
}

template <int D>
using EdgeOffsets = std::array<Vec<D>, edges_per_simplex<D>>;
template <int D>
using Lattice = std::array<Vec<D>, node_count<lattice_degree, D>>;

template <int D>
[[nodiscard]] EdgeOffsets<D> edge_offsets(const QuadraticMesh<D>& mesh, ElementId e) {
    EdgeOffsets<D> offsets{};
    if (mesh.mid_nodes.empty()) return offsets;
    for (std::size_t k = 0; k < offsets.size(); ++k) offsets[k] = edge_of(mesh, mesh.edges.of_elements[e][k]).offset();
    return offsets;
}

/// Returns the position Σ λ_v x_v + Σ 4 λ_i λ_j d_ij in an element with vertices x_v. `at`: barycentric coordinates λ;
/// `offsets`: d_ij of edges i–j.
template <int D>
[[nodiscard]] Vec<D> position_within(const LinearMesh<D>& mesh, ElementId e, const EdgeOffsets<D>& offsets,
                                     const std::array<double, D + 1>& at) {
    Vec<D> x;
    for (std::size_t v = 0; v <= D; ++v) x += at[v] * mesh.points[mesh.elements.vertices[e][v]];
    for (int k = 0; k < edges_per_simplex<D>; ++k) x += edge_shape<D>(at, k) * offsets[k];
    return x;
}

template <int D>
[[nodiscard]] Lattice<D> lattice_of(const LinearMesh<D>& mesh, ElementId e, const EdgeOffsets<D>& offsets) {
    constexpr auto& all = multi_indices<lattice_degree, D>;
    Lattice<D> places{};
    for (std::size_t q = 0; q < places.size(); ++q) {
        std::array<double, D + 1> at{};
        for (std::size_t v = 0; v <= D; ++v) at[v] = all[q][v] * (1.0 / lattice_degree);
        places[q] = position_within(mesh, e, offsets, at);
    }
    return places;
}

template <int D, int P>
[[nodiscard]] std::array<double, node_count<lattice_degree, D>> values_at(const Coefficients<D, P>& c,
                                                                          const Lattice<D>& places) {
    std::array<double, node_count<lattice_degree, D>> values{};
    for (std::size_t q = 0; q < values.size(); ++q) {
        std::array<double, monomials_up_to<D>(P)> m{1.0};
        values[q] = c[0];
        for (std::size_t i = 1; i < m.size(); ++i) {
            m[i] = m[monomials<D, P>[i].parent] * places[q][monomials<D, P>[i].axis];
            values[q] += c[i] * m[i];
        }
    }
    return values;
}

template <int D>
struct CheckedNodes {
    int degree = 1;  ///< degree of the fields, from the numbers of values
    Incidence<ElementId> balls;

    [[nodiscard]] NodalMesh<D> of(const QuadraticMesh<D>& mesh) const { return {mesh, balls, degree}; }
};

/// Checks the input of fits. Errors, with the node if it is known: usage (numbers of values that differ or do not match
/// the mesh; a value that is not finite), input (missing data for degree 2; not one reference per element; a node
/// without finite coordinates).
template <int D>
[[nodiscard]] Outcome<CheckedNodes<D>> checked_nodes(const QuadraticMesh<D>& mesh,
                                                     std::span<const Column<double>> fields,
                                                     const Execution& execution);

/// Errors: usage (derivatives out of range at the named vertex).
template <int D>
[[nodiscard]] Outcome<Done> check_results(const RecoveredDerivatives<D>& recovered, const Execution& execution);

}  // namespace camber
