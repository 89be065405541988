module;
#include <cstddef>
#include <tuple>
export module camber.cavity:reinsert_all;
import camber.core;
import camber.metric;
import camber.validity;
import camber.curving;
import camber.repair;
import :reinsert;

export namespace camber {

/// Options of the global algorithm.
struct ReinsertAllOptions {
    ReinsertOptions cavity = {};
    /// Turns over the vertices that have a node short of its target next to something that changed. The first turn
    /// reinserts every vertex: those of the volume, then those of the boundary.
    int max_turns = 20;

    [[nodiscard]] static constexpr auto options() {
        return std::tuple(option("max_turns", &ReinsertAllOptions::max_turns,
                                 "turns over the vertices; after the first only those with nodes that neighbours kept "
                                 "from their places")
                              .at_least(1)
                              .at_most(1000));
    }
};

/// What the walk over the vertices came to.
struct ReinsertStatistics {
    std::size_t turns = 0, rounds = 0;  ///< a round: cavities that do not overlap, planned together and committed once
    std::size_t patches = 0;            ///< committed
    std::size_t not_valid = 0, no_gain = 0;  ///< rejections
    std::size_t left = 0;                    ///< vertices that had reason for another turn when max_turns ended it
};

/// The outcome of the global algorithm.
template <int D>
struct Reinserted {
    Curved<D> wanted;       ///< the targets of all edges: what curve would propose
    Proposal<D> proposal;   ///< what the cavities made of them
    QuadraticMesh<D> mesh;  ///< with these nodes
    ReinsertStatistics statistics;
};

/// The paper's global algorithm (§4): every vertex is reinserted with its ball as the cavity. The mesh is as valid as
/// it was at all times: no element that is valid becomes not valid, between any two commits. Vertices whose nodes fell
/// short of their targets because their neighbours' were not yet curved have another turn once these have changed.
/// Cavities that do not overlap are planned in parallel; the result is the same for any number of threads. `base`: as
/// `edge_targets` has it. Errors:
/// columns that do not fit, options out of range, stopped.
template <int D>
[[nodiscard]] Outcome<Reinserted<D>> reinsert_all(QuadraticMesh<D> mesh, const Column<EdgeKind>& kinds,
                                                  const Column<LagrangeNode<D>>& base, const BackMesh<D>& back,
                                                  const ReinsertAllOptions& options, const Execution& execution);

}  // namespace camber
