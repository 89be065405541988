module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <tuple>
#include <utility>
export module camber.solution_metric:models;
import camber.core;
import camber.bezier;
import camber.metric;

namespace camber {

template <int D>
[[nodiscard]] constexpr std::array<double, sym_size<D>> quadratic_row(const Vec<D>& y) {
    std::array<double, sym_size<D>> row{};
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j) row[Sym<D>::index(i, j)] = (i == j ? 1 : 2) * y[i] * y[j];
    return row;
}

template <int D>
[[nodiscard]] constexpr std::array<double, cubic_size<D>> cubic_row(const Vec<D>& y) {
    std::array<double, cubic_size<D>> row{};
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j)
            for (int k = 0; k < D; ++k) row[CubicForm<D>::index(i, j, k)] += y[i] * y[j] * y[k];
    return row;
}

/// Evenly spread unit directions, one of each pair y and −y. The first n(n+1)/2 (n: dimension) form the initial basis
/// of the linear program (2D: at angles of 60 degrees; 3D: axes of an icosahedron). Their matrices yyᵀ are independent
/// and sum to a multiple of the identity.
template <int D>
struct Directions {
    static constexpr int packs = D == 2 ? 6 : 16;
    static constexpr int count = packs * pack_size;

    std::array<Vec<D>, count> unit;
    std::array<std::array<Pack, sym_size<D>>, packs> quadratic{};
    std::array<std::array<Pack, cubic_size<D>>, packs> cubic{};

    Directions() : unit(evenly()) {
        for (std::size_t i = 0; i < count; ++i) {
            const auto q = quadratic_row(unit[i]);
            const auto c = cubic_row(unit[i]);
            for (std::size_t k = 0; k < q.size(); ++k) quadratic[i / pack_size][k][i % pack_size] = q[k];
            for (std::size_t k = 0; k < c.size(); ++k) cubic[i / pack_size][k][i % pack_size] = c[k];
        }
    }

  private:
    [[nodiscard]] static std::array<Vec<D>, count> evenly() {
        std::array<Vec<D>, count> out;
        if constexpr (D == 2) {
            static_assert(count % 3 == 0);
            int next = 3;
            for (int i = 0; i < count; ++i) {
                const double angle = std::numbers::pi * i / count;
                const bool is_first = i % (count / 3) == 0;
                out[is_first ? i / (count / 3) : next++] = {{cos(angle), sin(angle)}};
            }
        } else {
            const double golden = std::numbers::phi, length = std::sqrt(1 + golden * golden);
            for (int i = 0; i < 3; ++i)
                for (int sign = 0; sign < 2; ++sign) {
                    Vec<3>& y = out[2 * i + sign];
                    y[i] = 1 / length;
                    y[(i + 1) % 3] = (sign == 0 ? golden : -golden) / length;
                }
            // Fibonacci spiral on a hemisphere.
            constexpr int spiral = count - 6;
            for (int i = 0; i < spiral; ++i) {
                const double z = 1 - (i + 0.5) / spiral, r = std::sqrt(1 - z * z);
                const double angle = 2 * std::numbers::pi * (i + 0.5) * golden;
                out[6 + i] = {{r * cos(angle), r * sin(angle), z}};
            }
        }
        return out;
    }
};

/// Linear program: min cᵀx subject to a_i·x ≥ b_i, with P packs of rows and U ≤ 6 unknowns. The simplex method solves
/// the dual program max Σ b_i μ_i subject to Σ μ_i a_i = c and μ ≥ 0. If only b changes, the last basis remains
/// feasible. Unused rows have b = no_row.
template <int U, int P>
class SmallLinearProgram {
  public:
    using Basis = std::array<int, U>;
    using Unknowns = std::array<double, U>;
    static constexpr double no_row = -1e30;

    std::array<std::array<Pack, U>, P> rows{};
    std::array<Pack, P> least{};
    Unknowns cost{};
    Basis basis{};  ///< must be feasible: Σ μ_i a_i = c with μ ≥ 0

