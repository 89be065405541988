module;
#include <cstddef>
#include <cstdint>
#include <tuple>
export module camber.repair:relax;
import camber.core;
import camber.validity;

export namespace camber {

/// How `relax` goes about it.
enum class RelaxStrategy : std::uint8_t {
    /// Node by node, as little as needed: each moves on the segment to the middle of its chord to the farthest place
    /// where the elements of its shell hold, by a linear programme; plain steps only for what that cannot mend; relaxed
    /// nodes are put back as far as they may at the end.
    shell,
    /// The paper's (§3.2): P_11 ← θ P_11 + (1 − θ) M for all volume edges of an element that is not valid, then for its
    /// surface edges, until it is; elements that break by it are next.
    paper,
};

/// How far and in which way `relax` moves nodes.
struct RelaxOptions {
    double min_scaled_jacobian = default_bound;
    double target = 1e-2;  ///< of the shell strategy
    double theta = 0.75;
    int max_corrections = 40;
    RelaxStrategy strategy = RelaxStrategy::shell;

    [[nodiscard]] static constexpr auto options() {
        using S = RelaxOptions;
        return std::tuple(
            bound_option<S>(),
            option("target", &S::target,
                   "what is aimed at in mended elements where it can be had, as a share of the straight element's "
                   "determinant; keeps them off the very edge of validity")
                .at_least(0)
                .below(1),
            option("theta", &S::theta, "what a correction leaves of a node's offset")
                .unit("shares of the offset")
                .above(0)
                .below(1),
            option("max_corrections", &S::max_corrections, "corrections before a node goes to the middle of its chord")
                .at_least(1)
                .at_most(10000));
    }
    friend bool operator==(const RelaxOptions&, const RelaxOptions&) = default;
};

/// What `relax` made of a proposal.
template <int D>
struct Relaxation {
    JudgedProposal<D> judged;
    std::size_t corrected_elements = 0;     ///< not valid before, valid now
    std::size_t relaxed_volume_edges = 0;   ///< whose node is not where it was
    std::size_t relaxed_surface_edges = 0;  ///< the same, of surface and ridge edges
};

/// The fourth verb: moves nodes of elements that are not valid (and of those that break by it) towards the middle of
/// their chords, volume edges first, surface and ridge edges last, until every element is valid. Succeeds whenever the
/// straight mesh is valid to the bound; what cannot be mended remains, and the validation says so. Nothing changes
/// when all elements are valid. A proposal that was judged for another bound is judged again. Errors: options out of
/// range (usage), columns that do not fit the mesh (internal), stopped.
template <int D>
[[nodiscard]] Outcome<Relaxation<D>> relax(const JudgedProposal<D>& wanted, RelaxOptions options,
                                           const Execution& execution);

}  // namespace camber
