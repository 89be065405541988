module;
#include <cstddef>
#include <span>
#include <vector>
export module camber.crossing:crossings;
import camber.core;
import camber.bezier;
import :pair;

export namespace camber {

/// Two facets that are not disjoint; one that is not of itself.
struct FacetCrossing {
    FacetId first, second;  ///< the lower one first; the same twice: of itself
    Crossing verdict = Crossing::undecided;
    friend bool operator==(const FacetCrossing&, const FacetCrossing&) = default;
};

/// Pairs of pieces that a mesh's open pairs of facets may take in all.
[[nodiscard]] constexpr std::size_t max_steps(std::size_t facets) { return 100'000 + 16 * facets; }

/// What became of all pairs of a mesh's facets.
struct Crossings {
    std::size_t pairs = 0;  ///< whose boxes meet, and that were looked at; the others are disjoint by their boxes
    std::size_t crossing = 0, touching = 0, undecided = 0;
    std::size_t cut_short = 0;              ///< of the undecided: for want of work; more of it might have told
    std::size_t steps = 0;                  ///< the work: pairs of pieces that were looked at
    std::vector<FacetCrossing> found = {};  ///< those that are not disjoint, by rising facets

    [[nodiscard]] bool all_disjoint() const { return found.empty(); }
    friend bool operator==(const Crossings&, const Crossings&) = default;
};

/// Whether the mesh's facets (boundary and interfaces) cross each other or themselves. Elements may all be valid and
/// walls yet pass through each other: det J > 0 speaks of each element alone. Every pair has a first look; what that
/// leaves open shares `max_steps`. Time: n log n and what pairs of near facets take. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Crossings> find_crossings(const QuadraticMesh<D>& mesh, const Execution& execution);

/// The same with other places of vertices and mid nodes: those of a proposal.
template <int D>
[[nodiscard]] Outcome<Crossings> find_crossings(const QuadraticMesh<D>& mesh, std::span<const Vec<D>> points,
                                                std::span<const LagrangeNode<D>> mid_nodes, const Execution& execution);

/// The same of a straight mesh.
template <int D>
[[nodiscard]] Outcome<Crossings> find_crossings(const LinearMesh<D>& mesh, const Execution& execution);

}  // namespace camber