    void set_row(int i, const Unknowns& row) {
        for (int k = 0; k < U; ++k) rows[at(i).first][k][at(i).second] = row[k];
    }
    void set_least(int i, double bound) { least[at(i).first][at(i).second] = bound; }
    [[nodiscard]] double least_of(int i) const { return least[at(i).first][at(i).second]; }

    [[nodiscard]] Unknowns solve() {
        constexpr int most_pivots = 120;
        constexpr double tolerance = 1e-9;
        invert();
        for (int pivot = 0; pivot < most_pivots; ++pivot) {
            const Unknowns x = unknowns();
            const Missing m = most_violated(x);
            if (!(m.amount > tolerance) || !enter(m.row)) return x;
        }
        return unknowns();
    }

  private:
    static constexpr std::pair<std::size_t, std::size_t> at(int i) {
        return {static_cast<std::size_t>(i) / pack_size, static_cast<std::size_t>(i) % pack_size};
    }
    [[nodiscard]] Unknowns row(int i) const {
        Unknowns out;
        for (int k = 0; k < U; ++k) out[k] = rows[at(i).first][k][at(i).second];
        return out;
    }
    [[nodiscard]] Unknowns unknowns() const {
        Unknowns x{};
        for (int j = 0; j < U; ++j)
            for (int k = 0; k < U; ++k) x[k] += inverse_[j][k] * least_of(basis[j]);
        return x;
    }
    struct Missing {
        int row = 0;
        double amount = 0;
    };
    [[nodiscard]] Missing most_violated(const Unknowns& x) const {
        Pack most = packed(-std::numeric_limits<double>::max());
        Mask where{};
        with_instructions(widest_instructions(), [&]() __attribute__((always_inline)) {
            for (int p = 0; p < P; ++p) {
                Pack lacks = least[p];
                for (int k = 0; k < U; ++k) lacks -= rows[p][k] * x[k];
                const Mask more = lacks > most;
                most = select(more, lacks, most);
                where = more ? Mask(p) : where;
            }
        });
        int best = 0;
        for (int lane = 1; lane < pack_size; ++lane)
            if (most[lane] > most[best]) best = lane;
        return {static_cast<int>(where[best]) * pack_size + best, most[best]};
    }
    /// Exchanges the row `entering` with the basis row whose μ_i first falls to 0. Returns false if there is none.
    [[nodiscard]] bool enter(int entering) {
        const Unknowns a = row(entering);
        Unknowns along{}, weight{};
        for (int j = 0; j < U; ++j)
            for (int k = 0; k < U; ++k) {
                along[j] += inverse_[j][k] * a[k];
                weight[j] += inverse_[j][k] * cost[k];
            }
        int leaving = -1;
        double first = std::numeric_limits<double>::max();
        for (int j = 0; j < U; ++j)
            if (along[j] > 1e-9 && std::max(weight[j], 0.0) / along[j] < first) {
                first = std::max(weight[j], 0.0) / along[j];
                leaving = j;
            }
        if (leaving < 0) return false;
        for (double& x : inverse_[leaving]) x /= along[leaving];
        for (int j = 0; j < U; ++j)
            if (j != leaving)
                for (int k = 0; k < U; ++k) inverse_[j][k] -= along[j] * inverse_[leaving][k];
        basis[leaving] = entering;
        return true;
    }
    void invert() {
        SquareMatrix<U> m;
        for (int j = 0; j < U; ++j) {
            const Unknowns a = row(basis[j]);
            for (int k = 0; k < U; ++k) m[k][j] = a[k];
        }
        inverse_ = inverted(m).matrix;
    }

    std::array<Unknowns, U> inverse_{};
};

}  // namespace camber

