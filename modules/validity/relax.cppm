module;
#include <cstddef>
#include <cstdint>
export module camber.validity:relax;
import camber.core;
import :validate;

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
    double min_scaled_jacobian = 1e-12;  ///< det J / |det straight| that makes an element valid (paper §4.3)
    /// What the shell strategy aims at in mended elements, where it can be had: keeps them off the very edge of
    /// validity.
    double target = 1e-2;
    double theta = 0.75;       ///< factor of a plain step, in (0, 1)
    int max_corrections = 10;  ///< plain steps of one edge before it is made straight
    RelaxStrategy strategy = RelaxStrategy::shell;
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
