module;
#include <cstddef>
#include <tuple>
export module camber.adapt:reinsert;
import camber.core;
import camber.cavity;
import camber.operation;
import camber.metric;
import camber.validity;

export namespace camber {

/// How vertices are put in again.
struct ReinsertionOptions {
    double min_scaled_jacobian = min_bound;
    double target = 0.01;
    /// Through a stack of layers nodes come one layer a turn. Turns over the vertices that have a node short of its
    /// target next to something that changed; the first turn is over all of them: those of the volume, then those of
    /// the boundary.
    int max_sweeps = 100;

    [[nodiscard]] static constexpr auto options() {
        using S = ReinsertionOptions;
        return std::tuple(
            option("min_scaled_jacobian", &S::min_scaled_jacobian, "of new elements, unless they were not valid before")
                .at_least(0)
                .below(1),
            option("target", &S::target, "of new elements the scaled Jacobian, unless one before is worse")
                .at_least(0)
                .below(1),
            option("max_sweeps", &S::max_sweeps,
                   "sweeps over the vertices; after the first only those with nodes that neighbours kept from their "
                   "places")
                .at_least(1)
                .at_most(1000));
    }
    friend bool operator==(const ReinsertionOptions&, const ReinsertionOptions&) = default;
};

/// What the walk over the vertices made.
template <int D>
struct Reinserted {
    Proposal<D> proposal;  ///< what the cavities made of the wanted nodes
    PassStatistics statistics;
    std::size_t sweeps = 0;
    std::size_t left = 0;  ///< vertices that had reason for another sweep when max_sweeps ended it
};

/// The paper's global algorithm (§4): every vertex is put in again where it is, with its ball as the cavity (§3.2), and
/// the nodes of its edges go to where `wanted` has them, as far as elements stay valid: all of the way, or by halves of
/// it. Those that other nodes keep back have another sweep once these have moved. No element is worse for it than the
/// worst of its cavity, unless it is good, and none is invalid that was not. `wanted`: of `curve`, a row an edge; the
/// kind `fixed` stays. `breaks`: see make_dynamic. `field`: by which elements are judged. Edges that no element holds
/// go to their places straight away. Threads have no say. Errors: options out of range, a proposal that is not the
/// mesh's, those of make_dynamic; stopped, memory.
template <int D>
[[nodiscard]] Outcome<Reinserted<D>> reinsert(const QuadraticMesh<D>& mesh, const Proposal<D>& wanted,
                                              const BreaksOfMesh& breaks, const BackMesh<D>& field,
                                              const ReinsertionOptions& options, const Execution& execution);

}  // namespace camber