export namespace camber {

enum class CubicBound : std::uint8_t {
    optimal,   ///< determinant within 1 % of the minimum
    diagonal,  ///< computed from the entries of the third derivatives T in the eigenvectors of T:T; 4 times faster,
               ///< determinant mostly 1 to 1.5 times the minimum
};
[[nodiscard]] constexpr auto words(CubicBound) {
    return words_of(Word{CubicBound::optimal, "optimal"}, Word{CubicBound::diagonal, "diagonal"});
}

struct ModelOptions {
    CubicBound bound = CubicBound::optimal;
    /// Maximum anisotropy of a model Q. Along some axes derivatives may vanish or be rounding errors. Smaller
    /// eigenvalues of Q are therefore raised to the largest one divided by the square of this limit. Rounding of third
    /// derivatives gives an anisotropy of 2e5 with meaningless axes.
    double max_anisotropy = 1e5;

    [[nodiscard]] static constexpr auto options() {
        using S = ModelOptions;
        return std::tuple(
            option("cubic_bound", &S::bound,
                   "metric that bounds the third derivatives. optimal: of nearly the "
                   "smallest determinant; diagonal: four times faster, with a determinant "
                   "mostly up to 1.5 times as large"),
            option("max_anisotropy", &S::max_anisotropy, "largest ratio of the sizes that derivatives alone determine")
                .at_least(1)
                .at_most(1e12));
    }
    friend bool operator==(const ModelOptions&, const ModelOptions&) = default;
};

enum class ModelKind : std::uint8_t {
    regular,
    floored,  ///< some eigenvalues were raised
    zero,     ///< all derivatives are 0, so any size is sufficient
};

/// Local error model Q for elements of degree k: |d^{k+1}u(v)|^{2/(k+1)} ≤ vᵀQv for all vectors v, with the derivatives
/// d^{k+1}u of order k + 1 of the solution u, in any unit. It is stored as log-eigenvalues λ_i and axes R: Q = R
/// diag(e^{λ_i}) Rᵀ. Zero model: λ_i = −∞, R = I.
template <int D>
struct LocalModel {
    EigenSystem<D> logs;
    ModelKind kind = ModelKind::regular;
};

template <int D>
[[nodiscard]] inline LocalModel<D> zero_model() {
    LocalModel<D> out{{{}, Mat<D>::identity()}, ModelKind::zero};
    for (double& x : out.logs.values.c) x = -std::numeric_limits<double>::infinity();
    return out;
}

template <int D>
[[nodiscard]] inline LocalModel<D> floored(LocalModel<D> model, double max_anisotropy) {
    auto& values = model.logs.values.c;
    constexpr double near = 0.1;  // log-eigenvalues less than this above the bound count as raised, since `CubicModels`
                                  // may have raised them before
    const double least = *std::max_element(values.begin(), values.end()) - 2 * log(max_anisotropy);
    for (double& x : values)
        if (!(x >= least + near)) {
            x = std::fmax(x, least);
            model.kind = ModelKind::floored;
        }
    return model;
}

/// Returns the model of degree k = 1: Q = |H|, the Hessian with absolute eigenvalues.
template <int D>
[[nodiscard]] inline LocalModel<D> hessian_model(Sym<D> hessian, const ModelOptions& options) {
    double scale = 0;
    for (const double x : hessian.c) scale = std::max(scale, std::abs(x));
    if (scale == 0) return zero_model<D>();
    for (double& x : hessian.c) x /= scale;
    LocalModel<D> model{eigen_system(hessian)};
    for (double& x : model.logs.values.c) x = log(std::abs(x)) + log(scale);
    return floored(model, options.max_anisotropy);
}

/// Computes models of degree k = 2: the Q of minimum determinant with |T[v,v,v]|^{2/3} ≤ vᵀQv for all v and the third
/// derivatives T. The log-simplex method (Coulaud and Loseille, "Very high order anisotropic metric-based mesh
/// adaptation in 3D", Procedia Engineering 163, 2016) solves a sequence of linear programs for symmetric matrices L
/// (docs/algorithms/metric-from-solution.md). In coordinates y = Q^{1/2} v of the current Q,
///
///     min tr L, yᵀLy ≥ ⅔ log|T(y)| for directions |y| = 1; Q ← Q^{1/2} e^L Q^{1/2}
///
/// until L vanishes. `CubicBound::diagonal` returns the start of this sequence.
///
/// Use one object for many models, since it holds tables. T may have any scale.
template <int D>
class CubicModels {
  public:
    explicit CubicModels(const ModelOptions& options);
    /// T must be finite.
    [[nodiscard]] LocalModel<D> operator()(const CubicForm<D>& t) const;

