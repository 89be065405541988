module;
#include <array>
#include <cstddef>
#include <limits>
#include <vector>
export module camber.optimisation:joint_programme;
import camber.core;
import camber.bezier;
import camber.validity;

export namespace camber {

/// One unknown point's part of the objective: ½ (x − centre)ᵀ H (x − centre), x its offset from where it is.
template <int D>
struct OffsetModel {
    Vec<D> centre;
    Sym<D> hessian;

    [[nodiscard]] double operator()(const Vec<D>& offset) const {
        const Vec<D> r = offset - centre;
        return 0.5 * dot(r, hessian * r);
    }
};

/// Edge nodes and vertices that move together, and the elements that watch them. A vertex takes half of its
/// displacement along to the nodes of its edges; a node's own unknown is its offset beyond that.
template <int D>
struct JointProgramme {
    static constexpr int fixed = -1;

    struct Element {
        QuadraticSimplex<D, D> bezier;                   ///< where its points are now
        std::array<int, quadratic_nodes<D>> unknowns{};  ///< of its vertices and edges, in that order; or fixed
        double floor = 0;  ///< what the coefficients are to be above, as shares of |det straight|
        double least =
            -std::numeric_limits<double>::infinity();  ///< and as they are: vertices take |det straight| along
    };
    std::vector<OffsetModel<D>> unknowns;
    std::vector<Element> elements;
    double first_penalty = weak;                                ///< of a shortfall, beside the models
    double max_work = std::numeric_limits<double>::infinity();  ///< after it no more steps are taken

    static constexpr double weak = 0.1;   ///< the first steps choose the way that costs little
    static constexpr double strong = 10;  ///< they go where the constraints hold
};

/// Work is counted so that what is decided by it does not depend on the machine; a unit takes about 50 µs. A step with
/// ten unknowns and thirty elements is about one: 0.4 (unknowns / 10)² for its equations, and this for each evaluation
/// of an element.
inline constexpr double element_work = 0.01;
[[nodiscard]] constexpr double equations_work(std::size_t unknowns) {
    const auto n = static_cast<double>(unknowns);
    return 0.4 * n * n / 100;
}

/// How far below its floor a coefficient may end, as a share of |det straight|.
inline constexpr double largest_shortfall = 1e-6;

/// Where the unknowns ended.
template <int D>
struct JointSolution {
    std::vector<Vec<D>> offsets;
    double shortfall = 0;  ///< how far below its floor the lowest coefficient is; at most 0 when all are above
    double work = 0;       ///< of all steps, and of those that led nowhere
};

/// Minimises the sum of the models subject to c ≥ max(floor · |det straight|, least) for every Bézier coefficient c of
/// det J of every element: an augmented Lagrangian (Hestenes, Powell, Rockafellar) of Gauss–Newton steps from the
/// offsets `start`, which need not be feasible. The unknowns are in the metric's frame by their models, and the
/// constraints by the division, so thin elements are not punished for being thin. A local minimum; deterministic; one
/// thread.
template <int D>
[[nodiscard]] JointSolution<D> solve(const JointProgramme<D>& programme, std::vector<Vec<D>> start);

}  // namespace camber
