module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
module camber.solution_metric:small_programme;
import camber.core;

namespace camber {

/// min cᵀx with a_i·x ≥ b_i for P packs of rows and U ≤ 6 unknowns, by the simplex method on the dual, max Σ b_i μ_i
/// with Σ μ_i a_i = c, μ ≥ 0. Rows stay and only b changes from one programme to the next, so the basis of one is a
/// feasible one of the next: some pivots, each a product of a few packs. A row that is not there has b = no_row.
template <int U, int P>
class SmallProgramme {
  public:
    using Basis = std::array<int, U>;  ///< rows whose μ may be positive
    using Unknowns = std::array<double, U>;
    static constexpr double no_row = -1e30;

    std::array<std::array<Pack, U>, P> rows{};
    std::array<Pack, P> least{};
    Unknowns cost{};
    Basis basis{};  ///< feasible: Σ μ_i a_i = c with μ ≥ 0 over its rows

    void set_row(int i, const Unknowns& row) {
        for (int k = 0; k < U; ++k) rows[at(i).first][k][at(i).second] = row[k];
    }
    void set_least(int i, double bound) { least[at(i).first][at(i).second] = bound; }
    [[nodiscard]] double least_of(int i) const { return least[at(i).first][at(i).second]; }

    /// Leaves the best basis in `basis`.
    [[nodiscard]] Unknowns solve() {
        constexpr int most_pivots = 120;
        constexpr double tolerance = 1e-9;
        invert();
        for (int pivot = 0; pivot < most_pivots; ++pivot) {
            const Unknowns x = unknowns();
            const Missing m = most_missing(x);
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
    /// x with a_i·x = b_i on the basis.
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
    /// The row of which most is missing, and how much.
    [[nodiscard]] Missing most_missing(const Unknowns& x) const {
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
    /// Takes a row into the basis, and out of it the one whose μ is the first to vanish. False: none does.
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
    /// Gauss and Jordan, with the largest pivot of the column: the matrix whose columns are the basis' rows.
    void invert() {
        std::array<std::array<double, 2 * U>, U> m{};
        for (int j = 0; j < U; ++j) {
            const Unknowns a = row(basis[j]);
            for (int k = 0; k < U; ++k) m[k][j] = a[k];
            m[j][U + j] = 1;
        }
        for (int c = 0; c < U; ++c) {
            int pivot = c;
            for (int r = c + 1; r < U; ++r)
                if (std::abs(m[r][c]) > std::abs(m[pivot][c])) pivot = r;
            std::swap(m[c], m[pivot]);
            const double factor = 1 / m[c][c];
            for (double& x : m[c]) x *= factor;
            for (int r = 0; r < U; ++r) {
                const double share = m[r][c];
                if (r == c || share == 0) continue;
                for (int k = c; k < 2 * U; ++k) m[r][k] -= share * m[c][k];
            }
        }
        for (int j = 0; j < U; ++j)
            for (int k = 0; k < U; ++k) inverse_[j][k] = m[j][U + k];
    }

    std::array<Unknowns, U> inverse_{};
};

}  // namespace camber