  private:
    ModelOptions options_;
    std::shared_ptr<const Directions<D>> directions_;
};

template <int D>
struct LocalModels {
    Column<LocalModel<D>> rows;
    std::size_t zero = 0, floored = 0;  ///< number of zero and of floored models
};

/// Computes models of degree 1 from Hessians, or of degree 2 from third derivatives. Errors: a row that is not finite
/// (input, entity "derivatives, row N"); options out of range (usage); memory; stopped.
template <int D>
[[nodiscard]] Outcome<LocalModels<D>> hessian_models(const Column<Sym<D>>& hessians, const ModelOptions& options,
                                                     const Execution& execution);
template <int D>
[[nodiscard]] Outcome<LocalModels<D>> cubic_models(const Column<CubicForm<D>>& thirds, const ModelOptions& options,
                                                   const Execution& execution);

/// Returns the mean of the rows (vectors, Hessians, third derivatives) at the vertices of each element: their linear
/// interpolation at the centroid. `row_of(e, i)` is the row of element e at local vertex i. Errors: memory; stopped.
template <class Row, int D, class RowOf>
[[nodiscard]] Outcome<Column<Row>> element_means(const LinearMesh<D>& mesh, const Column<Row>& rows, RowOf&& row_of,
                                                 const Execution& execution) {
    auto means = map_each(execution, mesh.elements.size(), [&](std::size_t e) {
        Row sum{};
        for (int i = 0; i <= D; ++i) sum += rows[row_of(ElementId(e), i)];
        sum *= 1.0 / (D + 1);
        return sum;
    });
    if (!means) return fail(means.error());
    return Column<Row>(std::move(*means));
}

template <class Row, int D>
[[nodiscard]] Outcome<Column<Row>> element_means(const LinearMesh<D>& mesh, const Column<Row>& at_vertices,
                                                 const Execution& execution) {
    if (at_vertices.size() != mesh.points.size())
        return fail(ErrorKind::usage, "the derivatives belong to another mesh; there must be one row per vertex");
    const auto row_of = [&](ElementId e, int i) { return mesh.elements.vertices[e][i].index(); };
    return element_means(mesh, at_vertices, row_of, execution);
}

/// Computes models of curved elements from derivatives at centroids (`element_means`). They include the effect of the
/// elements' curvature on the error, with the Jacobian J at the centroid (docs/algorithms/metric-from-solution.md). On
/// straight elements they equal `hessian_models` and `cubic_models`. Elements with det J = 0 have the zero model.
/// Errors: those of `cubic_models`, with elements as rows; not one row per element (usage).
template <int D>
[[nodiscard]] Outcome<LocalModels<D>> curved_hessian_models(const QuadraticMesh<D>& mesh,
                                                            const Column<Vec<D>>& gradients,
                                                            const Column<Sym<D>>& hessians, const ModelOptions& options,
                                                            const Execution& execution);
template <int D>
[[nodiscard]] Outcome<LocalModels<D>> curved_cubic_models(const QuadraticMesh<D>& mesh, const Column<Sym<D>>& hessians,
                                                          const Column<CubicForm<D>>& thirds,
                                                          const ModelOptions& options, const Execution& execution);

}  // namespace camber
